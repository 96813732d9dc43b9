"""The camera among the actors: a positionable object that renders others (§3.1.1)."""

from collections.abc import Mapping, Sequence

import numpy as np

from lod.actors.actor import PositionableObject, Test, always
from lod.actors.appearance import ConeStick
from lod.actors.dispatch import query
from lod.actors.joint import IDENTITY_JOINT, RevoluteJoint
from lod.actors.message import Route, ask
from lod.actors.object_with_parts import ObjectWithParts
from lod.actors.quaternion import NORTH, UP, rotate
from lod.camera import GRID_M, split_position
from lod.camera import Camera as Projection
from lod.pruning.shapes import Sticks


class CameraActor(PositionableObject):
    """A camera that renders other actors.

    Its eye is its origin; it looks along its own y, its own z upwards.

    fov_x_deg  full horizontal field of view [degrees]
    size       width and height [px]
    """

    def __init__(
        self,
        joint: RevoluteJoint = IDENTITY_JOINT,
        fov_x_deg: float = 60.0,
        size: tuple[int, int] = (640, 360),
        parts: Mapping[str, ObjectWithParts] | None = None,
        part_types: Mapping[str, type[ObjectWithParts]] | None = None,
        name: str | None = None,
    ) -> None:
        super().__init__(parts, joint, part_types, name)
        self._fov_x_deg, self._size = fov_x_deg, size

    @query
    def projection(
        self, whole: RevoluteJoint = IDENTITY_JOINT, cell: tuple[int, int] = (0, 0)
    ) -> Projection:
        """Return the camera of the theory that stands where this one does.

        whole  frame of the whole that carries it
        cell   grid square that positions count from
        """
        frame = whole.compose(self._joint)
        corner, x, y = split_position(frame.position[0], frame.position[1], *cell)
        eye = np.array((x, y, frame.position[2]))
        forward, up = (np.array(rotate(frame.orientation, axis)) for axis in (NORTH, UP))
        return Projection(corner, eye, forward, up, np.radians(self._fov_x_deg), *self._size)

    @query
    def render(
        self,
        actors: Sequence[PositionableObject],
        displayed: Test = always,
        whole: RevoluteJoint = IDENTITY_JOINT,
    ) -> Sticks:
        """Return the sticks of the displayed parts of actors, in the frame of ``projection``.

        displayed  test of a part's route and position in that frame, where the eye is too (§2.4)

        The owner of a stick is a row of the parts that show any, in the order shown.
        """
        corner = self.projection(whole).corner
        frame = RevoluteJoint((-corner.x * GRID_M, -corner.y * GRID_M, 0.0))
        found: list[tuple[int, Route, ConeStick]] = []
        for number, actor in enumerate(actors):
            sticks = actor.receive(ask("", "displayed_sticks", frame, displayed)).value or ()
            found += [(number, route, stick) for route, stick in sticks]
        return _batched(found)


def _batched(found: Sequence[tuple[int, Route, ConeStick]]) -> Sticks:
    sticks = [stick for _, _, stick in found]
    rows = {key: row for row, key in enumerate(dict.fromkeys(key[:2] for key in found))}
    tints = list(dict.fromkeys(stick.albedo for stick in sticks))
    return Sticks(
        start=np.array([stick.start for stick in sticks]).reshape(-1, 3),
        end=np.array([stick.end for stick in sticks]).reshape(-1, 3),
        start_radius=np.array([stick.start_radius for stick in sticks]),
        end_radius=np.array([stick.end_radius for stick in sticks]),
        tint=np.array([tints.index(stick.albedo) for stick in sticks], np.int64),
        tints=np.array(tints).reshape(-1, 3),
        owner=np.array([rows[key[:2]] for key in found], np.int64),
    )
