"""What the colonnade claims, judged from its raw sizes, parts and errors alone (§2.1)."""

from collections.abc import Sequence

import numpy as np

from bench.experiments.colonnade.scene import COUNT, image_width, places
from bench.records.claims import Claim
from bench.records.old_claims import claim, verification
from bench.records.records import Point, where
from bench.statistics.estimates import Estimate, exactly, two_sided_mean

BLAKE, DEPTH = ("blake", 8.0), ("depth", 12.0)
"""The metric and the detail of both cuts that are compared: they display about as many parts."""

MIDDLE, OUTER = COUNT // 2, (0, COUNT - 1)
_SOURCE = "§2.1"


def columns(points: Sequence[Point], which: tuple[str, float]) -> list[Point]:
    """Return the points of the columns of one cut, from left to right."""
    return where(points, metric=which[0], detail=which[1])


def judge(points: tuple[Point, ...]) -> tuple[Claim, ...]:
    """Return every claim that these points decide."""
    blake, depth = columns(points, BLAKE), columns(points, DEPTH)
    return (
        _width(blake),
        _solid_angle(blake),
        _parts("blake", blake, "Seen by true distance, columns to the side lose detail."),
        _parts("depth", columns(points, ("depth", 3.0)), "Seen by depth, all are as detailed."),
        _same_parts(blake, depth),
        _error("eye", "error by solid angle", blake, depth),
        _error("image", "error by area of the image", blake, depth),
    )


def _width(row: list[Point]) -> Claim:
    found = _over_middle(row, "shaft_mpx")
    about = "Images of columns to the side are larger, as a flat picture has them."
    words = about, "width of the outermost shaft's image ÷ the middle one's", _SOURCE
    predicted = image_width(places()[-1]) / image_width(0.0)
    return verification(claim("sizes/column/image_width", words, round(predicted, 4), 0.07, found))


def _solid_angle(row: list[Point]) -> Claim:
    about = "They subtend less, all the same."
    words = about, "solid angle of the outermost column ÷ the middle one's", _SOURCE
    found = _over_middle(row, "solid_angle_usr")
    return verification(claim("sizes/column/solid_angle", words, 1.0, 0.0, found, "at most"))


def _parts(metric: str, row: list[Point], about: str) -> Claim:
    share = np.mean([row[k].column("parts")[0] for k in OUTER]) / row[MIDDLE].column("parts")[0]
    words = about, "parts of the outermost column ÷ the middle one's", _SOURCE
    name = f"{metric}/column/parts"
    if metric == "depth":
        return verification(claim(name, words, 1.0, 0.0, exactly(float(share))))
    return claim(name, words, 0.9, 0.0, exactly(float(share)), "at most")


def _same_parts(blake: list[Point], depth: list[Point]) -> Claim:
    share = _total(blake) / _total(depth)
    about = "The two cuts whose errors are compared display about as many parts."
    words = about, "parts of all columns, blake at 8 px ÷ depth at 12 px", _SOURCE
    return verification(claim("blake/column/budget", words, 1.0, 0.1, exactly(share)))


def _error(weight: str, what: str, blake: list[Point], depth: list[Point]) -> Claim:
    size = "solid_angle_usr" if weight == "eye" else "pixels"
    ratios = _mean_error(blake, weight, size) / _mean_error(depth, weight, size)
    about = f"For as many parts, true distance makes less {what} than depth."
    words = about, f"{what} over all columns, blake at 8 px ÷ depth at 12 px", _SOURCE
    return claim(f"blake/column/error_{weight}", words, 1.0, 0.0, two_sided_mean(ratios), "at most")


def _mean_error(row: list[Point], weight: str, size: str) -> np.ndarray:
    """Return the error of all columns together, by seed."""
    error = np.array([point.values("error_ppm", weight=weight) for point in row])
    return np.average(error, axis=0, weights=np.array([p.values(size) for p in row]))


def _total(row: list[Point]) -> float:
    return float(sum(point.column("parts")[0] for point in row))


def _over_middle(row: list[Point], name: str) -> Estimate:
    outer = np.mean([row[k].values(name) for k in OUTER], axis=0)
    return two_sided_mean(outer / row[MIDDLE].values(name))
