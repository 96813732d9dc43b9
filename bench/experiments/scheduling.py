"""How many parts of what moves need drawing again in a frame?

``updates`` schedules one frame of every field by each rule, from the window of earlier frames on
which it depends (``lod.update_schedule``): a crowd of walkers among trees in the wind, from a
camera that stands, walks, turns and flies. Then a small frame is rendered with a schedule and
without, in turns. (§2)
"""

import math
import time
from collections.abc import Iterator, Sequence
from functools import partial

import numpy as np

from bench.experiment import Experiment, Topic
from bench.images.differences import PIXELS_PER_DEGREE
from bench.plots import Curve, Plot, curves
from bench.records.claims import EXACT, Claim, at_most, claim
from bench.records.records import Column, Point, Record, columns, where
from bench.statistics.estimates import Estimate, exactly, two_sided_paired_ratio, two_sided_share
from lod.arrays import Reals
from lod.motion import critical_hz
from lod.pruner import prune
from lod.update_schedule import (
    WINDOW,
    DrawnState,
    TruePose,
    displacement_px,
    initial_state,
    replay,
    replay_frames,
    threshold_rule,
)
from scenes.frame.frame_input import DisplayedRepresentation, display
from scenes.presets.load import load_preset
from scenes.render.render import render_frame
from scenes.render.variants import choose
from scenes.scene import Scene, is_scheduled

# Cases and what is measured of them.

FPS = 24
FRAME = WINDOW + 8
THRESHOLDS = (0.25, 0.5, 1.0)
SPEEDS = (0.0, *(2.0**k for k in range(-6, 4)))
"""The edges of the classes of a part's own speed on the image [px a frame]."""

CROWD = (
    "render.size=320x180",
    "wind.speed=6",
    "species.figure.density=0.01",
    "species.figure.prototypes=4",
    "species.figure.sizes=[1.0]",
    "species.tree.density=0.0003",
    "species.tree.prototypes=2",
    "species.tree.sizes=[1.0]",
)
MOVES = {
    "rest": (),
    "walk-through": ("camera.speed=1.4",),
    "pan": ("camera.turn=90",),
    "fly-over": ("camera.speed=20", "camera.height=30", "camera.pitch=-20"),
}
TIMED = ("render.size=160x90", "render.spp=16", "render.max_depth=3")
TIMED_PX = 0.5


def measure_field(number: int, seed: int) -> list[Point]:
    """Schedule one frame of a field by every rule, for every camera."""
    presets = {
        move: load_preset("crowd", (*CROWD, *settings, f"seed={seed + number}"))
        for move, settings in MOVES.items()
    }
    still = Scene(presets["rest"])  # cameras are no part of its world
    return [
        Point(
            {"topic": "updates", "what": "schedule", "move": move},
            samples=counted(still.with_preset(preset)),
        )
        for move, preset in presets.items()
    ]


def _measure_times(rounds: int, variant: str, seed: int) -> Point:
    """Time frames that draw all parts and scheduled ones, in turns [µs of CPU time]."""
    common = (*CROWD, *TIMED, f"seed={seed}")
    scenes = {
        way: Scene(load_preset("crowd", (*common, f"view.update_threshold={px}")))
        for way, px in (("all", 0.0), ("scheduled", TIMED_PX))
    }
    found = dict[tuple[str, str], list[int]]()
    for number in range(rounds + 1):
        for way, scene in scenes.items():
            stages = _stage_seconds(scene, FRAME + number, variant)
            for stage, spent in stages.items() if number else ():  # the first is compiled
                found.setdefault((way, stage), []).append(round(1e6 * spent))
    times = (Column("cpu_us", t, {"way": way, "stage": s}) for (way, s), t in found.items())
    return Point({"topic": "updates", "what": "time", "move": "rest"}, samples=tuple(times))


def counted(scene: Scene) -> tuple[Column, ...]:
    """Count the parts that could move, those redrawn, and the farthest that a part is off.

    The farthest is in px/1000, by every threshold. Counts are also given by class of speed.
    """
    rules = {f"{t:g} px": threshold_rule(t) for t in THRESHOLDS}
    states: dict[str, list[DrawnState]] = {rule: [] for rule in rules}
    moved = []
    for each in _movers(scene, FRAME):
        frames = list(scene.poses(replay_frames(FRAME), each))
        for rule, state in zip(rules, replay(iter(frames), list(rules.values())), strict=True):
            states[rule].append(state)
        (before,) = replay(iter(frames[-2:-1]), [threshold_rule(0.0)])
        moved.append(displacement_px(before, frames[-1]))
    kind = np.searchsorted(SPEEDS, np.concatenate(moved), "right") - 1
    found = [Column("parts", [len(kind)])]
    found += (Column("parts", [int((kind == k).sum())], {"speed_from": s}) for k, s in _CLASSES)
    for rule, several in states.items():
        updated = np.concatenate([each.updated for each in several])
        off = max(float(each.error_px.max(initial=0)) for each in several)
        counts = {"redrawn": [int(updated.sum())], "off_mpx": [math.ceil(1000 * off)]}
        found += columns(counts, rule=rule)
        for k, speed in _CLASSES:
            again = [int(updated[kind == k].sum())]
            found.append(Column("redrawn", again, {"rule": rule, "speed_from": speed}))
    return tuple(found)


_CLASSES = tuple(enumerate(SPEEDS))


def _movers(scene: Scene, frame: int) -> list[DisplayedRepresentation]:
    view = scene.view(frame)
    shown = (display(each, prune(each, view), view) for each in scene.world.representations)
    return [each for each in shown if is_scheduled(each, scene.time_s(frame + 1))]


