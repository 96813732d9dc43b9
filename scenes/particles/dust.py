"""Dust behind walkers: trails of puffs that footfalls throw up, their wisps and their grains.

Each footfall of a field's walkers throws up one puff, where and when the foot strikes
(``scenes.particles.footfalls``); it stays in the world while the walker goes on. Walkers have
always walked. A puff is a low dome of wisps, each of grains of one size. All of it is a function of
its age:

    spreads   its radius grows as age^0.6: near the √age of diffusion (G. I. Taylor, Proc. London
              Math. Soc. s2-20:196, 1922), faster while what threw it up lasts
    rises     to its height, slower and slower, e-fold in RISE_S
    drifts    some way behind the walker, then as the air does; with the wind, as fast as that is
              near the ground
    settles   each wisp at the speed of its grains by Stokes' law, v = ρ·g·d²/(18·μ): 2 cm/s for
              quartz of 15 µm, 0.3 m/s for 60 µm
    thins     air mixes in until nothing is seen of it, at LIFE_S

How much is thrown up, how far and how high is chosen by eye, as Reeves chose; lengths are shares of
the walker's longest stride, 1.4 m for a person. A drawn grain stands for many finer ones. The
middle of a trail is where the walker was half a puff's life ago.

Footfalls, wisps and grains are rows of arrays; ``row`` says which puff a wisp or grain is of.
"""

import math
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float64

from lod.arrays import Ints, Points, Reals
from lod.camera import Corner
from lod.hierarchy import Hierarchy
from lod.pruner import Parts
from lod.shapes import Sticks
from lod.view import View
from scenes.field.cells import candidates, search_bounds
from scenes.field.species_field import SpeciesField, patrol_orbits
from scenes.figures.gait import GRAVITY
from scenes.noise import hash_name
from scenes.particles.footfalls import Footfalls, Landing, Legs, Soil, Walkers, footfalls, landing
from scenes.particles.system import (
    Children,
    Drawn,
    Moment,
    ParticleSystem,
    points_in_ball,
    random_units,
    random_words,
    smoothstep,
)

LIFE_S = 3.5
RISE_S = 0.5

YOUNG, OLD = 0.06, 0.34
"""Radius of a puff as the foot strikes and at the end."""

LOW, HIGH = 0.02, 0.24
"""Height of a puff as the foot strikes and at the end."""

WAKE = 0.12
"""Distance that a puff follows the walker."""

STIR_M_S = 0.1
"""Largest speed of the air where there is no wind, in any direction [m/s]."""

WISP = 0.1
"""Size of a wisp over its puff's."""

GRAIN = 6.6e-4
"""Radius of a grain."""

WISPS, GRAINS = 256, 128
"""Wisps of a puff, and grains of a wisp."""

WISPS_EACH, GRAINS_EACH = 16, 4
"""Wisps and grains that one larger grain replaces in the leaf appearance of puffs and of wisps."""

FAINTEST = 0.35
"""Area of the faintest puff over that of the thickest."""

STEEPEST = 0.7
"""Largest slope of a trail and of a puff on the ground: loose ground's angle of repose, 35°."""

LEAST_AREA = 1e-6
"""Least area, over the full one, of what is not there yet or no longer."""

_FINEST_M, _COARSEST_M = 12e-6, 70e-6
_DENSITY, _VISCOSITY = 2650.0, 1.81e-5
"""Density of quartz [kg/m³], and viscosity of air of 15 °C [Pa·s]."""

_ROUGHNESS_M, _CROWNS_M, _ANKLES_M = 0.01, 10.0, 0.3
_WAKING_S, _WAKE_S, _GROWTH = 0.25, 0.6, 0.6

_STRATA = 5
"""Strata of each random number of a wisp over which the area of wisps is averaged."""

_BEFORE_S = 1e4
"""Time before 0 from which on footfalls have numbers above 0 [s]."""

_OF_PUFF, _OF_WISP = 1 + WISPS * (1 + GRAINS), 1 + GRAINS
"""Part numbers that a puff and a wisp take, with all that they hold."""


def settling_speed(u: Reals) -> Reals:
    """Compute the speeds at which grains settle by Stokes' law, from uniform numbers, (m,) [m/s].

    Their sizes are log-uniform.
    """
    diameter = _FINEST_M * (_COARSEST_M / _FINEST_M) ** u
    return _DENSITY * GRAVITY * diameter**2 / (18 * _VISCOSITY)


