"""What do a frame's time and memory come to by other methods of simplification, at the same error?

Errors are those of ``images``: excess FLIP over pairs of sampler seeds. The settings next to the
one of equal error are timed, all methods taking turns, frame by frame, in an order drawn again for
each frame, since who follows a large scene finds other memory: each stage by the clock, and all of
a frame by the processor. While one method is timed no scene of another exists: its shapes would
be in the code that is compiled, and garbage would be looked for. Memory is the most that a fresh
process holds that makes one frame.

An unpruned world that is estimated to need more memory than there is has no picture, and so its
window has no errors; the other methods are timed as they are.

Each method also walks through one window at its setting nearest to equal error. Every frame has the
same seed as the unpruned world's, so that noise is the same where the same is displayed. ``flip``
is the difference of a frame; ``residual`` is what changes from frame to frame beside what the
reference changes: the mean over pixels and colours of |ΔT − ΔW|, of pictures as they are displayed.
Where ColorVideoVDP is here, it judges the sequences too.
"""

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from functools import partial
from typing import Any

import numpy as np

from bench.children import run_in_child
from bench.experiment import Case, Experiment, Table, Topic
from bench.frame_costs import Picture
from bench.images.differences import (
    BAND_EDGES_M,
    Reference,
    mean_flip,
    pair_band_name,
    picture_errors,
    reference_of,
)
from bench.images.equal_error import EQUAL_ERROR
from bench.methods.comparison import (
    AtEqualError,
    at_equal_error,
    beside_best_baseline,
    excess,
    frame_seconds,
    is_measured,
    judged_error,
    megabytes,
    optional,
)
from bench.methods.cycles import measure_cycles, noise
from bench.methods.environments import CYCLES, VIDEO
from bench.methods.known_methods import CLIPPED, methods
from bench.methods.method import Method
from bench.methods.runner import STAGES, Runner, Window, make_one_frame
from bench.methods.video import just_objectionable_differences
from bench.plots import Curve, Panel, Plot, figure, number_text
from bench.records.claims import EXACT, Claim, at_most, claim
from bench.records.records import Column, Point, Record, grouped, where
from bench.statistics.estimates import two_sided_factor
from scenes.frame.layers import SKY_Z, Layers
from scenes.processes.memory_limit import memory_limit
from scenes.render.memory import forecast, frame_bytes
from scenes.render.pictures import auto_exposure, to_srgb
from scenes.render.variants import choose
from scenes.scene import Scene, frame_quality

TIMED = 3
"""Settings of each method that are timed: those next to equal error."""

MOST_BYTES = 18_000_000_000
"""What a method may need at most, on a machine that has as much."""

JUDGED = "blake", "clipped", "discrete", "stochastic"
"""The methods whose sequences ColorVideoVDP judges."""

LEFT_OUT = "bounded", "solid_angle", "depth"
"""Methods that do not walk: readings of the metric that move as ``blake`` does."""

LEVEL = 1.0 - 1e-4
"""A normal that points up by this or more is level ground's."""

_KEPT_STICK = 200
"""Bytes that a stick takes here beside what is estimated for ``render``: in unpruned woods and
crowds of 6 to 31 M sticks 140 to 195. Some of it ``render`` frees before it builds, and some its
model leaves out."""

_KINDS = "crowd", "meadow", "swaying", "forest", "swaying forest"
_BASELINES = "blake", "full", "distance", "in_view", "discrete", "stochastic"
_FEW = "blake", "full", "in_view", "discrete"


def _each(
    kinds: Sequence[str], sizes: Sequence[float], fields: int, few: Sequence[str] = ()
) -> list[list[Any]]:
    """List kinds and sizes of worlds, the number of fields, and the methods; none = all."""
    return [[kind, objects, fields, list(few)] for objects in sizes for kind in kinds]


