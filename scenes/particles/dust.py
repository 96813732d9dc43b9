"""Dust behind walkers as a particle system: a trail, its puffs, their wisps and grains.

After W. T. Reeves, "Particle systems: a technique for modeling a class of fuzzy objects", SIGGRAPH
'83 Proceedings, p. 359. Each footfall of a field's walkers throws up one puff, where and when the
foot strikes (``scenes.particles.footfalls``); it stays in the world while the walker goes on, and
lives as ``scenes.particles.puffs`` has it. Walkers have always walked, so that every frame follows
from seed and time alone.

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
from typing import NamedTuple

import numpy as np
from jaxtyping import Float64

from lod.arrays import Ints, Points, Reals
from lod.hierarchy import Hierarchy
from lod.pruner import BlendWeights, Parts
from lod.shapes import Sticks
from lod.view import View
from scenes.field.cells import SearchBounds, candidates, search_bounds
from scenes.field.species_field import SpeciesField, patrol_orbits
from scenes.noise import hash_name
from scenes.particles import puffs as growth
from scenes.particles.footfalls import (
    Footfalls,
    Legs,
    Soil,
    Walkers,
    fastest,
    footfalls,
    landing,
    object_keys,
)
from scenes.particles.plume import ball_sticks
from scenes.particles.puffs import (
    GRAINS,
    GRAINS_EACH,
    LEAST_AREA,
    LIFE_S,
    WISPS,
    WISPS_EACH,
    Air,
    Puffs,
    decode,
    decode_ids,
    grain_id,
    grains_at,
    puff_id,
    puffs_at,
    trail_centres,
    wisp_id,
    wisps_at,
)


class DustFrame(NamedTuple):
    """Dust at one time: air, walkers, their prototypes' legs, and the time [s]."""

    air: Air
    walkers: Walkers
    legs: Legs
    time_s: float

    def puffs(self, falls: Footfalls) -> Puffs:
        """Return the puffs that footfalls have thrown up."""
        return puffs_at(self.air, self.walkers, self.legs, falls, self.time_s)


class ChildParts(NamedTuple):
    """Parts of wholes: row of the whole, part number, place (n, 3) [m], share of the area."""

    parent: np.ndarray
    part: np.ndarray
    place: np.ndarray
    share: np.ndarray


class DustBalls(NamedTuple):
    """Balls that are drawn for parts.

    owner (n,), place (n, 3)  row of the part, and middle of the ball [m]
    area (n,)                 area over that of a full grain
    struck (n, 2)             place where the foot struck [m]
    """

    owner: np.ndarray
    place: np.ndarray
    area: np.ndarray
    struck: np.ndarray


def live_puffs(frame: DustFrame, parts: Parts, rows: Ints) -> ChildParts:
    """Return the puffs of trails that are in the air."""
    parent, falls = _recent_footfalls(frame, parts, rows)
    live = np.flatnonzero(_is_in_air(frame, falls))
    puffs, parent = frame.puffs(falls.take(live)), parent[live]
    area = puffs.mean_area
    total = np.bincount(parent, area, len(parts))
    return ChildParts(
        parent, puff_id(frame.legs, puffs.footfall), puffs.origin, area / total[parent]
    )


def wisps_of_puffs(frame: DustFrame, parts: Parts, rows: Ints) -> ChildParts:
    """Return the wisps of puffs."""
    puffs, row, _, _ = _distinct(frame, parts, rows)
    own, wisp = np.divmod(np.arange(len(rows) * WISPS), WISPS)
    place, area = wisps_at(frame.air, puffs, row[own], wisp)
    total = np.bincount(own, area, len(rows))
    return ChildParts(rows[own], wisp_id(parts.part[rows[own]], wisp), place, area / total[own])


def grains_of_wisps(frame: DustFrame, parts: Parts, rows: Ints) -> ChildParts:
    """Return the grains of wisps."""
    puffs, row, wisp, _ = _distinct(frame, parts, rows)
    own, grain = np.divmod(np.arange(len(rows) * GRAINS), GRAINS)
    place, _ = grains_at(frame.air, puffs, row[own], wisp[own], grain)
    part = grain_id(parts.part[rows[own]], grain)
    return ChildParts(rows[own], part, place, np.full(len(part), 1 / GRAINS))


