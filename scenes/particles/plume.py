"""Smoke and flames as particle systems: a plume, its puffs, and their particles (Blake 1987 §1.3).

After W. T. Reeves, "Particle systems: a technique for modeling a class of fuzzy objects", SIGGRAPH
'83 Proceedings, p. 359: particles are born at random, move, change size and colour, and die. Here
they are born in clusters, and everything about puff k is a function of (seed, k, time): no frame
needs another, and time may run any way.

Level 0 is the plume, level 1 its puffs, level 2 their particles. The leaf appearance of n hidden
particles is a few larger ones, as many times larger in area as they are fewer: as porous, and with
about the same cover. Inner appearances are empty. Sizes are the largest that a puff or particle
ever has:

    P  √ of the largest cross-sections of the leaf appearance, added up
    R  of a particle its half length; of a puff how far its particles reach from its middle; of the
       plume the same from the middle of its axis
"""

import math
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
from jaxtyping import Float64, Int64

from lod.arrays import Ints, Points, Reals, expand
from lod.camera import GRID_M, Corner
from lod.errors import InputError
from lod.hierarchy import Hierarchy
from lod.pruner import BlendWeights, Parts
from lod.shapes import Sticks, Triangles
from lod.view import View
from scenes.particles.growth import LARGEST, Growth, Puffs
from scenes.particles.kinds import PARTICLES_PER_BALL, PlumeKind
from scenes.particles.shapes import ball_sticks, flame_octahedra
from scenes.terrain.ground import Ground

CLUMPS = 4
"""Balls for each puff in a plume's leaf appearance."""

SHADES = 8
"""Number of colours between birth and death."""


@dataclass(frozen=True)
class PlumeState:
    """State that the parts of one frame share: its grid corner and its time [s]."""

    corner: Corner
    time_s: float


class DrawnParticles(NamedTuple):
    """Particles that are drawn for parts.

    owner, birth (n,)  row of the part, and birth number of its puff
    area (n,)          area over that of one particle of size 1
    offset (n, 3)      place in a puff of radius 1
    """

    owner: np.ndarray
    birth: np.ndarray
    area: np.ndarray
    offset: np.ndarray