def cases(
    worlds: Sequence[tuple[str, float, int, Sequence[str]]],
    walk: tuple[str, float, str, int],
    cycles: Sequence[Sequence[object]],
    size: str,
    spp: int,
    **common: int,
) -> list[Case]:
    """Return every field of every world, the walk, and what Cycles renders if it is here."""
    variant = choose()
    windows = [
        Window(
            kind, objects, field, Picture(size, spp), variant=variant, tried=tuple(few), **common
        )
        for kind, objects, fields, few in worlds
        for field in range(fields)
    ]
    kind, objects, walk_size, frames = walk
    window = Window(kind, objects, 0, Picture(walk_size, spp), 2, 1, variant)
    others = [w for w in windows if [w.kind, w.objects] in cycles and CYCLES.python()]
    return [
        *(partial(measure_window, each) for each in windows),
        partial(measure_walk, window, frames),
        *(partial(measure_cycles, each) for each in others),
    ]


def measure_window(case: Window, seed: int) -> list[Point]:
    """Measure every method in one window: errors, then times in turns, then memory."""
    scene = case.scene(seed)
    where = {"kind": case.kind, "objects": case.objects, "field": case.field}
    tried: dict[str, list[Runner]] = {}
    too_large = []
    most = min(MOST_BYTES, memory_limit().bytes or MOST_BYTES)
    for name, method in methods().items():
        for setting in method.settings if name in (case.tried or methods()) else ():
            needed = estimated_bytes(method, setting, scene, case.variant)
            if needed <= most:
                tried.setdefault(name, []).append(Runner(method, setting, scene))
            else:
                named = {"topic": "rivals", **where, "arm": name, "setting": setting}
                too_large.append(Point(named, samples=(Column("foretold_bytes", [needed]),)))
    if "full" in tried:
        tried["full"][0].frame(1, case.variant)
        rendered = [tried["full"][0].picture(seed) for seed in range(2 * case.pairs)]
        reference, pictures = reference_of(rendered[0::2], rendered[1::2]), rendered[0::2]
        for runner in (each for row in tried.values() for each in row):
            _measure_error(runner, reference, pictures, case)
    timed = {name: next_to_equal_error(row) for name, row in tried.items()}
    turns = [each for row in timed.values() for each in row]
    for frame in range(2, case.repeats + 2):
        for k in np.random.default_rng((case.field, frame)).permutation(len(turns)):
            turns[k].timed_frame(frame, case.variant)
            turns[k].forget()
    for runner in (each for row in timed.values() for each in row[: case.weighed]):
        runner.columns.append(Column("peak_bytes", [peak_bytes(runner, case, seed)]))
    return [each.point(**where) for row in tried.values() for each in row] + too_large


def estimated_bytes(method: Method, setting: float, scene: Scene, variant: str) -> int:
    """Estimate the memory of the first frame of a method [bytes]; 0 where it is never much."""
    if method.widest is None:
        return 0
    view = scene.view(1)
    copies = frame_quality(scene.preset, variant).draws_copies
    found = forecast(scene.world, view, method.widest(view, setting), copies)
    return frame_bytes(found, scene.preset, variant) + round(_KEPT_STICK * found.sticks)


def _measure_error(runner: Runner, reference: Reference, same: list[Layers], case: Window) -> None:
    """Render the first frame with one seed of every pair, and compare it with the reference."""
    if runner.built is None:
        runner.frame(1, case.variant)
    layers = [runner.picture(seed) for seed in range(0, 2 * case.pairs, 2)]
    tested = [each.rgb.astype(np.float64) for each in layers]
    runner.columns += picture_errors(tested, reference)
    runner.columns += covered(layers, same)
    runner.columns.append(Column("noise", noise(tested, case.picture.spp)))
    runner.error = judged_error(runner.point())
    runner.forget()


def covered(tested: Sequence[Layers], reference: Sequence[Layers]) -> list[Column]:
    """Count the pixels that things cover in every picture, by bands of what they show.

    A pixel counts where its first sample meets something that is not level ground, whose normal
    is straight up; a stick's is so with probability 0. Pictures of one seed have the same samples.
    """
    made = []
    for low, high in zip(BAND_EDGES_M, (*BAND_EDGES_M[1:], float(SKY_Z)), strict=True):
        for which, row in (("tested", tested), ("reference", reference)):
            things = [(each.Z >= low) & (each.Z < high) & (each.N[..., 2] < LEVEL) for each in row]
            counts = [int(np.count_nonzero(each)) for each in things]
            made.append(Column("covered", counts, {"picture": which, "band": pair_band_name(low)}))
    return made


