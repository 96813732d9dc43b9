"""How far are the frames of every arm from the whole ones, and what do they cost?

Errors are those of ``fidelity``: excess FLIP over pairs of sampler seeds. The settings next to the
one of equal error are timed, all arms taking turns, frame by frame: each stage by the clock, and
all of a frame by the processor. Memory is the most that a fresh process holds that makes one frame
(``child``), at the setting nearest to equal error.
"""

import json
import math
import os
import subprocess
import sys
import time
from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path

import numpy as np

from bench.arms.arm import Arm, Updater
from bench.arms.registry import arms
from bench.experiments.fidelity.equal_error import EQUAL_ERROR
from bench.experiments.fidelity.image_errors import Reference, picture_errors, reference_of
from bench.experiments.rivals.equal_error import STAGES
from bench.experiments.rivals.windows import Window
from bench.records.points import Column, Point, columns
from scenes.frame.frame_input import FrameInput
from scenes.frame.layers import Layers
from scenes.render.mitsuba.variants import trusting
from scenes.render.pipeline.stages import BuiltFrame, build_frame, move_camera, trace
from scenes.world.world import build_world

TIMED = 3
"""Settings of each arm that are timed: those next to equal error."""

_LONGEST_S = 900
_ROOT = Path(__file__).resolve().parents[3]


@dataclass
class Runner:
    """One arm at one setting: its updater, what it built last, and what was measured."""

    arm: Arm
    setting: float
    updater: Updater
    made: FrameInput | None = None
    built: BuiltFrame | None = None
    excess: float = 0.0
    columns: list[Column] = field(default_factory=list)
    statistics: dict[str, int] = field(default_factory=dict)
    times: dict[str, list[int]] = field(default_factory=dict)

    def frame(self, number: int, variant: str) -> dict[str, float]:
        """Make a frame ready to trace; give the seconds of each stage so far."""
        start = time.perf_counter()
        made = self.updater(number, variant)
        spent = {"update": time.perf_counter() - start}
        if self.made is not None and self.built is not None:
            if made.displayed is self.made.displayed:
                self.built = move_camera(self.built, made.camera, made.air)
                self.made = made
                return {**spent, **self.built.seconds}
        self.made, self.built = made, build_frame(made)
        return {**spent, **self.built.seconds}

    def ready(self) -> tuple[FrameInput, BuiltFrame]:
        """Return the frame that was made last. Raises RuntimeError where there is none."""
        if self.made is None or self.built is None:
            raise RuntimeError(f"{self.arm.name}: no frame was made")
        return self.made, self.built

    def timed_frame(self, number: int, variant: str) -> None:
        """Make and trace a frame, and note what each stage took."""
        before = time.process_time()
        spent = self.frame(number, variant)
        made, built = self.ready()
        layers = trace(built, made.quality)
        spent["trace"] = layers.seconds["trace"]
        for stage in STAGES:
            self.times.setdefault(stage, []).append(round(1e6 * spent[stage]))
        self.times.setdefault("cpu", []).append(round(1e6 * (time.process_time() - before)))

    def forget(self) -> None:
        """Free what was built, unless it will be used again."""
        if self.arm.name != "full":
            self.made = self.built = None


def measure(case: Window, seed: int) -> list[Point]:
    """Measure every arm in one window: errors, then times in turns, then memory."""
    preset = case.preset(seed)
    world = build_world(preset)
    tried = {
        arm.name: [Runner(arm, s, arm.prepare(world, preset, s)) for s in arm.settings]
        for arm in arms().values()
    }
    whole = _reference(tried["full"][0], case)
    for runner in (each for row in tried.values() for each in row):
        _measure_error(runner, whole, case)
    timed = [each for row in tried.values() for each in next_to_equal_error(row)]
    for frame in range(2, case.repeats + 2):
        for runner in timed:
            runner.timed_frame(frame, case.variant)
            runner.forget()
    for row in tried.values():
        nearest = next_to_equal_error(row)[0]
        nearest.columns.append(Column("peak_bytes", [_peak_bytes(nearest, case, seed)]))
    return [_point(each, case) for row in tried.values() for each in row]


def next_to_equal_error(row: Sequence[Runner]) -> list[Runner]:
    """Return the settings of an arm whose excess is next to equal error, the nearest first."""

    def away(runner: Runner) -> float:
        return abs(math.log(max(runner.excess, 1e-6) / EQUAL_ERROR))

    return sorted(row, key=away)[:TIMED]


def _reference(full: Runner, case: Window) -> Reference:
    """Render the whole window with every seed of every pair."""
    full.frame(1, case.variant)
    pictures = _pictures(full, range(2 * case.pairs))
    full.statistics = dict(pictures[0].statistics)
    return reference_of(pictures[0::2], pictures[1::2])


def _measure_error(runner: Runner, whole: Reference, case: Window) -> None:
    """Render the first frame with one seed of every pair, and compare it with the whole one."""
    if runner.built is None:
        runner.frame(1, case.variant)
    tested = _pictures(runner, range(0, 2 * case.pairs, 2))
    runner.statistics = dict(tested[0].statistics)
    runner.columns += picture_errors([each.rgb.astype(np.float64) for each in tested], whole)
    flip, floor = (
        np.mean(each.values)
        for name in ("flip", "flip_floor")
        for each in runner.columns
        if each.quantity == name
    )
    runner.excess = float(flip - floor) / 1e6
    runner.forget()


def _pictures(runner: Runner, seeds: Iterable[int]) -> list[Layers]:
    made, built = runner.ready()
    return [trace(built, replace(made.quality, seed=each)) for each in seeds]


def _point(runner: Runner, case: Window) -> Point:
    where = {"kind": case.kind, "objects": case.objects, "field": case.field}
    named = {"arm": runner.arm.name, "setting": runner.setting}
    drawn = columns({name: [count] for name, count in runner.statistics.items()})
    times = (Column("us", row, {"stage": stage}) for stage, row in runner.times.items())
    return Point(where | named, samples=(*runner.columns, *drawn, *times))


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
