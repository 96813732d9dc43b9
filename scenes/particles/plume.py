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
from numba import njit

from lod.arrays import Ints, Points, Reals, expand
from lod.camera import GRID_M, Corner
from lod.errors import InputError
from lod.hierarchy import Hierarchy
from lod.pruner import BlendWeights, Parts
from lod.shapes import Sticks, Triangles
from lod.view import View
from scenes.ground.relief import Ground
from scenes.noise import hash_name, philox4x64, unit_float

_CORNERS = np.array(((1, 0, 0), (0, 1, 0), (-1, 0, 0), (0, -1, 0), (0, 0, 1), (0, 0, -1)), float)
_FACES = np.array(
    ((0, 1, 4), (1, 2, 4), (2, 3, 4), (3, 0, 4), (1, 0, 5), (2, 1, 5), (3, 2, 5), (0, 3, 5))
)
_SOOT = 0.04
"""Albedo of flames."""


def ball_sticks(
    centre: Points, radius: Reals, tint: Ints, tints: Float64[np.ndarray, "t 3"], owner: Ints
) -> Sticks:
    """Make balls, as sticks of no length."""
    return Sticks(centre, centre, radius, radius, tint, tints, owner)


def flame_octahedra(
    centre: Points,
    radius: Reals,
    stretch: float,
    glow: Ints,
    glows: Float64[np.ndarray, "t 3"],
    owner: Ints,
) -> Triangles:
    """Make upright octahedra of eight faces that give light, ``stretch`` times as high as wide."""
    scale = radius[:, None] * np.array((1.0, 1.0, stretch))
    vertices = (centre[:, None] + scale[:, None] * _CORNERS).reshape(-1, 3)
    faces = (len(_CORNERS) * np.arange(len(centre))[:, None, None] + _FACES).reshape(-1, 3)
    return Triangles(
        vertices=vertices,
        normals=np.tile(_CORNERS, (len(centre), 1)),
        colours=np.full((len(vertices), 3), _SOOT),
        faces=faces,
        owner=np.repeat(owner, len(_FACES)),
        glow=np.repeat(glow, len(_FACES)),
        glows=glows,
    )


def points_in_ball(u: Float64[np.ndarray, "n k"]) -> Points:
    """Spread points evenly in the unit ball, from three uniform numbers each, (n, 3)."""
    z, turn = 2 * u[:, 1] - 1, 2 * np.pi * u[:, 2]
    flat = np.sqrt(1 - z * z)
    place = np.stack((flat * np.cos(turn), flat * np.sin(turn), z), axis=1)
    return place * np.cbrt(u[:, 0])[:, None]


def smoothstep(x: Reals) -> Reals:
    """Smooth step: from 0 to 1 as x does, level at both ends, (n,)."""
    t = np.clip(x, 0.0, 1.0)
    return t * t * (3 - 2 * t)


@njit(cache=True)
def random_units(birth, number, seed, word):  # type: ignore[no-untyped-def]
    """Eight numbers in [0, 1) for each birth and number, (n,) int64 each, (n, 8)."""
    u = np.empty((len(birth), 8))
    key, zero = np.uint64(seed), np.uint64(0)
    for i in range(len(birth)):
        for half in range(2):
            words = philox4x64(
                np.uint64(birth[i]), np.uint64(number[i]), np.uint64(half), zero, key, word
            )
            for k in range(4):
                u[i, 4 * half + k] = unit_float(words[k])
    return u


PARTICLES_PER_BALL = 8
"""Particles that one larger ball replaces in a puff's leaf appearance."""

SHORTEST_LIFE = 0.75
"""Shortest life of a puff, as a share of the longest."""


@dataclass(frozen=True)
class PlumeKind:
    """Numbers of one kind of plume; lengths are of a plume of size 1.

    rate       puffs born in a second; life_s: longest life of one [s]
    particles  in a puff, a multiple of PARTICLES_PER_BALL
    height     to which a puff rises in its life [m]; lean: how far the wind takes it meanwhile [m]
    mouth      radius in which puffs are born [m]; wander: radius of their winding at the end [m]
    young, old radius of a puff at birth and at the end [m]
    grain      radius of a particle beside its puff's, at its largest
    stretch    its half length beside its radius: 1 = a ball
    colours    (k, 3) from birth to death: albedo, or radiance where it glows
    glows      whether it is a flame, which gives light and is bounded by triangles
    """

    rate: float
    life_s: float
    particles: int
    height: float
    lean: float
    mouth: float
    wander: float
    young: float
    old: float
    grain: float
    stretch: float
    colours: tuple[tuple[float, float, float], ...]
    glows: bool = False

    def __post_init__(self) -> None:
        if self.particles % PARTICLES_PER_BALL or self.particles < PARTICLES_PER_BALL:
            raise InputError("particles", self.particles, f"a multiple of {PARTICLES_PER_BALL}")
        if not (self.grain > 0 and self.stretch >= 1):
            raise InputError("grain, stretch", (self.grain, self.stretch), "above 0; 1 or more")
        if not self.rate * self.life_s * SHORTEST_LIFE >= 2:
            rule = "births a second such that one puff at least is always alive"
            raise InputError("rate", self.rate, rule, f"try {4 / self.life_s:.3g}")

    @property
    def widest(self) -> float:
        """Return the largest radius of a puff [m]."""
        return max(self.young, self.old)