def next_to_equal_error(row: Sequence[Runner]) -> list[Runner]:
    """Return the settings of a method whose error is next to equal error.

    The last setting within the error and the first beyond it come first, because time at equal
    error is read between them. Without errors, those in the middle come first.
    """

    def away(runner: Runner) -> float:
        if math.isnan(runner.error):
            return abs(row.index(runner) - (len(row) - 1) / 2)
        return abs(math.log(max(runner.error, 1e-6) / EQUAL_ERROR))

    beyond = next((k for k, each in enumerate(row) if not each.error <= EQUAL_ERROR), len(row))
    between = [row[k] for k in (beyond - 1, beyond) if 0 <= k < len(row)]
    first = [] if math.isnan(row[0].error) else between
    others = sorted((each for each in row if each not in first), key=away)
    return [*first, *others][:TIMED]


def peak_bytes(runner: Runner, case: Window, seed: int) -> int:
    """Return the most that a fresh process holds while it makes one frame [bytes]."""
    words = case, seed, runner.method.name, runner.setting
    return run_in_child(make_one_frame, *words, variant=case.variant).peak_bytes


def measure_walk(window: Window, frames: int, seed: int) -> list[Point]:
    """Measure every method over one sequence of frames, in which motion is looked at."""
    scene = window.scene(seed)
    found = {name: method for name, method in methods().items() if name not in LEFT_OUT}
    unpruned = _frames(Runner(found.pop("full"), 0.0, scene), window, frames)
    exposure = auto_exposure(unpruned[0])

    def displayed(pictures: Sequence[np.ndarray]) -> np.ndarray:
        shown = [to_srgb(each.astype(np.float64), exposure) for each in pictures]
        return np.stack(shown).astype("f4")

    def away(setting: float) -> float:
        """Tell how far the first frame is from equal error, in logarithms; noise is the same."""
        first = displayed(_frames(Runner(method, setting, scene), window, 1))
        return abs(math.log(max(mean_flip(first[0], reference[0]), 1e-6) / EQUAL_ERROR))

    reference = displayed(unpruned)
    walked, judged = [], dict[str, np.ndarray]()
    for method in (*found.values(), CLIPPED):
        runner = Runner(method, min(method.settings, key=away), scene)
        tested = displayed(_frames(runner, window, frames))
        runner.columns += changes(tested, reference)
        walked.append(runner)
        if method.name in JUDGED:
            judged[method.name] = tested
    if VIDEO.python():
        jod = just_objectionable_differences(judged, reference, float(scene.preset.camera.fps))
        for runner in walked:
            if runner.method.name in jod:
                runner.columns.append(Column("jod", [round(1e6 * jod[runner.method.name][0])]))
    return [each.point(part="walk", kind=window.kind, objects=window.objects) for each in walked]


def _frames(runner: Runner, window: Window, frames: int) -> list[np.ndarray]:
    found = []
    for number in range(1, frames + 1):
        runner.frame(number, window.variant)
        found.append(runner.picture(0).rgb)
    runner.forget()
    return found


def changes(tested: np.ndarray, reference: np.ndarray) -> tuple[Column, Column]:
    """Compare two displayed sequences, (n, h, w, 3): FLIP of frames, and residuals of steps."""
    flip = [round(1e6 * mean_flip(*pair)) for pair in zip(tested, reference, strict=True)]
    left = np.abs(np.diff(tested, axis=0) - np.diff(reference, axis=0)).mean(axis=(1, 2, 3))
    return Column("flip", flip), Column("residual", [round(1e6 * float(each)) for each in left])


# Claims, from raw errors, times and bytes alone.

HEADLINES = ("crowd", 1e5, "time"), ("forest", 1e4, "memory")


def claims(points: Sequence[Point]) -> Iterator[Claim]:
    """Claim, for every kind and size of world, that the metric's frame costs no more than others'.

    It is compared with the baseline that needs least; fields are the replicates.
    """
    made = partial(claim, unit="field", source="§4.1, derived: docs/method.md", alone=EXACT)
    for (kind, objects), window in grouped(points, "kind", "objects").items():
        found = at_equal_error(window)
        for cost, (quantity, _, _) in COSTS.items():
            best = beside_best_baseline(found, quantity)
            if best is not None and len(best[1]) > 1:
                of = {"kind": kind, "objects": objects, "baseline": best[0]}
                estimand = f"{cost} of a frame at equal error, blake ÷ best baseline"
                shown = (kind, objects, cost) in HEADLINES
                yield made(estimand, at_most(1), of, two_sided_factor(best[1]), headline=shown)


