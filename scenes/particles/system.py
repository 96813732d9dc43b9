"""A particle system: what is born at random, moves, changes size and colour, and dies (Blake §1.3).

After W. T. Reeves, "Particle systems: a technique for modeling a class of fuzzy objects", SIGGRAPH
'83 Proceedings, p. 359. Smoke and flames, here, and the dust behind walkers
(``scenes.particles.dust``) are its kinds. Particles are born in clusters, here called puffs, and
everything about one is a function of its seed, its number and the time: no frame needs another, and
time may run any way.

Level 0 is all that comes of one source, level 1 its puffs, and the finest level single particles.
The leaf appearance of n hidden particles is one or a few larger ones, as many times larger in area
as they are fewer: as porous, and with about the same cover. Inner appearances are empty. Sizes are
the largest that a puff or particle ever has:

    P  √ of the largest cross-sections of the leaf appearance, added up
    R  of a particle its half length; of a puff how far anything of it can be from its middle; of a
       source the same from the middle of all its puffs

Of smoke and flames puff k is born at random in the k-th of even intervals. It rises, drifts, winds
about the middle of the plume and spreads; its particles grow, and shrink to nothing as it dies.
"""

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from jaxtyping import Float64

from lod.arrays import Ints, Points, Reals
from lod.camera import GRID_M, Corner
from lod.hierarchy import Hierarchy
from lod.kernels import njit
from lod.pruner import BlendWeights, Parts
from lod.shapes import Sticks, Triangles
from lod.view import View
from scenes.ground.relief import Ground
from scenes.noise import hash_name, philox4x64

SHADES = 8
"""Number of colours that the particles of one system have."""


@dataclass(frozen=True, eq=False)
class Moment:
    """What the parts of one frame share.

    corner, time_s   grid corner of the frame, and the time [s]
    variant (n,)     row of each source's sizes in ``hierarchies``
    limits (2, v, l) limit distances of each variant's levels, in view and out of it [m]
    sources          data of the system itself
    """

    corner: Corner
    time_s: float
    variant: np.ndarray
    limits: np.ndarray
    sources: Any = None


class Children(NamedTuple):
    """Parts of wholes: row of the whole, part number, place (n, 3) [m], share of its area."""

    parent: np.ndarray
    part: np.ndarray
    place: np.ndarray
    share: np.ndarray


class Drawn(NamedTuple):
    """Particles that are drawn for parts.

    owner (n,), place (n, 3)  row of the part, and middle of the particle [m]
    radius (n,)               radius of one particle that is not enlarged [m]
    area (n,)                 area over that of such a particle
    shade (n,)                row of its colour
    """

    owner: np.ndarray
    place: np.ndarray
    radius: np.ndarray
    area: np.ndarray
    shade: np.ndarray


