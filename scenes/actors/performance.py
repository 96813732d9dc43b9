"""What the actors of a scene do, frame by frame, as the pruner and the camera read it.

A pose track has all that actors do in all frames, as arrays, with a hash of them. Frames are
replayed from it in any order. The numbers that act may differ in their last bits between
processors; those of one track do not.

The pruner sees a cast: actors posed as they answered, by a crowd's own walk. Those of one model
that stand alike but for place and phase share a row of the tables; what holds a limb by a message
has a row of its own, whose motion has that limb at rest where it is held.
"""

import hashlib
import io
import json
import zipfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache, partial
from typing import Any, NamedTuple

import numpy as np

from lod.arrays import ArrayData, FlagArray, FloatArray
from lod.camera import GRID_M, Corner
from lod.errors import InputError
from lod.pruner import BlendWeights, Cut, Parts
from lod.shapes import Sticks
from lod.view import View
from scenes.field.prototypes import (
    InstancesInView,
    SpeciesPrototypes,
    instances_in_view,
    shutter_times,
    species_prototypes,
)
from scenes.ground.relief import Ground
from scenes.rig.foot_placement import Placements, place_on_ground
from scenes.rig.pose import Instances
from scenes.rig.rigged_prototype import RiggedPrototype

X, Y, YAW, PHASE, STRIDE_FACTOR, EIGHTHS = range(6)
"""Columns of ``ActedFrame.places``, as in ``scenes.actors.body.Posture``."""

Components = tuple[float, float, float, float]
"""Of a quaternion, as ``lod.actors.actor`` has them; that module loads Dr.Jit."""

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
    return change - whole * np.round(change / whole)


def _between(a: Components, b: Components | None, share: float) -> Components:
    if b is None or a == b:
        return a
    sign = np.copysign(1.0, np.dot(a, b))
    q = (1 - share) * np.array(a) + share * sign * np.array(b)
    x, y, z, w = (q / np.linalg.norm(q)).tolist()
    return x, y, z, w


_NAMES = ("places", "updated", "bound_px", "eye", "held_at", "held_turn")


class Track(NamedTuple):
    """The frames 1 to F + 1 of n actors; rows of ``held`` are limbs that messages hold.

    places (F + 1, n, 6), updated and bound_px (F + 1, n): as in ActedFrame
    eye (F + 1, 5): NaN where the camera is as the preset has it
    held_at (h, 3): frame − 1, actor and joint; held_turn (h, 4)
    """

    names: tuple[str, ...]
    places: np.ndarray
    updated: np.ndarray
    bound_px: np.ndarray
    eye: np.ndarray
    held_at: np.ndarray
    held_turn: np.ndarray

    @property
    def digest(self) -> str:
        """Compute the SHA-256 of names, shapes and numbers, in little-endian order."""
        found = hashlib.sha256(json.dumps(self.names).encode())
        for array in self[1:]:
            found.update(f"\n{array.dtype.name} {array.shape}\n".encode())
            found.update(array.astype(array.dtype.newbyteorder("<"), copy=False).tobytes())
        return found.hexdigest()


def track_of(performance: Performance) -> Track:
    """Act all frames, and the one after the last, which motion ends in; lay them out as arrays."""
    frames = [performance.frame(number) for number in range(1, performance.most + 2)]
    held = [
        ((frame, actor, joint), turn)
        for frame, each in enumerate(frames)
        for actor in sorted(each.held)
        for joint, turn in each.held[actor]
    ]
    size = len(frames), len(performance.names)
    return Track(
        performance.names,
        np.array([each.places for each in frames]).reshape(*size, 6),
        np.array([each.updated for each in frames]).reshape(size),
        np.array([each.bound_px for each in frames]).reshape(size),
        np.array([each.eye or (np.nan,) * 5 for each in frames], np.float64),
        np.array([at for at, _ in held], np.int64).reshape(-1, 3),
        np.array([turn for _, turn in held], np.float64).reshape(-1, 4),
    )


def performance_of(track: Track) -> Performance:
    """Return the frames of a track."""
    held: list[Held] = [{} for _ in track.places]
    for (frame, actor, joint), turn in zip(
        track.held_at.tolist(), track.held_turn.tolist(), strict=True
    ):
        x, y, z, w = turn
        held[frame][actor] = (*held[frame].get(actor, ()), (joint, (x, y, z, w)))
    frames = [
        ActedFrame(places, updated, bound, limbs, None if np.isnan(eye[0]) else Eye(*eye.tolist()))
        for places, updated, bound, eye, limbs in zip(*track[1:5], held, strict=True)
    ]
    return Performance(track.names, frames, None, len(frames) - 1)


def to_bytes(track: Track) -> bytes:
    """Pack a track, with its hash."""
    target = io.BytesIO()
    found: dict[str, Any] = dict(zip(_NAMES, track[1:], strict=True))
    found |= {"names": json.dumps(track.names), "sha256": track.digest, "by": "lodbench"}
    np.savez_compressed(target, **found)
    return target.getvalue()