@dataclass(frozen=True)
class Plume:
    """A Representation: smoke or flames rising from a place on the ground.

    x, y     from the plane's origin [m]; size: factor on every length; azimuth_deg: where the wind
             blows to, clockwise from north
    """

    name: str
    kind: PlumeKind
    seed: int
    x: float
    y: float
    ground: Ground
    size: float = 1.0
    azimuth_deg: float = 60.0

    def __post_init__(self) -> None:
        if not (math.isfinite(self.size) and self.size > 0):
            raise InputError(f"{self.name}.size", self.size, "a size factor above 0")

    @cached_property
    def growth(self) -> Growth:
        """Return the law by which its puffs live."""
        return Growth(self.kind, self.name, self.seed, self.size, self.azimuth_deg)

    @cached_property
    def hierarchy(self) -> Hierarchy:
        """Return the sizes that all parts of a level have in common, one row for each level."""
        kind, n = self.kind, self.kind.particles
        half = LARGEST * kind.grain * kind.stretch
        reach = kind.widest * (1 + half * math.sqrt(max(PARTICLES_PER_BALL, n / CLUMPS)))
        axis = self.growth.axis(np.linspace(0, 1, 257))
        bend = float(np.linalg.norm(axis - self.growth.axis(np.array([0.5])), axis=1).max())
        separation = 1.01 * bend + kind.mouth + kind.wander
        side = (
            math.sqrt((2.0 if kind.glows else math.pi) * kind.stretch)
            * LARGEST
            * kind.grain
            * kind.widest
        )
        live = kind.rate * kind.life_s
        R = np.array([separation + reach, reach, half * kind.widest]) * self.size
        return Hierarchy(
            parent=np.array([-1, 0, 1]),
            level=np.array([0, 1, 2]),
            position=np.zeros((3, 3)),
            P=side * np.sqrt([n * live, n, 1]) * self.size,
            R=R,
            B=R * (1 + 1e-9),
            separation=np.array([0.0, separation, kind.widest]) * self.size,
        )

    @property
    def top_m(self) -> float:
        """Bound on its height above the ground under it [m]."""
        return float(self.size * self.growth.axis(np.array([0.5]))[0, 2] + self.hierarchy.B[0])

    def roots(self, view: View) -> Parts:
        """Return the plume itself, whether near or far."""
        time = PlumeState(view.camera.corner, view.time_s)
        zero = np.zeros(1, np.int64)
        return self._parts(time, view, zero, zero, zero - 1, np.ones(1))

    def parts_of(self, parts: Parts, view: View) -> Parts:
        """Return the live puffs of a plume, the particles of a puff."""
        n, births = self.kind.particles, self.growth.live(parts.state.time_s)
        count = np.array([len(births), n, 0])[parts.level]
        parent, number = expand(count)
        level = parts.level[parent] + 1
        puff = self._puff_id(births[np.where(level == 1, number, 0)])
        part = np.where(level == 1, puff, parts.part[parent] + 1 + number)
        share = self._shares(parts.state, births, level, part, number)
        return self._parts(parts.state, view, part, parts.object[parent], parent, share)

    def appearance(self, parts: Parts, weights: BlendWeights) -> Sticks | Triangles:
        """Make balls of smoke or tongues of flame: leaf appearances, as much as each shows."""
        grains, time = self._drawn_particles(parts, weights), parts.state
        puffs = self._puffs(time, grains.birth)
        last = SHADES - 1
        shade = np.minimum((np.clip(puffs.age, 0, 1) * SHADES).astype(np.int64), last)
        radius = puffs.radius * puffs.size * self.kind.grain * np.sqrt(grains.area)
        centre = puffs.middle + puffs.radius[:, None] * grains.offset
        colours = _colour_steps(self.kind.colours)
        if self.kind.glows:
            return flame_octahedra(centre, radius, self.kind.stretch, shade, colours, grains.owner)
        return ball_sticks(centre, radius, shade, colours, grains.owner)

    def later(self, parts: Parts, view: View, time_s: float) -> Parts:
        """Return the same parts at another time; what has died by then has the least size."""
        return replace(parts, state=replace(parts.state, time_s=time_s))

    def _parts(
        self, time: PlumeState, view: View, part: Ints, object_: Ints, parent: Ints, share: Reals
    ) -> Parts:
        level = self._levels(part)
        inside, outside = view.limits(self.hierarchy)
        position = self._places(time, part)
        return Parts(
            position=position,
            centre=position,
            bound=self.hierarchy.B[level],
            limit=inside[level],
            limit_offscreen=outside[level],
            level=level,
            object=object_,
            part=part,
            parent=parent,
            share=share,
            state=time,
        )

    def _places(self, time: PlumeState, part: Ints) -> Points:
        """Origins of parts, (n, 3) [m]."""
        birth, number = self._birth_and_number(part)
        puffs = self._puffs(time, birth)
        at = puffs.middle.copy()
        rows = np.flatnonzero(number >= 0)
        at[rows] += puffs.radius[rows, None] * self.growth.members(birth[rows], number[rows])[0]
        at[part == 0] = self._base(time.corner) + self.size * self.growth.axis(np.array([0.5]))[0]
        return at

    def _drawn_particles(self, parts: Parts, weights: BlendWeights) -> DrawnParticles:
        """What is drawn: CLUMPS for each puff of a plume, one for PARTICLES_PER_BALL particles."""
        n, births = self.kind.particles, self.growth.live(parts.state.time_s)
        count = np.array([CLUMPS * len(births), n // PARTICLES_PER_BALL, 1])[parts.level] * (
            weights.leaf > 0
        )
        owner, number = expand(count)
        birth, member = self._birth_and_number(parts.part[owner])
        level = parts.level[owner]
        birth = np.where(level == 0, births[np.where(level == 0, number // CLUMPS, 0)], birth)
        of_each = np.array([n // CLUMPS, PARTICLES_PER_BALL, 1])[level]
        member = np.where(level == 2, member, of_each * np.where(level, number, number % CLUMPS))
        areas, row = self.growth.areas(birth)
        upto = np.column_stack((np.zeros(len(areas)), np.cumsum(areas, axis=1)))
        area = upto[row, member + of_each] - upto[row, member]
        offset = self.growth.members(birth, member)[0]
        return DrawnParticles(owner, birth, area * weights.leaf[owner], offset)

    def _shares(
        self,
        time: PlumeState,
        births: Int64[np.ndarray, " b"],
        level: Ints,
        part: Ints,
        number: Ints,
    ) -> Reals:
        """Share of each part in the area of its whole, (n,)."""
        puffs = self._puffs(time, births)
        of_puff = (puffs.radius * puffs.size) ** 2
        share = np.ones(len(part))
        rows = level == 1
        share[rows] = (of_puff / of_puff.sum())[number[rows]]
        rows = np.flatnonzero(level == 2)
        birth, member = self._birth_and_number(part[rows])
        areas, row = self.growth.areas(birth)
        share[rows] = areas[row, member] / areas.sum(axis=1)[row]
        return share

    def _puffs(self, time: PlumeState, births: Ints) -> Puffs:
        """Puffs as they are in a frame."""
        return self.growth.puffs(time.time_s, births, self._base(time.corner))

    def _base(self, corner: Corner) -> Float64[np.ndarray, "3"]:
        """Point of the ground that it rises from, (3,) [m]."""
        xy = np.array([[self.x - corner.x * GRID_M, self.y - corner.y * GRID_M]])
        return np.append(xy[0], self.ground.height(corner, xy))

    def _puff_id(self, birth: Ints) -> Ints:
        """Part numbers of puffs; those of puffs born before time 0 are above 0, too."""
        earliest = math.ceil(self.kind.rate * self.kind.life_s) + 2
        return 1 + (birth + earliest) * (self.kind.particles + 1)

    def _birth_and_number(self, part: Ints) -> tuple[Ints, Ints]:
        """Birth number of each part's puff, and number of the particle in it, -1 = the puff."""
        first = int(self._puff_id(np.zeros(1, np.int64))[0])
        birth, number = np.divmod(part - first, self.kind.particles + 1)
        return birth, number - 1

    def _levels(self, part: Ints) -> Ints:
        return np.where(part == 0, 0, np.where(self._birth_and_number(part)[1] < 0, 1, 2))


def _colour_steps(colours: tuple[tuple[float, float, float], ...]) -> Float64[np.ndarray, "s 3"]:
    """SHADES colours at even steps from the first to the last, (SHADES, 3)."""
    at = np.linspace(0, len(colours) - 1, SHADES)
    columns = np.array(colours).T
    return np.stack([np.interp(at, np.arange(len(colours)), column) for column in columns], axis=1)