class ParticleSystem(ABC):
    """A Representation; its kinds say where particles are, and this makes parts and shapes."""

    @property
    @abstractmethod
    def hierarchies(self) -> tuple[Hierarchy, ...]:
        """Return the sizes that all parts of a level have in common, one row for each level."""

    @abstractmethod
    def children(self, at: Moment, parts: Parts, rows: Ints, level: int) -> Children:
        """Return the direct parts of these rows, which are of one level and not the finest."""

    @abstractmethod
    def drawn(self, at: Moment, parts: Parts, rows: Ints, level: int) -> Drawn:
        """Return the particles of the leaf appearances of these rows, which are of one level."""

    @abstractmethod
    def shape(self, drawn: Drawn, radius: Reals) -> Sticks | Triangles:
        """Make the shape of particles with these radii [m]; a ball is a stick of no length."""

    def parts_of(self, parts: Parts, view: View) -> Parts:
        """Return the puffs of sources, and so on down to particles."""
        at = replace(parts.state, time_s=view.time_s)
        finest = int(self.hierarchies[0].level[-1])
        found = [
            self.children(at, parts, np.flatnonzero(parts.level == level), level)
            for level in range(finest)
        ]
        parent, part, place, share = (np.concatenate(column) for column in zip(*found, strict=True))
        order = np.argsort(parent, kind="stable")
        parent = parent[order]
        owners = parts.level[parent] + 1, parts.object[parent]
        return self.batch(at, *owners, part[order], parent, place[order], share[order])

    def appearance(self, parts: Parts, weights: BlendWeights) -> Sticks | Triangles:
        """Return leaf appearances alone, as much as each shows."""
        shown = weights.leaf > 0
        found = [
            self.drawn(parts.state, parts, np.flatnonzero(shown & (parts.level == level)), level)
            for level in self.hierarchies[0].level.tolist()
        ]
        columns = [np.concatenate(column) for column in zip(*found, strict=True)]
        order = np.argsort(columns[0], kind="stable")
        drawn = Drawn(*(column[order] for column in columns))
        return self.shape(drawn, drawn.radius * np.sqrt(drawn.area * weights.leaf[drawn.owner]))

    def later(self, parts: Parts, view: View, time_s: float) -> Parts:
        """Return the same parts at another time; what is gone by then has the least size."""
        return replace(parts, state=replace(parts.state, time_s=time_s))

    def limits(self, view: View) -> Float64[np.ndarray, "2 v l"]:
        """Return the limit distances of each variant's levels, in view and out of it [m]."""
        return np.stack([np.stack(view.limits(each)) for each in self.hierarchies], axis=1)

    def batch(
        self,
        at: Moment,
        level: Ints,
        source: Ints,
        part: Ints,
        parent: Ints,
        place: Points,
        share: Reals,
    ) -> Parts:
        """Make a batch of parts from their columns."""
        variant = at.variant[source]
        bound = np.array([each.B for each in self.hierarchies])
        return Parts(
            position=place,
            centre=place,
            bound=bound[variant, level],
            limit=at.limits[0, variant, level],
            limit_offscreen=at.limits[1, variant, level],
            level=level,
            object=source,
            part=part,
            parent=parent,
            share=share,
            state=at,
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


def random_units(
    first: Ints, second: Ints, third: Ints, fourth: int, seed: int, word: np.uint64
) -> Float64[np.ndarray, "n 4"]:
    """Return four random numbers in [0, 1) for each row of three counters, (n, 4)."""
    words = random_words(first, second, third, fourth, np.uint64(seed), word)
    return (words >> np.uint64(11)) * 2.0**-53


@njit(cache=True)
def random_words(first, second, third, fourth, seed, word):  # type: ignore[no-untyped-def]
    """Four random 64-bit words for each row of three counters, (n, 4)."""
    found = np.empty((len(first), 4), np.uint64)
    for i in range(len(first)):
        a, b, c = np.uint64(first[i]), np.uint64(second[i]), np.uint64(third[i])
        words = philox4x64(a, b, c, np.uint64(fourth), seed, word)
        for k in range(4):
            found[i, k] = words[k]
    return found


PARTICLES_PER_BALL = 8
"""Particles that one larger ball replaces in a puff's leaf appearance."""

CLUMPS = 4
"""Balls for each puff in a plume's leaf appearance."""

SHORTEST_LIFE = 0.75
"""Shortest life of a puff, as a share of the longest."""

SMALLEST, LARGEST = 0.7, 1.3
"""Range of the particles' sizes, over the mean."""

_WAKING, _DYING = 0.12, 0.4
"""Shares of life over which particles grow to full size, and shrink to nothing."""

_GROWTH, _BENT, _SLOWING = 0.7, 1.6, 0.85
"""Exponents of age by which a puff spreads, drifts ever faster, and rises ever slower."""

_LEAST_SIZE = 1e-3
"""Least size of a particle at birth and death, as a share of its full size."""

_SOOT = 0.04
"""Albedo of flames."""

_CORNERS = np.array(((1, 0, 0), (0, 1, 0), (-1, 0, 0), (0, -1, 0), (0, 0, 1), (0, 0, -1)), float)
_FACES = np.array(
    ((0, 1, 4), (1, 2, 4), (2, 3, 4), (3, 0, 4), (1, 0, 5), (2, 1, 5), (3, 2, 5), (0, 3, 5))
)


@dataclass(frozen=True)
class PlumeKind:
    """Numbers of one kind of plume; lengths are of a plume of size 1.

    rate       puffs born in a second, so many that one at least is always alive
    life_s     longest life of one [s]
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


SMOKE = PlumeKind(
    rate=10.0,
    life_s=9.0,
    particles=1920,
    height=13.0,
    lean=5.0,
    mouth=0.12,
    wander=0.7,
    young=0.16,
    old=1.5,
    grain=0.0075,
    stretch=1.0,
    colours=((0.16, 0.15, 0.14), (0.30, 0.30, 0.30), (0.42, 0.42, 0.43)),
)
"""Smoke of a wood fire in light wind; chosen by eye."""

FLAMES = PlumeKind(
    rate=40.0,
    life_s=0.9,
    particles=128,
    height=1.05,
    lean=0.14,
    mouth=0.24,
    wander=0.07,
    young=0.1,
    old=0.03,
    grain=0.09,
    stretch=3.0,
    colours=((0.9, 0.22, 0.02), (0.7, 0.12, 0.008), (0.45, 0.05, 0.002), (0.2, 0.012, 0.0005)),
    glows=True,
)
"""Flames of a campfire, hotter below. Radiance in the units of the sky at dusk, chosen by eye."""

KINDS = {"smoke": SMOKE, "flames": FLAMES}


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
class Plume(ParticleSystem):
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

    @cached_property
    def hierarchies(self) -> tuple[Hierarchy, ...]:
        """Return the sizes that all parts of a level have in common, one row for each level."""
        kind, n = self.kind, self.kind.particles
        widest = max(kind.young, kind.old)
        half = LARGEST * kind.grain * kind.stretch
        reach = widest * (kind.stretch + half * math.sqrt(max(PARTICLES_PER_BALL, n / CLUMPS)))
        axis = self.axis(np.linspace(0, 1, 257))
        bend = float(np.linalg.norm(axis - self.axis(np.array([0.5])), axis=1).max())
        separation = 1.01 * bend + kind.mouth + kind.wander
        face = math.sqrt((2.0 if kind.glows else math.pi) * kind.stretch)
        side = face * LARGEST * kind.grain * widest
        live = kind.rate * kind.life_s
        R = np.array([separation + reach, reach, half * widest]) * self.size
        sizes = Hierarchy(
            parent=np.array([-1, 0, 1]),
            level=np.array([0, 1, 2]),
            position=np.zeros((3, 3)),
            P=side * np.sqrt([n * live, n, 1]) * self.size,
            R=R,
            B=R * (1 + 1e-9),
            separation=np.array([0.0, separation, kind.stretch * widest]) * self.size,
        )
        return (sizes,)

    def roots(self, view: View) -> Parts:
        """Return the plume itself, whether near or far."""
        zero, corner = np.zeros(1, np.int64), view.camera.corner
        at = Moment(corner, view.time_s, zero, self.limits(view))
        place = self._base(corner) + self.size * self.axis(np.array([0.5]))
        return self.batch(at, zero, zero, zero, zero - 1, place, np.ones(1))

    def children(self, at: Moment, parts: Parts, rows: Ints, level: int) -> Children:
        """Return the live puffs of a plume, or the particles of puffs."""
        if level == 0:
            births = self.live(at.time_s)
            puffs, puff = self.puffs(at, births), np.tile(np.arange(len(births)), len(rows))
            area = (puffs.radius * puffs.size) ** 2
            columns = self._puff_id(births), puffs.middle, area / area.sum()
            return Children(np.repeat(rows, len(births)), *(each[puff] for each in columns))
        n = self.kind.particles
        puff, number = np.divmod(np.arange(len(rows) * n), n)
        births, _ = self._birth_and_number(parts.part[rows])
        puffs, (offset, size) = self.puffs(at, births), self.members(births[puff], number)
        place = puffs.middle[puff] + puffs.radius[puff, None] * offset
        area = (size**2).reshape(-1, n)
        share = (area / area.sum(axis=1)[:, None]).ravel()
        return Children(rows[puff], parts.part[rows[puff]] + 1 + number, place, share)

    def drawn(self, at: Moment, parts: Parts, rows: Ints, level: int) -> Drawn:
        """Return CLUMPS for each puff of a plume, one of PARTICLES_PER_BALL particles of a puff."""
        births, member = self._birth_and_number(parts.part[rows])
        if level == 2:
            owner, (offset, size) = rows, self.members(births, member)
            area = size**2
        else:
            n, owner = self.kind.particles, rows
            if level == 0:
                live = self.live(at.time_s)
                owner, births = np.repeat(rows, len(live)), np.tile(live, len(rows))
            each = PARTICLES_PER_BALL if level else n // CLUMPS
            puff, number = np.divmod(np.arange(len(births) * n), n)
            offset, size = self.members(births[puff], number)
            area = (size**2).reshape(-1, each).sum(axis=1)
            offset, puff = offset[::each], puff[::each]
            owner, births = owner[puff], births[puff]
        puffs = self.puffs(at, births)
        age = (np.clip(puffs.age, 0, 1) * SHADES).astype(np.int64)
        place = puffs.middle + puffs.radius[:, None] * offset
        radius = puffs.radius * puffs.size * self.kind.grain
        return Drawn(owner, place, radius, area, np.minimum(age, SHADES - 1))

    def shape(self, drawn: Drawn, radius: Reals) -> Sticks | Triangles:
        """Make balls of smoke or tongues of flame."""
        colours, columns = self.kind.colours, np.array(self.kind.colours).T
        at = np.linspace(0, len(colours) - 1, SHADES)
        shades = np.stack([np.interp(at, np.arange(len(colours)), c) for c in columns], axis=1)
        centre, count = drawn.place, len(drawn.place)
        if not self.kind.glows:
            return Sticks(centre, centre, radius, radius, drawn.shade, shades, drawn.owner)
        # Upright octahedra that give light, so many times as high as wide.
        scale = radius[:, None] * np.array((1.0, 1.0, self.kind.stretch))
        vertices = (centre[:, None] + scale[:, None] * _CORNERS).reshape(-1, 3)
        faces = len(_CORNERS) * np.arange(count)[:, None, None] + _FACES
        return Triangles(
            vertices=vertices,
            normals=np.tile(_CORNERS, (count, 1)),
            colours=np.full((len(vertices), 3), _SOOT),
            faces=faces.reshape(-1, 3),
            owner=np.repeat(drawn.owner, len(_FACES)),
            glow=np.repeat(drawn.shade, len(_FACES)),
            glows=shades,
        )

    def live(self, time_s: float) -> Ints:
        """Return the birth numbers of the puffs that live at a time, ascending."""
        rate, life = self.kind.rate, self.kind.life_s
        births = np.arange(math.floor((time_s - life) * rate) - 1, math.floor(time_s * rate) + 2)
        born, lives = self._lifetimes(births, self._units(births, 0 * births, 0))
        return births[(born <= time_s) & (time_s < born + lives)]

    def puffs(self, at: Moment, births: Ints) -> Puffs:
        """Return the puffs of these births, alive or not."""
        kind, u = self.kind, self._units(births, 0 * births, 0)
        winding = self._units(births, 0 * births, 1)
        born, lives = self._lifetimes(births, u)
        age = (at.time_s - born) / lives
        s = np.maximum(age, 0.0)
        mouth = kind.mouth * np.sqrt(u[:, 2])
        wander, turn = kind.wander * s, 2 * np.pi * (winding[:, 0] + (0.5 + winding[:, 1]) * s)
        middle = self.axis(s)
        middle[:, 0] += mouth * np.cos(2 * np.pi * u[:, 3]) + wander * np.cos(turn)
        middle[:, 1] += mouth * np.sin(2 * np.pi * u[:, 3]) + wander * np.sin(turn)
        radius = kind.young + (kind.old - kind.young) * s**_GROWTH
        size = np.maximum(smoothstep(s / _WAKING) * smoothstep((1 - s) / _DYING), _LEAST_SIZE)
        middle = self._base(at.corner) + self.size * middle
        return Puffs(age, middle, self.size * np.maximum(radius, _LEAST_SIZE), size)

    def members(self, birth: Ints, number: Ints) -> tuple[Points, Reals]:
        """Place particles in puffs of radius 1, (n, 3), with sizes over the mean, (n,).

        Smoke is densest in the middle and thins out to nothing at the edge. Of flames a puff is a
        tongue, pointed at its top, so many times as high as wide as its particles are.
        """
        u = self._units(birth, number + 1, 0)
        size = SMALLEST + (LARGEST - SMALLEST) * u[:, 3]
        if self.kind.glows:
            place = points_in_ball(u)
            taper = (1 - place[:, 2]) / 2
            tall = np.full_like(taper, self.kind.stretch)
            return place * np.stack((taper, taper, tall), axis=1), size
        u[:, 0] = (0.5 - np.sin(np.arcsin(1 - 2 * u[:, 0]) / 3)) ** 3  # 3r² - 2r³ lie within r
        return points_in_ball(u), size

    def axis(self, age: Reals) -> Points:
        """Compute the path of a puff by age in a plume of size 1 that does not wind, (n, 3) [m]."""
        wind = math.radians(self.azimuth_deg)
        away = self.kind.lean * age**_BENT
        up = self.kind.height * age**_SLOWING
        return np.stack((away * math.sin(wind), away * math.cos(wind), up), axis=1)

    def _units(self, birth: Ints, number: Ints, block: int) -> Float64[np.ndarray, "n 4"]:
        word = hash_name(self.name)
        return random_units(birth, number, np.full(len(birth), block), 0, self.seed, word)

    def _lifetimes(self, births: Ints, u: Float64[np.ndarray, "n 4"]) -> tuple[Reals, Reals]:
        lives = self.kind.life_s * (SHORTEST_LIFE + (1 - SHORTEST_LIFE) * u[:, 1])
        return (births + u[:, 0]) / self.kind.rate, lives

    def _base(self, corner: Corner) -> Float64[np.ndarray, "3"]:
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
