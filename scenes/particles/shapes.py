"""Shapes that particles are drawn as, and the random numbers of their births."""

import numpy as np
from jaxtyping import Float64
from numba import njit

from lod.arrays import Ints, Points, Reals
from lod.shapes import Sticks, Triangles
from scenes.noise import philox4x64, unit_float

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
