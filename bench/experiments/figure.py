"""How do the parts of a figure drop off with distance, do they shrink with depth, and what does
posing them cost? (§2.3, §3.3, §4)

The view is fixed: 640×360 pixels, 60° across, so m is τ·1.8 mrad. Distances run in even ratios from
the sphere that bounds the object in every pose, so that the eye is outside, to where its last part
goes. Each pose is looked at from distances of its own between one and the next, so that no count
depends on where the grid of distances lies.

Claims are stated alike for every kind of object. The paper makes the one about distance for its
human figure alone, and conjectures that the one about size holds for living things of our size
only: that an insect or a windmill refutes it would agree with the paper.
"""

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import asdict, dataclass
from functools import lru_cache, partial

import numpy as np
from jaxtyping import Bool, Float64, Int64

from bench.experiment import Case, Experiment, Table, Topic
from bench.plots import Curve as Drawn
from bench.plots import Panel, Plot, curves, figure
from bench.posing import posing_times
from bench.records.claims import EXACT, Claim, at_most, claim, four_decimals, within
from bench.records.provenance import scene_digest
from bench.records.records import Point, Record, columns, grouped, where
from bench.statistics.estimates import TWO_SIDED_TAILS, Estimate, exactly, two_sided_median
from lod.arrays import Ints, Reals
from lod.camera import Corner, camera_from_heading
from lod.errors import InputError
from lod.view import View
from scenes.figures.animal_file import animal, people_at_rest
from scenes.plugins import metric_by_name
from scenes.rig.rigged_prototype import RiggedPrototype

PERSON = "person"
EVERYTHING = (PERSON, "rabbit", "giraffe", "ostrich", "insect", "windmill")
"""The objects that are measured; their order gives their seeds, so new ones go to the end."""

METRICS = ("blake", "bounded", "solid_angle")

DETAIL_PX = 1.0
EXAGGERATED_PX = 16.0
"""τ of exaggerated detail [px]: the paper exaggerated its detail, and does not say how much."""

SIZE_PX, FOV_DEG = (640, 360), 60.0
POINTS_PER_JOINT = {"composing": 0, "composing_and_placing": 2}
"""The points that posing places on each joint: none, or both ends of a stick."""

COUNTED, SIZED, POSED = "parts against distance", "sizes", "posing"
UM_PER_M = 1e6

Distances = Float64[np.ndarray, "distances poses"]
Counts = Int64[np.ndarray, "distances poses"]
Chosen = Bool[np.ndarray, "distances poses"]


@dataclass(frozen=True)
class Curve:
    """The curve of parts against distance of one kind, metric and detail threshold τ [px]."""

    kind: str
    metric: str
    detail: float

    @property
    def view(self) -> View:
        """The view of the metric, which sees all round."""
        camera = camera_from_heading(Corner(0, 0), np.zeros(3), 0.0, 0.0, FOV_DEG, SIZE_PX)
        return View(camera, metric_by_name(self.metric), self.detail, look_around=True)

    @property
    def limits(self) -> Reals:
        """The clamped limit distance of every part, (n,) [m]."""
        return self.view.limits(object_of(self.kind).hierarchy)[0]

    @property
    def fits(self) -> float:
        """The distance from which the object fits into the picture, whatever its pose [m]."""
        return float(object_of(self.kind).hierarchy.B[0] / self.view.camera.tan_half[1])

    def distances(self, count: int) -> Reals:
        """Return distances of the eye from the object's origin, in even ratios, (count,) [m]."""
        near = object_of(self.kind).hierarchy.B[0]
        return np.geomspace(near, self.limits[0], count + 1)[:-1]


def cases(
    poses: int, distances: int, repeats: int, posed: int, metric: str | None = None
) -> list[Case]:
    """Return every curve, the sizes of all parts of every kind, and posing in two ways."""
    metrics = (*METRICS, *([metric] if metric else []))
    every = [Curve(kind, each, DETAIL_PX) for kind in EVERYTHING for each in metrics]
    every += [Curve(PERSON, each, EXAGGERATED_PX) for each in metrics]
    return [
        *(partial(measure_curve, curve, poses, distances) for curve in every),
        *(partial(_measure_sizes, kind) for kind in EVERYTHING),
        *(partial(_measure_posing, task, posed, repeats) for task in POINTS_PER_JOINT),
    ]


