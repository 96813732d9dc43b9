"""How far are the frames of every arm from the whole ones, and what do they cost?

Errors are those of ``fidelity``: excess FLIP over pairs of sampler seeds. The settings next to the
one of equal error are timed, all arms taking turns, frame by frame, in an order drawn anew for each
frame, since who follows a large scene finds other memory: each stage by the clock, and all of a
frame by the processor. While one arm is timed no scene of another exists: its shapes would
be in the code that is compiled, and garbage would be looked for. Memory is the most that a fresh
process holds that makes one frame (``child``).

A whole world that is foretold to need more memory than there is has no picture, and so its window
has no errors; the other arms are timed as they are.
"""

import json
import math
import os
import subprocess
import sys
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from bench.arms.arm import Arm
from bench.arms.registry import arms
from bench.experiments.fidelity.equal_error import EQUAL_ERROR
from bench.experiments.fidelity.image_errors import Reference, picture_errors, reference_of
from bench.experiments.rivals.coverage import covered
from bench.experiments.rivals.cycles import measure_cycles
from bench.experiments.rivals.equal_error import judged_error
from bench.experiments.rivals.noise import noise
from bench.experiments.rivals.turns import Runner, prepared_runner
from bench.experiments.rivals.walk import measure_walk
from bench.experiments.rivals.windows import Case, OtherRenderer, Walk, Window
from bench.records.points import Column, Point
from scenes.frame.layers import Layers
from scenes.preset.tables import Preset
from scenes.render.mitsuba.variants import trusting
from scenes.render.pipeline.memory_limit import frame_bytes, memory_limit
from scenes.world.forecast import forecast
from scenes.world.view import view_at
from scenes.world.world import World, build_world

TIMED = 3
"""Settings of each arm that are timed: those next to equal error."""

MOST_BYTES = 18_000_000_000
"""What an arm may need at most, on a machine that has as much."""

_KEPT_STICK = 200
"""Bytes that a stick takes here beside what is foretold for ``render``: in whole woods and crowds
of 6 to 31 M sticks 140 to 195 (``lodbench run rivals``). Some of it ``render`` frees before it
builds, and some its model leaves out."""

_LONGEST_S = 900
_ROOT = Path(__file__).resolve().parents[3]


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
    words = {"window": asdict(case), "seed": seed, "arm": runner.arm.name}
    paths = os.pathsep.join([str(_ROOT), *filter(None, [os.environ.get("PYTHONPATH")])])
    done = subprocess.run(
        [sys.executable, "-P", "-m", "bench.experiments.rivals.child"],
        input=json.dumps(words | {"setting": runner.setting}),
        env={**trusting(case.variant), "PYTHONPATH": paths},
        stdout=subprocess.PIPE,
        timeout=_LONGEST_S,
        check=True,
        text=True,
    )
    return int(done.stdout.splitlines()[-1])
