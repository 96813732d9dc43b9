"""How far are the frames of every arm from the whole ones, and what do they cost?

Errors are those of ``fidelity``: excess FLIP over pairs of sampler seeds. The settings next to the
one of equal error are timed, all arms taking turns, frame by frame, in an order drawn anew for each
frame, since who follows a large scene finds other memory: each stage by the clock, and all of a
frame by the processor. While one arm is timed no scene of another exists: its shapes would
be in the code that is compiled, and garbage would be looked for. Memory is the most that a fresh
process holds that makes one frame.

A whole world that is foretold to need more memory than there is has no picture, and so its window
has no errors; the other arms are timed as they are.

Each arm also walks through one window at its setting nearest to equal error. Every frame has the
same seed as the whole world's, so that noise is the same where the same is displayed. ``flip`` is
the difference of a frame; ``residual`` is what changes from frame to frame beside what the whole
changes: the mean over pixels and colours of |ΔT − ΔW|, of pictures as they are displayed. Where
ColorVideoVDP is here, it judges the sequences too. And the same frames are rendered in Cycles.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from bench.children import run_in_child
from bench.images.compare import (
    BAND_EDGES_M,
    Reference,
    mean_flip,
    pair_band_name,
    picture_errors,
    reference_of,
)
from bench.images.equal_error import EQUAL_ERROR
from bench.methods.catalogue import CLIPPED, arms
from bench.methods.comparison import judged_error
from bench.methods.cycles import measure_cycles, noise
from bench.methods.environments import CYCLES, VIDEO
from bench.methods.method import Arm
from bench.methods.runner import KINDS, Runner, Window, make_one_frame, prepared_runner
from bench.methods.video import just_objectionable_differences
from bench.old_experiment import Effort
from bench.records.provenance import scene_digest
from bench.records.records import Column, Point
from bench.windows import Picture
from scenes.frame.layers import SKY_Z, Layers
from scenes.presets.load import load_preset
from scenes.presets.schema import Preset
from scenes.processes.memory import memory_limit
from scenes.render.memory import forecast, frame_bytes
from scenes.render.pictures import auto_exposure, to_srgb
from scenes.render.variants import choose
from scenes.scene import view_at
from scenes.world.world import World, build_world

JUDGED = "blake", "clipped", "discrete", "stochastic"
"""The arms whose sequences ColorVideoVDP judges."""


@dataclass(frozen=True)
class Walk:
    """A sequence of ``frames`` frames through a window, in which motion is looked at."""

    window: Window
    frames: int

    @property
    def label(self) -> str:
        """The name of the case, in short."""
        return f"{self.frames} frames of {self.window.label}"


@dataclass(frozen=True)
class OtherRenderer:
    """A window that Cycles renders, too: whole, and cut by the metric."""

    window: Window

    @property
    def label(self) -> str:
        """The name of the case, in short."""
        return f"Cycles, {self.window.label}"


Case = Window | Walk | OtherRenderer


def cases(effort: Effort) -> list[Case]:
    """Return every field of every world, the walk, and what Cycles renders if it is here."""
    variant = choose()
    common = {name: effort[name] for name in ("pairs", "repeats", "weighed")}
    picture = Picture(effort["size"], effort["spp"])
    windows = [
        Window(kind, objects, field, picture, variant=variant, arms=tuple(few), **common)
        for kind, objects, fields, few in effort["worlds"]
        for field in range(fields)
    ]
    kind, objects, size, frames = effort["walk"]
    small = Window(kind, objects, 0, Picture(size, effort["spp"]), 2, 1, variant)
    walk = Walk(small, frames)
    others = [OtherRenderer(w) for w in windows if [w.kind, w.objects] in effort["cycles"]]
    return [*windows, walk, *(others if CYCLES.python() else [])]


def scene_hash(points: tuple[Point, ...]) -> str:
    """Return the SHA-256 of the kinds of worlds, and of the arms with their settings."""
    tried = {name: arm.settings for name, arm in arms().items()}
    worlds = sorted({(p.case["kind"], p.case["objects"]) for p in points})
    presets = [load_preset(*KINDS[kind]).model_dump(mode="json") for kind, _ in worlds]
    return scene_digest([KINDS, worlds, tried, presets])


LEFT_OUT = "bounded", "solid_angle", "depth"
"""Arms that do not walk: readings of the metric that move as ``blake`` does."""


def measure_walk(case: Walk, seed: int) -> list[Point]:
    """Measure every arm over one sequence."""
    window = case.window
    preset = window.preset(seed)
    world = build_world(preset)
    found = {name: arm for name, arm in arms().items() if name not in LEFT_OUT}
    whole = _frames(prepared_runner(found.pop("full"), 0.0, world, preset), case)
    exposure = auto_exposure(whole[0])
    reference = _displayed(whole, exposure)
    points, judged = [], {}
    for arm in (*found.values(), CLIPPED):
        settings = [prepared_runner(arm, s, world, preset) for s in arm.settings]
        nearest = min(settings, key=lambda each: _away(each, reference[0], exposure, case))
        walked = prepared_runner(arm, nearest.setting, world, preset)
        tested = _displayed(_frames(walked, case), exposure)
        walked.columns += changes(tested, reference)
        points.append(walked.point(part="walk", kind=window.kind, objects=window.objects))
        if arm.name in JUDGED:
            judged[arm.name] = tested
    if not VIDEO.python():
        return points
    jod = just_objectionable_differences(judged, reference, _fps(preset))
    return [_with_jod(each, jod) for each in points]


def changes(tested: np.ndarray, whole: np.ndarray) -> tuple[Column, Column]:
    """Compare two displayed sequences, (n, h, w, 3): FLIP of frames, and residuals of steps."""
    pairs = zip(tested, whole, strict=True)
    flip = [round(1e6 * mean_flip(one, two)) for one, two in pairs]
    left = np.abs(np.diff(tested, axis=0) - np.diff(whole, axis=0)).mean(axis=(1, 2, 3))
    return Column("flip", flip), Column("residual", [round(1e6 * float(each)) for each in left])


def _away(runner: Runner, whole: np.ndarray, exposure: float, case: Walk) -> float:
    """Tell how far the first frame is from equal error, in logarithms; noise is the same."""
    runner.frame(1, case.window.variant)
    tested = _displayed([runner.picture(0).rgb], exposure)[0]
    runner.forget()
    return abs(math.log(max(mean_flip(tested, whole), 1e-6) / EQUAL_ERROR))


def _frames(runner: Runner, case: Walk) -> list[np.ndarray]:
    found = []
    for number in range(1, case.frames + 1):
        runner.frame(number, case.window.variant)
        found.append(runner.picture(0).rgb)
    runner.forget()
    return found


def _displayed(frames: list[np.ndarray], exposure: float) -> np.ndarray:
    return np.stack([to_srgb(each.astype(np.float64), exposure) for each in frames]).astype("f4")


def _fps(preset: Preset) -> float:
    return float(preset.camera.fps)


def _with_jod(point: Point, jod: dict[str, float]) -> Point:
    name = point.case["arm"]
    if name not in jod:
        return point
    return Point(point.case, samples=(*point.samples, Column("jod", [round(1e6 * jod[name])])))


LEVEL = 1.0 - 1e-4
"""A normal that points up by this or more is the ground's."""


