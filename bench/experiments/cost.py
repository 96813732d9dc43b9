"""What does a frame cost, what does pruning save, and does the size of the world matter? (§4)

``cost`` times frames of a preset stage by stage, and of ever larger worlds, unpruned and pruned at
one pixel: every process is fresh, its first frame compiles, and times are by the clock, on all
cores. ``world`` times the first frame of worlds of 10³ to 10¹⁵ objects, up to plain arrays, all in
turns, in CPU seconds of one thread; unpruned, every object of a finite window is displayed, up to a
stated number of parts. ``start`` holds commands from the shell against the imports that they need,
``variants`` scalar code against LLVM's, and ``tracing`` our integrator against Mitsuba's and
against intersections alone.
"""

from collections.abc import Iterator, Mapping, Sequence
from functools import partial

import numpy as np

from bench.children import run_in_child
from bench.experiment import Case, Experiment, OwnPreset, Table, Topic
from bench.frame_costs import WORLD, Size, measure_process, measure_worlds, own_kind, window_costs
from bench.images.differences import errors, flips
from bench.images.equal_error import EQUAL_ERROR
from bench.plots import SIDE, Curve, Panel, Plot, curves, estimated, figure, number_text
from bench.records.claims import EXACT, Claim, at_least, at_most, claim, equals, within
from bench.records.records import Column, Point, Record, columns, grouped, where
from bench.seeds import first_seed
from bench.statistics.estimates import (
    LEAST_REPEATS,
    Estimate,
    exactly,
    fit_exponent,
    one_sided_mean,
    two_sided_factor,
    two_sided_median,
)
from bench.timing import measure_command, start_claims, start_tables, variants_claims
from bench.tracing import measure_tracing, tracing_claims, tracing_tables
from lod.arrays import Reals
from scenes.render.variants import JIT_VARIANT, SCALAR_VARIANT, choose


def _measure_size(case: Size, seed: int) -> list[Point]:
    made, seen = [], dict[str, list[np.ndarray]]()
    world_seed = first_seed(case.unseen, 4) + 12 * seed + case.field
    for side in ("whole", "pruned"):
        found = run_in_child(window_costs, case, side, world_seed, variant=case.variant).result
        seen[side] = [each.astype(np.float64) for each in found["pictures"]]
        rows = found["rows"]
        counts = {"field": case.field, "peak_bytes": found["peak_bytes"], **found["statistics"]}
        errors = flips(seen[side], seen["whole"]) if side == "pruned" else []
        samples = (
            *(Column("us", [row[stage] for row in rows], {"stage": stage}) for stage in rows[0]),
            *columns({name: [value] for name, value in counts.items()}),
            *(
                Column("flip_ppm", [round(1e6 * error)], {"samples": spp, "number": number})
                for number, (spp, error) in enumerate(zip(case.samples, errors, strict=False))
            ),
        )
        named = {"topic": "cost", "what": "size", "kind": case.kind, "objects": case.objects}
        made.append(Point(named | {"side": side}, samples=samples))
    return made


# Claims, from raw points alone.

STAGES = {
    "prune": "examine and prune",
    "appearance": "pose and look",
    "describe": "describe",
    "build": "build, with its BVH",
    "trace": "render, haze included",
    "write": "write and read back",
}
"""The stages that make up a frame, in their order, with their names in words."""

SET_UP = "prune", "appearance", "describe", "build"  # the stages of a frame before its trace

STILL = {"meadow"}
"""Kinds of world in which nothing moves: the unpruned scene is built once, and then only traced."""

SEQUENCE = 240  # the number of frames over which setting up is amortised: ten seconds of film

BEYOND = 2.5
"""The side, in limit distances, from which on a world is beyond the limit.

The eye is in the middle, and whoever walks may come from a little further.
"""


