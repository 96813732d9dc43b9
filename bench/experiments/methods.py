"""What do a frame's time and memory come to by other methods of simplification, at the same error?

All that is no method is the same for all: how much coarser what is off screen may be, air, fading,
what stands on the ground for what is not displayed; ``bare`` has none of it. What equal error is
says ``bench.methods.comparison``. All settings are timed, those next to equal error most often, all
methods taking turns, frame by frame, in an order drawn again for each frame, since who follows a
large scene finds other memory: each stage by the clock, and all of a frame by the processor.
While one method is looked at no scene of another exists: its shapes, which may be 10⁵ copies, would
be in the code that is compiled, and garbage would be looked for. Memory is the most that a fresh
process holds that makes one frame.

An unpruned world that is estimated to need more memory than there is has no picture, and so its
window has no errors; the other methods are timed as they are.
"""

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import partial
from itertools import pairwise
from typing import Any

import numpy as np
from scipy import stats

from bench.children import run_in_child
from bench.experiment import Case, Experiment, OwnPreset, Topic
from bench.frame_costs import Picture, own_kind
from bench.images.differences import (
    BAND_EDGES_M,
    EPSILON,
    Reference,
    pair_band_name,
    picture_errors,
    reference_of,
)
from bench.methods.comparison import (
    COSTS,
    EQUAL_SHARE,
    MARGIN,
    RULES,
    at_equal_error,
    beside_best,
    error,
    is_measured,
    judged_error,
)
from bench.methods.known_methods import methods
from bench.methods.method import Method
from bench.methods.runner import Runner, Window, make_one_frame
from bench.methods.tables import tables
from bench.plots import Curve, Panel, Plot, figure, number_text
from bench.records.claims import EXACT, Claim, at_most, claim, within
from bench.records.records import Column, Key, Point, Record, grouped
from bench.statistics.estimates import two_sided_factor
from scenes.frame.layers import SKY_Z, Layers
from scenes.processes.memory_limit import memory_limit
from scenes.render.memory import forecast, frame_bytes
from scenes.render.pictures import auto_exposure
from scenes.render.variants import choose
from scenes.scene import Scene, frame_quality
from scenes.sticks.prototype import LUMINANCE

FEW_REPEATS, SLOW_S = 2, 4.0
"""Timed frames of settings that are not next to equal error, and of those that take this long [s].
"""

ANEW = 10
"""How many fields away the objects of the ceiling are: the same world, redrawn."""

MOST_BYTES = 18_000_000_000
"""What a method may need at most, on a machine that has as much."""

BY_CONTRAST = "contrast_weighted"

LEVEL = 1.0 - 1e-4
"""A normal that points up by this or more is level ground's."""

_KEPT_STICK = 200
"""Bytes that a stick takes here beside what is estimated for ``render``: in unpruned woods and
crowds of 6 to 31 M sticks 140 to 195. Some of it ``render`` frees before it builds, and some its
model leaves out."""

_BASELINES = "blake", "bare", "full", "in_view", "discrete", "stochastic"


PILOT = {
    ("crowd", 1e5): (0.034, 190.0),
    ("still crowd", 1e5): (0.098, 220.0),
    ("forest", 1e4): (0.060, 350.0),
    ("swaying forest", 3e3): (0.060, 350.0),
    ("meadow", 1e4): (0.088, 180.0),
    ("swaying", 1e4): (0.149, 300.0),
}
"""What a pilot says of each world: the standard deviation of the logarithm of blake's time ÷ the
best baseline's between fields, and the seconds that a field takes on two cores.

The figures are those of the run before, whose fields are not judged again; ``swaying forest`` has
those of ``forest``. docs/method.md lists the worlds that were dropped.
"""


def plan(worlds: Sequence[Sequence[Any]], **sizes: object) -> list[str]:
    """Return what each world is expected to tell, in the order of information per hour.

    It is 1 ÷ the square of half the 95 % interval of the logarithm of a ratio, per hour.
    """
    rows = []
    for kind, objects, fields, _ in worlds:
        if (kind, objects) in PILOT and fields > 1:
            deviation, seconds = PILOT[kind, objects]
            half = float(stats.t.ppf(0.975, fields - 1)) * deviation / math.sqrt(fields)
            hours = fields * seconds / 3600
            rows.append((1 / half**2 / hours, kind, objects, fields, hours, half))
    return [
        f"{kind}, {number_text(objects)}: {fields} fields, {hours:.1f} h, ratio ± "
        f"{100 * half:.0f} %, {worth:.0f} of information an hour"
        for worth, kind, objects, fields, hours, half in sorted(rows, reverse=True)
    ]


def _each(
    kinds: Sequence[str], sizes: Sequence[float], fields: int, few: Sequence[str] = ()
) -> list[list[Any]]:
    """List kinds and sizes of worlds, the number of fields, and the methods; none = all."""
    return [[kind, objects, fields, list(few)] for objects in sizes for kind in kinds]