def covered(tested: Sequence[Layers], whole: Sequence[Layers]) -> list[Column]:
    """Count the covered pixels of every picture, by bands of what they show."""
    made = []
    for low, high in zip(BAND_EDGES_M, (*BAND_EDGES_M[1:], float(SKY_Z)), strict=True):
        for which, row in (("tested", tested), ("reference", whole)):
            counts = [int(np.count_nonzero(_things(each, low, high))) for each in row]
            made.append(Column("covered", counts, {"picture": which, "band": pair_band_name(low)}))
    return made


def _things(layers: Layers, low: float, high: float) -> np.ndarray:
    inside = (layers.Z >= low) & (layers.Z < high)
    return np.asarray(inside & (layers.N[..., 2] < LEVEL))


TIMED = 3
"""Settings of each arm that are timed: those next to equal error."""

MOST_BYTES = 18_000_000_000
"""What an arm may need at most, on a machine that has as much."""

_KEPT_STICK = 200
"""Bytes that a stick takes here beside what is foretold for ``render``: in whole woods and crowds
of 6 to 31 M sticks 140 to 195 (``lodbench run rivals``). Some of it ``render`` frees before it
builds, and some its model leaves out."""

_LONGEST_S = 900


def measure(case: Case, seed: int) -> list[Point]:
    """Measure a window, a walk, or a window in Cycles."""
    if isinstance(case, Walk):
        return measure_walk(case, seed)
    if isinstance(case, OtherRenderer):
        return measure_cycles(case.window, seed)
    return measure_window(case, seed)


