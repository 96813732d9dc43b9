"""Does what a frame displays follow the law, and is depth complexity bounded? (§4.1)

``scaling`` sweeps one quantity of K(P + R)²/m² at a time, prefactor and all; and then, one at a
time, what the flat-ground model πK((P + R)/m)² leaves out: several species, hills, uneven K, limits
near the eye, high eyes and haze. The extended model must predict every case. The flat-ground model
is tried at the mildest and at the hardest case of each sweep: where the extended model is further
from it than the margin, it is expected to fail.

``depth`` tests level rays all round against every stick that is displayed: a line pierces a stick
where a point of its axis is nearer to the line than the radius there. Pruned, the count should
depend neither on the size of the world nor on the direction; unpruned, it grows with its radius.
"""

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict
from functools import partial
from typing import Any, NamedTuple

import numpy as np
from scipy import stats

from bench import preset_growth
from bench.counting import (
    BEYOND,
    COLUMNS,
    EYE_HEIGHT_M,
    FLAT,
    SWEEPS,
    Case,
    count_field,
    field_seed,
    pierced,
    predict,
    scaling_grid,
    shapes_digest,
)
from bench.experiment import Experiment, Topic
from bench.part_sizes import camera, prototypes_with, seed_of
from bench.plots import Curve, Panel, Plot, curves, estimated, figure
from bench.records.claims import EXACT, Claim, at_most, claim, within
from bench.records.records import Column, Point, Record, columns, grouped, predictions, where
from bench.statistics.estimates import (
    TWO_SIDED_TAILS,
    Estimate,
    StoppingRule,
    exactly,
    fields_needed,
    sample,
    two_sided_mean,
    two_sided_paired_ratio,
    two_sided_ratio,
    two_sided_slope,
    worst_error,
)
from lod.arrays import Reals
from lod.metric import METRICS
from lod.pruner import blend_weights, prune
from lod.view import View
from scenes.field.species_field import Species, SpeciesField

# Cases and what is measured of them.

EXTENTS_M = (75.0, 150.0, 300.0, 450.0)
DEPTH_DENSITY = 4e-3
DEPTH_DETAIL_PX, DEPTH_WIDTH_PX = 4.0, 320
"""Detail and width of the picture [px]: a person is displayed within some 130 m."""

QUADRANTS, RAYS = 4, 32
"""The rays in each quadrant; they are even, and the first direction is random."""

RAY_HEIGHT_M = 1.2
"""Height of the rays [m], at which they meet chests and arms."""

PRUNED, UNPRUNED = "blake", "full"


def measure_scaling(case: Case, rule: StoppingRule, seed: int) -> Point:
    """Count as many independent fields of a case as its means need."""
    law = predict(case)
    pairs = (law.objects, law.objects_variance), (law.parts, law.parts_variance)
    needed = max(fields_needed(mean, variance, rule.target) for mean, variance in pairs)

    def draw(index: int) -> tuple[int, ...]:
        return count_field(case, field_seed(asdict(case), seed, index))

    # Objects and parts displayed, the first two columns, decide how many fields there are.
    counts = sample(draw, needed, 2, rule)
    samples = dict(zip(COLUMNS, map(list, zip(*counts, strict=True)), strict=True))
    named, scene = {"topic": "scaling", **asdict(case)}, shapes_digest(case.species)
    return Point(named, predictions(asdict(law)), columns(samples), scene)


def _measure_depth(extent: float, metric: str, fields: int, seed: int) -> Point:
    rows = np.array([pierced_in_field(extent, metric, seed, k) for k in range(fields)])
    found = [Column("pierced", rows[:, k].tolist(), {"quadrant": k}) for k in range(QUADRANTS)]
    named = {"topic": "depth", "extent": extent, "metric": metric}
    return Point(named, samples=tuple(found), scene=shapes_digest("figure"))


def pierced_in_field(extent: float, metric: str, seed: int, index: int) -> list[int]:
    """Count the sticks that all rays of each quadrant together pierce, in one field."""
    view = View(camera(DEPTH_WIDTH_PX), METRICS[metric], DEPTH_DETAIL_PX, look_around=True)
    own = seed_of("depth", seed, index)
    species = Species("depth", prototypes_with("figure", None), DEPTH_DENSITY)
    field = SpeciesField(species, own, FLAT, extent)
    cut = prune(field, view)
    shape = field.prototypes.sticks(cut.parts, blend_weights(cut, view))
    eye = np.array((view.camera.eye[0], view.camera.eye[1], RAY_HEIGHT_M))
    turn = np.random.Generator(np.random.Philox(own)).random()
    angle = (np.arange(QUADRANTS * RAYS) + turn) * math.tau / (QUADRANTS * RAYS)
    rays = np.stack((np.cos(angle), np.sin(angle), np.zeros(len(angle))), axis=1)
    found: list[int] = pierced(shape, eye, rays).reshape(QUADRANTS, RAYS).sum(axis=1).tolist()
    return found


