"""What the haze experiment claims, judged from its raw points alone."""

from collections.abc import Iterable

import numpy as np

from bench.fields.part_sizes import BOUNDS_M, SIZES, law_total, total
from bench.records.claims import Claim, claim
from bench.records.records import Point
from bench.statistics.estimates import share

BIG = SIZES[len(BOUNDS_M) - 1 :]
"""Over 1 m."""

SMALL = SIZES[: len(BOUNDS_M) - 1]
"""Under 1 m."""

AIRS = "hazy", "clear"

JUDGED_AT_M = 2e3
"""The visibility at which shares are claimed: V = 2 km."""

_DERIVED = "issue 5: derivation"


def judge(points: tuple[Point, ...]) -> tuple[Claim, ...]:
    """Every claim that these points decide."""
    made: list[Claim] = []
    for kind, chosen in by_kind(points).items():
        name = "/".join(map(str, kind))
        made.append(_law(name, chosen))
        made.append(_near(name, chosen))
        at = [point for point in chosen if point.case["visibility"] == JUDGED_AT_M]
        made += [each for point in at for each in _shares(name, kind[0], point)]
    return tuple(made)


Kind = tuple[str, str, int]


def by_kind(points: Iterable[Point]) -> dict[Kind, list[Point]]:
    """Points by species, viewer and width of the picture, in the order they come."""
    kinds: dict[Kind, list[Point]] = {}
    for point in points:
        kind = point.case["species"], point.case["viewer"], point.case["width"]
        kinds.setdefault(kind, []).append(point)
    return kinds


def _law(name: str, points: list[Point]) -> Claim:
    """Over all visibilities together, so that a row is a field of its own."""
    hazy, clear = (np.sum([total(p, air) for p in points], axis=0) for air in AIRS)
    law = [sum(law_total(p, air) for p in points) for air in AIRS]
    about = "Haze leaves the share of the parts that is predicted, with nothing fitted."
    words = about, "share of all parts that is kept, all visibilities", "§2.1, §4.1"
    return claim(f"{name}/kept", words, law[0] / law[1], 0.02, share(hazy, clear))


def _near(name: str, points: list[Point]) -> Claim:
    """What is lost from nearer than V, of all that is lost, over all visibilities."""
    near = sum(_column(p, "clear") - _column(p, "hazy") for p in points)
    lost = sum(total(p, "clear") - total(p, "hazy") for p in points)
    about = "Haze takes nothing that is nearer than the visibility."
    words = about, "share of the parts lost that were nearer than V", _DERIVED
    found = share(np.asarray(near, np.float64), np.asarray(lost, np.float64))
    return claim(f"{name}/lost_near", words, 0, 0.01, found, "at most")


def _column(point: Point, air: str) -> np.ndarray:
    return np.array(point.samples[f"{air}, nearer than V"], np.float64)


def _shares(name: str, species: str, point: Point) -> list[Claim]:
    """At V = 2 km: of the big at most half are kept, of the small at least 95 %."""
    made = []
    if species == "tree":
        kept = share(total(point, "hazy", BIG), total(point, "clear", BIG))
        about = "At V = 2 km at least half of the parts over 1 m are gone."
        words = about, "share of parts over 1 m that is kept", "issue 5, 4"
        made.append(claim(f"{name}/kept_over_1m", words, 0.5, 0, kept, "at most"))
    clear = total(point, "clear", SMALL)
    lost = share(clear - total(point, "hazy", SMALL), clear)
    about = "At V = 2 km hardly any part under 1 m is gone."
    words = about, "share of parts under 1 m that is lost", _DERIVED
    made.append(claim(f"{name}/lost_under_1m", words, 0, 0.05, lost, "at most"))
    return made