def measure_window(case: Window, seed: int) -> list[Point]:
    """Measure every arm in one window: errors, then times in turns, then memory."""
    preset = case.preset(seed)
    world = build_world(preset)
    where = {"kind": case.kind, "objects": case.objects, "field": case.field}
    tried, too_large = _that_fit(case, world, preset, where)
    if "full" in tried:
        whole, pictures = _reference(tried["full"][0], case)
        for runner in (each for row in tried.values() for each in row):
            _measure_error(runner, whole, pictures, case)
    timed = {name: next_to_equal_error(row) for name, row in tried.items() if row}
    turns = [each for row in timed.values() for each in row]
    for frame in range(2, case.repeats + 2):
        for k in np.random.default_rng((case.field, frame)).permutation(len(turns)):
            turns[k].timed_frame(frame, case.variant)
            turns[k].forget()
    for runner in (each for row in timed.values() for each in row[: case.weighed]):
        runner.columns.append(Column("peak_bytes", [_peak_bytes(runner, case, seed)]))
    measured = [each.point(**where) for row in tried.values() for each in row]
    return measured + too_large


def next_to_equal_error(row: Sequence[Runner]) -> list[Runner]:
    """Return the settings of an arm whose error is next to equal error.

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


def _that_fit(
    case: Window, world: World, preset: Preset, where: dict[str, Any]
) -> tuple[dict[str, list[Runner]], list[Point]]:
    """Prepare every arm at every setting; apart are the points of those foretold not to fit."""
    fit: dict[str, list[Runner]] = {}
    too_large = []
    most = min(MOST_BYTES, memory_limit().bytes or MOST_BYTES)
    for name, arm in arms().items():
        if case.arms and name not in case.arms:
            continue
        for setting in arm.settings:
            needed = _foretold(arm, setting, world, preset, case.variant)
            if needed <= most:
                fit.setdefault(name, []).append(prepared_runner(arm, setting, world, preset))
            else:
                named = {**where, "arm": name, "setting": setting}
                too_large.append(Point(named, samples=(Column("foretold_bytes", [needed]),)))
    return fit, too_large


def _foretold(arm: Arm, setting: float, world: World, preset: Preset, variant: str) -> int:
    """Foretell the memory of the first frame of an arm [bytes]; 0 where it is never much."""
    if arm.widest is None:
        return 0
    view = view_at(world, preset, 1)
    found = forecast(world, view, arm.widest(view, setting))
    return frame_bytes(found, preset, variant) + round(_KEPT_STICK * found.sticks)


def _reference(full: Runner, case: Window) -> tuple[Reference, list[Layers]]:
    """Render the whole window with every seed of every pair."""
    full.frame(1, case.variant)
    pictures = [full.picture(seed) for seed in range(2 * case.pairs)]
    return reference_of(pictures[0::2], pictures[1::2]), pictures[0::2]


def _measure_error(runner: Runner, whole: Reference, same: list[Layers], case: Window) -> None:
    """Render the first frame with one seed of every pair, and compare it with the whole one."""
    if runner.built is None:
        runner.frame(1, case.variant)
    layers = [runner.picture(seed) for seed in range(0, 2 * case.pairs, 2)]
    tested = [each.rgb.astype(np.float64) for each in layers]
    runner.columns += picture_errors(tested, whole)
    runner.columns += covered(layers, same)
    runner.columns.append(Column("noise", noise(tested, case.picture.spp)))
    runner.error = judged_error(runner.point())
    runner.forget()


def _peak_bytes(runner: Runner, case: Window, seed: int) -> int:
    """Ask a fresh process for the most that it holds while it makes one frame [bytes]."""
    words = case, seed, runner.arm.name, runner.setting
    child = run_in_child(make_one_frame, *words, variant=case.variant, timeout_s=_LONGEST_S)
    return child.peak_bytes