def cases(
    worlds: Sequence[Sequence[Any]],
    size: str,
    spp: int,
    preset: OwnPreset | None = None,
    **common: Any,
) -> list[Case]:
    """Return every field of every world.

    A user's own preset stands in place of all worlds, with as many objects as there are in the
    smallest and as many fields as the first has.
    """
    variant = choose()
    if preset is not None:
        fewest = min(objects for _, objects, *_ in worlds)
        worlds = _each(preset[:1], (fewest,), worlds[0][2], _BASELINES)
        common["world"] = own_kind(preset[1])
    windows = (
        Window(
            kind, objects, field, Picture(size, spp), variant=variant, tried=tuple(few), **common
        )
        for kind, objects, fields, few in worlds
        for field in range(fields)
    )
    return [partial(measure_window, each) for each in windows]


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
        full = tried["full"][0]
        full.frame(1, case.variant)
        rendered = [full.picture(seed) for seed in range(2 * case.pairs)]
        full.forget()
        reference, pictures = reference_of(rendered[0::2], rendered[1::2]), rendered[0::2]
        every = [each for row in tried.values() for each in row]
        for runner in every:
            _measure_error(runner, reference, pictures, case)
        ceiling = _ceiling(case, scene, reference, seed)
        for runner in every:
            runner.columns.append(ceiling)
            runner.error = judged_error([runner.point(**where)])
    timed = {name: next_to_equal_error(row) for name, row in tried.items()}
    turns = [each for row in timed.values() for each in row]
    often = {id(each) for row in timed.values() for each in row[:2]}
    for frame in range(2, case.repeats + 2):
        for k in np.random.default_rng((case.field, frame)).permutation(len(turns)):
            due = id(turns[k]) in often and turns[k].last_s < SLOW_S
            if due or frame < 2 + FEW_REPEATS:
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
    widest = method.widest(view, setting)
    from_size = scene.copied_from(widest, frame_quality(scene.preset, variant))
    found = forecast(scene.world, view, widest, from_size)
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
    runner.forget()


def _ceiling(case: Window, scene: Scene, reference: Reference, seed: int) -> Column:
    """Measure FLIP of the reference to the same ground with its objects redrawn, by pairs."""
    other = replace(case, field=case.field + ANEW).scene(seed).world
    anew = scene.with_world(replace(scene.world, fields=other.fields))
    runner = Runner(methods()["full"], 0.0, anew)
    runner.frame(1, case.variant)
    tested = [runner.picture(k).rgb.astype(np.float64) for k in range(0, 2 * case.pairs, 2)]
    found = next(each for each in picture_errors(tested, reference) if each.quantity == "flip")
    return replace(found, quantity="flip_ceiling")


def covered(tested: Sequence[Layers], reference: Sequence[Layers]) -> list[Column]:
    """Count the pixels that things cover in every picture, by bands, and sum their luminance.

    A pixel counts where its first sample meets something that is not level ground, whose normal
    is straight up; a stick's is so with probability 0. Pictures of one seed have the same samples.
    """
    made = []
    for low, high in zip(BAND_EDGES_M, (*BAND_EDGES_M[1:], float(SKY_Z)), strict=True):
        for which, row in (("tested", tested), ("reference", reference)):
            things = [(each.Z >= low) & (each.Z < high) & (each.N[..., 2] < LEVEL) for each in row]
            counts = [int(np.count_nonzero(each)) for each in things]
            keys: dict[str, Key] = {"picture": which, "band": pair_band_name(low)}
            made.append(Column("covered", counts, keys))
            light = [
                float((p.rgb[at] @ LUMINANCE).sum()) for p, at in zip(row, things, strict=True)
            ]
            made.append(Column("lit", [round(1e6 * each) for each in light], keys))
    return made


def next_to_equal_error(row: Sequence[Runner]) -> list[Runner]:
    """Return the settings of a method, those whose error is next to equal error first.

    They are the last within the error and the first beyond it, because time at equal error is read
    between them. Without errors, those in the middle come first.
    """

    def away(runner: Runner) -> float:
        if math.isnan(runner.error):
            return abs(row.index(runner) - (len(row) - 1) / 2)
        return abs(math.log(max(runner.error, 1e-6) / EQUAL_SHARE))

    beyond = next((k for k, each in enumerate(row) if not each.error <= EQUAL_SHARE), len(row))
    between = [row[k] for k in (beyond - 1, beyond) if 0 <= k < len(row)]
    first = [] if math.isnan(row[0].error) else between
    others = sorted((each for each in row if each not in first), key=away)
    return [*first, *others]


def peak_bytes(runner: Runner, case: Window, seed: int) -> int:
    """Return the most that a fresh process holds while it makes one frame [bytes]."""
    words = case, seed, runner.method.name, runner.setting
    return run_in_child(make_one_frame, *words, variant=case.variant).peak_bytes


def noise(pictures: Sequence[np.ndarray], spp: int) -> list[int]:
    """Return the relative variance of a sample, from each picture and the next [millionths].

    It is the variance of a pixel times its samples, ÷ squared light, by ``rel_mse``'s rule; a
    stratified sampler has less than independent samples would have.
    """
    mean = np.mean(pictures, axis=0)
    exposure = auto_exposure(mean)
    over = (mean * exposure) ** 2 + EPSILON
    squares = (((a - b) * exposure) ** 2 / over for a, b in pairwise(pictures))
    found = (spp * np.mean(each) / 2 for each in squares)
    return [round(1e6 * float(each)) for each in found]