# Claims, from raw points alone.

FAR = 20.0
"""The limit distance, in eye heights, from which on slopes against m are claimed."""

POOLED, SINGLE = 0.005, 0.02
"""How far a ratio may be from 1: of one metric and species over all sweeps, and of one sweep."""


class Rows(NamedTuple):
    """Fields of some points, one row each: counts, swept values, predictions and dispersion."""

    counts: np.ndarray
    swept: np.ndarray
    predicted: np.ndarray
    dispersion: np.ndarray

    def exponent(self, against: str) -> Estimate:
        """Estimate the exponent of counts against what was ``swept`` or ``predicted``."""
        return two_sided_slope(self.counts, getattr(self, against), self.dispersion)

    def over_prediction(self) -> Estimate:
        """Estimate measured ÷ predicted, one number over all fields."""
        return two_sided_ratio(self.counts, self.predicted, self.dispersion)


def swept(point: Point) -> float:
    """Return the quantity that the point's sweep varies; of ``size``, P + R [m]."""
    case = Case(**{key: value for key, value in point.case.items() if key != "topic"})
    if case.sweep == "size":
        return point.prediction("P_plus_R")
    value = getattr(case, {**SWEEPS, **BEYOND}[case.sweep].key)
    return math.inf if value is None else float(value)


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


def _by_kind(points: Iterable[Point]) -> dict[tuple[Any, ...], list[Point]]:
    chosen = [point for point in points if point.case.get("sweep") in SWEEPS]
    return grouped(chosen, "species", "metric")


def noise_of(points: Sequence[Point]) -> dict[str, float]:
    """Estimate the variance of fields about their prediction ÷ the variance of the law."""
    return {
        f"{metric}/{species}/{what}": round(rows(chosen, what).over_prediction().scale, 4)
        for (species, metric), chosen in _by_kind(points).items()
        for what in ("objects", "parts")
    }


def beyond(point: Point) -> bool:
    """Say whether the world reaches beyond the limit distance on all sides."""
    return float(point.case["extent"] or np.inf) > 2 * point.prediction("farthest_limit")


_claim = partial(claim, unit="field", source="§4.1")
_check = partial(_claim, kind="verification")


def _scaling_claims(points: Sequence[Point]) -> Iterator[Claim]:
    for (species, metric), chosen in _by_kind(points).items():
        yield from _of_kind({"metric": metric, "species": species}, chosen)
    for sweep in BEYOND:
        if chosen := where(points, sweep=sweep):
            yield from _beyond_claims(sweep, chosen)


def _of_kind(kind: dict[str, str], points: list[Point]) -> Iterator[Claim]:
    for name in SWEEPS if kind["metric"] == PRUNED else ("density",):
        sweep = SWEEPS[name]
        chosen = [p for p in where(points, sweep=name) if _is_claimed(name, p)]
        if len({swept(p) for p in chosen}) > 1:
            found = rows(chosen, "objects").exponent("swept")
            estimand = f"exponent of objects displayed against {sweep.symbol}"
            yield _check(estimand, within(*sweep.exponent), {**kind, "sweep": name}, found)
    for what in ("objects", "parts"):
        data, prefactor = rows(points, what), partial(_check, source="§4.1, prefactor")
        estimand = f"exponent of {what} displayed against {what} predicted"
        yield prefactor(estimand, within(1, 0.02), kind, data.exponent("predicted"))
        estimand = f"{what} displayed ÷ predicted"
        yield prefactor(estimand, within(1, POOLED), kind, data.over_prediction())
    world = [p for p in where(points, sweep="world") if beyond(p)]
    endless = where(points, extent=None)
    if len(world) > 1:
        found = rows(world, "objects", examined=True).exponent("swept")
        yield _claim("exponent of objects examined against L", within(0, 0.005), kind, found)
    for what in ("objects", "parts"):
        found = rows(endless, what, examined=True).exponent("predicted")
        estimand = f"exponent of {what} examined against {what} displayed"
        yield _claim(estimand, at_most(1.02), kind, found)