def _cost_claims(points: Sequence[Point]) -> Iterator[Claim]:
    told, made = {"preset": "meadow"}, partial(claim, source="§4.2")
    if frames := where(points, what="frames"):
        whole = _frame_us(frames[0])
        for what, stage, most in (
            ("the metric", "metric", 0.01),
            ("finding and pruning", "prune", 0.1),
        ):
            found = two_sided_median(_stage_us(frames[0], stage) / whole)
            estimand, shown = f"time of {what} ÷ time of a frame", stage == "prune"
            yield made(estimand, at_most(most), told, found, unit="frame", headline=shown)
        world = where(points, what="processes")[0].values("world")
        if len(world) >= LEAST_REPEATS:
            estimand = f"time to set up the hierarchies ÷ time of {SEQUENCE} frames"
            found = two_sided_median(world / (SEQUENCE * np.median(whole)))
            yield made(estimand, at_most(0.01), told, found, unit="process")
    sizes = where(points, what="size")
    for (kind, objects), both in grouped(sizes, "kind", "objects").items():
        sides = {p.case["side"]: p for p in both}
        yield from _size_claims(kind, objects, sides["pruned"], sides["whole"])


def _size_claims(kind: str, objects: float, pruned: Point, unpruned: Point) -> Iterator[Claim]:
    of: dict[str, str | float] = {"kind": kind, "objects": objects}
    later = {**of, "scene": "unpruned built once" if kind in STILL else "both rebuilt per frame"}
    made = partial(claim, unit="field", source="§4.1, §4.2")
    fields = len(pruned.values("peak_bytes"))
    trace = ratio(_stage_us(pruned, "trace"), _stage_us(unpruned, "trace"), fields)
    yield made("time to trace, pruned ÷ unpruned", within(1, 0.25), of, trace)
    frame = ratio(_frame_us(pruned), later_us(unpruned), fields)
    yield made("time of a later frame, pruned ÷ unpruned", at_most(1), later, frame)
    set_up = ratio(_set_up_us(pruned), _set_up_us(unpruned), fields)
    yield made("time to set up a frame, pruned ÷ unpruned", at_most(1), of, set_up)
    held = ratio(pruned.values("peak_bytes"), unpruned.values("peak_bytes"), fields)
    yield made("memory of a first frame, pruned ÷ unpruned", at_most(1), of, held)
    wrong, bound = one_sided_mean(errors(pruned)), at_most(EQUAL_ERROR)
    yield made("FLIP to unpruned without noise", bound, of, wrong)


def ratio(pruned: Reals, unpruned: Reals, fields: int) -> Estimate:
    """Estimate pruned ÷ unpruned; frames of one field, one after the other, are one value."""
    logs = np.log(np.maximum(pruned, 1) / np.maximum(unpruned, 1)).reshape(fields, -1)
    return two_sided_factor(np.exp(logs.mean(axis=1)))


def _stage_us(point: Point, stage: str) -> Reals:
    return point.values("us", stage=stage)


def _set_up_us(point: Point) -> Reals:
    """Return the time of every frame before its trace, (frames,) [µs]."""
    return np.asarray(np.sum([_stage_us(point, stage) for stage in SET_UP], axis=0))


def _frame_us(point: Point) -> Reals:
    timed = [each.values for each in point.samples if each.keys.get("stage") in STAGES]
    return np.asarray(np.sum(timed, axis=0), np.float64)


def later_us(point: Point) -> Reals:
    """Return the time of a later frame, (frames,) [µs]: what stands still is not set up again.

    That is so of an unpruned scene. What a walking eye has pruned changes with every step.
    """
    still = point.case["kind"] in STILL and point.case["side"] == "whole"
    return _stage_us(point, "trace") if still else _frame_us(point)