# Plots and tables.


COSTS: dict[str, tuple[str, Callable[[Point], float], str]] = {
    "time": ("seconds", frame_seconds, "seconds of a frame, all stages"),
    "memory": ("megabytes", megabytes, "most that a process holds (MB)"),
}
"""What is compared: its name at equal error, that of a point, and an axis."""


def plots(record: Record) -> Iterator[Plot]:
    """Draw the error of every method against time and memory, in the largest world of each kind.

    That is the largest that has a reference; the moving kinds are in the tables.
    """
    windows = grouped(filter(is_measured, record.points), "kind", "objects")
    largest = {
        kind: max(n for k, n in windows if k == kind)
        for kind, _ in windows
        if "swaying" not in kind or all("swaying" in k for k, _ in windows)
    }
    panels, told = [], []
    for kind, objects in largest.items():
        points = windows[kind, objects]
        for cost, (_, of_point, axis) in COSTS.items():
            drawn = [
                curve
                for (method,), mine in grouped(points, "arm").items()
                for curve in _cost_curve(method, mine, of_point)
            ]
            title = f"{kind}, {number_text(objects)} objects: {cost}"
            panels.append(Panel(title, (axis, "excess FLIP, whole picture"), drawn))
        best = beside_best_baseline(at_equal_error(points), "seconds")
        if best is not None:
            ratios = best[1]
            spread = f"{two_sided_factor(ratios):.2f}" if len(ratios) > 1 else f"{ratios[0]:.2f}"
            told.append(f"{kind} {spread} of {best[0]}'s")
    title = "Error against the seconds and the memory of a frame, by method"
    if told:
        title = f"At equal error blake takes, of the best baseline's time: {'; '.join(told)}"
    caption = (
        "Means over fields with the range of the fields, settings next to equal error; nearer to "
        "the lower left is better. Errors below 0.0001 are drawn there. `blake` coarsens what is "
        "off screen, which the baselines do not. What equal error is, and every other world, is in "
        "the tables."
    )
    if any(panel.drawn for panel in panels):
        yield figure("methods", title, caption, panels)


def _cost_curve(
    method: str, points: Sequence[Point], of_point: Callable[[Point], float]
) -> Iterator[Curve]:
    """Yield the error of a method by cost, the mean over fields and from least to most."""
    rows = []
    for (_,), mine in grouped(points, "setting").items():
        cost = float(np.mean([of_point(p) for p in mine]))
        flips = np.maximum([excess(p) for p in mine], _LEAST)  # noise: some are below 0
        if math.isfinite(cost):
            rows.append((cost, float(flips.mean()), float(flips.min()), float(flips.max())))
    if rows:
        x, y, low, high = (list(row) for row in zip(*sorted(rows), strict=True))
        yield Curve(method, x, y, low, high)


_LEAST = 1e-4


def _summary_table(record: Record) -> Table:
    """Show what the metric and the reference take in every world, and who is ahead.

    The metric's time and memory are divided by those of the baseline that needs least of them at
    equal error: above 1 that baseline is ahead.
    """
    heads = "world", "blake [s; MB]", "unpruned [s; MB]"
    rows: list[tuple[str, ...]] = []
    for world, points in _worlds(record):
        found = at_equal_error(points)
        costs = ["; ".join(_cost(found, points, method)) for method in ("blake", "full")]
        for quantity, _, _ in COSTS.values():
            best = beside_best_baseline(found, quantity)
            costs.append(f"{best[0]}: {_ahead(best[1])}" if best else "not compared")
        rows.append((world, *costs))
    return (*heads, *(f"{cost}, blake ÷ the best baseline (95 %)" for cost in COSTS)), rows


