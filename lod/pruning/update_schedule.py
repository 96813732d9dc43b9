"""When a part must be drawn again: when it has moved too far on the image since it last was (§2).

The paper's temporal priority, left to the future in §5.2, taken literally: that of a part is the
farthest that an end of any of its sticks is, seen from the eye, from where it was last drawn, in
pixels. It is measured between two places in world space from one eye, so that the camera's own
motion never counts, nor its end. A part past the threshold is drawn anew and the others are kept:
no part is ever shown farther from its place than the threshold says. Where there is only time for
some, the most urgent go first, and the rest are as far off as they are.

A frame's state follows from its number alone, by replaying the WINDOW of frames in which every part
has had its turn: frames may be rendered in any order, on any machine.
"""

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numba import njit

from lod.arrays import Flags, Ints, Reals, freeze
from lod.pruning.shapes import Sticks

WINDOW = 32
"""Frames after which every part is drawn anew, due or not: the state of a frame depends on no more
frames before it."""

UpdateRule = Callable[[Reals], Flags]
"""From how far each part is off (p,) [px] to whether it is drawn anew, (p,)."""


@dataclass(frozen=True, eq=False)
class DrawnState:
    """Sticks as they stand in the picture.

    start, end (s, 3) [m]; moved, off (p,): how far each part was off before and is after some were
    drawn anew [px]; anew (p,) which
    """

    start: np.ndarray
    end: np.ndarray
    displacement_px: np.ndarray
    error_px: np.ndarray
    updated: np.ndarray

    def __post_init__(self) -> None:
        freeze(self, start=np.float64, end=np.float64)
        freeze(self, displacement_px=np.float64, error_px=np.float64, updated=bool)


@dataclass(frozen=True, eq=False)
class TruePose:
    """Sticks (s,) of parts (p,) as they truly are in a frame, and where they are seen from.

    start, end (s, 3) [m]; owner (s,) row of the part; due (p,) parts that are drawn anew whatever
    they have moved; eye (3,) [m]; theta: angle of a pixel [rad]
    """

    start: np.ndarray
    end: np.ndarray
    owner: np.ndarray
    refresh_due: np.ndarray
    eye: np.ndarray
    theta: float

    def __post_init__(self) -> None:
        freeze(self, start=np.float64, end=np.float64, eye=np.float64)
        freeze(self, owner=np.int64, refresh_due=bool)


def threshold_rule(threshold_px: float) -> UpdateRule:
    """The rule of a threshold."""
    return lambda moved: moved > threshold_px


def budget_rule(budget: int) -> UpdateRule:
    """The rule of a budget: those that have moved farthest, at most so many; in their order where
    two are as far.
    """

    def rule(moved: Reals) -> Flags:
        first = np.argsort(-moved, kind="stable")[:budget]
        chosen = np.zeros(len(moved), bool)
        chosen[first] = moved[first] > 0
        return chosen

    return rule


def initial_state(now: TruePose) -> DrawnState:
    """The first frame of all: everything is where it is."""
    zero = np.zeros(len(now.refresh_due))
    return DrawnState(now.start, now.end, zero, zero, np.ones(len(now.refresh_due), bool))


def step(before: DrawnState, now: TruePose, rule: UpdateRule) -> DrawnState:
    """One frame on: from what was drawn to what is drawn, by a rule."""
    moved = displacement_px(before, now)
    anew = rule(moved) | now.refresh_due
    sticks = anew[now.owner][:, None]
    start = np.where(sticks, now.start, before.start)
    end = np.where(sticks, now.end, before.end)
    return DrawnState(start, end, moved, np.where(anew, 0.0, moved), anew)


def displacement_px(drawn: DrawnState, now: TruePose) -> Reals:
    """How far parts are from where they were drawn, seen from the eye now, (p,) [px].

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
    """The frames, from 1, that what ``frame`` draws depends on, itself the last."""
    return range(max(1, frame - WINDOW + 1), frame + 1)


def replay(frames: Iterator[TruePose], rules: Sequence[UpdateRule]) -> list[DrawnState]:
    """What the last of these frames draws, by each of the rules."""
    first = next(frames)
    states = [initial_state(first) for _ in rules]
    for now in frames:
        states = [step(state, now, rule) for state, rule in zip(states, rules, strict=True)]
    return states


def apply_state(drawn: DrawnState, sticks: Sticks) -> Sticks:
    """Sticks as they are at some moment of a frame, those of parts that it keeps as drawn."""
    anew = drawn.updated[sticks.owner][:, None]
    start = np.where(anew, sticks.start, drawn.start)
    return replace(sticks, start=start, end=np.where(anew, sticks.end, drawn.end))


def refresh_due(part: Ints, frame: int) -> Flags:
    """Parts (p,) whose turn it is in a frame: each once in WINDOW frames, spread over them all."""
    return (part + frame) % WINDOW == 0