def _world_claims(points: Sequence[Point]) -> Iterator[Claim]:
    beyond, unpruned = beyond_limit(points), where(points, metric="full")
    largest, last = unpruned[-1], beyond[-1]
    of, made = {"preset": WORLD}, partial(claim, unit="round", source="§4.1")
    pruned = {**of, "side of the world": f"beyond {BEYOND:g} limit distances"}
    check = partial(made, condition=pruned, kind="verification")
    same = exactly(float(len({p.case["scene"] for p in beyond})), len(beyond))
    yield check("different frames", equals(1), estimate=same, unit=EXACT)
    rounds = np.array([seconds(p) for p in beyond])
    objects = np.repeat([float(p.case["objects"]) for p in beyond], rounds.shape[1])
    flat = fit_exponent(objects, (rounds / rounds.mean(axis=0)).ravel())
    yield check("exponent of time against objects", within(0, 0.01), estimate=flat)
    growth, whole = fit_exponent(*added_by_parts(unpruned)), {**of, "pruning": "unpruned"}
    estimand = "exponent of added time against added parts"
    yield made(estimand, within(1, 0.1), whole, growth)
    ends = f"{largest.case['objects']:.0e} unpruned, {last.case['objects']:.0e} pruned"
    saved = two_sided_median(seconds(largest) / float(np.median(seconds(last))))
    estimand, compared = "time of a frame, unpruned ÷ pruned", {**of, "objects": ends}
    yield made(estimand, at_least(1), compared, saved, headline=True)


def beyond_limit(points: Sequence[Point]) -> list[Point]:
    """Return the pruned worlds that reach beyond the limit distance on all sides."""
    pruned = (p for p in points if p.case["metric"] != "full")
    return [p for p in pruned if p.case["side_m"] > BEYOND * p.case["limit_m"]]


def seconds(point: Point) -> Reals:
    """Return the CPU seconds of every repeat, (repeats,)."""
    return point.values("cpu_us") / 1e6


def added_by_parts(points: Sequence[Point]) -> tuple[np.ndarray, np.ndarray]:
    """Return the parts beyond those of the smallest world, and the time they add [s].

    There is a value for every repeat that takes longer. Ground and camera take time in an empty
    world, too.
    """
    parts = np.array([float(p.column("parts")[0]) for p in points])
    rounds = np.array([seconds(p) for p in points])
    added = (rounds[1:] - np.median(rounds[0])).ravel()
    x = np.repeat(parts[1:] - parts[0], rounds.shape[1])
    return x[added > 0], added[added > 0]


# Plots and tables.

SIDES = {"whole": "unpruned", "pruned": "pruned"}
_WORLD_AXIS = "objects in the world; left unpruned, right pruned"
_LABELS = {"blake": "pruned", "full": "unpruned"}


def _cost_plots(record: Record) -> Iterator[Plot]:
    points = where(record.points, what="size")
    if not points:
        return
    panels: list[Panel] = []
    told = {}
    for (kind,), row in grouped(points, "kind").items():
        sizes = grouped(sorted(row, key=lambda p: p.case["objects"]), "objects")
        both = [one for pair in sizes.values() for s in SIDES for one in where(pair, side=s)]
        x = [k + side for k in range(len(sizes)) for side in (-SIDE, SIDE)]
        ticks = [number_text(objects) for (objects,) in sizes]
        stacks = [
            Curve(STAGES[s], x, [float(np.median(_stage_us(p, s))) / 1e6 for p in both])
            for s in (*SET_UP, "trace")
        ]
        held = [float(np.median(p.values("peak_bytes"))) / 1e9 for p in both]
        for title, axis, drawn in (
            ("time", "seconds of a frame, medians", stacks),
            ("memory", "peak of a fresh process (GB)", [Curve("memory", x, held)]),
        ):
            axes, scales = (_WORLD_AXIS, axis), ("linear", "linear")
            panels.append(
                Panel(f"{kind}: {title}", axes, drawn, scales, "bars", ticks, [*SIDES.values()])
            )
        unpruned, pruned = both[-2:]
        times = [
            ratio(of(pruned), of(unpruned), len(pruned.values("peak_bytes"))).value
            for of in (_set_up_us, partial(_stage_us, stage="trace"))
        ]
        told[pruned.case["objects"]] = (
            f"{kind}, {ticks[-1]} objects: a pruned frame takes {times[0]:.2g} times the set-up, "
            f"{held[-1] / held[-2]:.2g} times the memory and {times[1]:.2g} times the tracing"
        )
    title = told.pop(max(told))
    caption = (
        f"{'; '.join((*told.values(), ''))}medians over frames, each side in a fresh process. "
        "Unpruned worlds of `meadow` are built once, of copies that share their models' shapes; "
        "people of `crowd` share nothing. Times are those of one machine."
    )
    title, caption = (each[:1].upper() + each[1:] for each in (title, caption))
    yield figure("stages", title, caption, panels)