def tables(record: Record) -> tuple[tuple[str, Table], ...]:
    """Return titled tables of who is ahead, methods, stages, the walk, and Cycles."""
    return (
        ("The metric beside the unpruned reference and the best baseline", _summary_table(record)),
        ("Each method at equal error", _methods_table(record)),
        ("What pruning helps, and what it does not", _stage_table(record)),
        ("A walk: motion beside the reference's", _walk_table(record)),
        ("The same cut in Cycles", _cycles_table(record)),
    )


def _worlds(record: Record) -> list[tuple[str, list[Point]]]:
    here = [point for point in record.points if "part" not in point.case]
    return [(f"{kind}, {n:g}", row) for (kind, n), row in grouped(here, "kind", "objects").items()]


def _methods_table(record: Record) -> Table:
    rows: list[tuple[str, ...]] = []
    for world, points in _worlds(record):
        found = at_equal_error(points)
        rows += [(world, m, *_cost(found, points, m)) for (m,) in grouped(points, "arm")]
    return ("world", "method", "seconds at equal error", "MB"), rows


def _cost(
    found: dict[str, list[AtEqualError]], points: Sequence[Point], method: str
) -> tuple[str, str]:
    if fields := found.get(method):
        reached = all(each.reached for each in fields)
        seconds = f"{np.mean([e.seconds for e in fields]):.2f}" if reached else "never reached"
        return seconds, f"{np.mean([each.megabytes for each in fields]):.0f}"
    row = where(points, arm=method)
    needed = [1e6 * optional(p, "foretold_bytes")[0] for p in row]
    if np.isfinite(needed).any():
        return "does not fit", f"{np.nanmax(needed) / 1e6:,.0f} estimated"
    timed = [p for p in row if math.isfinite(frame_seconds(p))]
    told = ", ".join(
        f"{np.mean([frame_seconds(p) for p in mine]):.2f} at {setting:g}"
        for (setting,), mine in grouped(timed, "setting").items()
    )
    return f"no reference; {told}", _mean([megabytes(p) for p in timed], ".0f")


def _ahead(ratios: np.ndarray) -> str:
    """Tell a mean ratio with its interval, and who is ahead where that is decided."""
    if len(ratios) < 2:
        return f"{ratios[0]:.3g}"
    found = two_sided_factor(ratios)
    ahead = (
        "blake ahead" if found.high < 1 else "baseline ahead" if found.low > 1 else "inconclusive"
    )
    return f"{found:.3g}, {ahead}"


def _stage_table(record: Record) -> Table:
    heads = "world", "stage", "blake (s)", "unpruned (s)", "blake ÷ unpruned (95 %)"
    stages: dict[str, tuple[Callable[[Point], float], str]] = {
        **{name: (partial(_stage, stage=name), ".3f") for name in ("prepare", *STAGES, "cpu")},
        "MB": (megabytes, ".0f"),
        "variance of a sample": (lambda p: float(optional(p, "noise").mean()), ".4f"),
    }
    rows: list[tuple[str, ...]] = []
    for world, points in _worlds(record):
        blake, full = _nearest(points, "blake"), _nearest(points, "full")
        if not full or len(blake) != len(full):
            continue
        for name, (of_point, form) in stages.items():
            mine, reference = (np.array([of_point(p) for p in row]) for row in (blake, full))
            ratio = ""
            if len(mine) > 1 and min(*mine, *reference) > 0:
                ratio = f"{two_sided_factor(mine / reference):.3g}"
            means = (format(row.mean(), form) for row in (mine, reference))
            rows.append((world, name, *means, ratio))
    return heads, rows


def _walk_table(record: Record) -> Table:
    heads = "world", "method", "setting", "FLIP", "residual of a step (1e-3)", "JOD of 10"
    rows: list[tuple[str, ...]] = []
    for point in where(record.points, part="walk"):
        case = point.case
        jod = _mean(optional(point, "jod"), ".2f") or "not measured here"
        rows.append(
            (
                *(f"{case['kind']}, {case['objects']:g}", str(case["arm"])),
                f"{case['setting']:g}",
                _mean(optional(point, "flip"), ".4f"),
                _mean(1e3 * optional(point, "residual"), ".2f"),
                jod if case["arm"] in JUDGED else "",
            )
        )
    return heads, rows