def _is_claimed(sweep: str, point: Point) -> bool:
    if sweep == "world":
        return beyond(point)
    return not SWEEPS[sweep].far or point.prediction("nearest_limit") > FAR * EYE_HEIGHT_M


def _beyond_claims(sweep: str, points: list[Point]) -> Iterator[Claim]:
    title = BEYOND[sweep].title
    scene, bound = {"scene": title[:1].lower() + title[1:]}, within(1, SINGLE)
    for what in ("objects", "parts"):
        found, source = rows(points, what).over_prediction(), "§4.1, with what the case adds"
        yield _check(f"{what} displayed ÷ extended model", bound, scene, found, source=source)
    for point in (points[0], points[-1]) if len(points) > 1 else ():
        extended = point.prediction("objects") / point.prediction("bare")
        yield _check(
            "objects displayed ÷ flat-ground model",
            bound,
            {**scene, BEYOND[sweep].axis: float(f"{swept(point):.3g}")},
            over_flat_ground(point),
            source="§4.1, flat ground",
            violation_expected=abs(extended - 1) > SINGLE,
        )


def over_flat_ground(point: Point) -> Estimate:
    """Estimate objects displayed ÷ those of the flat-ground model, of one point."""
    share = point.prediction("objects") / point.prediction("bare")
    return rows([point], "objects").over_prediction() * share


def _all_pierced(point: Point) -> Reals:
    return np.sum([point.values("pierced", quadrant=k) for k in range(QUADRANTS)], axis=0)


def _depth_claims(points: Sequence[Point]) -> Iterator[Claim]:
    pruned, full = (
        sorted(where(points, metric=m), key=lambda p: p.case["extent"]) for m in (PRUNED, UNPRUNED)
    )
    counts = np.concatenate([_all_pierced(p) for p in full])
    extent = np.concatenate([np.full(len(_all_pierced(p)), p.case["extent"]) for p in full])
    estimand, unpruned = "exponent of surfaces pierced against side of the world", "unpruned"
    growth = two_sided_slope(counts, extent)
    yield _claim(estimand, within(1.0, 0.2), {"pruning": unpruned}, growth)
    near, far = pruned[-2:]  # the same fields in two windows, both larger than the limit
    sides = f"{far.case['extent']:g} m ÷ {near.case['extent']:g} m"
    same = two_sided_paired_ratio(_all_pierced(far), _all_pierced(near))
    of, check = {"pruning": "pruned"}, partial(_check, alone=EXACT)
    yield check(f"surfaces pierced, side of the world {sides}", within(1.0, 0.02), of, same)
    for k in range(QUADRANTS):
        counts = QUADRANTS * far.values("pierced", quadrant=k)
        found = two_sided_paired_ratio(counts, _all_pierced(far))
        estimand = "surfaces pierced ÷ mean of all directions"
        yield check(estimand, within(1.0, 0.15), {**of, "quadrant": k + 1}, found)


def notes(points: tuple[Point, ...]) -> dict[str, Any]:
    """Return the error that sampling reached, how many fields it took, and how noisy they were."""
    scaling = where(points, topic="scaling")
    if not scaling:
        return {}
    tables = [list(zip(*(each.values for each in p.samples), strict=True)) for p in scaling]
    return {
        "worst_standard_error": round(max(worst_error(table, 2) for table in tables), 6),
        "fields": sum(len(point.column(COLUMNS[0])) for point in scaling),
        "variance_measured_over_predicted": noise_of(scaling),
    }


# Plots.

_KINDS = {"figure": "people", "tree": "trees", "sward": "grass"}


def _mean(point: Point, column: str) -> float:
    return float(point.values(column).mean())


def _series(point: Point) -> str:
    """Name what a point of a sweep shows: its species; or that the extended model predicts it."""
    if point.case["gathered"] != "evenly":
        return "placed unevenly"
    return _KINDS[point.case["species"]] if point.case["sweep"] in SWEEPS else "hills, haze, mixed"


def half_interval(point: Point, what: str, noise: Mapping[str, float]) -> float:
    """Return half the two-sided 95 % interval of the mean.

    The variance is the law's, times the ratio ``noise`` that all fields of the species and metric
    together have to it: few large fields alone could not say how much they vary.
    """
    scale = noise.get(f"{point.case['metric']}/{point.case['species']}/{what}", 1.0)
    variance = scale * point.prediction(f"{what}_variance") / len(point.column(what))
    return float(stats.norm.ppf(TWO_SIDED_TAILS[1]) * np.sqrt(variance))


