"""What the actors of a scene do, frame by frame, as the pruner and the camera read it."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from lod.actors.vectors import Components
from lod.arrays import ArrayData, FlagArray, FloatArray
from lod.errors import InputError

X, Y, YAW, PHASE, STRIDE_FACTOR, EIGHTHS = range(6)
"""Columns of ``ActedFrame.places``, as in ``scenes.actors.body.Posture``."""

Held = dict[int, tuple[tuple[int, Components], ...]]
"""By the number of an actor: joints that messages hold, with their orientations."""


class Eye(NamedTuple):
    """Where the camera is, by messages: place [m], height above the ground, and view [degrees]."""

    x: float
    y: float
    height: float
    heading: float
    pitch: float


@dataclass(frozen=True, eq=False)
class ActedFrame(ArrayData):
    """How n actors stand in one frame.

    places    (n, 6) in the columns X to EIGHTHS; a row of NaN has left
    updated   (n,) whose behaviour was run for this frame; the others coast
    bound_px  (n,) by how much a part of each may be off on the image, for coasting [px]
    held      joints that messages hold
    eye       where messages put the camera; None = where the preset has it
    """

    places: FloatArray
    updated: FlagArray
    bound_px: FloatArray
    held: Held
    eye: Eye | None = None


class Performance:
    """The frames of a scene's actors, from frame 1; those that are not there yet are acted.

    act  makes the next frame; None where all frames are there
    """

    def __init__(
        self,
        names: Sequence[str],
        frames: Sequence[ActedFrame] = (),
        act: Callable[[], ActedFrame] | None = None,
        most: int = 10**6,
    ) -> None:
        self.names, self.most = tuple(names), most
        self._frames, self._act = list(frames), act

    def frame(self, number: int) -> ActedFrame:
        """Return a frame. Raises InputError for one in which nobody acts."""
        if not 1 <= number <= self.most + 1:
            cure = f"add -D acting.frames={number}, or ask for frames from 1 to {self.most}"
            raise InputError("--frames", number, f"the actors act in frames 1 to {self.most}", cure)
        while len(self._frames) < number and self._act is not None:
            self._frames.append(self._act())
        return self._frames[number - 1]

    def all_frames(self) -> tuple[ActedFrame, ...]:
        """Return all frames, and the one after the last, which motion ends in."""
        return tuple(self.frame(number) for number in range(1, self.most + 2))

    def between(self, at: float) -> ActedFrame:
        """Return how actors stand at a frame or between two; before the first, they go backwards.

        Places go straight, and everything turns the shorter way round.
        """
        first = max(1, min(int(np.floor(at)), self.most))
        share, a = at - first, self.frame(first)
        if share == 0.0:
            return a
        b = self.frame(first + 1)
        change = b.places - a.places
        change[:, YAW] = _within(change[:, YAW], 2 * np.pi)
        change[:, PHASE] = _within(change[:, PHASE], 1.0)
        places = a.places + share * change
        places[:, EIGHTHS] = a.places[:, EIGHTHS]
        gone = np.isnan(places)
        places[gone] = a.places[gone]
        held = {}
        for actor, rows in a.held.items():
            then = dict(b.held.get(actor, ()))
            held[actor] = tuple((row, _between(turn, then.get(row), share)) for row, turn in rows)
        eye = a.eye
        if a.eye is not None and b.eye is not None:
            way = np.subtract(b.eye, a.eye)
            way[3] = _within(way[3:4], 360.0)[0]
            eye = Eye(*(np.array(a.eye) + share * way).tolist())
        return ActedFrame(places, a.updated, a.bound_px, held, eye)


def _within(change: np.ndarray, whole: float) -> np.ndarray:
    """Give changes the shorter way round."""
    return change - whole * np.round(change / whole)


def _between(a: Components, b: Components | None, share: float) -> Components:
    """Interpolate between two orientations on the chord, the shorter way round."""
    if b is None or a == b:
        return a
    sign = np.copysign(1.0, np.dot(a, b))
    q = (1 - share) * np.array(a) + share * sign * np.array(b)
    x, y, z, w = (q / np.linalg.norm(q)).tolist()
    return x, y, z, w