@lru_cache(maxsize=16)
def object_of(kind: str) -> RiggedPrototype:
    """Return the one object of a kind; the person is an adult."""
    return people_at_rest(0, 1, 0.0)[0] if kind == PERSON else animal(kind)


@lru_cache(maxsize=16)
def shapes_digest(kind: str) -> str:
    """Return the SHA-256 of the hierarchy and the joints of a kind."""
    thing = object_of(kind)
    names = ("parent", "level", "position", "P", "R", "B", "separation")
    arrays = [getattr(thing.hierarchy, name) for name in names] + [thing.joint]
    arrays += [getattr(thing.rig, name) for name in ("parent", "offset", "rest", "low", "high")]
    return scene_digest(kind, arrays)


def _measure_sizes(kind: str, seed: int) -> Point:
    tree = object_of(kind).hierarchy
    P_um = np.rint(tree.P * UM_PER_M).astype(np.int64).tolist()
    found = {"level": tree.level.tolist(), "whole": tree.parent.tolist(), "P_um": P_um}
    named = {"topic": "figure", "what": SIZED, "kind": kind}
    return Point(named, samples=columns(found), scene=shapes_digest(kind))


def _measure_posing(task: str, poses: int, repeats: int, seed: int) -> Point:
    rig, points = object_of(PERSON).rig, POINTS_PER_JOINT[task]
    apart, times = posing_times(rig, poses, points, repeats, seed)
    named = {"topic": "figure", "what": POSED, "task": task, "poses": poses, "joints": len(rig)}
    named |= {"points": len(rig) * points, "apart_m": apart}
    return Point(named, samples=columns(times), scene=shapes_digest(PERSON))


def measure_curve(curve: Curve, poses: int, distances: int, seed: int) -> list[Point]:
    """Count a curve in so many poses, a point a distance."""
    grid, scene = curve.distances(distances), shapes_digest(curve.kind)
    named = {"topic": "figure", "what": COUNTED, **asdict(curve)}
    named |= {"parts": len(object_of(curve.kind).hierarchy), "fits": curve.fits}
    counts = displayed_parts(curve, looked_from(grid, poses), seed)
    return [
        Point({**named, "distance": float(far)}, (), columns({"parts": row.tolist()}), scene)
        for far, row in zip(grid, counts, strict=True)
    ]


def looked_from(distances: Reals, poses: int) -> Distances:
    """Return where each pose is looked at from: a share of a step past each distance [m].

    The shares are multiples of the golden section, which fill a step evenly however many there are.
    """
    golden = (math.sqrt(5) - 1) / 2
    step = (distances[-1] / distances[0]) ** (1 / (len(distances) - 1))
    return distances[:, None] * step ** np.mod(golden * np.arange(poses), 1.0)


