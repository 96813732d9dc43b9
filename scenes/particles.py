"""Smoke and flames as particle systems: a plume, its puffs, and the particles in them (§1.3).

After W. T. Reeves, "Particle systems: a technique for modeling a class of fuzzy objects", SIGGRAPH
'83 Proceedings, p. 359: particles are born at random, move, change size and colour, and die. Here
they are born in clusters, and everything about puff k is a function of (seed, k, time): no frame
needs another, and time may run any way.

Level 0 is the plume, level 1 its puffs, level 2 their particles. What stands for n hidden particles
is a few larger ones, as many times larger in area as they are fewer: as porous, and about the same
cover. Inner appearances are nothing. Sizes are the largest that a puff or particle ever has:

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

from lod.arrays import Ints, Points, Reals
from lod.camera import GRID_M, Corner
from lod.errors import InputError
from lod.hierarchy import Hierarchy
from lod.parts import Look, Parts, Sticks, Triangles
from lod.view import View
from scenes.field import Ground
from scenes.particle_shapes import balls, chances, tongues
from scenes.random import word_of

STAND_INS = 8
"""Particles for which one larger stands in a puff's leaf appearance."""

CLUMPS = 4
"""Those that stand for each puff in a plume's leaf appearance."""

_SMALLEST, _LARGEST = 0.7, 1.3
_SHORTEST_LIFE = 0.75
_WAKING, _DYING = 0.12, 0.4
"""Shares of life over which particles come to size, and dwindle."""

_GROWTH, _BENT, _SLOWING = 0.7, 1.6, 0.85
"""Powers of age: how a puff spreads, drifts ever faster, and rises ever slower."""

SHADES = 8
"""Colours between birth and death."""

_SPARK = 1e-3
"""Least size of what is just born, or has just died, as a share of its full size."""


@dataclass(frozen=True)
class Kind:
    """What a plume is made of; lengths at size 1.

    rate       puffs born in a second; life_s: longest life of one [s]
    particles  in a puff, a multiple of STAND_INS
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
        if self.particles % STAND_INS or self.particles < STAND_INS:
            raise InputError("particles", self.particles, f"a multiple of {STAND_INS}")
        if not (self.grain > 0 and self.stretch >= 1):
            raise InputError("grain, stretch", (self.grain, self.stretch), "above 0; 1 or more")
        if not self.rate * self.life_s * _SHORTEST_LIFE >= 2:
            rule = "births a second such that one puff at least is always alive"
            raise InputError("rate", self.rate, rule, f"try {4 / self.life_s:.3g}")

    @property
    def widest(self) -> float:
        """Largest radius of a puff [m]."""
        return max(self.young, self.old)


SMOKE = Kind(
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
"""Of a wood fire in light wind; chosen by eye."""

FLAMES = Kind(
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
"""Of a campfire; hotter below. Radiance in the units of the sky at dusk, chosen by eye."""

KINDS = {"smoke": SMOKE, "flames": FLAMES}


@dataclass(frozen=True)
class Moment:
    """What a frame's parts are parts of: where it counts from, and when."""

    corner: Corner
    time_s: float


class Puffs(NamedTuple):
    """Puffs at some time: share of life gone (n,), middle (n, 3) [m], radius (n,) [m], and size
    (n,) of their particles beside the largest they get to, above 0.
    """

    age: np.ndarray
    middle: np.ndarray
    radius: np.ndarray
    size: np.ndarray