def spread(point: Point, what: str) -> Estimate:
    """Estimate the standard deviation of fields ÷ the law's, with the interval of χ²."""
    counts = point.values(what)
    freedom = len(counts) - 1
    found = float(counts.std(ddof=1) / math.sqrt(point.prediction(f"{what}_variance")))
    low, high = (found * math.sqrt(freedom / v) for v in stats.chi2.ppf(TWO_SIDED_TAILS, freedom))
    return Estimate(found, float(high), float(low), math.nan, 1.0, len(counts))


_ENOUGH = 50
"""The fields from which on a spread or a percentile is drawn."""


def _scaling_plots(record: Record) -> Iterator[Plot]:
    noise = noise_of(record.points)
    points = [p for p in record.points if p.prediction("objects") >= 1.0]
    several = [p for p in points if len(p.column("objects")) >= _ENOUGH]
    ratios = {w: [_mean(p, w) / p.prediction(w) for p in points] for w in ("objects", "parts")}
    panels = [
        Panel(
            f"{what.capitalize()}: mean count of fields",
            (f"{what} predicted in a field", "counted ÷ predicted, 95 %"),
            _by_series(points, partial(_over_law, what=what, noise=noise)),
            ("log", "linear"),
            "points",
            between=(1 - SINGLE, 1 + SINGLE),
        )
        for what in ratios
    ]
    if several:
        spreads = _by_series(several, lambda p: (p.prediction("parts"), spread(p, "parts")))
        axis = "parts predicted in a field", "standard deviation ÷ predicted, 95 %"
        title = "Parts: spread of a count from field to field"
        panels += [Panel(title, axis, spreads, ("log", "linear"), "points", between=(0.9, 1.1))]
        tail = _by_series(several, _tail)
        ends = [x for each in tail for x in each.x]
        x = np.geomspace(min(ends), max(ends), 30)
        normal = (x.tolist(), (1 + float(stats.norm.ppf(0.99)) * x).tolist())
        tail.append(Curve("normal distribution", [], [], line=normal))
        axis = "standard deviation ÷ mean, predicted", "99th percentile ÷ mean, objects"
        title = "Objects: the fullest field of a hundred"
        panels += [Panel(title, axis, tail, look="points")]
    near = np.mean([abs(r - 1) <= SINGLE for row in ratios.values() for r in row])
    title = f"{100 * near:.0f} % of mean counts lie within {100 * SINGLE:g} % of the prediction"
    if several:
        middle = np.median([spread(p, "parts").value for p in several])
        uneven = [_tail(p)[1].value for p in several if p.case["gathered"] != "evenly"]
        title += f", and their spread is {middle:.2f} times the predicted"
    caption = (
        f"{len(points)} cases, {sum(len(p.column('objects')) for p in points)} fields; cases that "
        "predict less than one object in a field are in the tables alone. The "
        "prediction has no free parameter: its density K, sizes and eye are those of the case. "
        f"Shaded: ± {100 * SINGLE:g} % of the mean, ± 10 % of the spread. "
    )
    if several:
        caption += (
            f"Spread and percentile are of cases with at least {_ENOUGH} fields; placed unevenly, "
            f"one field in a hundred holds up to {max(uneven, default=1.0):.2f} times the mean."
        )
    yield figure("counts", title, caption, panels)
    if world := where(points, sweep="world", metric=PRUNED):
        yield _world_plot(sorted(world, key=swept))


def _by_series(
    points: Iterable[Point], place: Callable[[Point], tuple[float, Estimate]]
) -> list[Curve]:
    found: dict[str, list[tuple[float, Estimate]]] = {}
    for point in points:
        found.setdefault(_series(point), []).append(place(point))
    rows = {label: sorted(row, key=lambda each: each[0]) for label, row in found.items()}
    return [
        estimated(label, [x for x, _ in row], [each for _, each in row])
        for label, row in rows.items()
    ]


def _over_law(point: Point, what: str, noise: Mapping[str, float]) -> tuple[float, Estimate]:
    law, half = point.prediction(what), half_interval(point, what, noise)
    value, low, high = ((_mean(point, what) + k * half) / law for k in (0, -1, 1))
    return law, Estimate(value, low, high, half / law, 1.0, len(point.column(what)))


