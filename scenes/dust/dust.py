"""Dust behind walkers as a particle system: a trail, its puffs, their wisps and grains.

After W. T. Reeves, "Particle systems: a technique for modeling a class of fuzzy objects", SIGGRAPH
'83 Proceedings, p. 359. Each footfall of a field's walkers throws up one puff, where and when the
foot strikes (``scenes.dust.footfalls``); it stays in the world while the walker goes on, and lives
as ``scenes.dust.growth`` has it. Walkers have always walked, so that every frame follows from seed
and time alone.

Level 0 is the trail of one walker, level 1 its puffs, level 2 their wisps, level 3 grains. The leaf
appearance of n hidden grains is one or a few larger ones, as many times larger in area as they are
fewer: as porous, and with the same cover. Inner appearances are empty. Sizes are the largest that a
puff ever has at the walker's longest stride:

    P  √ of the largest cross-sections of the leaf appearance, added up
    R  of a grain its radius; of a wisp, a puff and a trail how far anything of it can be from its
       middle. That of a trail is where the walker was half a puff's life ago
"""

import math
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from jaxtyping import Float64

from lod.arrays import Ints, Points, Reals
from lod.hierarchy import Hierarchy
from lod.pruner import BlendWeights, Parts
from lod.shapes import Sticks
from lod.view import View
from scenes.dust import growth
from scenes.dust.appearance import (
    DustFrame,
    grains_of_wisps,
    leaf_balls,
    live_puffs,
    wisps_of_puffs,
)
from scenes.dust.footfalls import Legs, Walkers, fastest, object_keys
from scenes.dust.growth import GRAINS, GRAINS_EACH, LIFE_S, WISPS, WISPS_EACH
from scenes.dust.puffs import Air, trail_centres
from scenes.dust.soil import Soil
from scenes.field.cells import SearchBounds, candidates, search_bounds
from scenes.field.species_field import SpeciesField, patrol_orbits
from scenes.noise import hash_name
from scenes.particles.shapes import ball_sticks


@dataclass(frozen=True, eq=False)
class DustState:
    """State that the parts of one frame share.

    walkers, time_s   walkers whose dust it is, and the time [s]
    limits (2, v, 4)  limit distances of each prototype's levels, in view and out of it [m]
    """

    walkers: Walkers
    time_s: float
    limits: np.ndarray


