"""How a scene acts, frame by frame: cues of the script, then behaviours, the most urgent first.

With a threshold, an actor is updated when it may be off by more than that on the image
(``scenes.actors.urgency``), or has coasted for ``LONGEST_COAST_S``, or is sent a message: whoever
is asked is brought up to date first. With a budget no more than so many are, the most urgent first.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from lod.actors.message import Message, ask, change
from lod.arrays import Flags, Reals
from scenes.actors.behaviour import Process
from scenes.actors.performance import ActedFrame, Eye, Held, X
from scenes.actors.stage import CAMERA, Stage, Standings
from scenes.actors.urgency import Lens, Restlessness, bound_px
from scenes.rig.rigged_prototype import RiggedPrototype

LONGEST_COAST_S = 1.0
"""Longest time between two updates [s]."""

DEEPEST = 16
"""How many who are asked while they ask others are brought up to date; the next one coasts."""


@dataclass(frozen=True)
class Rules:
    """Which actors are updated in a frame.

    threshold  [px] beyond which an actor is updated; 0 = everyone in every frame
    budget     of updates in a frame; None = as many as are due
    """

    threshold: float = 0.0
    budget: int | None = None


class Acting:
    """A scene that acts: its stage, its processes and its clock.

    processes  of the actors by name, of those that have a behaviour; and of the camera
    cues       of the script, in their order
    path       where the preset has the camera in a frame
    rules      may be replaced between two frames
    """

    def __init__(
        self,
        stage: Stage,
        prototypes: Sequence[RiggedPrototype],
        processes: Mapping[str, Process],
        cues: Sequence[Process],
        rules: Rules,
        lens: Lens,
        path: Callable[[float], Eye],
        fps: float,
    ) -> None:
        self.stage, self._processes, self._cues = stage, processes, cues
        self.rules, self._lens, self._path, self._fps = rules, lens, path, fps
        self._names: tuple[str, ...] = stage.names()
        self._row = {name: row for row, name in enumerate(self._names)}
        self._acts = np.array([name in processes for name in self._names], bool)
        self._bodies = Restlessness.of(prototypes)
        self._frame, self._now = 0, 0.0
        self._last = np.full(len(self._names), -math.inf)
        self._held: Held = {}
        self._updated: set[str] = set()
        self._depth = 0

    def act(self) -> ActedFrame:
        """Act the next frame. Raises InputError, in one line, for what goes wrong in it."""
        self._frame += 1
        self._now = (self._frame - 1) / self._fps
        self._updated = set()
        self._send(change("", "begin", self._now, self._path(self._frame)))
        for each in self._cues:
            each.update(self.stage, self._now, self._attend)
        for name in self._due():
            self._update(name)
        if CAMERA in self._processes:  # last: whom it follows has moved
            self._processes[CAMERA].update(self.stage, self._now, self._attend)
        stand: Standings = self._send(ask("", "standings"))
        moved = self._send(ask(CAMERA, "moved"))
        eye: Eye = self._send(ask(CAMERA, "eye"))
        self._held = stand.held
        updated = np.array([name in self._updated for name in self._names], bool)
        off = np.where(updated, 0.0, self._bounds(stand)[0])
        return ActedFrame(stand.places, updated, off, stand.held, eye if moved else None)

    def _due(self) -> list[str]:
        """List who is to be updated, the most urgent first."""
        stand: Standings = self._send(ask("", "standings"))
        acts = self._acts & np.isfinite(stand.places[:, X])
        urgency = self._bounds(stand)[1]
        if self.rules.threshold == 0:
            order = np.flatnonzero(acts)
        else:
            due: Flags = acts & (urgency > self.rules.threshold)
            due |= acts & (self._now - self._last >= LONGEST_COAST_S - 1e-9)
            restless = [row for row, held in stand.held.items() if self._held.get(row) != held]
            due[restless] = acts[restless]
            order = np.flatnonzero(due)[np.argsort(-urgency[due], kind="stable")]
        return [self._names[row] for row in order[: self.rules.budget].tolist()]

    def _bounds(self, stand: Standings) -> tuple[Reals, Reals]:
        eye: Eye = self._send(ask(CAMERA, "eye"))
        px, urgency = bound_px(self._bodies, stand, self._now, eye, self._lens)
        return np.where(self._acts, np.nan_to_num(px), 0.0), np.nan_to_num(urgency)

    def _attend(self, name: str) -> None:
        """Bring whoever is asked up to date first, unless that one asks just now."""
        if name in self._row and self._depth < DEEPEST:
            self._update(name)

    def _update(self, name: str) -> None:
        if name in self._updated or name not in self._processes:
            return
        self._updated.add(name)
        self._last[self._row[name]] = self._now
        self._depth += 1
        try:
            self._processes[name].update(self.stage, self._now, self._attend)
        finally:
            self._depth -= 1

    def _send(self, message: Message):  # type: ignore[no-untyped-def]
        return self.stage.receive(message).value