def wind_near_ground(wind_m_s: float) -> float:
    """Compute the speed of the wind where dust is, from that at the height of crowns [m/s].

    It follows the logarithmic profile over bare ground (Oke, "Boundary Layer Climates", 2nd ed.
    1987, ch. 2).
    """
    above = np.log(np.array((_ANKLES_M, _CROWNS_M)) / _ROUGHNESS_M)
    return float(wind_m_s * above[0] / above[1])


class Puffs(NamedTuple):
    """State of m puffs at one time, (m,) each.

    base (m, 3) middle, on the ground; slope (m, 2) of that; radius, height [m]
    age     time since the footfall, 0 before it [s]
    area    of its wisps over the full one, but for what has settled
    struck  (m, 2) where the foot struck [m]
    key, footfall   number of its walker, and of its footfall among that walker's
    """

    base: np.ndarray
    slope: np.ndarray
    radius: np.ndarray
    height: np.ndarray
    age: np.ndarray
    area: np.ndarray
    struck: np.ndarray
    key: np.ndarray
    footfall: np.ndarray

    @property
    def mean_area(self) -> Reals:
        """Return the expected area of their wisps over full ones, (m,)."""
        middles = (np.arange(_STRATA) + 0.5) / _STRATA
        total, rows = np.zeros(len(self.height)), np.arange(len(self.height))
        for u in middles:
            for v in middles:
                total += self._wisps(rows, np.full(len(rows), u), np.full(len(rows), v))[2]
        return total / _STRATA**2

    @property
    def origin(self) -> Points:
        """Return the points that distances are measured to: half-way up, (m, 3) [m]."""
        up = np.zeros((len(self.base), 3))
        up[:, 2] = self.height / 2
        return self.base + up

    def _wisps(self, row: Ints, u: Reals, v: Reals) -> tuple[Reals, Reals, Reals]:
        """Height of wisps above the ground [m], over that of round ones, and area, (m,) each."""
        height, start = self.height[row], WISP + (1 - WISP) * u**2  # more of it lower down
        up = np.maximum(start * height - settling_speed(v) * self.age[row], 0.0)
        squash = np.minimum(up / (WISP * height), 1.0)
        area = np.maximum(self.area[row] * smoothstep(squash), LEAST_AREA)
        return up, squash, area