@dataclass(frozen=True, eq=False)
class Dust:
    """A Representation: the dust that the walkers of a field throw up.

    wind_m_s: speed of the wind at the height of crowns [m/s]
    wind_azimuth_deg: where it blows to, clockwise from north [degrees]
    """

    walkers: SpeciesField
    soil: Soil
    wind_m_s: float = 0.0
    wind_azimuth_deg: float = 60.0

    @property
    def name(self) -> str:
        """Return the name of the species with ``.dust`` behind it, which no species has."""
        return f"{self.walkers.name}.dust"

    @cached_property
    def legs(self) -> Legs:
        """Return the legs of all prototypes."""
        return Legs.of([prototype.motion for prototype in self.walkers.prototypes.rigged])

    @cached_property
    def air(self) -> Air:
        """Return the wind and ground, and the key of the random numbers."""
        chance = np.uint64(self.walkers.seed), hash_name(self.name)
        azimuth = np.radians(self.wind_azimuth_deg)
        downwind = np.array((np.sin(azimuth), np.cos(azimuth)))
        speed = growth.wind_near_ground(self.wind_m_s)
        return Air(self.walkers.ground, speed, downwind, *chance)

    @cached_property
    def hierarchies(self) -> tuple[Hierarchy, ...]:
        """Return the sizes that all parts of a level have in common, for each prototype."""
        far = (fastest(self.legs) + self.air.wind_m_s) * LIFE_S / 2 + self.legs.reach
        far += growth.WAKE * self.legs.stride + growth.STIR_M_S * LIFE_S
        puffs = self.legs.walks.sum(axis=1) * self.legs.slots(LIFE_S)
        sizes = (column.tolist() for column in (self.legs.stride, far, puffs))
        return tuple(_hierarchy(*each) for each in zip(*sizes, strict=True))

    @property
    def top_m(self) -> float:
        """Bound on its height above the ground under it [m]."""
        tilted = growth.STEEPEST * growth.OLD * (1 + growth.WISP)
        return float(self.legs.stride.max()) * (2 * growth.HIGH + tilted + growth.GRAIN)

    def roots(self, view: View) -> Parts:
        """Find the trails of walkers of which something could be displayed."""
        corner, field = view.camera.corner, self.walkers
        limits = self._limits(view)
        samples, _ = candidates(field.cells, view, self._search_bounds(view, limits))
        samples = field.in_habitat(corner, samples)
        orbits = patrol_orbits(field.species, field.prototypes, samples)
        prototype, stride_factor, rounds = orbits
        key = object_keys(
            samples.cell_x, samples.cell_y, samples.index, self.air.seed, self.air.word
        )
        walkers = Walkers(
            corner, field.homes(corner, samples), prototype, stride_factor, rounds, key
        )
        row = np.arange(len(walkers))
        at = trail_centres(self.air, walkers, row, view.time_s)
        at[:, 2] += growth.HIGH / 2 * self.legs.stride[prototype]
        moment = DustState(walkers, view.time_s, limits)
        return self._parts(moment, 0 * row, at, row, 0 * row, 0 * row - 1, np.ones(len(row)))

    def parts_of(self, parts: Parts, view: View) -> Parts:
        """Return the live puffs of trails, the wisps of puffs, the grains of wisps."""
        moment = replace(parts.state, time_s=view.time_s)
        found = [
            each(self._scene(moment), parts, np.flatnonzero(parts.level == level))
            for level, each in enumerate((live_puffs, wisps_of_puffs, grains_of_wisps))
        ]
        parent, part, place, share = (np.concatenate(column) for column in zip(*found, strict=True))
        order = np.argsort(parent, kind="stable")
        parent = parent[order]
        level, who = parts.level[parent] + 1, parts.object[parent]
        return self._parts(moment, level, place[order], who, part[order], parent, share[order])

    def appearance(self, parts: Parts, weights: BlendWeights) -> Sticks:
        """Return balls: leaf appearances alone, as much as each shows."""
        moment = parts.state
        owner, place, area, struck = leaf_balls(self._scene(moment), parts, weights.leaf > 0)
        stride = self.legs.stride[moment.walkers.prototype[parts.object[owner]]]
        radius = growth.GRAIN * stride * np.sqrt(area * weights.leaf[owner])
        tint = self.soil.tint(moment.walkers.corner, struck)
        return ball_sticks(place, radius, tint, self.soil.tints, owner)

    def later(self, parts: Parts, view: View, time_s: float) -> Parts:
        """Return the same parts at another time; what is gone by then has the least area."""
        return replace(parts, state=replace(parts.state, time_s=time_s))

    def _scene(self, moment: DustState) -> DustFrame:
        return DustFrame(self.air, moment.walkers, self.legs, moment.time_s)

    def _limits(self, view: View) -> Float64[np.ndarray, "2 v 4"]:
        """Limit distances of each prototype's levels, in view and out of it [m]; 0 without legs."""
        limits = np.stack([np.stack(view.limits(each)) for each in self.hierarchies], axis=1)
        limits[:, ~self.legs.walks.any(axis=1)] = 0.0
        return limits

    def _search_bounds(self, view: View, limits: Float64[np.ndarray, "2 v 4"]) -> SearchBounds:
        """Bounds of the search for trails that can be displayed, prototype by prototype."""
        field, bound = self.walkers, np.array([each.B[0] for each in self.hierarchies])
        inside, outside = limits[:, :, 0]
        offset = field.species.patrol_m + self.air.wind_m_s * LIFE_S / 2
        low, high = field.ground.bounds()
        high += growth.HIGH / 2 * float(self.legs.stride.max())
        return search_bounds(view, (inside, outside), bound, offset, (low, high), field.extent)

    def _parts(
        self,
        moment: DustState,
        level: Ints,
        position: Points,
        object_: Ints,
        part: Ints,
        parent: Ints,
        share: Reals,
    ) -> Parts:
        prototype = moment.walkers.prototype[object_]
        bound = np.array([each.B for each in self.hierarchies])
        return Parts(
            position=position,
            centre=position,
            bound=bound[prototype, level],
            limit=moment.limits[0, prototype, level],
            limit_offscreen=moment.limits[1, prototype, level],
            level=level,
            object=object_,
            part=part,
            parent=parent,
            share=share,
            state=moment,
        )


def _hierarchy(stride: float, far: float, puffs: int) -> Hierarchy:
    """Sizes of the levels of a trail, of a prototype with this stride [m].

    far    largest horizontal distance of puffs from the trail's middle [m]
    puffs  largest number of puffs that are alive
    """
    stride = stride or 1.0
    radius, height, wisp = growth.OLD, growth.HIGH, growth.WISP
    tilted = growth.STEEPEST * radius
    in_wisp = wisp * math.hypot(radius, tilted + height)
    in_puff = math.hypot(radius, tilted + height / 2)
    far = math.hypot(far, growth.STEEPEST * far + height * stride / 2)
    separation = np.array([0.0, far, in_puff * stride, in_wisp * stride])
    balls = growth.GRAIN * stride * np.sqrt([WISPS * GRAINS, WISPS_EACH * GRAINS, GRAINS_EACH, 1])
    B = balls.copy()
    for level in (2, 1, 0):
        B[level] = separation[level + 1] + max(balls[level], B[level + 1])
    count = np.array([max(puffs, 1) * WISPS * GRAINS, WISPS * GRAINS, GRAINS, 1])
    return Hierarchy(
        parent=np.arange(-1, 3),
        level=np.arange(4),
        position=np.zeros((4, 3)),
        P=growth.GRAIN * stride * np.sqrt(np.pi * count),
        R=B,
        B=B * (1 + 1e-9) + 1e-9,
        separation=separation,
    )
