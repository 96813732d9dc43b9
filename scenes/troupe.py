"""Objects of one species, wherever they stand: their parts and looks, posed by compiled walks."""

from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Any

import numpy as np

from lod.parts import Look, Parts, Sticks
from lod.prune import Cut
from lod.view import View
from scenes.atlas import Atlas
from scenes.emit import emit
from scenes.prototype import Prototype
from scenes.rig_cast import Bodies, Cast
from scenes.rig_pose import pose_points
from scenes.rig_prototype import RiggedPrototype, rigid
from scenes.walk import Slots, limits_of, slots_of, walk


@dataclass(frozen=True, eq=False)
class Objects:
    """The objects of one frame that were examined: as they stand, and what they are elsewhere.

    bodies: place, heading, prototype and phase of each; draws: whatever identifies them (n rows)
    """

    bodies: Bodies
    draws: Any

    def __len__(self) -> int:
        return len(self.bodies)


@dataclass(frozen=True, eq=False)
class Troupe:
    """The prototypes of a species, ready to be handed out part by part."""

    prototypes: tuple[Prototype | RiggedPrototype, ...]

    @cached_property
    def rigged(self) -> tuple[RiggedPrototype, ...]:
        """Every prototype as something that can be posed, if only in one way."""
        return tuple(p if isinstance(p, RiggedPrototype) else rigid(p) for p in self.prototypes)

    @cached_property
    def atlas(self) -> Atlas:
        """All parts and sticks in one set of arrays."""
        return Atlas.of(self.rigged)

    @cached_property
    def cast(self) -> Cast:
        """All rigs and motions."""
        return Cast.of(self.rigged)

    @cached_property
    def slots(self) -> Slots:
        """All parts, as the compiled walk reads them."""
        return slots_of(self.atlas, np.array([_sway(p) for p in self.rigged]))

    @cached_property
    def lean_m(self) -> float:
        """Farthest in plan that the origin of a whole can be from where its object stands [m]."""
        rest = self.atlas.rest[self.atlas.root]
        return float(np.hypot(rest[:, 0], rest[:, 1]).max()) + self.sway_m

    @cached_property
    def sway_m(self) -> float:
        """More than the origin of any whole moves from where it rests [m]."""
        return max(_sway(prototype) for prototype in self.rigged)

    def cut(self, objects: Objects, view: View, examined: int) -> Cut:
        """What is displayed of these objects, by the compiled walk.

        examined: objects that were tested, of which these are left.
        """
        limits = limits_of(self.slots, self.atlas, view)
        rows = walk(self.cast, self.slots, limits, objects.bodies, view)
        rejected = examined - len(objects)

        def tell() -> Parts:
            owner, part, whole = (a.astype(np.int64) for a in (rows.object, rows.part, rows.whole))
            return self._parts(objects, owner, part, whole, view)

        level = self.atlas.level.astype(np.int16)[rows.part]
        counted = examined, rejected + rows.examined
        return Cut(rows.object, rows.part, level, rows.whole, *counted, tell)

    def wholes(self, objects: Objects, view: View) -> Parts:
        """The wholes of these objects."""
        rows = np.arange(len(objects))
        part = self.atlas.root[objects.bodies.variant]
        return self._parts(objects, rows, part, np.full(len(rows), -1), view)

    def parts_of(self, parts: Parts, view: View) -> Parts:
        """The parts that ``parts`` own directly."""
        whole, part = self.atlas.parts_of(parts.part)
        return self._parts(parts.state, parts.object[whole], part, whole, view)

    def appearance(self, parts: Parts, look: Look) -> Sticks:
        """Sticks of displayed parts, as much of both appearances as they show.

        Parts of one object stand together, so that every joint is posed once.
        """
        owner, stick, share = self.atlas.sticks_of(parts.part, look)
        return emit(self.cast, self.atlas, parts.state.bodies, parts.object, owner, stick, share)

    def _parts(
        self, objects: Objects, rows: np.ndarray, part: np.ndarray, whole: np.ndarray, view: View
    ) -> Parts:
        atlas = self.atlas
        position = pose_points(self.cast, objects.bodies, rows, part, atlas.origin, atlas.joint)
        limit, limit_offscreen = atlas.limits(view)
        return Parts(
            position=position,
            centre=position,
            bound=atlas.bound[part],
            limit=limit[part],
            limit_offscreen=limit_offscreen[part],
            level=atlas.level[part],
            object=rows,
            part=part,
            whole=whole,
            share=atlas.share[part],
            state=objects,
        )


def _sway(prototype: RiggedPrototype) -> float:
    """More than the origin of the whole moves from where it rests: what bounds it all [m]."""
    motion = prototype.motion
    moves = len(motion.turns) > 1 or len(motion.feet) > 0
    return float(prototype.hierarchy.B[0]) if moves else 0.0


@lru_cache(maxsize=64)
def troupe_of(prototypes: tuple[Prototype | RiggedPrototype, ...]) -> Troupe:
    """The troupe of these very prototypes, made once."""
    return Troupe(prototypes)