def _world_plots(record: Record) -> Iterator[Plot]:
    points = record.points
    beyond, unpruned = beyond_limit(points), where(points, metric="full")
    drawn = []
    for metric, label in _LABELS.items():
        row = where(points, metric=metric)
        found = [two_sided_median(seconds(p)) for p in row]
        drawn.append(estimated(label, [float(p.case["objects"]) for p in row], found))
    same = len({p.case["scene"] for p in beyond})
    most = number_text(unpruned[-1].case["objects"])
    title = (
        f"Beyond the limit distance a frame takes {drawn[0].y[-1]:.2g} s in a world of any size; "
        f"unpruned, {drawn[1].y[-1]:.2g} s for {most} objects"
    )
    caption = (
        "From prune to plain frame, seconds of one core: medians with their 95 % intervals. Of the "
        f"worlds larger than the limit distance, {len(beyond)} give {same} "
        f"frame{'s' if same > 1 else ''}, compared bit for bit."
    )
    axis = "objects in the world", "seconds for a frame"
    yield curves("world", title, caption, axis, drawn)


def _size_tables(record: Record) -> Iterator[tuple[str, Table]]:
    stages = (*SET_UP, "trace")
    heads = ("world", "objects", "side", *(f"{STAGES[stage]} (s)" for stage in stages))
    rows: list[tuple[str, ...]] = []
    for point in where(record.points, what="size"):
        case, pruned = point.case, point.case["side"] == "pruned"
        times = (f"{np.median(_stage_us(point, stage)) / 1e6:.3f}" for stage in stages)
        held = f"{np.median(point.values('peak_bytes')) / 1e6:.0f}"
        error = f"{errors(point).mean():.4f}" if pruned else ""
        side = "pruned" if pruned else "unpruned"
        rows.append((case["kind"], f"{case['objects']:g}", side, *times, held, error))
    title = "Stages, memory and error of each side of every size of world"
    yield title, ((*heads, "memory (MB)", "FLIP without noise"), rows)


def _cost_cases(
    processes: int,
    worlds: Mapping[str, Sequence[float]],
    fields: int,
    unseen: bool,
    size: str,
    spp: int,
    frames: int,
    samples: Sequence[int],
    preset: OwnPreset | None = None,
) -> list[Case]:
    variant, world = choose(), None
    if preset is not None:  # in place of the process of a preset and of all worlds
        few = sorted({objects for several in worlds.values() for objects in several})[:2]
        processes, worlds, world = 0, {preset[0]: few}, own_kind(preset[1])
    looks = unseen, size, spp, frames, tuple(samples), variant, world
    return [
        *(partial(measure_process, number, variant) for number in range(processes)),
        *(
            partial(_measure_size, Size(kind, objects, field, *looks))
            for kind, several in worlds.items()
            for objects in several
            for field in range(fields)
        ),
    ]


def _start_cases(presets: Sequence[str], warm: int, cold: int) -> list[Case]:
    return [
        partial(measure_command, ("count", "meadow"), warm, cold, ()),
        *_frame_cases(presets, "640x360", warm, cold, (choose(),)),
    ]


def _frame_cases(
    presets: Sequence[str],
    size: str,
    warm: int,
    cold: int = 0,
    variants: Sequence[str] = (SCALAR_VARIANT, JIT_VARIANT),
) -> list[Case]:
    frames = (("render", preset, "--size", size, "--spp", "16") for preset in presets)
    return [partial(measure_command, words, warm, cold, variants) for words in frames]


