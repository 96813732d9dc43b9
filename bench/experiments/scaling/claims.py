"""What the scaling experiment claims, judged from its raw points alone (§4.1)."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from bench.experiments.scaling.claims_beyond import judge_beyond
from bench.fields.cases import EYE_HEIGHT_M, SWEEPS, Case
from bench.records.claims import Claim
from bench.records.old_claims import claim, verification
from bench.records.records import Point, grouped
from bench.statistics.estimates import Estimate, two_sided_ratio, two_sided_slope

FAR = 20.0
"""The limit distance, in eye heights, from which on slopes against m are claimed."""

POOLED = 0.005
"""How far the pooled ratio of one metric and species may be from 1; single sweeps may be 0.02."""

_LAW = "§4.1"
_PREFACTOR = "§4.1, prefactor"


@dataclass(frozen=True, eq=False)
class Rows:
    """Fields of some points, one row each: counts, swept values, predictions and dispersion."""

    counts: np.ndarray
    swept: np.ndarray
    predicted: np.ndarray
    dispersion: np.ndarray

    def against_sweep(self) -> Estimate:
        """Estimate the exponent of counts against what was swept."""
        return two_sided_slope(self.counts, self.swept, self.dispersion)

    def against_prediction(self) -> Estimate:
        """Estimate the exponent of counts against the law's prediction."""
        return two_sided_slope(self.counts, self.predicted, self.dispersion)

    def over_prediction(self) -> Estimate:
        """Estimate measured ÷ predicted."""
        return two_sided_ratio(self.counts, self.predicted, self.dispersion)


def case_of(point: Point) -> Case:
    """Return the case of a point."""
    return Case(**point.case)


def swept(point: Point) -> float:
    """Return the quantity of the law that the point's sweep varies."""
    case = case_of(point)
    match case.sweep:
        case "density":
            return case.density
        case "size":
            return point.prediction("P_plus_R")
        case "world":
            return float(case.extent or np.inf)
    return case.m


def rows(points: Iterable[Point], what: str, examined: bool = False) -> Rows:
    """Return all fields of the points; ``what`` is ``objects`` or ``parts``."""
    column = f"{what}_examined" if examined else what
    counts, values = [], []
    for point in points:
        mean = point.prediction(what)
        row = swept(point), mean, point.prediction(f"{what}_variance") / mean
        counts.append(point.values(column))
        values.append(np.tile(row, (len(counts[-1]), 1)))
    return Rows(np.concatenate(counts), *np.concatenate(values).T)


def judge(points: tuple[Point, ...]) -> tuple[Claim, ...]:
    """Return every claim that these points decide."""
    claims: list[Claim] = []
    for (species, metric), chosen in by_kind(points).items():
        name = f"{metric}/{species}"
        claims += _powers(name, chosen, tuple(_POWERS) if metric == "blake" else ("density",))
        claims += _prefactors(name, chosen)
        claims += _search(name, chosen)
    return (*claims, *judge_beyond(points))


def noise_of(points: Sequence[Point]) -> dict[str, float]:
    """Estimate the variance of fields about their prediction ÷ the variance of the law."""
    return {
        f"{metric}/{species}/{what}": round(rows(chosen, what).over_prediction().scale, 4)
        for (species, metric), chosen in by_kind(points).items()
        for what in ("objects", "parts")
    }


def by_kind(points: Iterable[Point]) -> dict[tuple[Any, ...], list[Point]]:
    """Group points of SWEEPS by species and metric, in the order they come."""
    swept_points = (point for point in points if point.case["sweep"] in SWEEPS)
    return grouped(swept_points, "species", "metric")


def _powers(name: str, points: list[Point], sweeps: tuple[str, ...]) -> list[Claim]:
    """Claim the exponents of K(P+R)²/m² in these sweeps, and that the world's size has none."""
    made = []
    for sweep in sweeps:
        about, quantity, exponent, tolerance, keep = _POWERS[sweep]
        chosen = [p for p in points if p.case["sweep"] == sweep and keep(p)]
        if len({swept(p) for p in chosen}) > 1:
            found = rows(chosen, "objects").against_sweep()
            words = about, f"exponent against {quantity}", _LAW
            label = f"{name}/objects/slope_{sweep}"
            made.append(verification(claim(label, words, exponent, tolerance, found)))
    return made


def _prefactors(name: str, points: list[Point]) -> list[Claim]:
    """Claim the exponent and the prefactor of counts against their own prediction."""
    made = []
    for what in ("objects", "parts"):
        data = rows(points, what)
        about = f"The {what} displayed grow just as predicted, over all sweeps together."
        words = about, "exponent against the prediction", _PREFACTOR
        found = data.against_prediction()
        made.append(verification(claim(f"{name}/{what}/slope_prediction", words, 1, 0.02, found)))
        about = f"The number of {what} displayed is the number predicted, with nothing fitted."
        words = about, "measured ÷ predicted", _PREFACTOR
        found = data.over_prediction()
        made.append(verification(claim(f"{name}/{what}/ratio", words, 1, POOLED, found)))
    return made


def _search(name: str, points: list[Point]) -> list[Claim]:
    """Claim that what is examined grows no faster than in proportion, whatever the world."""
    world = [p for p in points if p.case["sweep"] == "world" and beyond(p)]
    endless = [p for p in points if p.case["extent"] is None]
    made = []
    if len(world) > 1:
        about = "A larger world has no more objects to examine, once it is larger than the limit."
        found = rows(world, "objects", examined=True).against_sweep()
        words = about, "exponent against L", _LAW
        made.append(claim(f"{name}/objects_examined/slope_world", words, 0, 0.005, found))
    for what in ("objects", "parts"):
        about = f"The {what} examined grow no faster than the {what} displayed."
        words = about, f"exponent against {what} displayed", _LAW
        found = rows(endless, what, examined=True).against_prediction()
        label = f"{name}/{what}_examined/slope_prediction"
        made.append(claim(label, words, 1, 0.02, found, relation="at most"))
    return made


Keep = Callable[[Point], bool]


def _any(_: Point) -> bool:
    return True


def _far(point: Point) -> bool:
    return point.prediction("nearest_limit") > FAR * EYE_HEIGHT_M


def beyond(point: Point) -> bool:
    """Say whether the world reaches beyond the limit distance on all sides."""
    return float(point.case["extent"] or np.inf) > 2 * point.prediction("farthest_limit")


Power = tuple[str, str, float, float, Keep]

_POWERS: dict[str, Power] = {
    "density": ("Twice as many objects per area: twice as many displayed.", "K", 1, 0.02, _any),
    "size": ("Objects twice as large: four times as many displayed.", "P + R", 2, 0.02, _far),
    "detail": ("Detail twice as coarse: a quarter as many displayed.", "m", -2, 0.02, _far),
    "resolution": ("A picture half as wide in pixels: a quarter displayed.", "m", -2, 0.02, _far),
    "magnification": ("A view twice as magnified: four times displayed.", "m", -2, 0.02, _far),
    "world": (
        "A larger world displays no more objects, once it is larger than the limit.",
        *("L", 0, 0.005),
        beyond,
    ),
}
"""For each sweep the claim in words, its axis, the exponent, its tolerance, and its points."""