@dataclass(frozen=True, eq=False)
class Dust(ParticleSystem):
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

    def drift(self, time_s: float) -> Float64[np.ndarray, "2"]:
        """Return how far the wind takes dust near the ground in a time, (2,) [m]."""
        azimuth = np.radians(self.wind_azimuth_deg)
        downwind = np.array((np.sin(azimuth), np.cos(azimuth)))
        return wind_near_ground(self.wind_m_s) * time_s * downwind

    @cached_property
    def hierarchies(self) -> tuple[Hierarchy, ...]:
        """Return the sizes that all parts of a level have in common, for each prototype."""
        legs, speed = self.legs, wind_near_ground(self.wind_m_s)
        far = (legs.fastest + speed) * LIFE_S / 2 + legs.reach
        far += WAKE * legs.stride + STIR_M_S * LIFE_S
        puffs = legs.walks.sum(axis=1) * legs.slots(LIFE_S)
        sizes = (column.tolist() for column in (legs.stride, far, puffs))
        return tuple(_hierarchy(*each) for each in zip(*sizes, strict=True))

    def limits(self, view: View) -> Float64[np.ndarray, "2 v l"]:
        """Return the limit distances of each prototype's levels [m]; 0 without legs."""
        limits = super().limits(view)
        limits[:, ~self.legs.walks.any(axis=1)] = 0.0
        return limits

    def roots(self, view: View) -> Parts:
        """Find the trails of walkers of which something could be displayed."""
        corner, field, limits = view.camera.corner, self.walkers, self.limits(view)
        bound = np.array([each.B[0] for each in self.hierarchies])
        offset = field.species.patrol_m + wind_near_ground(self.wind_m_s) * LIFE_S / 2
        low, high = field.ground.bounds()
        high += HIGH / 2 * float(self.legs.stride.max())
        inside, outside = limits[:, :, 0]
        search = search_bounds(view, (inside, outside), bound, offset, (low, high), field.extent)
        samples, _ = candidates(field.cells, view, search)
        samples = field.in_habitat(corner, samples)
        prototype, pace, rounds = patrol_orbits(field.species, field.prototypes, samples)
        key = self.object_keys(samples.cell_x, samples.cell_y, samples.index)
        homes = field.cells.positions(corner, samples)
        walkers = Walkers(corner, homes, prototype, pace, rounds, key)
        row = np.arange(len(walkers))
        place = self.trail_centres(walkers, row, view.time_s)
        place[:, 2] += HIGH / 2 * self.legs.stride[prototype]
        at = Moment(corner, view.time_s, prototype, limits, walkers)
        return self.batch(at, 0 * row, row, 0 * row, 0 * row - 1, place, np.ones(len(row)))

    def children(self, at: Moment, parts: Parts, rows: Ints, level: int) -> Children:
        """Return the live puffs of trails, the wisps of puffs, or the grains of wisps."""
        if level == 0:
            parent, falls = self._recent_footfalls(at, parts, rows)
            live = np.flatnonzero(self._is_in_air(at, falls))
            puffs, parent = self.puffs(at.sources, falls.take(live), at.time_s), parent[live]
            area = puffs.mean_area
            total = np.bincount(parent, area, len(parts))
            part = 1 + (puffs.footfall + self._earliest) * _OF_PUFF
            return Children(parent, part, puffs.origin, area / total[parent])
        puffs, row, wisp, _ = self._distinct(at, parts, rows)
        count = WISPS if level == 1 else GRAINS
        own, number = np.divmod(np.arange(len(rows) * count), count)
        first = parts.part[rows[own]] + 1
        if level == 1:
            place, area = self._wisps(puffs, row[own], number)
            total = np.bincount(own, area, len(rows))
            return Children(rows[own], first + number * _OF_WISP, place, area / total[own])
        place, _ = self._grains(puffs, row[own], wisp[own], number)
        return Children(rows[own], first + number, place, np.full(len(own), 1 / GRAINS))

    def drawn(self, at: Moment, parts: Parts, rows: Ints, level: int) -> Drawn:
        """Return grains, each in the place of one of those that it stands for.

        There is one for each recent footfall of a trail, as many in every frame; one for WISPS_EACH
        wisps of a puff; and one for GRAINS_EACH grains of a wisp.
        """
        if level == 0:
            owner, falls = self._recent_footfalls(at, parts, rows)
            puffs, live = self.puffs(at.sources, falls, at.time_s), self._is_in_air(at, falls)
            nowhere = self.trail_centres(at.sources, falls.owner, at.time_s)
            place = np.where(live[:, None], puffs.origin, nowhere)
            area = WISPS * GRAINS * np.where(live, puffs.mean_area, LEAST_AREA)
            return self._drawn(at, parts, owner, place, area, puffs.struck)
        puffs, row, wisp, grain = self._distinct(at, parts, rows)
        if level == 1:
            own, number = np.divmod(np.arange(len(rows) * WISPS), WISPS)
            place, area = self._wisps(puffs, row[own], number)
            own, place = own[::WISPS_EACH], place[::WISPS_EACH]
            area = GRAINS * area.reshape(-1, WISPS_EACH).sum(axis=1)
        elif level == 2:
            count = GRAINS // GRAINS_EACH
            own, number = np.divmod(np.arange(len(rows) * count), count)
            place, area = self._grains(puffs, row[own], wisp[own], GRAINS_EACH * number)
            area = GRAINS_EACH * area
        else:
            own = np.arange(len(rows))
            place, area = self._grains(puffs, row, wisp, grain)
        return self._drawn(at, parts, rows[own], place, area, puffs.struck[row[own]])

    def _drawn(
        self, at: Moment, parts: Parts, owner: Ints, place: Points, area: Reals, struck: np.ndarray
    ) -> Drawn:
        stride = self.legs.stride[at.variant[parts.object[owner]]]
        return Drawn(owner, place, GRAIN * stride, area, self.soil.tint(at.corner, struck))

    def shape(self, drawn: Drawn, radius: Reals) -> Sticks:
        """Make balls of the colour of the ground that they come from."""
        colours = drawn.shade, self.soil.tints
        return Sticks(drawn.place, drawn.place, radius, radius, *colours, drawn.owner)

    def puffs(self, walkers: Walkers, falls: Footfalls, time_s: float) -> Puffs:
        """Compute the puffs of footfalls at a time, even before they are up and after their life.

        A puff lies on the ground below it, but is never steeper above the middle of its trail than
        loose ground can be.
        """
        fell = landing(walkers, self.legs, falls)
        age = np.clip(time_s - fell.time_s, 0.0, LIFE_S)
        stride, s = self.legs.stride[walkers.prototype[falls.owner]], age / LIFE_S
        radius = stride * (YOUNG + (OLD - YOUNG) * s**_GROWTH)
        height = stride * (LOW + (HIGH - LOW) * -np.expm1(-age / RISE_S))
        wake = stride * (WAKE * -np.expm1(-age / _WAKE_S))
        area = smoothstep(age / _WAKING_S) * (1 - s) ** 1.5
        key = walkers.key[falls.owner]
        number = falls.number * self.legs.strike.shape[1] + falls.leg
        u = self._units(key, number, 0 * key)
        turn = 2 * np.pi * u[:, 0]
        stir = STIR_M_S * u[:, 1, None] * np.stack((np.cos(turn), np.sin(turn)), axis=1)
        xy = fell.xy + wake[:, None] * fell.heading + (stir + self.drift(1.0)) * age[:, None]
        ground, slope = self._ground_below(walkers.corner, xy, radius)
        trail = self.trail_centres(walkers, falls.owner, time_s)
        climb = STEEPEST * np.linalg.norm(xy - trail[:, :2], axis=1)
        base = np.column_stack((xy, np.clip(ground, trail[:, 2] - climb, trail[:, 2] + climb)))
        area = area * (FAINTEST + (1 - FAINTEST) * u[:, 2])
        return Puffs(base, slope, radius, height, age, area, fell.xy, key, number)

    def trail_centres(self, walkers: Walkers, owner: Ints, time_s: float) -> Points:
        """Compute the points of the ground in the middle of walkers' trails, (m, 3) [m].

        They are where each walker was half a puff's life ago, and as far downwind as the dust of
        then has drifted.
        """
        body = walkers.rounds.take(owner).at(time_s - LIFE_S / 2)
        xy = walkers.home[owner] + body.offset + self.drift(LIFE_S / 2)
        return np.column_stack((xy, self.walkers.ground.height(walkers.corner, xy)))

    def object_keys(self, cell_x: Ints, cell_y: Ints, index: Ints) -> Ints:
        """Return a number of each object of the field, by its cell and index, (n,)."""
        key = np.uint64(self.walkers.seed), hash_name(self.name)
        found: Ints = random_words(cell_x, cell_y, index, 0, *key)[:, 0].view(np.int64)
        return found

    def _ground_below(
        self, corner: Corner, xy: Float64[np.ndarray, "m 2"], radius: Reals
    ) -> tuple[Reals, Float64[np.ndarray, "m 2"]]:
        sides = np.array(((1, 0), (-1, 0), (0, 1), (0, -1)), np.float64)
        edge = (xy + sides[:, None] * radius[:, None]).reshape(-1, 2)
        east, west, north, south = self.walkers.ground.height(corner, edge).reshape(4, -1)
        slope = np.stack((east - west, north - south), axis=1) / (2 * radius[:, None])
        steep = np.linalg.norm(slope, axis=1)
        slope = slope * (STEEPEST / np.maximum(steep, STEEPEST))[:, None]
        return (east + west + north + south) / 4, slope

    def _wisps(self, puffs: Puffs, row: Ints, wisp: Ints) -> tuple[Points, Reals]:
        """Places of wisps (m, 3) [m], and the area of each over the full one, (m,)."""
        flat, up, _, area = self._wisp_states(puffs, row, wisp)
        return _above_ground(puffs, row, flat, up), area

    def _grains(self, puffs: Puffs, row: Ints, wisp: Ints, grain: Ints) -> tuple[Points, Reals]:
        flat, up, squash, area = self._wisp_states(puffs, row, wisp)
        number = 1 + WISPS + wisp * GRAINS + grain
        at = points_in_ball(self._units(puffs.key[row], puffs.footfall[row], number))
        flat += WISP * puffs.radius[row, None] * at[:, :2]
        up = up + WISP * puffs.height[row] * squash * at[:, 2]
        return _above_ground(puffs, row, flat, up), area

    def _wisp_states(
        self, puffs: Puffs, row: Ints, wisp: Ints
    ) -> tuple[np.ndarray, Reals, Reals, Reals]:
        """Offsets (m, 2) of wisps from the middle of their puffs [m], height, squash and area."""
        u = self._units(puffs.key[row], puffs.footfall[row], 1 + wisp)
        turn, out = 2 * np.pi * u[:, 0], puffs.radius[row] * np.sqrt(u[:, 1])
        flat = out[:, None] * np.stack((np.cos(turn), np.sin(turn)), axis=1)
        return flat, *puffs._wisps(row, u[:, 2], u[:, 3])

    def _units(self, key: Ints, footfall: Ints, number: Ints) -> Float64[np.ndarray, "m 4"]:
        return random_units(key, footfall, number, 1, self.walkers.seed, hash_name(self.name))

    def _recent_footfalls(
        self, at: Moment, parts: Parts, rows: Ints
    ) -> tuple[np.ndarray, Footfalls]:
        """The last footfalls of the walkers of trails, and the row of the trail of each."""
        legs, walkers = self.legs, at.sources
        slots = legs.slots(LIFE_S)
        each = footfalls(walkers, legs, parts.object[rows], slots, at.time_s)
        parent = np.repeat(rows, slots * legs.strike.shape[1])
        treads = legs.walks[walkers.prototype[each.owner], each.leg]
        return parent[treads], each.take(treads)

    def _is_in_air(self, at: Moment, falls: Footfalls) -> Bool[np.ndarray, " m"]:
        fell: Landing = landing(at.sources, self.legs, falls)
        since = at.time_s - fell.time_s
        return (since >= 0) & (since < LIFE_S)

    def _distinct(self, at: Moment, parts: Parts, rows: Ints) -> tuple[Puffs, Ints, Ints, Ints]:
        """Puffs of these parts, each once; row of each part's puff, and its wisp and its grain."""
        footfall, rest = np.divmod(parts.part[rows] - 1, _OF_PUFF)
        wisp, grain = np.divmod(rest - 1, _OF_WISP)
        footfall -= self._earliest
        first = footfall.min(initial=0)
        span = footfall.max(initial=0) - first + 1
        both, row = np.unique(parts.object[rows] * span + footfall - first, return_inverse=True)
        owner, number = np.divmod(both, span)
        cycle, leg = np.divmod(number + first, self.legs.strike.shape[1])
        puffs = self.puffs(at.sources, Footfalls(owner, leg, cycle), at.time_s)
        return puffs, row, wisp, grain - 1

    @property
    def _earliest(self) -> int:
        legs = self.legs
        return math.ceil(_BEFORE_S / float(legs.period.min())) * legs.strike.shape[1]


