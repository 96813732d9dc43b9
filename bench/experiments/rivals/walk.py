"""What moves in a sequence that does not move in the whole one?

Each arm walks through one window at its setting nearest to equal error. Every frame has the same
seed as the whole world's, so that noise is the same where the same is displayed. ``flip`` is the
difference of a frame; ``residual`` is what changes from frame to frame beside what the whole
changes: the mean over pixels and colours of |ΔT − ΔW|, of pictures as they are displayed. Where
ColorVideoVDP is here, it judges the sequences too.
"""

import math

import numpy as np

from bench.arms.plain_arms import CLIPPED
from bench.arms.registry import arms
from bench.experiments.fidelity.equal_error import EQUAL_ERROR
from bench.experiments.rivals.turns import Runner, prepared_runner
from bench.experiments.rivals.windows import JUDGED, Walk
from bench.outside.environments import VIDEO
from bench.outside.video import just_objectionable_differences
from bench.records.points import Column, Point
from bench.statistics.excess_flip import mean_flip
from scenes.preset.tables import Preset
from scenes.render.pictures.tone_map import auto_exposure, to_srgb
from scenes.world.world import build_world

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