def _stage_seconds(scene: Scene, frame: int, variant: str) -> dict[str, float]:

    def posed(number: int) -> list[TruePose]:
        return [pose for each in shown for pose in scene.poses((number,), each)]

    clock = [time.process_time()]
    render_frame(scene.input(frame, variant), frame)
    clock.append(time.process_time())
    shown = _movers(scene, frame)
    drawn = [initial_state(each) for each in posed(frame - 1)]
    clock.append(time.process_time())
    now = posed(frame)
    clock.append(time.process_time())
    for before, after in zip(drawn, now, strict=True):
        displacement_px(before, after)
    clock.append(time.process_time())
    rendered, _, posing, deciding = np.diff(clock).tolist()
    return {"frame": rendered, "posing": posing, "deciding": deciding}


# Claims, from raw points alone.

_claim = partial(claim, source="derived: docs/method.md")


def _update_claims(points: Sequence[Point]) -> Iterator[Claim]:
    schedules = where(points, what="schedule")
    for threshold in THRESHOLDS if schedules else ():
        rule = f"{threshold:g} px"
        found = exactly(
            max(off_px(point, rule) for point in schedules),
            sum(len(point.column("parts")) for point in schedules),
        )
        estimand = "farthest distance of a part from its true place [px]"
        check = partial(_claim, unit=EXACT, kind="verification")
        yield check(estimand, at_most(threshold), {"τ": rule}, found)
    for point in schedules:
        told = {"camera": point.case["move"], "τ": "0.5 px"}
        found, estimand = redrawn(point, "0.5 px"), "share of the parts drawn again in a frame"
        yield _claim(estimand, at_most(0.5), told, found, unit="field", source="§2")
    for point in where(points, what="time"):
        every, kept = cpu_us(point, "all"), cpu_us(point, "scheduled")
        posing, deciding = (cpu_us(point, "all", stage) for stage in ("posing", "deciding"))
        for estimand, most, one, other in (
            ("CPU time of a frame, scheduled ÷ all drawn", 1, kept, every),
            ("CPU time, posing all that moves ÷ frame", 0.02, posing, every),
            ("CPU time, comparing with what was drawn ÷ posing", 1, deciding, posing),
        ):
            found, at = two_sided_paired_ratio(one, other), {"τ": f"{TIMED_PX:g} px"}
            yield _claim(estimand, at_most(most), at, found, unit="frame")


def redrawn(point: Point, rule: str) -> Estimate:
    """Estimate the share of the parts that a frame draws again by a rule."""
    return two_sided_share(point.values("redrawn", rule=rule), point.values("parts"))


def off_px(point: Point, rule: str) -> float:
    """Return the farthest that any part of any field is off [px]."""
    return float(point.values("off_mpx", rule=rule).max()) / 1000


def cpu_us(point: Point, way: str, stage: str = "frame") -> Reals:
    """Return the CPU time of a stage of every frame that is drawn in a way [µs]."""
    return point.values("cpu_us", way=way, stage=stage)


# Plots.

FINEST_CPD = PIXELS_PER_DEGREE / 2
"""The finest frequency that a display of so many pixels a degree can show."""


def plots(record: Record) -> tuple[Plot, ...]:
    """Draw how often parts of each class of speed are drawn again, and what the eye asks for."""
    (point,) = where(record.points, what="schedule", move="rest")
    classes = [c for c in point.samples if c.quantity == "parts" and c.keys]
    lows = [float(c.keys["speed_from"]) for c in classes if any(c.values)]
    lows = [low for low in lows if low > 0]
    speeds = [low * 2**0.5 for low in lows]  # the middle of a class that ends at twice its start
    drawn, words = [], []
    for threshold in THRESHOLDS:
        rule = f"{threshold:g} px"
        rates = [
            FPS
            * sum(point.column("redrawn", rule=rule, speed_from=low))
            / sum(point.column("parts", speed_from=low))
            for low in lows
        ]
        drawn.append(Curve(rule, speeds, rates))
        words.append(f"at {rule} {rates[0]:.2g} to {rates[-1]:.3g} updates a second")
    degrees = np.array(speeds) * FPS / PIXELS_PER_DEGREE
    eye = critical_hz(degrees, FINEST_CPD).tolist()
    drawn.append(Curve("ω_l + r·u_l (Watson & Ahumada)", speeds, eye))
    span = f"own speeds of {speeds[0]:.2g} to {speeds[-1]:.2g} pixels a frame"
    caption = (
        f"How often parts are drawn again, {FPS} frames/s, by threshold; {span}: "
        f"{'; '.join(words)}. The eye asks for {eye[0]:.0f} to {eye[-1]:.0f} (ω_l + r·u_l, Watson "
        f"& Ahumada 1983, at {PIXELS_PER_DEGREE:g} pixels a degree)."
    )
    axis = "own speed on the image (pixels a frame)", "updates a second"
    return (curves("updates", "When parts are drawn again", caption, axis, drawn),)


EXPERIMENT = Experiment(
    name="scheduling",
    question="How many parts of what moves need drawing again in a frame?",
    version=1,
    topics={
        "updates": Topic(
            about="how often parts are drawn again, how far off the others are, what is saved",
            cases=lambda fields, rounds: [
                *(partial(measure_field, number) for number in range(fields)),
                partial(_measure_times, rounds, choose()),
            ],
            claims=_update_claims,
            plots=plots,
            full={"fields": 8, "rounds": 6},
            quick={"fields": 3, "rounds": 3},
            seconds=(140.0, 90.0),
        )
    },
    rendered=True,
    caveats=(
        "A crowd among trees in wind of 6 m/s, 320 pixels wide, 24 frames a second: shares grow "
        "with the picture.",
        "Every frame is scheduled by itself, so that frames may come in any order: nothing of a "
        "frame is kept in memory for the next, and time can only be lost.",
    ),
    order=160,
)
