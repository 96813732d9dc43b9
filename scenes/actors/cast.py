"""The actors of a scene as the pruner sees them: posed as they answered, by a crowd's own walk.

Actors of one model that stand alike but for place and phase share a row of the tables; what holds
a limb by a message has a row of its own, whose motion has that limb at rest where it is held.
"""

from dataclasses import dataclass, replace
from functools import cached_property, lru_cache, partial

import numpy as np

from lod.actors.vectors import Components
from lod.camera import GRID_M, Corner
from lod.pruning.parts import BlendWeights, Parts
from lod.pruning.pruner import Cut
from lod.pruning.shapes import Sticks
from lod.pruning.view import View
from scenes.actors.motions import with_share
from scenes.actors.performance import (
    EIGHTHS,
    PHASE,
    STRIDE_FACTOR,
    YAW,
    ActedFrame,
    Performance,
    X,
    Y,
)
from scenes.field.posed_species import (
    InstancesInView,
    SpeciesPrototypes,
    instances_in_view,
    shutter_times,
    species_prototypes,
)
from scenes.rig.foot_placement import Placements, place_on_ground
from scenes.rig.pose_tables import Instances
from scenes.rig.rigged_prototype import RiggedPrototype
from scenes.terrain.ground import Ground

_HeldRows = tuple[tuple[int, Components], ...]


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

    @cached_property
    def highest_m(self) -> float:
        """Return the height above the ground that no actor exceeds [m]."""
        trees = [each.hierarchy for each in self.prototypes]
        return max((float(tree.position[0, 2] + tree.B[0]) for tree in trees), default=0.0)

    def name_of(self, cut: Cut, row: int) -> str:
        """Return the name of the actor in a row of the objects of a cut."""
        standing: Standing = cut.parts.state.samples
        return self.performance.names[int(standing.actor[row])]

    def roots(self, view: View) -> Parts:
        """Return all actors, near or far."""
        objects = self._in_view(view)
        return objects.samples.prototypes.wholes(objects, view)

    def cut(self, view: View) -> Cut:
        """Find what is displayed of them, by the compiled traversal."""
        objects = self._in_view(view)
        return objects.samples.prototypes.cut(objects, view, len(objects))

    def parts_of(self, parts: Parts, view: View) -> Parts:
        """Return the parts that ``parts`` own directly."""
        return parts.state.samples.prototypes.parts_of(parts, view)

    def appearance(self, parts: Parts, weights: BlendWeights) -> Sticks:
        """Return the sticks of the displayed parts."""
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
        variants = [self._variant(acted, k, places[i]) for i, k in enumerate(actor.tolist())]
        rows = {each: row for row, each in enumerate(dict.fromkeys(variants))}
        row = np.array([rows[each] for each in variants], np.int64)
        return Standing(actor, places, species_prototypes(tuple(rows)), row)

    def _variant(self, acted: ActedFrame, actor: int, place: np.ndarray) -> RiggedPrototype:
        held = acted.held.get(actor, ())
        return posed_prototype(self.prototypes[actor], int(place[EIGHTHS]), held)

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
def posed_prototype(prototype: RiggedPrototype, eighths: int, held: _HeldRows) -> RiggedPrototype:
    """Return the prototype with so much of its walk, and joints held in these orientations.

    A leg of which a joint is held does not follow the ground.
    """
    moving = with_share(prototype, eighths)
    if not held:
        return moving
    rotations = moving.motion.rotations.copy()
    rows = [row for row, _ in held]
    rotations[:, rows] = [turn for _, turn in held]
    feet = moving.motion.feet
    free = np.flatnonzero(~np.isin(feet.legs, rows).any(axis=1))
    kept = replace(feet, **{name: column[free] for name, column in vars(feet).items()})
    return moving.with_motion(replace(moving.motion, rotations=rotations, feet=kept))