def _tail(point: Point) -> tuple[float, Estimate]:
    law = point.prediction("objects")
    counts = point.values("objects")
    found = exactly(float(np.quantile(counts, 0.99)) / law, len(counts))
    return math.sqrt(point.prediction("objects_variance")) / law, found


def _world_plot(world: Sequence[Point]) -> Plot:
    x = [swept(p) for p in world]
    drawn = [
        Curve(
            f"{what} {kind}",
            x,
            [_mean(p, what + column) for p in world],
            line=((x, [p.prediction(what) for p in world]) if kind == "displayed" else ((), ())),
        )
        for what in ("objects", "parts")
        for kind, column in (("displayed", ""), ("examined", "_examined"))
    ]
    ends = [p for p in world if beyond(p)]
    grown = [_mean(p, "objects_examined") for p in ends]
    title = "What a frame examines and displays stops growing beyond the limit distance"
    if grown and max(grown) > 1.02 * min(grown):
        title = f"Beyond the limit distance a frame still examines {max(grown) / min(grown):.2f} ×"
    caption = (
        f"People, {PRUNED}; mean counts of fields. The world reaches beyond the limit distance on "
        f"all sides from {min(map(swept, ends)):.3g} m on. "
        if ends
        else "People, mean counts. "
    ) + "Dashed: predicted."
    axis = "side of the world (m)", "mean number in a field"
    return curves("world-size", title, caption, axis, drawn)


def _depth_plots(record: Record) -> Iterator[Plot]:
    drawn = []
    for metric, label in ((PRUNED, "pruned"), (UNPRUNED, "unpruned")):
        row = where(record.points, metric=metric)
        found = [two_sided_mean(_all_pierced(p) / (QUADRANTS * RAYS)) for p in row]
        drawn.append(estimated(label, [p.case["extent"] for p in row], found, least=1e-3))
    ends = ", ".join(f"{c.label} from {c.y[0]:.2g} to {c.y[-1]:.2g}" for c in drawn)
    title = f"A level ray pierces, in ever larger worlds, {ends} surfaces"
    caption = "Means over fields with 95 % intervals. The eye is in the middle."
    axis = "side of the world (m)", "surfaces pierced by a ray"
    yield curves("depth", title, caption, axis, drawn)


EXPERIMENT = Experiment(
    name="law",
    question=(
        "Does what a frame displays depend on what the viewer can resolve, and not on the size of "
        "the world?"
    ),
    version=1,
    topics={
        "scaling": Topic(
            about="objects and parts against K(P+R)²/m², prefactor and all; and where that breaks",
            cases=lambda metric, **rule: [
                partial(measure_scaling, case, StoppingRule(**rule))
                for case in scaling_grid(metric)
            ],
            claims=_scaling_claims,
            plots=_scaling_plots,
            accepts=("metric",),
            full={"target": 0.005, "least": 4, "most": 20_000},
            quick={"target": 0.01, "least": 2, "most": 4_000},
            seconds=(400.0, 110.0),
        ),
        "depth": Topic(
            about="surfaces pierced by a ray to the limit, pruned and unpruned",
            cases=lambda fields: [
                partial(_measure_depth, extent, metric, fields)
                for extent in EXTENTS_M
                for metric in (PRUNED, UNPRUNED)
            ],
            claims=_depth_claims,
            plots=_depth_plots,
            full={"fields": 400},
            quick={"fields": 60},
            seconds=(35.0, 16.0),
        ),
        "growth": Topic(
            about="parts, CPU time and memory of a preset against K, side of the world and pixels",
            cases=preset_growth.cases,
            claims=preset_growth.claims,
            plots=preset_growth.plots,
            full={"fields": 12, "unseen": True},
            quick={"fields": 4, "unseen": False},
            seconds=(560.0, 160.0),
            accepts=("preset",),
        ),
    },
    notes=notes,
    caveats=(
        "An eye that looks all round; a field of view has predictions of its own (`lodbench "
        "count`).",
        "Hills of one shape, patches of one kind, haze of one visibility: they show where the "
        "flat-ground model breaks, and that the extended model does not.",
        "Counts; `growth` adds the time and memory before tracing, and what a whole frame costs is "
        "another experiment.",
        "Depth complexity is of people on flat ground, by level rays at the height of chests; "
        "every stick is a surface, and a level ray never meets the ground.",
    ),
    order=10,
)