EXPERIMENT = Experiment(
    name="cost",
    question="What does a frame cost, stage by stage, and does the size of the world matter?",
    version=1,
    topics={
        "cost": Topic(
            about="seconds and bytes of a frame, stage by stage; of larger worlds, pruned or not",
            cases=_cost_cases,
            claims=_cost_claims,
            plots=_cost_plots,
            tables=_size_tables,
            full={
                "processes": 8,
                "worlds": {"meadow": [1e3, 1e4, 3e4], "crowd": [1e3, 1e4, 1e5]},
                "fields": 3,
                "unseen": True,
                "size": "320x180",
                "spp": 64,
                "frames": 4,
                "samples": [32, 128],
            },
            quick={
                "processes": 2,
                "worlds": {"meadow": [300.0], "crowd": [1e3]},
                "fields": 2,
                "unseen": False,
                "size": "64x36",
                "spp": 16,
                "frames": 2,
                "samples": [16, 64],
            },
            seconds=(1400.0, 60.0),
            accepts=("preset",),
        ),
        "world": Topic(
            about="one frame in worlds of 10³ to 10¹⁵ objects, and all objects of small ones",
            cases=lambda repeats: [partial(measure_worlds, repeats)],
            claims=_world_claims,
            plots=_world_plots,
            full={"repeats": 31},
            quick={"repeats": 8},
            seconds=(120.0, 40.0),
        ),
        "start": Topic(
            about="seconds from the shell to an answer, with nothing kept and with all kept",
            cases=_start_cases,
            claims=start_claims,
            tables=start_tables,
            full={"presets": ["meadow"], "warm": 9, "cold": 8},
            quick={"presets": [], "warm": 2, "cold": 0},
            seconds=(900.0, 40.0),
            apart=True,
        ),
        "variants": Topic(
            about="seconds to trace a frame in scalar code and in LLVM's, in turns",
            cases=_frame_cases,
            claims=variants_claims,
            tables=start_tables,
            full={"presets": ["meadow", "forest"], "size": "320x180", "warm": 9},
            quick={"presets": ["fly_in"], "size": "64x36", "warm": 2},
            seconds=(900.0, 40.0),
            apart=True,
        ),
        "tracing": Topic(
            about="seconds of a frame's rays, no copies, by us, by Mitsuba, and by intersections",
            cases=lambda presets, sizes, fields, unseen: [
                partial(measure_tracing, preset, size, field, unseen)
                for preset in presets
                for size in sizes
                for field in range(fields)
            ],
            claims=tracing_claims,
            tables=tracing_tables,
            full={
                "presets": ["meadow", "crowd", "forest", "mountain"],
                "sizes": ["640x360", "1280x720"],
                "fields": 8,
                "unseen": True,
            },
            quick={"presets": ["crowd"], "sizes": ["64x36"], "fields": 2, "unseen": False},
            seconds=(5400.0, 30.0),
            apart=True,
        ),
    },
    rendered=True,
    timed=True,
    all_cores=True,
    probe="crowd",
    caveats=(
        "Small pictures, wall-clock times of one machine; a larger picture with more samples makes "
        "the shares of the metric and of all set-up smaller, for tracing takes as long either way.",
        "The metric alone is timed as arrays of distances; in the walk it is one with the "
        "search, whose time stands beside it.",
        "Memory is the most that a process has held, its libraries with it.",
        "Unpruned worlds of `meadow` are copies that share the shapes of their models. People of "
        "`crowd` have poses of their own, so that each is built whole.",
        "Worlds of 10³ to 10¹⁵ objects are endless fields seen through a window: none of their "
        "objects is stored, so that what grows with the world is what a frame examines, and "
        "nothing else. Seconds of one core, from prune to plain frame; rendering is the same for "
        "the same frame. Unpruned, only as far as the stated number of parts.",
    ),
    order=120,
)
