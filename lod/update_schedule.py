"""When a part is drawn again: once it has moved too far on the image since it was drawn (§2).

The paper's temporal priority, left to the future in §5.2, taken literally: that of a part is the
farthest that an end of any of its sticks is, seen from the eye, from where it was last drawn, in
pixels. ``docs/method.md`` says what that enforces: no part is ever shown farther from its place
than the threshold says, and a frame's state follows from its number alone, by replaying the WINDOW
of frames in which every part has had its turn.
"""

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from lod.arrays import ArrayData, FlagArray, Flags, FloatArray, IntArray, Ints, Reals
from lod.kernels import njit
from lod.shapes import Sticks

WINDOW = 32
"""Frames in which every part is updated at least once: the state of a frame depends on no more
frames before it."""

UpdateRule = Callable[[Reals], Flags]
"""A function from the displacement of every part (p,) [px] to whether it is updated, (p,)."""


@dataclass(frozen=True, eq=False)
class DrawnState(ArrayData):
    """Sticks (s,) of parts (p,) as they are drawn in a frame.

    start, end       (s, 3) ends of the sticks [m]
    displacement_px  (p,) distance of each part from where it was drawn before [px]
    error_px         (p,) the same distance after the update: 0 for updated parts [px]
    updated          (p,) whether the part is drawn at its true pose in this frame
    """

    start: FloatArray
    end: FloatArray
    displacement_px: FloatArray
    error_px: FloatArray
    updated: FlagArray


@dataclass(frozen=True, eq=False)
class TruePose(ArrayData):
    """Sticks (s,) of parts (p,) at their true pose in a frame, and the eye that sees them.

    start, end   (s, 3) ends of the sticks [m]
    owner        (s,) row of the part of each stick
    refresh_due  (p,) whether the part is updated whatever its displacement
    eye          (3,) [m]
    theta        angle of one pixel [rad]
    """

    start: FloatArray
    end: FloatArray
    owner: IntArray
    refresh_due: FlagArray
    eye: FloatArray
    theta: float


def threshold_rule(threshold_px: float) -> UpdateRule:
    """Return the rule that updates every part displaced by more than a threshold [px]."""
    return lambda moved: moved > threshold_px


def initial_state(now: TruePose) -> DrawnState:
    """Return the state of the first frame: every part is drawn at its true pose."""
    zero = np.zeros(len(now.refresh_due))
    return DrawnState(now.start, now.end, zero, zero, np.ones(len(now.refresh_due), bool))


def step(before: DrawnState, now: TruePose, rule: UpdateRule) -> DrawnState:
    """Advance by one frame: update the parts that the rule chooses, and those due."""
    moved = displacement_px(before, now)
    redrawn = rule(moved) | now.refresh_due
    sticks = redrawn[now.owner][:, None]
    start = np.where(sticks, now.start, before.start)
    end = np.where(sticks, now.end, before.end)
    return DrawnState(start, end, moved, np.where(redrawn, 0.0, moved), redrawn)


def displacement_px(drawn: DrawnState, now: TruePose) -> Reals:
    """Compute the distance of parts from where they were drawn, as the eye sees it now, (p,) [px].

    The angle between two directions, exact for the least of them (Kahan), is
    2·atan2(|û − v̂|, |û + v̂|), here of |v|·u and |u|·v.
    """
    moved = np.zeros(len(now.refresh_due))
    _farthest(drawn.start, now.start, now.owner, now.eye, moved)
    _farthest(drawn.end, now.end, now.owner, now.eye, moved)
    return moved / now.theta


@njit(cache=True)
def _farthest(old, new, owner, eye, moved):  # type: ignore[no-untyped-def]
    """Raises ``moved`` (p,) [rad] to the largest angle that any place of a part has moved by."""
    for i in range(len(owner)):
        same, before, after = True, 0.0, 0.0
        for c in range(3):
            same = same and old[i, c] == new[i, c]
            before += (old[i, c] - eye[c]) ** 2
            after += (new[i, c] - eye[c]) ** 2
        if same:
            continue
        before, after, apart, along = math.sqrt(before), math.sqrt(after), 0.0, 0.0
        for c in range(3):
            u, v = (old[i, c] - eye[c]) * after, (new[i, c] - eye[c]) * before
            apart += (u - v) ** 2
            along += (u + v) ** 2
        angle = 2 * math.atan2(math.sqrt(apart), math.sqrt(along))
        moved[owner[i]] = max(moved[owner[i]], angle)


def replay_frames(frame: int) -> range:
    """List the frames, from 1, on which the state of ``frame`` depends; it is the last of them."""
    return range(max(1, frame - WINDOW + 1), frame + 1)


def replay(frames: Iterator[TruePose], rules: Sequence[UpdateRule]) -> list[DrawnState]:
    """Return the state of the last of these frames under each of the rules."""
    first = next(frames)
    states = [initial_state(first) for _ in rules]
    for now in frames:
        states = [step(state, now, rule) for state, rule in zip(states, rules, strict=True)]
    return states


def apply_state(drawn: DrawnState, sticks: Sticks) -> Sticks:
    """Replace the ends of sticks whose part is not updated by the ends as they were drawn."""
    redrawn = drawn.updated[sticks.owner][:, None]
    start = np.where(redrawn, sticks.start, drawn.start)
    return replace(sticks, start=start, end=np.where(redrawn, sticks.end, drawn.end))


def refresh_due(part: Ints, frame: int) -> Flags:
    """Tell whether each part (p,) is due in a frame: once in WINDOW frames, spread over them."""
    return (part + frame) % WINDOW == 0