def _above_ground(puffs: Puffs, row: Ints, flat: Float64[np.ndarray, "m 2"], up: Reals) -> Points:
    """Places at offsets ``flat`` from the middle of puffs and heights ``up`` above the ground."""
    at = puffs.base[row].copy()
    at[:, :2] += flat
    at[:, 2] += (puffs.slope[row] * flat).sum(axis=1) + up
    return at


def _hierarchy(stride: float, far: float, puffs: int) -> Hierarchy:
    """Sizes of the levels of a trail, of a prototype with this stride [m].

    far    largest horizontal distance of puffs from the trail's middle [m]
    puffs  largest number of puffs that are alive
    """
    stride = stride or 1.0
    tilted = STEEPEST * OLD
    in_wisp = WISP * math.hypot(OLD, tilted + HIGH)
    in_puff = math.hypot(OLD, tilted + HIGH / 2)
    far = math.hypot(far, STEEPEST * far + HIGH * stride / 2)
    separation = np.array([0.0, far, in_puff * stride, in_wisp * stride])
    balls = GRAIN * stride * np.sqrt([WISPS * GRAINS, WISPS_EACH * GRAINS, GRAINS_EACH, 1])
    B = balls.copy()
    for level in (2, 1, 0):
        B[level] = separation[level + 1] + max(balls[level], B[level + 1])
    count = np.array([max(puffs, 1) * WISPS * GRAINS, WISPS * GRAINS, GRAINS, 1])
    return Hierarchy(
        parent=np.arange(-1, 3),
        level=np.arange(4),
        position=np.zeros((4, 3)),
        P=GRAIN * stride * np.sqrt(np.pi * count),
        R=B,
        B=B * (1 + 1e-9) + 1e-9,
        separation=separation,
    )
