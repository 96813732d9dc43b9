"""Prototypes of a species compiled into tables, and the parts and sticks of its posed instances."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from typing import Any

import numpy as np

from lod.arrays import ArrayData, FloatArray, Ints, Points
from lod.metric import METRICS
from lod.motion import motion_steps
from lod.pruner import BlendWeights, Cut, Parts, blend_weights
from lod.shapes import Appearance, Instanced, Sticks, SticksAndTriangles
from lod.view import View, distance
from scenes.appearance.tone import Illumination, fit_tone
from scenes.field.part_tables import PartTables, emit, emit_meshes
from scenes.field.traversal import TraversalTables, node_limits, traverse
from scenes.processes.cache import content_key
from scenes.rig.pose import Instances, PoseTables, pose_points
from scenes.rig.rigged_prototype import RiggedPrototype, rigged, speed_bound
from scenes.sticks.prototype import Prototype


@lru_cache(maxsize=32)
def lit_part_tables(
    prototypes: tuple[Prototype | RiggedPrototype, ...], illumination: Illumination
) -> PartTables:
    """Lay prototypes end to end, with the tones of their leaf appearances in that light.

    Those without shapes that look otherwise from elsewhere stay as they are.
    """
    # Those that look the same but for their size are fitted once, and all of a species together:
    # one table of tones stands for them (``scenes.appearance.tone``).
    views = [each.view_dependence for each in prototypes]
    looks = [content_key(each.table_row, each.area_share) for each in views]
    kinds = dict(zip(looks, prototypes, strict=True))
    objects = [each for each in kinds.values() if len(each.view_dependence.area_share)]
    if objects:
        at_rest = [each.posed() if isinstance(each, RiggedPrototype) else each for each in objects]
        tone = fit_tone(at_rest, illumination)
        toned = [replace(each, tone=tone[: len(each.area_share)]) for each in views]
        pairs = zip(prototypes, toned, strict=True)
        prototypes = tuple(replace(each, view_dependence=own) for each, own in pairs)
    return PartTables.of(tuple(map(rigged, prototypes)))


@dataclass(frozen=True, eq=False)
class InstancesInView(ArrayData):
    """Instances examined in a frame: pose, identity and image motion.

    instances    place, heading, prototype and phase of each, n rows
    samples      whatever identifies them, n rows
    motion_step  (n,) how much motion hides of each, on the scale of lod.motion
    """

    instances: Instances
    samples: Any
    motion_step: FloatArray

    def __len__(self) -> int:
        return len(self.motion_step)

    def take(self, rows: Ints) -> "InstancesInView":
        """Select the objects at ``rows``; ``samples`` stay those of all."""
        return replace(
            self, instances=self.instances.take(rows), motion_step=self.motion_step[rows]
        )

    @property
    def max_step(self) -> float:
        """Return the greatest motion step of any of them."""
        return float(self.motion_step.max(initial=0.0))


@dataclass(frozen=True, eq=False)
class SpeciesPrototypes:
    """The prototypes of a species, with all tables that pruning and posing read."""

    prototypes: tuple[Prototype | RiggedPrototype, ...]

    @cached_property
    def rigged(self) -> tuple[RiggedPrototype, ...]:
        """Return every prototype as something that can be posed, if only in one way."""
        return tuple(map(rigged, self.prototypes))

    @cached_property
    def part_tables(self) -> PartTables:
        """Return all parts and sticks in one set of arrays."""
        return PartTables.of(self.rigged)

    @cached_property
    def pose_tables(self) -> PoseTables:
        """Return all rigs and motions."""
        return PoseTables.of(self.rigged)

    @cached_property
    def traversal_tables(self) -> TraversalTables:
        """Return all parts in the order of the compiled traversal."""
        return TraversalTables.of(self.part_tables, np.array([_max_sway(p) for p in self.rigged]))

    @cached_property
    def standing(self) -> InstancesInView:
        """Return one object of each prototype: at the origin of its own frame, x ahead."""
        models = len(self.prototypes)
        contacts = np.zeros((models, self.pose_tables.max_legs, 6))
        still, ahead = np.zeros(models), np.ones(models)
        rest = Instances(np.zeros((models, 3)), ahead, still, np.arange(models), still, contacts)
        return InstancesInView(rest, None, still)

    @cached_property
    def foot_parts(self) -> np.ndarray:
        """Tell whether each part of the part tables rides on an ankle, or below it, (m,)."""
        found = []
        for each in self.rigged:
            under = np.zeros(len(each.rig) + 1, bool)
            under[each.motion.feet.legs[:, 2] + 1] = True
            for row, parent in enumerate(each.rig.parent):
                under[row + 1] |= under[parent + 1]
            found.append(under[each.joint + 1])
        return np.concatenate(found)

    @cached_property
    def max_sway_m(self) -> float:
        """Bound how far the origin of any whole moves from where it rests [m]."""
        return max(_max_sway(prototype) for prototype in self.rigged)

    @cached_property
    def moves(self) -> bool:
        """Tell whether any of them has a motion, and does not just stand."""
        return any(len(prototype.motion.rotations) > 1 for prototype in self.rigged)

    @cached_property
    def max_speed(self) -> np.ndarray:
        """Bound on the speed of anything of each prototype by its own motion, (v,) [m/s]."""
        return np.array([speed_bound(prototype) for prototype in self.rigged])

    def cut(self, objects: InstancesInView, view: View, examined: int) -> Cut:
        """Find what is displayed of these objects, by the compiled traversal.

        examined: objects that were tested, of which these are left.
        """
        nodes, tables = self.traversal_tables, self.part_tables
        limits = node_limits(nodes, tables, view, objects.max_step)
        steps = objects.motion_step
        rows = traverse(self.pose_tables, nodes, limits, objects.instances, steps, view)

        def load_parts() -> Parts:
            object_, part, parent = (a.astype(np.int64) for a in rows[:3])
            return self.parts(objects, object_, part, parent, view)

        level = tables.level.astype(np.int16)[rows.part]
        examined_parts = examined - len(objects) + rows.examined
        cut = rows.object, rows.part, level, rows.parent
        return Cut(*cut, examined, examined_parts, load_parts)

    def wholes(self, objects: InstancesInView, view: View) -> Parts:
        """Return the wholes of these objects."""
        rows = np.arange(len(objects))
        part = self.part_tables.root[objects.instances.prototype]
        return self.parts(objects, rows, part, np.full(len(rows), -1), view)

    def parts_of(self, parts: Parts, view: View) -> Parts:
        """Return the parts that ``parts`` own directly."""
        parent, part = self.part_tables.parts_of(parts.part)
        return self.parts(parts.state, parts.object[parent], part, parent, view)

    def parts(
        self, objects: InstancesInView, rows: Ints, part: Ints, parent: Ints, view: View
    ) -> Parts:
        """Make a batch of parts from rows of their objects, of the tables and of parents, (k,)."""
        tables = self.part_tables
        position = self.positions(objects.instances, rows, part)
        limits = tables.limits_by_motion(view, objects.max_step)
        # Interpolated between whole steps of motion, as the traversal does it.
        step = objects.motion_step[rows].astype(np.int64)
        share, after = objects.motion_step[rows] - step, np.minimum(step + 1, len(limits) - 1)
        sides = []
        for side in range(2):
            low = limits[step, part, side]
            if objects.max_step > 0:
                with np.errstate(invalid="ignore"):
                    between = low + share * (limits[after, part, side] - low)
                low = np.where(share > 0, between, low)
            sides.append(low)
        return Parts(
            position=position,
            centre=position,
            bound=tables.bound[part],
            limit=sides[0],
            limit_offscreen=sides[1],
            level=tables.level[part],
            object=rows,
            part=part,
            parent=parent,
            share=tables.share[part],
            state=objects,
            kept=tables.kept(part, distance(view, position), view, objects.motion_step[rows]),
        )

    def appearance(
        self, parts: Parts, weights: BlendWeights, illumination: Illumination | None = None
    ) -> Appearance:
        """Return sticks and meshes of displayed parts, as much of both appearances as they show."""
        sticks = self.sticks(parts, weights, illumination)
        if self.part_tables.meshes is None:
            return sticks
        tables, instances = (self.pose_tables, self.part_tables), parts.state.instances
        triangles = emit_meshes(*tables, instances, parts.object, parts.part, weights.leaf)
        return SticksAndTriangles(sticks, triangles)

    def sticks(
        self, parts: Parts, weights: BlendWeights, illumination: Illumination | None = None
    ) -> Sticks:
        """Return the sticks of displayed parts; those that are shown as meshes have none.

        Parts of one object stand together, so that every joint is posed once. Leaf appearances
        have the tone that they need in that light; without one they have their own albedo.
        """
        tables = self.part_tables
        if illumination is not None:
            tables = lit_part_tables(self.prototypes, illumination)
        displayed = tables.sticks_of(parts.part, weights)
        instances = parts.state.instances
        return emit(self.pose_tables, tables, instances, parts.object, displayed)

    def copies(
        self, objects: InstancesInView, rows: Ints, view: View, illumination: Illumination | None
    ) -> Instanced:
        """Return every part of the objects at ``rows``, which stand still, as copies."""
        placed, view = objects.instances.take(rows), replace(view, metric=METRICS["full"])
        cut = self.cut(self.standing, view, len(self.prototypes))
        shape = self.appearance(cut.parts, blend_weights(cut, view), illumination)
        turn = np.stack((placed.cos, placed.sin), axis=1)
        parts = cut.object, cut.part, cut.level
        return Instanced(shape, *parts, placed.prototype, rows, placed.origin, turn)

    def positions(self, instances: Instances, rows: Ints, part: Ints) -> Points:
        """Compute the origins of parts of posed objects, (k,) rows of each, (k, 3) [m]."""
        origin, joint = self.part_tables.origin, self.part_tables.joint
        return pose_points(self.pose_tables, instances, rows, part, origin, joint)


@lru_cache(maxsize=64)
def species_prototypes(prototypes: tuple[Prototype | RiggedPrototype, ...]) -> SpeciesPrototypes:
    """Return the tables of these very prototypes, made once."""
    return SpeciesPrototypes(prototypes)


def shutter_times(view: View) -> tuple[float, ...]:
    """Times at which objects are placed for a view [s]: its own; and, where their image motion
    matters, when the shutter opens and when it closes."""
    shutter = view.shutter
    if shutter is None or not view.metric.finite:
        return (view.time_s,)
    return view.time_s, shutter.open_s, shutter.close_s


def instances_in_view(
    prototypes: SpeciesPrototypes, samples: Any, view: View, placed: Sequence[Instances]
) -> InstancesInView:
    """Return the objects as a view has them, and how much motion hides of each.

    samples: whatever identifies them; placed: how they stand at each of ``shutter_times``
    """
    instances = placed[0]
    if len(placed) == 1 or view.shutter is None:
        return InstancesInView(instances, samples, np.zeros(len(instances.prototype)))
    _, opens, closes = placed
    root = prototypes.part_tables.root[instances.prototype]
    rows = np.arange(len(root))
    start, end = (prototypes.positions(each, rows, root) for each in (opens, closes))
    bound = prototypes.part_tables.bound[root]
    turn = np.sqrt((closes.cos - opens.cos) ** 2 + (closes.sin - opens.sin) ** 2)
    # The origin of the whole may swing one way and something of it the other.
    own = 2 * prototypes.max_speed[instances.prototype] * view.shutter.duration_s + turn * bound
    corner = view.camera.corner
    steps = motion_steps(view.shutter, corner, view.theta, start, end, bound, own)
    return InstancesInView(instances, samples, steps)


def _max_sway(prototype: RiggedPrototype) -> float:
    """More than the origin of the whole moves from where it rests: what bounds it all [m]."""
    motion = prototype.motion
    moves = len(motion.rotations) > 1 or len(motion.feet) > 0
    return float(prototype.hierarchy.B[0]) if moves else 0.0