# Claims, from raw errors, times and bytes alone.

HEADLINES = ("crowd", 1e5, "time"), ("forest", 1e4, "memory")


def claims(points: Sequence[Point]) -> Iterator[Claim]:
    """Claim, for every kind and size of world, that the metric's frame costs no more than others'.

    It is compared with the baseline that needs least, with everything and bare, by each way to say
    what equal error is; and claimed that the two are equivalent. Weighted by contrast it is
    compared with ``blake``. Fields are the replicates.
    """
    made = partial(claim, unit="field", source="§4.1, derived: docs/method.md", alone=EXACT)
    for (kind, objects), window in grouped(points, "kind", "objects").items():
        for rule in RULES:
            found = at_equal_error(window, rule)
            for cost, (quantity, _, _) in COSTS.items():
                for mine, others in (("blake", None), ("bare", None), (BY_CONTRAST, ("blake",))):
                    best = beside_best(found, quantity, mine, others)
                    if best is None or len(best[1]) < 2:
                        continue
                    of = {"kind": kind, "objects": objects, "error by": rule, "baseline": best[0]}
                    estimand = f"{cost} of a frame at equal error, {mine} ÷ best baseline"
                    lead = (kind, objects, cost) in HEADLINES and rule == RULES[0]
                    ratio, shown = two_sided_factor(best[1]), lead and mine == "blake"
                    yield made(estimand, at_most(1), of, ratio, headline=shown)
                    estimand = f"equivalence in {estimand}"
                    yield made(estimand, within(1, MARGIN), of, ratio)


# Plots.


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
            panels.append(Panel(title, (axis, "error, floor 0 to ceiling 1"), drawn))
        best = beside_best(at_equal_error(points), "seconds")
        if best is not None:
            ratios = best[1]
            spread = f"{two_sided_factor(ratios):.2f}" if len(ratios) > 1 else f"{ratios[0]:.2f}"
            told.append(f"{spread} in {kind} ({best[0]})")
    title = "Error against the seconds and the memory of a frame, by method"
    if told:
        title = f"Time at equal error, blake ÷ best baseline: {'; '.join(told)}"
    caption = (
        "Means over fields with the range of the fields, settings next to equal error; nearer to "
        "the lower left is better. Errors below 0.001 are drawn there. What is off screen, air, "
        "fading and far cover are the same for all but `bare`, which has none of them. Every other "
        "world is in the tables."
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
        flips = np.maximum([error(p) for p in mine], _LEAST)  # noise: some are below 0
        if math.isfinite(cost):
            rows.append((cost, float(flips.mean()), float(flips.min()), float(flips.max())))
    if rows:
        x, y, low, high = (list(row) for row in zip(*sorted(rows), strict=True))
        yield Curve(method, x, y, low, high)


_LEAST = 1e-3


EXPERIMENT = Experiment(
    name="methods",
    question="What do a frame's time and memory come to by other methods, at the same error?",
    version=3,
    topics={
        "rivals": Topic(
            about="the same frames by other methods of simplification, at equal error",
            cases=cases,
            claims=claims,
            plots=plots,
            tables=tables,
            full={
                "worlds": [
                    *_each(("crowd", "still crowd"), (1e5,), 6, _BASELINES),
                    *_each(("forest",), (1e4,), 6, _BASELINES),
                    *_each(("swaying forest",), (3e3,), 6, _BASELINES),
                    *_each(("meadow",), (1e4,), 6, (*_BASELINES, BY_CONTRAST)),
                    *_each(("swaying",), (1e4,), 6, _BASELINES),
                ],
                "size": "320x180",
                "spp": 16,
                "pairs": 2,
                "repeats": 16,
                "weighed": 2,
                "unseen": True,
            },
            quick={
                "worlds": [
                    *_each(("crowd", "meadow"), (1e3,), 2),
                    *_each(("swaying",), (300.0,), 2),
                    *_each(("forest", "swaying forest"), (300.0,), 2, _BASELINES),
                ],
                "size": "160x90",
                "repeats": 2,
                "weighed": 1,
                "unseen": False,
            },
            plan=plan,
            seconds=(16_600.0, 600.0),
            apart=True,
            accepts=("preset",),
        )
    },
    rendered=True,
    timed=True,
    all_cores=True,
    whole_cases=True,
    caveats=(
        "Level ground without grass, as trees and people are compared; own models, one sun, one "
        "renderer. In `full` and `in_view` copies of still objects share the sticks "
        "of their prototypes; what walks or sways shares none.",
        "`full` is built once where nothing moves: its seconds there are those of a later frame.",
        "A ray-tracing level of detail (Yoon et al. 2006) stops at a node of the acceleration "
        "structure; Mitsuba's, from Embree and OptiX, cannot be stopped, and one of our own would "
        "be compared with those by its code and not by its idea. It is not measured.",
        "A method that no setting brings to equal error is not compared; the table says which.",
    ),
    order=130,
)