def _cycles_table(record: Record) -> Table:
    stages = "describe", "synchronise", "build", "trace"
    plain = "world", "frame", "renderer", "excess FLIP", "variance", "light", "MB"
    heads = (*plain, *(f"{stage} (s)" for stage in stages))
    points = where(record.points, part="cycles")
    names = "kind", "objects", "arm", "setting", "renderer"
    rows: list[tuple[str, ...]] = [
        (
            f"{kind}, {n:g}",
            "unpruned" if method == "full" else f"{method}, {setting:g} px",
            str(renderer),
            _mean(((optional(p, "flip") - optional(p, "flip_floor")).mean() for p in row), ".4f"),
            *(_mean((optional(p, q).mean() for p in row), ".4f") for q in ("noise", "light")),
            _mean(map(megabytes, row), ".0f"),
            *(_mean((_stage(p, stage) for p in row), ".3f") for stage in stages),
        )
        for (kind, n, method, setting, renderer), row in grouped(points, *names).items()
    ]
    return heads, rows or [("all", "not measured here", "cycles", *[""] * (len(heads) - 3))]


def _mean(values: Iterable[float], form: str) -> str:
    """Write the mean of those that are known; nothing where none is."""
    known = [each for each in values if math.isfinite(each)]
    return format(np.mean(known), form) if known else ""


def _stage(point: Point, stage: str) -> float:
    return float(np.median(optional(point, "us", stage=stage)))


def _nearest(points: Sequence[Point], method: str) -> list[Point]:
    """Return each field's point of a method at its last weighed setting within equal error.

    Where no setting is within it, the finest that was weighed.
    """
    found = []
    for row in grouped(filter(is_measured, where(points, arm=method)), "field").values():
        weighed = [p for p in row if math.isfinite(megabytes(p))]
        within = [p for p in weighed if judged_error(p) <= EQUAL_ERROR]
        found += within[-1:] or weighed[:1]
    return found


EXPERIMENT = Experiment(
    name="methods",
    question="What do a frame's time and memory come to by other methods, at the same error?",
    version=1,
    topics={
        "rivals": Topic(
            about="the same frames by other methods of simplification, at equal error",
            cases=cases,
            claims=claims,
            plots=plots,
            tables=tables,
            full={
                "worlds": [
                    *_each(("crowd",), (1e5,), 4, _BASELINES),
                    *_each(("forest", "swaying forest"), (1e4,), 4, _BASELINES),
                    *_each(_KINDS[:3], (1e4,), 2),
                    *_each(_KINDS[1:], (1e5,), 2, _BASELINES),
                    *_each(("from above",), (1e5,), 2, _BASELINES),
                    *_each(_KINDS, (1e3, 1e6), 2, _FEW),
                ],
                "walk": ["crowd", 1e4, "320x180", 48],
                "cycles": [["crowd", 1e4], ["meadow", 1e4]],
                "size": "320x180",
                "spp": 16,
                "pairs": 2,
                "repeats": 4,
                "weighed": 2,
            },
            quick={
                "worlds": [
                    *_each(("crowd", "meadow"), (1e3,), 2),
                    *_each(("swaying",), (300.0,), 2),
                    *_each(("forest", "swaying forest"), (300.0,), 2, _BASELINES),
                ],
                "walk": ["crowd", 300.0, "160x90", 8],
                "cycles": [["crowd", 1e3], ["meadow", 1e3]],
                "size": "160x90",
                "repeats": 2,
                "weighed": 1,
            },
            seconds=(18_000.0, 600.0),
            apart=True,
        ),
    },
    rendered=True,
    timed=True,
    all_cores=True,
    whole_cases=True,
    caveats=(
        "Level ground without grass, as trees and people are compared; own models, one sun, one "
        "renderer but for Cycles. In `full` and `in_view` copies of still objects share the sticks "
        "of their prototypes; what walks or sways shares none.",
        "`full` is built once where nothing moves: its seconds there are those of a later frame.",
        "A ray-tracing level of detail (Yoon et al. 2006) stops at a node of the acceleration "
        "structure; Mitsuba's, from Embree and OptiX, cannot be stopped, and one of our own would "
        "be compared with those by its code and not by its idea. It is not measured.",
        "A method that no setting brings to equal error is not compared; the table says which.",
    ),
    order=130,
)