def from_bytes(data: bytes) -> Track:
    """Unpack a track. Raises ValueError for what is none, or is not as it was written."""
    try:
        with np.load(io.BytesIO(data), allow_pickle=False) as file:
            names = tuple(json.loads(str(file["names"])))
            track = Track(names, *(file[name] for name in _NAMES))
            digest = str(file["sha256"])
    except (OSError, EOFError, KeyError, zipfile.BadZipFile) as error:
        raise ValueError(str(error)) from error
    if track.digest != digest:
        raise ValueError("its numbers do not have the hash that it says")
    return track


@dataclass(frozen=True, eq=False)
class Standing:
    """How actors stand at one moment.

    actor       (n,) number of each
    places      (n, 6) as in ActedFrame
    prototypes  the poses that occur
    row         (n,) which of them each has
    """

    actor: np.ndarray
    places: np.ndarray
    prototypes: SpeciesPrototypes
    row: np.ndarray


@dataclass(frozen=True, eq=False)
class Cast:
    """A Representation: the live actors of a scene.

    prototypes  (n,) of each actor
    fps         frames a second
    """

    performance: Performance
    prototypes: tuple[RiggedPrototype, ...]
    ground: Ground
    fps: float
    name: str = "actors"

    def name_of(self, cut: Cut, row: int) -> str:
        """Return the name of the actor in a row of the objects of a cut."""
        standing: Standing = cut.parts.state.samples
        return self.performance.names[int(standing.actor[row])]

    def roots(self, view: View) -> Parts:
        objects = self._in_view(view)
        return objects.samples.prototypes.wholes(objects, view)

    def cut(self, view: View) -> Cut:
        objects = self._in_view(view)
        return objects.samples.prototypes.cut(objects, view, len(objects))

    def parts_of(self, parts: Parts, view: View) -> Parts:
        return parts.state.samples.prototypes.parts_of(parts, view)

    def appearance(self, parts: Parts, weights: BlendWeights) -> Sticks:
        return parts.state.samples.prototypes.appearance(parts, weights)

    def later(self, parts: Parts, view: View, time_s: float) -> Parts:
        """Return the same parts, posed as they are at another time [s]."""
        before: Standing = parts.state.samples
        then = self._standing(time_s, before)
        instances = self._placed(then, view.camera.corner)
        first, now = (each.prototypes.part_tables.root[each.row] for each in (before, then))
        part = parts.part + (now - first)[parts.object]
        state = InstancesInView(instances, then, parts.state.motion_step)
        return replace(parts, part=part, state=state)

    def _in_view(self, view: View) -> InstancesInView:
        now = self._standing(view.time_s)
        placed = []
        for time_s in shutter_times(view):
            there = replace(self._standing(time_s, now), prototypes=now.prototypes, row=now.row)
            placed.append(self._placed(there, view.camera.corner))
        return instances_in_view(now.prototypes, now, view, placed)

    def _standing(self, time_s: float, before: Standing | None = None) -> Standing:
        """Find how actors stand at a time; those of ``before``, where it is given, in their order.

        Of those who have left since, as they stood.
        """
        acted = self.performance.between(1 + time_s * self.fps)
        actor = before.actor if before else np.flatnonzero(np.isfinite(acted.places[:, X]))
        places = acted.places[actor]
        if before is not None:
            places = np.where(np.isfinite(places), places, before.places)
        eighths = places[:, EIGHTHS].astype(int).tolist()
        variants = [
            posed_prototype(self.prototypes[k], share, acted.held.get(k, ()))
            for k, share in zip(actor.tolist(), eighths, strict=True)
        ]
        rows = {each: row for row, each in enumerate(dict.fromkeys(variants))}
        row = np.array([rows[each] for each in variants], np.int64)
        return Standing(actor, places, species_prototypes(tuple(rows)), row)

    def _placed(self, standing: Standing, corner: Corner) -> Instances:
        places = standing.places
        xy = places[:, (X, Y)] - np.array((corner.x, corner.y)) * GRID_M
        return place_on_ground(
            standing.prototypes.pose_tables,
            partial(self.ground.height, corner),
            Placements(
                xy,
                cos=np.cos(places[:, YAW]),
                sin=np.sin(places[:, YAW]),
                prototype=standing.row,
                phase=places[:, PHASE],
                stride_factor=places[:, STRIDE_FACTOR],
            ),
        )


@lru_cache(maxsize=1024)
def posed_prototype(
    prototype: RiggedPrototype, eighths: int, held: tuple[tuple[int, Components], ...]
) -> RiggedPrototype:
    """Return the prototype with so much of its walk, and joints held in these orientations.

    A leg of which a joint is held does not follow the ground.
    """
    from scenes.actors.limb import with_share  # loads Dr.Jit, which few frames need

    moving = with_share(prototype, eighths)
    if not held:
        return moving
    rotations = moving.motion.rotations.copy()
    rows = [row for row, _ in held]
    rotations[:, rows] = [turn for _, turn in held]
    feet = moving.motion.feet
    free = np.flatnonzero(~np.isin(feet.legs, rows).any(axis=1))
    kept = replace(feet, **{name: column[free] for name, column in vars(feet).items()})
    return replace(moving, motion=replace(moving.motion, rotations=rotations, feet=kept))