SMOKE = PlumeKind(
    rate=5.0,
    life_s=9.0,
    particles=240,
    height=13.0,
    lean=5.0,
    mouth=0.12,
    wander=0.7,
    young=0.16,
    old=1.5,
    grain=0.03,
    stretch=1.0,
    colours=((0.16, 0.15, 0.14), (0.30, 0.30, 0.30), (0.42, 0.42, 0.43)),
)
"""Smoke of a wood fire in light wind; chosen by eye."""

FLAMES = PlumeKind(
    rate=26.0,
    life_s=0.9,
    particles=32,
    height=1.05,
    lean=0.14,
    mouth=0.24,
    wander=0.07,
    young=0.15,
    old=0.05,
    grain=0.13,
    stretch=3.0,
    colours=((0.9, 0.22, 0.02), (0.7, 0.12, 0.008), (0.45, 0.05, 0.002), (0.2, 0.012, 0.0005)),
    glows=True,
)
"""Flames of a campfire, hotter below. Radiance in the units of the sky at dusk, chosen by eye."""

KINDS = {"smoke": SMOKE, "flames": FLAMES}


SMALLEST, LARGEST = 0.7, 1.3
"""Range of the particles' sizes, over the mean."""

_WAKING, _DYING = 0.12, 0.4
"""Shares of life over which particles grow to full size, and shrink to nothing."""

_GROWTH, _BENT, _SLOWING = 0.7, 1.6, 0.85
"""Exponents of age by which a puff spreads, drifts ever faster, and rises ever slower."""

_LEAST_SIZE = 1e-3
"""Least size of a particle at birth and death, as a share of its full size."""


class Puffs(NamedTuple):
    """State of n puffs at one time.

    age (n,)        share of life that is over
    middle (n, 3), radius (n,)  of each puff [m]
    size (n,)       factor on the size of its particles, above 0 and at most 1
    """

    age: np.ndarray
    middle: np.ndarray
    radius: np.ndarray
    size: np.ndarray


@dataclass(frozen=True)
class Growth:
    """Law by which the puffs of one plume live.

    size         factor on every length
    azimuth_deg  where the wind blows to, clockwise from north [degrees]
    """

    kind: PlumeKind
    name: str
    seed: int
    size: float
    azimuth_deg: float

    def live(self, time_s: float) -> Ints:
        """Return the birth numbers of the puffs that live at a time, ascending."""
        rate, life = self.kind.rate, self.kind.life_s
        births = np.arange(math.floor((time_s - life) * rate) - 1, math.floor(time_s * rate) + 2)
        born, lives = self.lifetimes(births)
        return births[(born <= time_s) & (time_s < born + lives)]

    def lifetimes(self, births: Ints) -> tuple[Reals, Reals]:
        """Return the times of birth and lengths of life of puffs, (n,) each [s]."""
        u = random_units(births, 0 * births, self.seed, hash_name(self.name))
        lives = self.kind.life_s * (SHORTEST_LIFE + (1 - SHORTEST_LIFE) * u[:, 1])
        return (births + u[:, 0]) / self.kind.rate, lives

    def puffs(self, time_s: float, births: Ints, base: Float64[np.ndarray, "3"]) -> Puffs:
        """Return the puffs of these births at a time, alive or not.

        base (3,)  point that the plume rises from [m]
        """
        kind, u = self.kind, random_units(births, 0 * births, self.seed, hash_name(self.name))
        born, lives = self.lifetimes(births)
        age = (time_s - born) / lives
        s = np.maximum(age, 0.0)
        mouth = kind.mouth * np.sqrt(u[:, 2])
        wander, turn = kind.wander * s, 2 * np.pi * (u[:, 4] + (0.5 + u[:, 5]) * s)
        middle = self.axis(s)
        middle[:, 0] += mouth * np.cos(2 * np.pi * u[:, 3]) + wander * np.cos(turn)
        middle[:, 1] += mouth * np.sin(2 * np.pi * u[:, 3]) + wander * np.sin(turn)
        radius = kind.young + (kind.old - kind.young) * s**_GROWTH
        size = np.maximum(smoothstep(s / _WAKING) * smoothstep((1 - s) / _DYING), _LEAST_SIZE)
        at = base + self.size * middle
        return Puffs(age, at, self.size * np.maximum(radius, _LEAST_SIZE), size)

    def members(self, birth: Ints, number: Ints) -> tuple[Points, Reals]:
        """Place particles in puffs of radius 1, (n, 3), with sizes over the mean, (n,)."""
        u = random_units(birth, number + 1, self.seed, hash_name(self.name))
        return points_in_ball(u), SMALLEST + (LARGEST - SMALLEST) * u[:, 3]

    def areas(self, births: Ints) -> tuple[Float64[np.ndarray, "u k"], Ints]:
        """Compute areas (u, k) of all particles of distinct puffs, and each birth's row of them,
        (n,).

        A particle of size 1 has area 1.
        """
        distinct, row = np.unique(births, return_inverse=True)
        n = self.kind.particles
        every = np.tile(np.arange(n), len(distinct))
        sizes = self.members(np.repeat(distinct, n), every)[1]
        return (sizes**2).reshape(len(distinct), n), row

    def axis(self, age: Reals) -> Points:
        """Compute the path of a puff by age in a plume of size 1 that does not wind, (n, 3) [m]."""
        wind = math.radians(self.azimuth_deg)
        away = self.kind.lean * age**_BENT
        up = self.kind.height * age**_SLOWING
        return np.stack((away * math.sin(wind), away * math.cos(wind), up), axis=1)


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
