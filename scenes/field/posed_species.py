"""Objects of one species, wherever they stand: their parts and looks, posed by compiled walks."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Any

import numpy as np
from numba import njit

from lod.arrays import Ints, freeze
from lod.motion.image_motion import motion_steps
from lod.pruning.parts import BlendWeights, Parts
from lod.pruning.pruner import Cut
from lod.pruning.shapes import Sticks
from lod.pruning.view import View
from scenes.field.ground_contact_detail import foot_parts, heed
from scenes.field.part_tables import PartTables
from scenes.field.stick_emission import emit
from scenes.field.traversal import DisplayedRows, walk
from scenes.field.traversal_tables import TraversalTables, limit_table, slots_of
from scenes.rig.pose import pose_points
from scenes.rig.pose_tables import Instances, PoseTables
from scenes.rig.rigged_prototype import RiggedPrototype, rigid_prototype
from scenes.rig.speed_bound import speed_bound
from scenes.sticks.prototype import Prototype


@dataclass(frozen=True, eq=False)
class InstancesInView:
    """The objects of one frame that were examined: as they stand, and what they are elsewhere.

    instances   place, heading, prototype and phase of each
    samples     whatever identifies them, n rows
    motion_step (n,) how much motion hides of each, on the scale of lod.motion.shutter
    """

    instances: Instances
    samples: Any
    motion_step: np.ndarray

    def __post_init__(self) -> None:
        freeze(self, motion_step=np.float64)

    def __len__(self) -> int:
        return len(self.instances)


@dataclass(frozen=True, eq=False)
class SpeciesPrototypes:
    """The prototypes of a species, ready to be handed out part by part."""

    prototypes: tuple[Prototype | RiggedPrototype, ...]

    @cached_property
    def rigged(self) -> tuple[RiggedPrototype, ...]:
        """Every prototype as something that can be posed, if only in one way."""
        return tuple(
            p if isinstance(p, RiggedPrototype) else rigid_prototype(p) for p in self.prototypes
        )

    @cached_property
    def part_tables(self) -> PartTables:
        """All parts and sticks in one set of arrays."""
        return PartTables.of(self.rigged)

    @cached_property
    def pose_tables(self) -> PoseTables:
        """All rigs and motions."""
        return PoseTables.of(self.rigged)

    @cached_property
    def traversal_tables(self) -> TraversalTables:
        """All parts, as the compiled walk reads them."""
        return slots_of(self.part_tables, np.array([_sway(p) for p in self.rigged]))

    @cached_property
    def feet(self) -> np.ndarray:
        """Which parts of the part tables ride on a foot, (m,)."""
        return foot_parts(self.rigged)

    @cached_property
    def max_offset_m(self) -> float:
        """Farthest in plan that the origin of a whole can be from where its object stands [m]."""
        rest = self.part_tables.rest[self.part_tables.root]
        return float(np.hypot(rest[:, 0], rest[:, 1]).max()) + self.max_sway_m

    @cached_property
    def max_sway_m(self) -> float:
        """More than the origin of any whole moves from where it rests [m]."""
        return max(_sway(prototype) for prototype in self.rigged)

    @cached_property
    def moves(self) -> bool:
        """Whether any of them has a motion, and does not just stand."""
        return any(len(prototype.motion.rotations) > 1 for prototype in self.rigged)

    @cached_property
    def max_speed(self) -> np.ndarray:
        """How fast anything of each prototype moves by its own motion, (v,) [m/s]."""
        return np.array([speed_bound(prototype) for prototype in self.rigged])

    def heed(self, view: View, xy: np.ndarray, prototype: Ints) -> Ints:
        """How closely bodies at xy (n, 2) [m] mind the ground."""
        return heed(self.part_tables, self.traversal_tables, self.feet, view, xy, prototype)

    def seen(
        self, samples: Any, view: View, bodies_at: Callable[[float], Instances]
    ) -> InstancesInView:
        """Objects as they are in a view, and how much motion hides of each.

        ``bodies_at`` gives them as they are at a time [s]; the same where none of them moves.
        """
        instances = bodies_at(view.time_s)
        shutter, still = view.shutter, np.zeros(len(instances))
        if shutter is None or not view.metric.finite:
            return InstancesInView(instances, samples, still)
        opens, closes = (bodies_at(t) for t in (shutter.open_s, shutter.close_s))
        start, end = self._origins(opens), self._origins(closes)
        bound = self.part_tables.bound[self.part_tables.root][instances.prototype]
        turn = np.sqrt((closes.cos - opens.cos) ** 2 + (closes.sin - opens.sin) ** 2)
        # The origin of the whole may swing one way and something of it the other.
        own = 2 * self.max_speed[instances.prototype] * shutter.duration_s + turn * bound
        motion_step = motion_steps(shutter, view.camera.corner, view.theta, start, end, bound, own)
        return InstancesInView(instances, samples, motion_step)

    def _origins(self, instances: Instances) -> np.ndarray:
        """Origins of the wholes, (n, 3) [m]."""
        part_tables, rows = self.part_tables, np.arange(len(instances))
        part = part_tables.root[instances.prototype]
        return pose_points(
            self.pose_tables, instances, rows, part, part_tables.origin, part_tables.joint
        )

    def cut(self, objects: InstancesInView, view: View, examined: int) -> Cut:
        """What is displayed of these objects, by the compiled walk.

        examined: objects that were tested, of which these are left.
        """
        limits = limit_table(self.traversal_tables, self.part_tables, view, _most(objects))
        rows = walk(
            self.pose_tables,
            self.traversal_tables,
            limits,
            objects.instances,
            objects.motion_step,
            view,
        )
        rejected = examined - len(objects)
        level = self.part_tables.level.astype(np.int16)[rows.part]
        counted = examined, rejected + rows.examined
        return Cut(
            rows.object,
            rows.part,
            level,
            rows.parent,
            *counted,
            lambda: self.parts_shown(objects, rows, view),
        )

    def parts_shown(self, objects: InstancesInView, rows: DisplayedRows, view: View) -> Parts:
        """All that is known of displayed parts."""
        owner, part, whole = (a.astype(np.int64) for a in (rows.object, rows.part, rows.parent))
        return self._parts(objects, owner, part, whole, view)

    def wholes(self, objects: InstancesInView, view: View) -> Parts:
        """The wholes of these objects."""
        rows = np.arange(len(objects))
        part = self.part_tables.root[objects.instances.prototype]
        return self._parts(objects, rows, part, np.full(len(rows), -1), view)

    def parts_of(self, parts: Parts, view: View) -> Parts:
        """The parts that ``parts`` own directly."""
        whole, part = self.part_tables.parts_of(parts.part)
        return self._parts(parts.state, parts.object[whole], part, whole, view)

    def appearance(self, parts: Parts, weights: BlendWeights) -> Sticks:
        """Sticks of displayed parts, as much of both appearances as they show.

        Parts of one object stand together, so that every joint is posed once.
        """
        displayed = self.part_tables.sticks_of(parts.part, weights)
        return emit(
            self.pose_tables, self.part_tables, parts.state.instances, parts.object, displayed
        )

    def _parts(
        self,
        objects: InstancesInView,
        rows: np.ndarray,
        part: np.ndarray,
        whole: np.ndarray,
        view: View,
    ) -> Parts:
        part_tables = self.part_tables
        position = pose_points(
            self.pose_tables, objects.instances, rows, part, part_tables.origin, part_tables.joint
        )
        limits = _between(
            part_tables.limits_by_motion(view, _most(objects)), part, rows, objects.motion_step
        )
        return Parts(
            position=position,
            centre=position,
            bound=part_tables.bound[part],
            limit=limits[0],
            limit_offscreen=limits[1],
            level=part_tables.level[part],
            object=rows,
            part=part,
            parent=whole,
            share=part_tables.share[part],
            state=objects,
        )


def _most(objects: InstancesInView) -> float:
    return float(objects.motion_step.max(initial=0.0))


@njit(cache=True)
def _between(limits, part, rows, motion_step):  # type: ignore[no-untyped-def]
    """Limits of parts (n,) of objects ``rows`` (n,), (2, n), as the compiled walk takes them.

    limits (steps, m, 2) at whole motion steps; motion_step of each object
    """
    found = np.empty((2, len(part)))
    for i in range(len(part)):
        step = int(motion_step[rows[i]])
        share = motion_step[rows[i]] - step
        for side in range(2):
            found[side, i] = limits[step, part[i], side]
            if share > 0:
                found[side, i] += share * (limits[step + 1, part[i], side] - found[side, i])
    return found


def _sway(prototype: RiggedPrototype) -> float:
    """More than the origin of the whole moves from where it rests: what bounds it all [m]."""
    motion = prototype.motion
    moves = len(motion.rotations) > 1 or len(motion.feet) > 0
    return float(prototype.hierarchy.B[0]) if moves else 0.0


@lru_cache(maxsize=64)
def species_prototypes(prototypes: tuple[Prototype | RiggedPrototype, ...]) -> SpeciesPrototypes:
    """The tables of these very prototypes, made once."""
    return SpeciesPrototypes(prototypes)