def leaf_balls(frame: DustFrame, parts: Parts, shown: np.ndarray) -> DustBalls:
    """Return the balls of the leaf appearances of the parts that are ``shown`` (n,)."""
    levels = (_trail_balls, _puff_balls, _wisp_balls, _grain_balls)
    found = [
        each(frame, parts, np.flatnonzero(shown & (parts.level == level)))
        for level, each in enumerate(levels)
    ]
    columns = [np.concatenate(column) for column in zip(*found, strict=True)]
    order = np.argsort(columns[0], kind="stable")
    return DustBalls(*(column[order] for column in columns))


def _trail_balls(frame: DustFrame, parts: Parts, rows: Ints) -> DustBalls:
    """One ball for each recent footfall, as many in every frame."""
    owner, falls = _recent_footfalls(frame, parts, rows)
    puffs, live = frame.puffs(falls), _is_in_air(frame, falls)
    area = np.where(live, puffs.mean_area, LEAST_AREA)
    nowhere = trail_centres(frame.air, frame.walkers, falls.owner, frame.time_s)
    place = np.where(live[:, None], puffs.origin, nowhere)
    return DustBalls(owner, place, WISPS * GRAINS * area, puffs.struck)


def _puff_balls(frame: DustFrame, parts: Parts, rows: Ints) -> DustBalls:
    """One ball for WISPS_EACH wisps, in the place of one of them."""
    puffs, row, _, _ = _distinct(frame, parts, rows)
    own, wisp = np.divmod(np.arange(len(rows) * WISPS), WISPS)
    place, area = wisps_at(frame.air, puffs, row[own], wisp)
    each = GRAINS * area.reshape(-1, WISPS_EACH).sum(axis=1)
    own = own[::WISPS_EACH]
    return DustBalls(rows[own], place[::WISPS_EACH], each, puffs.struck[row[own]])


def _wisp_balls(frame: DustFrame, parts: Parts, rows: Ints) -> DustBalls:
    """One ball for GRAINS_EACH grains, in the place of one of them."""
    puffs, row, wisp, _ = _distinct(frame, parts, rows)
    own, some = np.divmod(np.arange(len(rows) * (GRAINS // GRAINS_EACH)), GRAINS // GRAINS_EACH)
    place, area = grains_at(frame.air, puffs, row[own], wisp[own], GRAINS_EACH * some)
    return DustBalls(rows[own], place, GRAINS_EACH * area, puffs.struck[row[own]])


def _grain_balls(frame: DustFrame, parts: Parts, rows: Ints) -> DustBalls:
    puffs, row, wisp, grain = _distinct(frame, parts, rows)
    place, area = grains_at(frame.air, puffs, row, wisp, grain)
    return DustBalls(rows, place, area, puffs.struck[row])


def _recent_footfalls(frame: DustFrame, parts: Parts, rows: Ints) -> tuple[np.ndarray, Footfalls]:
    """The last footfalls of the walkers of trail_centres, and the row of the trail of each."""
    legs, slots = frame.legs, frame.legs.slots(LIFE_S)
    each = footfalls(frame.walkers, legs, parts.object[rows], slots, frame.time_s)
    parent = np.repeat(rows, slots * legs.strike.shape[1])
    treads = legs.walks[frame.walkers.prototype[each.owner], each.leg]
    return parent[treads], each.take(treads)


def _is_in_air(frame: DustFrame, falls: Footfalls) -> np.ndarray:
    """Whether the dust of these footfalls is in the air, (m,)."""
    since = frame.time_s - landing(frame.walkers, frame.legs, falls).time_s
    return (since >= 0) & (since < LIFE_S)


def _distinct(frame: DustFrame, parts: Parts, rows: Ints) -> tuple[Puffs, Ints, Ints, Ints]:
    """Puffs of these parts, each once; row of each part's puff, and its wisp and its grain."""
    of = decode_ids(frame.legs, parts.part[rows])
    first = of.footfall.min(initial=0)
    span = of.footfall.max(initial=0) - first + 1
    both, row = np.unique(parts.object[rows] * span + of.footfall - first, return_inverse=True)
    owner, number = np.divmod(both, span)
    puffs = frame.puffs(decode(frame.legs, owner, number + first))
    return puffs, row, of.wisp, of.grain


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