class Grains(NamedTuple):
    """What is drawn: owner (n,), birth number of its puff (n,), area beside that of one particle
    of size 1 (n,), and place in a puff of radius 1 (n, 3).
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
    kind: Kind
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
    def hierarchy(self) -> Hierarchy:
        """One row for each level: what all its parts have in common."""
        kind, n = self.kind, self.kind.particles
        half = _LARGEST * kind.grain * kind.stretch
        reach = kind.widest * (1 + half * math.sqrt(max(STAND_INS, n / CLUMPS)))
        axis = self._axis(np.linspace(0, 1, 257))
        bend = float(np.linalg.norm(axis - self._axis(np.array([0.5])), axis=1).max())
        separation = 1.01 * bend + kind.mouth + kind.wander
        side = (
            math.sqrt((2.0 if kind.glows else math.pi) * kind.stretch)
            * _LARGEST
            * kind.grain
            * kind.widest
        )
        live = kind.rate * kind.life_s
        R = np.array([separation + reach, reach, half * kind.widest]) * self.size
        return Hierarchy(
            whole=np.array([-1, 0, 1]),
            level=np.array([0, 1, 2]),
            position=np.zeros((3, 3)),
            P=side * np.sqrt([n * live, n, 1]) * self.size,
            R=R,
            B=R * (1 + 1e-9),
            separation=np.array([0.0, separation, kind.widest]) * self.size,
        )

    @property
    def top_m(self) -> float:
        """Height above the ground under it that nothing of it is above [m]."""
        return float(self.size * self._axis(np.array([0.5]))[0, 2] + self.hierarchy.B[0])

    def roots(self, view: View) -> Parts:
        """The plume itself, whether near or far."""
        time = Moment(view.camera.corner, view.time_s)
        zero = np.zeros(1, np.int64)
        return self._parts(time, view, zero, zero, zero - 1, np.ones(1))

    def parts_of(self, parts: Parts, view: View) -> Parts:
        """The live puffs of a plume, the particles of a puff."""
        n, births = self.kind.particles, self._live(parts.state.time_s)
        count = np.array([len(births), n, 0])[parts.level]
        whole = np.repeat(np.arange(len(parts)), count)
        number = np.arange(len(whole)) - np.repeat(np.cumsum(count) - count, count)
        level = parts.level[whole] + 1
        puff = self._code(births[np.where(level == 1, number, 0)])
        part = np.where(level == 1, puff, parts.part[whole] + 1 + number)
        share = self._shares(parts.state, births, level, part, number)
        return self._parts(parts.state, view, part, parts.object[whole], whole, share)

    def appearance(self, parts: Parts, look: Look) -> Sticks | Triangles:
        """Balls of smoke or tongues of flame: leaf appearances alone, as much as each shows."""
        grains, time = self._grains(parts, look), parts.state
        puffs = self._puffs(time, grains.birth)
        last = SHADES - 1
        shade = np.minimum((np.clip(puffs.age, 0, 1) * SHADES).astype(np.int64), last)
        radius = puffs.radius * puffs.size * self.kind.grain * np.sqrt(grains.area)
        centre = puffs.middle + puffs.radius[:, None] * grains.offset
        colours = _shades(self.kind.colours)
        if self.kind.glows:
            return tongues(centre, radius, self.kind.stretch, shade, colours, grains.owner)
        return balls(centre, radius, shade, colours, grains.owner)

    def later(self, parts: Parts, view: View, time_s: float) -> Parts:
        """The same parts as they look at another time; what has died by then is but a spark."""
        return replace(parts, state=replace(parts.state, time_s=time_s))

    def _parts(
        self, time: Moment, view: View, part: Ints, object_: Ints, whole: Ints, share: Reals
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
            whole=whole,
            share=share,
            state=time,
        )

    def _places(self, time: Moment, part: Ints) -> Points:
        """Where the origins of parts are, (n, 3) [m]."""
        birth, number = self._names(part)
        puffs = self._puffs(time, birth)
        at = puffs.middle.copy()
        rows = np.flatnonzero(number >= 0)
        at[rows] += puffs.radius[rows, None] * self._members(birth[rows], number[rows])[0]
        at[part == 0] = self._base(time.corner) + self.size * self._axis(np.array([0.5]))[0]
        return at

    def _grains(self, parts: Parts, look: Look) -> Grains:
        """What is drawn: of plumes CLUMPS for each puff, of puffs one for STAND_INS particles."""
        n, births = self.kind.particles, self._live(parts.state.time_s)
        count = np.array([CLUMPS * len(births), n // STAND_INS, 1])[parts.level] * (look.leaf > 0)
        owner = np.repeat(np.arange(len(parts)), count)
        number = np.arange(len(owner)) - np.repeat(np.cumsum(count) - count, count)
        birth, member = self._names(parts.part[owner])
        level = parts.level[owner]
        birth = np.where(level == 0, births[np.where(level == 0, number // CLUMPS, 0)], birth)
        of_each = np.array([n // CLUMPS, STAND_INS, 1])[level]
        member = np.where(level == 2, member, of_each * np.where(level, number, number % CLUMPS))
        areas, row = self._areas(birth)
        upto = np.column_stack((np.zeros(len(areas)), np.cumsum(areas, axis=1)))
        area = upto[row, member + of_each] - upto[row, member]
        offset = self._members(birth, member)[0]
        return Grains(owner, birth, area * look.leaf[owner], offset)

    def _shares(
        self,
        time: Moment,
        births: Int64[np.ndarray, " b"],
        level: Ints,
        part: Ints,
        number: Ints,
    ) -> Reals:
        """Share of each part in the area of its whole's, (n,)."""
        puffs = self._puffs(time, births)
        of_puff = (puffs.radius * puffs.size) ** 2
        share = np.ones(len(part))
        rows = level == 1
        share[rows] = (of_puff / of_puff.sum())[number[rows]]
        rows = np.flatnonzero(level == 2)
        birth, member = self._names(part[rows])
        areas, row = self._areas(birth)
        share[rows] = areas[row, member] / areas.sum(axis=1)[row]
        return share

    def _areas(self, births: Ints) -> tuple[Float64[np.ndarray, "u k"], Ints]:
        """Areas of all particles of each puff, those of size 1 being 1; and its row for each."""
        distinct, row = np.unique(births, return_inverse=True)
        n = self.kind.particles
        every = np.tile(np.arange(n), len(distinct))
        sizes = self._members(np.repeat(distinct, n), every)[1]
        return (sizes**2).reshape(len(distinct), n), row

    def _live(self, time_s: float) -> Ints:
        """Birth numbers of the puffs that live at a time, in a row."""
        rate, life = self.kind.rate, self.kind.life_s
        births = np.arange(math.floor((time_s - life) * rate) - 1, math.floor(time_s * rate) + 2)
        born, lives = self._born(births)
        return births[(born <= time_s) & (time_s < born + lives)]

    def _born(self, births: Ints) -> tuple[Reals, Reals]:
        """When puffs are born and how long each lives, (n,) each [s]."""
        u = chances(births, 0 * births, self.seed, word_of(self.name))
        lives = self.kind.life_s * (_SHORTEST_LIFE + (1 - _SHORTEST_LIFE) * u[:, 1])
        return (births + u[:, 0]) / self.kind.rate, lives

    def _puffs(self, time: Moment, births: Ints) -> Puffs:
        """Puffs as they are at a time, alive or not; lengths in metres."""
        kind, u = self.kind, chances(births, 0 * births, self.seed, word_of(self.name))
        born, lives = self._born(births)
        age = (time.time_s - born) / lives
        s = np.maximum(age, 0.0)
        mouth = kind.mouth * np.sqrt(u[:, 2])
        wander, turn = kind.wander * s, 2 * np.pi * (u[:, 4] + (0.5 + u[:, 5]) * s)
        middle = self._axis(s)
        middle[:, 0] += mouth * np.cos(2 * np.pi * u[:, 3]) + wander * np.cos(turn)
        middle[:, 1] += mouth * np.sin(2 * np.pi * u[:, 3]) + wander * np.sin(turn)
        radius = kind.young + (kind.old - kind.young) * s**_GROWTH
        size = np.maximum(_smooth(s / _WAKING) * _smooth((1 - s) / _DYING), _SPARK)
        at = self._base(time.corner) + self.size * middle
        return Puffs(age, at, self.size * np.maximum(radius, _SPARK), size)

    def _members(self, birth: Ints, number: Ints) -> tuple[Points, Reals]:
        """Where particles are in puffs of radius 1, (n, 3), and their sizes, (n,)."""
        u = chances(birth, number + 1, self.seed, word_of(self.name))
        z, turn = 2 * u[:, 1] - 1, 2 * np.pi * u[:, 2]
        flat = np.sqrt(1 - z * z)
        place = np.stack((flat * np.cos(turn), flat * np.sin(turn), z), axis=1)
        size = _SMALLEST + (_LARGEST - _SMALLEST) * u[:, 3]
        return place * np.cbrt(u[:, 0])[:, None], size

    def _axis(self, age: Reals) -> Points:
        """The way of a puff without its own wandering, from the ground, in sizes, (n, 3)."""
        wind = math.radians(self.azimuth_deg)
        away = self.kind.lean * age**_BENT
        up = self.kind.height * age**_SLOWING
        return np.stack((away * math.sin(wind), away * math.cos(wind), up), axis=1)

    def _base(self, corner: Corner) -> Float64[np.ndarray, "3"]:
        """Where it rises from, (3,) [m]."""
        xy = np.array([[self.x - corner.x * GRID_M, self.y - corner.y * GRID_M]])
        return np.append(xy[0], self.ground.height(corner, xy))

    def _code(self, birth: Ints) -> Ints:
        """Numbers of puffs as parts: those before time 0 too are above 0."""
        earliest = math.ceil(self.kind.rate * self.kind.life_s) + 2
        return 1 + (birth + earliest) * (self.kind.particles + 1)

    def _names(self, part: Ints) -> tuple[Ints, Ints]:
        """Birth number of each part's puff, and number of the particle in it, -1 = the puff."""
        first = int(self._code(np.zeros(1, np.int64))[0])
        birth, number = np.divmod(part - first, self.kind.particles + 1)
        return birth, number - 1

    def _levels(self, part: Ints) -> Ints:
        return np.where(part == 0, 0, np.where(self._names(part)[1] < 0, 1, 2))


def _smooth(x: Reals) -> Reals:
    """From 0 to 1 while x does, level at both ends."""
    t = np.clip(x, 0.0, 1.0)
    return t * t * (3 - 2 * t)


def _shades(colours: tuple[tuple[float, float, float], ...]) -> Float64[np.ndarray, "s 3"]:
    """SHADES colours evenly from the first to the last."""
    at = np.linspace(0, len(colours) - 1, SHADES)
    columns = np.array(colours).T
    return np.stack([np.interp(at, np.arange(len(colours)), column) for column in columns], axis=1)