def displayed_parts(curve: Curve, distances: Distances, seed: int) -> Counts:
    """Count the parts nearer than their limit, at each distance in each pose.

    Poses are random within the joint limits, directions even over the sphere; every metric and
    detail of a kind has the same ones.
    """
    chance = np.random.SeedSequence((seed, EVERYTHING.index(curve.kind)))
    rng = np.random.Generator(np.random.Philox(chance))
    thing, poses = object_of(curve.kind), distances.shape[1]
    origin = thing.rig.frames(thing.rig.random_turns(rng, poses))[0][:, thing.joint]
    origin = origin - origin[:, :1]  # of its parts, from the origin of the whole object [m]
    directions = rng.normal(size=(poses, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    counts = []
    for far in distances:
        eye = directions * far[:, None]
        away = np.linalg.norm(eye[:, None] - origin, axis=-1)
        counts.append(np.count_nonzero(away < curve.limits, axis=1))
    return np.stack(counts)


# Points as curves, and their fits.


@dataclass(frozen=True, eq=False)
class Counted:
    """One curve as counted: counts (distances, poses) at distances (distances, poses) [m].

    parts  number of parts of the whole object
    fits   distance from which the object fits into the picture [m]
    """

    kind: str
    metric: str
    detail: float
    parts: int
    fits: float
    distances: Distances
    counts: Counts

    @property
    def between(self) -> Chosen:
        """Whether more than one part is displayed and not all, (distances, poses)."""
        return (self.counts > 1) & (self.counts < self.parts)

    def readings(self) -> dict[str, Chosen]:
        """Return readings of the claim about distance: the counts of each, by distances in words.

        The paper claims it of its person alone, "for those distances over which the figure was
        visible", which comes first. Others are where anything changes, and from where all of it is
        in the picture.
        """
        if self.kind != PERSON:
            return {"1 < parts < all": self.between}
        return {
            "visible": self.counts > 0,
            "1 < parts < all": self.between,
            "all in the picture": (self.counts > 0) & (self.distances >= self.fits),
        }

    def condition(self, reading: str) -> dict[str, str]:
        """Return the condition of the claim about distance, in one reading."""
        told = {"metric": self.metric, "object": self.kind, "distances": reading}
        return told | ({"τ": f"{self.detail:g} px"} if self.detail == EXAGGERATED_PX else {})


def counted(points: Iterable[Point]) -> list[Counted]:
    """Return the curves of a record, in the order they come."""
    found = grouped(where(points, what=COUNTED), "kind", "metric", "detail")
    made = []
    for (kind, metric, detail), rows in found.items():
        grid = np.array([row.case["distance"] for row in rows])
        distances = looked_from(grid, len(rows[0].column("parts")))
        counts = np.array([row.column("parts") for row in rows], np.int64)
        parts, fits = rows[0].case["parts"], rows[0].case["fits"]
        made.append(Counted(kind, metric, detail, parts, fits, distances, counts))
    return made


def sized(points: Iterable[Point]) -> dict[str, dict[str, np.ndarray]]:
    """Return level, whole and P [µm] of every part, by kind."""
    return {
        point.case["kind"]: {e.quantity: np.array(e.values, np.int64) for e in point.samples}
        for point in where(points, what=SIZED)
    }


RESAMPLES = 2000
"""Bootstrap samples of an interval (Efron & Tibshirani, "An Introduction to the Bootstrap", 1993,
ch. 13: percentiles). Exponents resample whole poses, since the counts of one pose at its distances
depend on each other; correlations resample groups of like parts, since a left arm repeats the right
one. Intervals say what other poses would have given; whether counts are a straight line on
logarithmic axes at all is seen by ``halves``."""

Weights = Float64[np.ndarray, "resamples parts"]


def exponent(
    counts: Counts, distances: Distances, chosen: Chosen, rng: np.random.Generator
) -> Estimate:
    """Estimate b of count ∝ distance^b: least squares of logarithms over chosen counts.

    Raises InputError unless every bootstrap sample has counts at 2 or more distances.
    """
    sums = _sums(counts, distances, chosen)
    drawn = _slopes(_resampled(counts.shape[1], rng) @ sums)
    if not np.isfinite(drawn).all():
        raise InputError("exponent", int(chosen.sum()), "counts at 2 or more distances a sample")
    return _estimate(float(_slopes(sums.sum(axis=0))), drawn, counts.shape[1])


def halves(counts: Counts, distances: Distances, chosen: Chosen) -> tuple[float, float]:
    """Return the exponents of the nearer and of the farther half of the chosen range, in ratio."""
    rows = np.flatnonzero(chosen.any(axis=1))
    middle = np.sqrt(distances[rows[0]].min() * distances[rows[-1]].max())
    near = distances <= middle
    fits = (_sums(counts, distances, chosen & half).sum(axis=0) for half in (near, ~near))
    nearer, farther = (float(_slopes(each)) for each in fits)
    return nearer, farther


LAWS = {"a·d^b": np.log, "a − b√d": np.sqrt, "a − b·ln d": np.log}
"""Laws of counts against distance by name, and what of the distance each is a straight line in."""


def fitted_laws(curve: Counted, chosen: Chosen) -> dict[str, tuple[float, list[float]]]:
    """Fit each law to chosen counts: its R² as a law of counts, and its mean count at distances.

    The power law is fitted to logarithms, as ``exponent`` is; the others to counts. Each R² is 1 −
    the sum of squares of counts about the law ÷ that about their mean. Distances are the means of
    the grid's (``_against_distance``).
    """
    far, counts = curve.distances[chosen], curve.counts[chosen].astype(np.float64)
    at = np.exp(np.log(curve.distances).mean(axis=1))
    made: dict[str, tuple[float, list[float]]] = {}
    for name, of in LAWS.items():
        power = name == next(iter(LAWS))
        b, a = np.polyfit(of(far), np.log(counts) if power else counts, 1)
        told, drawn = (a + b * of(x) for x in (far, at))
        told, drawn = (np.exp(told), np.exp(drawn)) if power else (told, drawn)
        left = np.square(counts - told).sum() / np.square(counts - counts.mean()).sum()
        made[name] = 1 - float(left), drawn.tolist()
    return made


def rank_correlation(level: Ints, size: Ints, alike: Ints, rng: np.random.Generator) -> Estimate:
    """Estimate Spearman's ρ of size with level; parts ``alike`` are drawn together.

    ``alike`` (n,) numbers the group of each part, from 0.
    """
    weight = _resampled(int(alike.max()) + 1, rng)[:, alike]
    drawn = _spearman(level, size, weight)
    value = float(_spearman(level, size, np.ones((1, len(level))))[0])
    # a sample in which all levels or all sizes are one says nothing
    return _estimate(value, drawn[np.isfinite(drawn)], len(level))


def _sums(counts: Counts, distances: Distances, chosen: Chosen) -> Float64[np.ndarray, "poses 5"]:
    """Return the sums of 1, x, y, x² and x·y over each pose's chosen counts, in logarithms."""
    x = np.where(chosen, np.log(distances), 0.0)
    y = np.log(np.where(chosen, counts, 1))
    return np.stack([term.sum(axis=0) for term in (1.0 * chosen, x, y, x * x, x * y)], axis=1)


def _slopes(sums: Float64[np.ndarray, "... 5"]) -> Float64[np.ndarray, "..."]:
    n, x, y, xx, xy = np.moveaxis(sums, -1, 0)
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.asarray((n * xy - x * y) / (n * xx - x * x))


def _resampled(n: int, rng: np.random.Generator) -> Float64[np.ndarray, "resamples n"]:
    """Draw how often each of n poses is in each bootstrap sample."""
    return rng.multinomial(n, np.full(n, 1 / n), size=RESAMPLES).astype(np.float64)


def _spearman(level: Ints, size: Ints, weight: Weights) -> Float64[np.ndarray, " resamples"]:
    """Return the correlation of ranks in samples that hold each part ``weight`` times."""
    a, b = (
        weight @ (values[:, None] < values) + (weight @ (values[:, None] == values)) / 2
        for values in (level, size)
    )
    total = weight.sum(axis=1, keepdims=True)
    a, b = (ranks - (weight * ranks).sum(axis=1, keepdims=True) / total for ranks in (a, b))
    with np.errstate(invalid="ignore"):
        both = np.sqrt((weight * a * a).sum(axis=1) * (weight * b * b).sum(axis=1))
        return np.asarray((weight * a * b).sum(axis=1) / both)


def _estimate(value: float, drawn: Reals, rows: int) -> Estimate:
    share = TWO_SIDED_TAILS[0]
    low, high = (float(v) for v in np.quantile(drawn, (share, 1 - share)))
    # scale is of models that assume a variance; a bootstrap assumes none
    return Estimate(value, min(low, value), max(high, value), float(drawn.std()), 1.0, rows)


# Claims.

SQUARE_ROOT, NEARLY = -0.5, 0.1
FEW = 0.05
"""The share of parts that may be no smaller than their whole, for "generally smaller"."""


def claims(points: Sequence[Point]) -> Iterator[Claim]:
    """Return every claim that these points decide."""
    rng = np.random.Generator(np.random.Philox(np.random.SeedSequence((0, 0xB007))))
    for curve in counted(points):
        for reading, chosen in curve.readings().items():
            first = (curve.kind, curve.metric, curve.detail) == (PERSON, "blake", DETAIL_PX)
            yield claim(
                "exponent of parts displayed against distance",
                within(SQUARE_ROOT, NEARLY),
                curve.condition(reading),
                exponent(curve.counts, curve.distances, chosen, rng),
                unit="pose",
                source="§4",
                headline=first and reading in ("visible", "1 < parts < all"),
            )
    for kind, table in sized(points).items():
        level, whole, size = table["level"], table["whole"], table["P_um"]
        # parts of one level and one size, in wholes of one size, are alike
        keys = np.stack((level, size, size[whole]), axis=1)
        alike = np.unique(keys, axis=0, return_inverse=True)[1].ravel()
        found = rank_correlation(level, size, alike, rng)
        of, shrinks = {"object": kind}, partial(claim, source="§2.3")
        name = "rank correlation of P with level"
        yield shrinks(name, at_most(0), of, found, unit="group of like parts")
        name = "share of parts no smaller than their whole"
        share = exactly(no_smaller(whole, size), len(whole) - 1)
        yield shrinks(name, at_most(FEW), of, share, unit=EXACT)
    for point in where(points, what=POSED):
        ratios = point.values("quaternions_ns") / point.values("matrices_ns")
        told = {"object": PERSON, "task": point.case["task"].replace("_", " ")}
        name, found = "processor time, quaternions ÷ matrices", two_sided_median(ratios)
        yield claim(name, at_most(1), told, found, unit="repeat", source="§3.3")


def no_smaller(whole: np.ndarray, size: np.ndarray) -> float:
    """Return the share of the parts that are no smaller than the whole that owns them."""
    return float(np.mean(size[1:] >= size[whole[1:]]))


# Plots and tables.


def plots(record: Record) -> tuple[Plot, ...]:
    """Draw parts and their local exponent against distance, by metric and kind; then sizes."""
    found = [curve for curve in counted(record.points) if curve.detail == DETAIL_PX]
    groups = {
        f"{PERSON}, by metric": {c.metric: c for c in found if c.kind == PERSON},
        "Kinds of object, by blake": {c.kind: c for c in found if c.metric == METRICS[0]},
    }
    panels = []
    for title, group in groups.items():
        title = title[:1].upper() + title[1:]
        counts = [_against_distance(label, curve) for label, curve in group.items()]
        panels += [Panel(title, (_FAR, "parts displayed, 5 to 95 % of poses"), counts)]
        slopes = [Drawn(label, *local_exponents(curve)) for label, curve in group.items()]
        axis = _FAR, "local exponent of parts against distance"
        drawn = [each for each in slopes if each.x]
        panels += [Panel(title, axis, drawn, ("log", "linear"), between=CLAIMED)]
    panels += [_laws_panel(each) for each in groups[f"{PERSON}, by metric"].values()]
    first = groups[f"{PERSON}, by metric"][METRICS[0]]
    exponents = local_exponents(first)[1]
    title = f"Parts of a {PERSON} that are displayed, against distance"
    if exponents:
        power = _claim_of(record, first, next(iter(first.readings()))).measured
        title = (
            f"Parts of a {PERSON} follow no one power of distance: the exponent goes from "
            f"{_signed(exponents[0])} to {_signed(min(exponents))}, one line through all gives "
            f"{_signed(power)}"
        )
    caption = (
        f"Means over {first.counts.shape[1]} random poses and directions, τ = {DETAIL_PX:g} px. "
        f"The local exponent is the slope of logarithms within a factor {_REACH:g} of the distance "
        "to either side, where more than one part is displayed and not all. Shaded: the paper's "
        "square root, −0.5 ± 0.1. Last: three laws over the distances at which the person is "
        "visible, with R² of counts in their order. Every species × metric stands in the table of "
        "exponents."
    )
    return figure("parts", title, caption, panels), _sizes_plot(record)


def _laws_panel(curve: Counted) -> Panel:
    """Draw what three laws make of one curve."""
    each, chosen = _against_distance(curve.metric, curve), next(iter(curve.readings().values()))
    at = np.exp(np.log(curve.distances).mean(axis=1)).tolist()
    laws = fitted_laws(curve, chosen)
    drawn = [each]
    for name, (_, fit) in laws.items():
        line = [(x, y) for x, y in zip(at, fit, strict=True) if y > 0.5]
        drawn.append(Drawn(name, [], [], line=([x for x, _ in line], [y for _, y in line])))
    told = ", ".join(_signed(r2) for r2, _ in laws.values())
    return Panel(f"{curve.metric}: R² {told}", (_FAR, "parts displayed"), drawn)


_FAR = "distance of the eye (m)"
_REACH = 1.5
CLAIMED = SQUARE_ROOT - NEARLY, SQUARE_ROOT + NEARLY


def _signed(value: float) -> str:
    return f"{value:.2f}".replace("-", "−")


def _against_distance(label: str, curve: Counted) -> Drawn:
    x, y = np.exp(np.log(curve.distances).mean(axis=1)), curve.counts.mean(axis=1)
    low, high = np.percentile(curve.counts, (5, 95), axis=1)
    seen = y > 0
    return Drawn(label, *(row[seen].tolist() for row in (x, y, np.maximum(low, 0.5), high)))


def local_exponents(curve: Counted) -> tuple[list[float], list[float]]:
    """Return distances [m], and the slope there of log mean count against log distance.

    Slopes are of lines by least squares through all distances within a factor of 1.5, 3 or more.
    """
    x, y = np.log(curve.distances).mean(axis=1), curve.counts.mean(axis=1)
    here = (y > 1) & (y < curve.parts)
    x, y = x[here], np.log(y[here])
    near = [np.abs(x - at) <= math.log(_REACH) for at in x]
    rows = [k for k, each in enumerate(near) if each.sum() >= 3]
    return np.exp(x[rows]).tolist(), [float(np.polyfit(x[near[k]], y[near[k]], 1)[0]) for k in rows]


def tables(record: Record) -> tuple[tuple[str, Table], ...]:
    """Return a table of every fitted exponent, with those of its nearer and farther half."""
    heads = (
        *("object", "metric", "detail (px)", "distances", "from (m)", "to (m)"),
        *("exponent (95 %)", "nearer half", "farther half"),
        *(f"R² of {name}" for name in LAWS),
    )
    rows = []
    for curve in counted(record.points):
        for reading, chosen in curve.readings().items():
            far = curve.distances[chosen]
            both = halves(curve.counts, curve.distances, chosen)
            rows.append(
                (
                    *(curve.kind, curve.metric, f"{curve.detail:g}", reading),
                    *(f"{far.min():.4g}", f"{far.max():.4g}"),
                    _claim_of(record, curve, reading).measured_text,
                    *(four_decimals(v) for v in both),
                    *(_signed(r2) for r2, _ in fitted_laws(curve, chosen).values()),
                )
            )
    return (("Exponents of parts displayed against distance", (heads, rows)),)


def _claim_of(record: Record, curve: Counted, reading: str) -> Claim:
    return next(c for c in record.claims if c.condition == curve.condition(reading))


def _sizes_plot(record: Record) -> Plot:
    drawn, told = [], {}
    for kind, sizes in sized(record.points).items():
        levels = range(int(sizes["level"].max()) + 1)
        P = [float(np.median(sizes["P_um"][sizes["level"] == n])) for n in levels]
        drawn.append(Drawn(kind, list(map(float, levels)), [each / P[0] for each in P]))
        told[kind] = 100 * no_smaller(sizes["whole"], sizes["P_um"])
    words = ", ".join(f"{kind} {share:.0f} %" for kind, share in told.items())
    least, most = min(told.values()), max(told.values())
    title = f"Between {least:.0f} and {most:.0f} % of parts are no smaller than their whole"
    caption = (
        "Median P of the parts of a level, as a share of the whole object's. The paper conjectures "
        f"that parts shrink with depth for living things of our size only. No smaller: {words}."
    )
    axis = "level", "median P ÷ P of the whole object"
    return curves("sizes", title, caption, axis, drawn, ("linear", "log"))


EXPERIMENT = Experiment(
    name="figure",
    question="Do the parts of a figure drop off with the square root of its distance?",
    version=2,
    topics={
        "figure": Topic(
            about="parts of one object against distance and level, and what posing it costs",
            cases=cases,
            claims=claims,
            plots=plots,
            tables=tables,
            accepts=("metric",),
            full={"poses": 200, "distances": 60, "repeats": 101, "posed": 4000},
            quick={"poses": 40, "distances": 30, "repeats": 21, "posed": 1000},
            seconds=(10.0, 5.0),
        )
    },
    caveats=(
        "One person and one of each kind, as tables made them: intervals are over poses, "
        "directions and places in the grid of distances, not over other people or animals.",
        "An exponent is that of the straight line nearest to a curve which is not straight: "
        "its nearer and farther halves stand in a table.",
        "Times are those of one machine, its compiler and these two kernels; they say which "
        "is cheaper here.",
    ),
    order=20,
)
