"""An assembled actor as frozen arrays.

A crowd is posed from arrays, never by one Python object per part; the actors' own recursive answers
(``PositionableObject.frames``) are the reference that it is tested against.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from lod.actors.actor import PartDescription, PositionableObject
from lod.actors.appearance import ConeStick
from lod.actors.joint import IDENTITY_JOINT
from lod.actors.message import Route, ask, format_route, nearest_route, parse_route
from lod.actors.quaternion import IDENTITY, Vector
from lod.arrays import ArrayData, FloatArray, IntArray
from lod.errors import InputError
from lod.stick_table import StickTable


@dataclass(frozen=True, eq=False)
class ActorArrays(ArrayData):
    """An actor and its n parts, row 0 the actor itself, every part after the part that owns it.

    routes             (n,) the way to each part; () for row 0
    parent             (n,) row of the part that owns this one; -1 for row 0
    position           (n, 3) origin in the frame of its whole [m]
    orientation        (n, 4) orientation in the frame of its whole: unit quaternions x, y, z, w
    rest               (n, 4) orientation that the limits count from
    low_deg, high_deg  (n, 3) box of rotation vectors from rest [degrees]; ±inf for a free joint
    inner, leaf        sticks of the two appearances (§2.4)
    tints              (t, 3) linear Rec.709 albedo, 0 to 1
    """

    routes: tuple[Route, ...]
    parent: IntArray
    position: FloatArray
    orientation: FloatArray
    rest: FloatArray
    low_deg: FloatArray
    high_deg: FloatArray
    inner: StickTable
    leaf: StickTable
    tints: FloatArray

    def __len__(self) -> int:
        return len(self.parent)

    def row(self, route: str | Sequence[str]) -> int:
        """Find the row of the part at a route. InputError names the nearest known route."""
        names = parse_route(route)
        if names not in self.routes:
            cure = f"did you mean {format_route(nearest_route(names, self.routes))!r}?"
            raise InputError("route", format_route(names), f"one of {len(self)} known routes", cure)
        return self.routes.index(names)


def compile_actor(actor: PositionableObject) -> ActorArrays:
    """Compile an actor as it stands, by its own answers. Raises Refused where a whole refuses."""
    parts: tuple[PartDescription, ...] = actor.receive(ask("", "description")).value
    row = {part.route: i for i, part in enumerate(parts)}
    joints = [part.joint for part in parts]
    boxes = [joint.limits for joint in joints]
    inner = [part.inner.sticks_in(IDENTITY_JOINT) for part in parts]
    leaf = [part.leaf.sticks_in(IDENTITY_JOINT) for part in parts]
    tints = {stick.albedo: None for sticks in (*inner, *leaf) for stick in sticks}
    tint = {albedo: i for i, albedo in enumerate(tints)}
    return ActorArrays(
        routes=tuple(part.route for part in parts),
        parent=np.array([row[part.route[:-1]] if part.route else -1 for part in parts]),
        position=np.array([joint.position for joint in joints]),
        orientation=np.array([joint.turn for joint in joints]),
        rest=np.array([box.rest if box else IDENTITY for box in boxes]),
        low_deg=np.array([box.low_deg if box else (-np.inf,) * 3 for box in boxes]),
        high_deg=np.array([box.high_deg if box else (np.inf,) * 3 for box in boxes]),
        inner=_stick_table(inner, tint),
        leaf=_stick_table(leaf, tint),
        tints=np.array(list(tints), np.float64).reshape(-1, 3),
    )


def _stick_table(looks: list[tuple[ConeStick, ...]], tint: dict[Vector, int]) -> StickTable:
    sticks = [stick for look in looks for stick in look]
    return StickTable(
        first=np.cumsum([0, *map(len, looks)]),
        start=np.array([stick.start for stick in sticks], np.float64).reshape(-1, 3),
        end=np.array([stick.end for stick in sticks], np.float64).reshape(-1, 3),
        start_radius=np.array([stick.start_radius for stick in sticks], np.float64),
        end_radius=np.array([stick.end_radius for stick in sticks], np.float64),
        tint=np.array([tint[stick.albedo] for stick in sticks], np.int64),
    )
