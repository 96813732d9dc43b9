"""How much does a frame's number of parts vary, and which τ keeps it within a budget? (§4.1)

The law gives the mean of a frame, whatever the pattern in which objects stand. Its variance follows
from their pair correlation, and its 99th percentile is that of a gamma variable of this mean and
variance. Fields are Poisson, clustered (Thomas) and regular (Matérn II), and a map of real stems if
``--stems`` names one; all go through the pruner as they stand.

``spread`` compares both predictions with many fields, one frame of each. ``budget`` asks for the τ
at which 99 of 100 frames hold no more parts than a budget, by the prediction alone, and then walks
through fields of other seeds: the share of frames within the budget must be 0.99. An eye that walks
does not meet a new field at every step, so that a walk is the replicate.
"""

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache, partial
from pathlib import Path
from typing import NamedTuple

import numpy as np
from scipy.optimize import brentq

from bench.counting import EYE_HEIGHT_M, FLAT, Case, field_seed, prototypes_of, shapes_digest
from bench.experiment import Case as MeasuredCase
from bench.experiment import Experiment, Topic
from bench.plots import Curve, Plot, curves
from bench.records.claims import UNREPLICATED, Claim, claim, within
from bench.records.records import Column, Point, Record, columns, predictions
from bench.statistics.estimates import two_sided_mean, two_sided_quantile
from lod.law import chained_limits, disc_areas
from lod.pair_correlation import (
    CountSpread,
    PairCorrelation,
    count_spread,
    mapped,
    matern,
    poisson,
    thomas,
)
from lod.pruner import prune
from scenes.field.cells import PoissonCells, SquareCells
from scenes.field.patterns import MappedCells, MaternCells, ThomasCells, read_stems
from scenes.field.species_field import Species, SpeciesField

DENSITY = 3.6e-3  # K of every pattern but that of a map [1/m²]

TIGHT, WIDE = (10.0, 8.0), (40.0, 25.0)  # members of a cluster, and its deviation [m]

PACKED = 0.6
"""Share of the ground that discs of a regular pattern's core would cover, were they all apart."""

PIXELS = {"figure": (10.0, 20.0), "tree": (80.0, 160.0)}
"""Details τ of a picture 640 pixels wide across 60° [px], by what stands there."""

BUDGET = {"figure": 1500, "tree": 8000}  # parts that a frame may hold
SHARE = 0.99  # share of frames that is to be within a budget
STEP_M = 10.0  # the way between two frames of a walk [m]: a fraction of what an eye sees

MAPPED = "stems of a map"


class Stems(NamedTuple):
    """The path of a map of stems, which no record keeps, and the SHA-256 of the file."""

    path: str
    sha256: str

    def __str__(self) -> str:
        return Path(self.path).name


Named = tuple[str, Stems | None]  # a pattern by its name, and the map that it is of


@dataclass(frozen=True)
class Pattern:
    """How objects stand: their kind and density [1/m²], the process, and its pair correlation."""

    species: str
    density: float
    cells: Callable[[int, str, float], SquareCells]
    g: PairCorrelation

    def case(self, detail: float) -> Case:
        """Return the view and the objects at a detail τ [px]."""
        return Case("", self.species, "blake", self.density, detail=detail)

    def predict(self, detail: float) -> CountSpread:
        """Predict the parts of a frame, without the pruner."""
        case = self.case(detail)
        areas = []
        for tree in (each.hierarchy for each in prototypes_of(self.species, 1.0)):
            limits = chained_limits(tree, case.view().metric, case.m)
            areas.append(disc_areas(limits, EYE_HEIGHT_M - tree.position[:, 2]))
        return count_spread(self.density, areas, self.g)

    def count(self, detail: float, seed: int, walked_m: float = 0.0) -> int:
        """Count the parts of one frame by the pruner, so far east of the plane's origin [m]."""
        kinds = prototypes_of(self.species, 1.0)
        species = Species(self.species, kinds, self.density, pattern=self.cells)
        view = self.case(detail).view()
        camera = replace(view.camera, eye=view.camera.eye + np.array((walked_m, 0.0, 0.0)))
        return prune(
            SpeciesField(species, seed, FLAT), replace(view, camera=camera)
        ).displayed_parts


