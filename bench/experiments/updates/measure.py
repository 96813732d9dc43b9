"""How often must parts be drawn again, how far off are those that are not, and what is won? (§2)

The scene is a crowd of walkers among trees in the wind, from a camera that stands, walks, turns and
flies. One frame of every field is scheduled by each rule, from the window of earlier frames on
which it depends (``lod.update_schedule``). Then a small frame is rendered with a schedule
and without, in turns.
"""

import math
import time
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from bench.old_experiment import Effort
from bench.records.provenance import scene_digest
from bench.records.records import Column, Key, Point
from lod.pruner import prune
from lod.update_schedule import (
    WINDOW,
    TruePose,
    budget_rule,
    displacement_px,
    initial_state,
    replay,
    replay_frames,
    threshold_rule,
)
from scenes.frame.frame_input import DisplayedRepresentation, display
from scenes.presets.load import load_preset
from scenes.presets.schema import Preset
from scenes.render.render import render_frame
from scenes.render.variants import choose
from scenes.scene import assemble_frame, frame_time, is_scheduled, poses_over, view_at
from scenes.world.world import World, build_world

FRAME = WINDOW + 8
THRESHOLDS = (0.25, 0.5, 1.0)
BUDGET = 0.1
"""The share of the parts that the rule of a budget draws anew."""

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


@dataclass(frozen=True)
class Field:
    """A field whose updates are counted; its number is added to the run's seed."""

    number: int


@dataclass(frozen=True)
class Timing:
    """The number of rounds of frames that are timed, and the variant that renders them."""

    rounds: int
    variant: str


def cases(effort: Effort) -> list[Field | Timing]:
    """Return as many fields as the effort says, then the frames that are timed."""
    return [*map(Field, range(effort["fields"])), Timing(effort["rounds"], choose())]


def measure(case: Field | Timing, seed: int) -> Point | list[Point]:
    """Measure one frame of a field by every rule, or time frames."""
    if isinstance(case, Timing):
        return timed(case.rounds, case.variant, seed)
    return schedule(seed + case.number)


def schedule(seed: int) -> list[Point]:
    """Schedule one frame of a field by every rule, for every camera."""
    presets = {
        move: load_preset("crowd", (*CROWD, *settings, f"seed={seed}"))
        for move, settings in MOVES.items()
    }
    world = build_world(presets["rest"])  # cameras are no part of it
    return [
        Point({"what": "schedule", "move": move}, samples=counted(world, preset))
        for move, preset in presets.items()
    ]


def counted(world: World, preset: Preset) -> tuple[Column, ...]:
    """Count the parts that could move, those drawn anew, and the farthest that a part is off.

    The farthest is in px/1000, by every rule. Counts are also given by class of speed.
    """
    shown, numbers = movers(world, preset, FRAME), replay_frames(FRAME)
    made = [poses_over(world, preset, numbers, each) for each in shown]
    frames = [_together(each) for each in zip(*made, strict=True)]
    last, parts = frames[-1], len(frames[-1].refresh_due)
    rules = {f"{t:g} px": threshold_rule(t) for t in THRESHOLDS}
    rules["budget"] = budget_rule(round(BUDGET * parts))
    states = dict(zip(rules, replay(iter(frames), list(rules.values())), strict=True))
    (before,) = replay(iter(frames[-2:-1]), [threshold_rule(0.0)])
    kind = np.searchsorted(SPEEDS, displacement_px(before, last), "right") - 1
    found = [Column("parts", [parts])]
    for rule, state in states.items():
        farthest = math.ceil(1000 * float(state.error_px.max(initial=0)))
        found.append(Column("redrawn", [int(state.updated.sum())], {"rule": rule}))
        found.append(Column("off_mpx", [farthest], {"rule": rule}))
    for k, low in enumerate(SPEEDS):
        mine = kind == k
        found.append(Column("parts", [int(mine.sum())], {"speed_from": low}))
        for rule, state in states.items():
            keys: dict[str, Key] = {"rule": rule, "speed_from": low}
            found.append(Column("redrawn", [int(state.updated[mine].sum())], keys))
    return tuple(found)


def movers(world: World, preset: Preset, frame: int) -> list[DisplayedRepresentation]:
    """Return what a frame displays of every representation whose parts may stay as drawn."""
    view, found = view_at(world, preset, frame), []
    for each in world.representations:
        shown = display(each, prune(each, view), view)
        if is_scheduled(shown, frame_time(preset, frame + 1)):
            found.append(shown)
    return found


def _together(several: Sequence[TruePose]) -> TruePose:
    """Join the poses of several representations at one moment: a budget is for all of them."""
    first = np.cumsum([0] + [len(each.refresh_due) for each in several])[:-1]
    owners = [each.owner + row for each, row in zip(several, first.tolist(), strict=True)]
    return TruePose(
        start=np.concatenate([each.start for each in several]),
        end=np.concatenate([each.end for each in several]),
        owner=np.concatenate(owners),
        refresh_due=np.concatenate([each.refresh_due for each in several]),
        eye=several[0].eye,
        theta=several[0].theta,
    )


def timed(rounds: int, variant: str, seed: int) -> Point:
    """Time frames that draw all parts and frames that are scheduled, in turns [µs of CPU time]."""
    ways = {"all": 0.0, "scheduled": TIMED_PX}
    presets = {
        name: load_preset("crowd", (*CROWD, *TIMED, f"seed={seed}", f"view.update_threshold={t}"))
        for name, t in ways.items()
    }
    world, found = build_world(presets["all"]), dict[tuple[str, str], list[int]]()
    for number in range(rounds + 1):
        for name, preset in presets.items():
            stages = _stages(world, preset, FRAME + number, variant)
            for stage, seconds in stages.items() if number else ():  # the first is compiled
                found.setdefault((name, stage), []).append(round(1e6 * seconds))
    times = (Column("cpu_us", t, {"way": way, "stage": s}) for (way, s), t in found.items())
    return Point({"what": "time", "move": "rest"}, samples=tuple(times))


def _stages(world: World, preset: Preset, frame: int, variant: str) -> dict[str, float]:
    """Time a frame, all that precedes rendering, posing what may stay, and comparing it [s]."""
    clock = [time.process_time()]
    made = assemble_frame(world, preset, frame, variant)
    clock.append(time.process_time())
    render_frame(made, frame)
    clock.append(time.process_time())
    shown = movers(world, preset, frame)
    drawn = [initial_state(each) for each in _posed(world, preset, frame - 1, shown)]
    clock.append(time.process_time())
    now = _posed(world, preset, frame, shown)
    clock.append(time.process_time())
    for before, after in zip(drawn, now, strict=True):
        displacement_px(before, after)
    clock.append(time.process_time())
    shot, rendered, _, posed, decided = np.diff(clock).tolist()
    stages = {"before rendering": shot, "posing": posed, "deciding": decided}
    return {"frame": shot + rendered, **stages}


def _posed(
    world: World, preset: Preset, frame: int, shown: Sequence[DisplayedRepresentation]
) -> list[TruePose]:
    """Return the true poses of what is displayed in a frame."""
    return [each for one in shown for each in poses_over(world, preset, (frame,), one)]


def scene_hash(points: tuple[Point, ...]) -> str:
    """Return the SHA-256 of the preset and of every case."""
    preset = load_preset("crowd", CROWD).model_dump(mode="json")
    words = [preset, MOVES, TIMED, TIMED_PX, FRAME, THRESHOLDS, BUDGET, SPEEDS]
    return scene_digest(words)
