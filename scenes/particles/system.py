"""A particle system: what is born at random, moves, changes size and colour, and dies (Blake §1.3).

After W. T. Reeves, "Particle systems: a technique for modeling a class of fuzzy objects", SIGGRAPH
'83 Proceedings, p. 359. Smoke and flames (``scenes.particles.plume``) and the dust behind walkers
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
"""

from abc import ABC, abstractmethod
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np
from jaxtyping import Float64

from lod.arrays import Ints, Points, Reals
from lod.camera import Corner
from lod.hierarchy import Hierarchy
from lod.kernels import njit
from lod.pruner import BlendWeights, Parts
from lod.shapes import Sticks, Triangles
from lod.view import View
from scenes.noise import philox4x64

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