@lru_cache(maxsize=8)
def pattern_of(name: str, stems: Stems | None) -> Pattern:
    """Return a pattern by its name; that of a map is read from the file."""
    if name == MAPPED and stems:
        found = read_stems(Path(stems.path))
        g = mapped(found.xy, tuple(found.period), farthest=800.0)
        return Pattern("tree", found.density, partial(MappedCells, stems=found), g)
    if name == "Poisson":
        return Pattern("figure", DENSITY, PoissonCells, poisson)
    if name == "regular":
        core = math.sqrt(PACKED / (math.pi * DENSITY))
        g = partial(matern, candidates=-math.log1p(-PACKED) / (math.pi * core**2), core=core)
        return Pattern("figure", DENSITY, partial(MaternCells, core=core), g)
    members, sigma = TIGHT if name == "tight clusters" else WIDE
    parents = DENSITY / members
    cells = partial(ThomasCells, parents=parents, sigma=sigma)
    return Pattern("figure", DENSITY, cells, partial(thomas, parents=parents, sigma=sigma))


def _patterns(stems: tuple[str, str] | None) -> list[Named]:
    made: list[Named] = [
        (name, None) for name in ("Poisson", "tight clusters", "wide clusters", "regular")
    ]
    return [*made, (MAPPED, Stems(*stems))] if stems else made


def _point(topic: str, named: Named, detail: float, rows: Sequence[Column]) -> Point:
    pattern = pattern_of(*named)
    law = pattern.predict(detail)
    case = {"topic": topic, "pattern": named[0], "species": pattern.species, "detail": detail}
    if named[1]:
        path, digest = named[1]
        case |= {"stems": digest, "licence": read_stems(Path(path)).licence}
    told = {"mean": law.mean, "variance": law.variance, "percentile": law.quantile(SHARE)}
    return Point(case, predictions(told), tuple(rows), shapes_digest(pattern.species))


def measure_spread(named: Named, detail: float, fields: int, seed: int) -> Point:
    """Count the parts of one frame in each of many fields."""
    pattern = pattern_of(*named)
    seeds = [field_seed("spread", named[0], detail, seed, k) for k in range(fields)]
    found = [pattern.count(detail, each) for each in seeds]
    return _point("spread", named, detail, columns({"parts": found}))


def detail_within(pattern: Pattern, budget: float) -> float:
    """Predict the finest τ [px] at which SHARE of all frames is within a budget of parts."""

    def over(logarithm: float) -> float:
        return math.log(pattern.predict(math.exp(logarithm)).quantile(SHARE) / budget)

    coarse = math.log(PIXELS[pattern.species][0])
    return math.exp(brentq(over, coarse - 1.5, coarse + 2.5, xtol=1e-4))


def measure_budget(named: Named, walks: int, frames: int, seed: int) -> Point:
    """Walk through fields at the detail that is predicted, and count the parts of each frame."""
    pattern = pattern_of(*named)
    detail = detail_within(pattern, BUDGET[pattern.species])
    rows = [
        Column(
            "parts",
            [
                pattern.count(detail, field_seed("budget", named[0], seed, walk), STEP_M * k)
                for k in range(frames)
            ],
            {"walk": walk},
        )
        for walk in range(walks)
    ]
    return _point("budget", named, detail, rows)


# Claims, from raw counts alone.


def _condition(point: Point) -> dict[str, str | int | float]:
    return {"pattern": point.case["pattern"], "species": point.case["species"]}


def _of(point: Point, unit: str) -> str:
    """Return the unit of replication; all frames of a map look at the one map."""
    return UNREPLICATED if "stems" in point.case else unit


def _spread_claims(points: Sequence[Point]) -> Iterator[Claim]:
    for point in points:
        made = partial(claim, unit=_of(point, "field"), source="derived: docs/method.md")
        where_ = {**_condition(point), "τ": f"{point.case['detail']:g} px"}
        parts, law = point.values("parts"), point.prediction
        mean = two_sided_mean(parts) * (1 / law("mean"))
        about = two_sided_mean(np.square(parts - law("mean")))
        most = two_sided_quantile(parts, SHARE) * (1 / law("percentile"))
        bound, estimand = within(1, 0.02), "mean parts of a frame ÷ predicted"
        yield made(estimand, bound, where_, mean, kind="verification")
        estimand = "variance of a frame's parts ÷ predicted by pair correlation"
        yield made(estimand, within(1, 0.05), where_, about * (1 / law("variance")))
        estimand = "99th percentile of a frame's parts ÷ predicted by pair correlation"
        yield made(estimand, within(1, 0.05), where_, most)


def _walked(point: Point) -> np.ndarray:
    return np.array([each.values for each in point.samples], np.float64)


def _budget_claims(points: Sequence[Point]) -> Iterator[Claim]:
    for point in points:
        most = BUDGET[point.case["species"]]
        found = two_sided_mean((_walked(point) <= most).mean(axis=1))
        yield claim(
            f"share of frames within {most} parts",
            within(SHARE, 0.005),
            _condition(point),
            found,
            unit=_of(point, "walk"),
            source="derived: docs/method.md",
            headline=point.case["pattern"] == "tight clusters",
        )


# Plots.

_SHARES = np.concatenate((np.linspace(0.5, 0.9, 5), [0.95, 0.98, 0.99, 0.995, 0.998]))


def _quantiles(point: Point, parts: np.ndarray, over: float) -> Curve:
    """Draw the share of frames that hold more, measured and predicted, against parts ÷ ``over``."""
    law = CountSpread(point.prediction("mean"), point.prediction("variance"))
    measured = [two_sided_quantile(parts.ravel(), share).value / over for share in _SHARES]
    line = [law.quantile(share) / over for share in _SHARES]
    beyond = (1 - _SHARES).tolist()
    return Curve(point.case["pattern"], measured, beyond, line=(line, beyond))


def _spread_plots(record: Record) -> Iterator[Plot]:
    finest = [p for p in record.points if p.case["detail"] == PIXELS[p.case["species"]][0]]
    drawn = [_quantiles(p, p.values("parts"), p.prediction("mean")) for p in finest]
    title, axis = "How often a frame holds more than its mean", "parts of a frame ÷ predicted mean"
    caption = (
        "The share of frames that hold more parts than that. Lines are predicted from the pair "
        "correlation, without free parameters; the mean of all patterns is the same."
    )
    yield curves("spread", title, caption, (axis, "share of frames that hold more"), drawn)


def _budget_plots(record: Record) -> Iterator[Plot]:
    drawn = [_quantiles(p, _walked(p), BUDGET[p.case["species"]]) for p in record.points]
    details = ", ".join(f"{p.case['pattern']} {p.case['detail']:.3g} px" for p in record.points)
    kept = [100 * float((_walked(p) <= BUDGET[p.case["species"]]).mean()) for p in record.points]
    title = (
        f"{min(kept):.1f} to {max(kept):.1f} of 100 frames keep a budget of parts by the τ that "
        f"was predicted for {100 * SHARE:.0f}"
    )
    axis = "parts of a frame ÷ budget"
    caption = f"Frames of walks at the τ that is predicted for the budget: {details}."
    yield curves("budget", title, caption, (axis, "share of frames that hold more"), drawn)


def _spread_cases(fields: int, stems: tuple[str, str] | None) -> list[MeasuredCase]:
    return [
        partial(measure_spread, named, detail, fields)
        for named in _patterns(stems)
        for detail in PIXELS["tree" if named[0] == MAPPED else "figure"]
    ]


EXPERIMENT = Experiment(
    name="spread",
    question="How much does a frame's number of parts vary, and which τ keeps it within a budget?",
    version=1,
    topics={
        "spread": Topic(
            about="variance and 99th percentile of a frame, from how objects stand to each other",
            cases=_spread_cases,
            claims=_spread_claims,
            plots=_spread_plots,
            accepts=("stems",),
            full={"fields": 16_000},
            quick={"fields": 1_500},
            seconds=(480.0, 60.0),
        ),
        "budget": Topic(
            about="the τ that keeps 99 of 100 frames of a walk within a budget of parts",
            cases=lambda walks, frames, stems: [
                partial(measure_budget, named, walks, frames) for named in _patterns(stems)
            ],
            claims=_budget_claims,
            plots=_budget_plots,
            accepts=("stems",),
            full={"walks": 1_200, "frames": 20},
            quick={"walks": 120, "frames": 20},
            seconds=(360.0, 45.0),
        ),
    },
    caveats=(
        "Standing people and trees on flat ground, in clear air, seen all round.",
        "The variance and the mean are derived; that frames are gamma variables is assumed, and "
        "these experiments try it.",
        "A map of stems is one sample of one forest: its intervals are over places in the map, and "
        "say nothing of other forests.",
    ),
    order=15,
)
