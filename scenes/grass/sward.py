"""How the tufts of a sward are made: blades, and seed heads and flowers on stems.

Level 0 is the tuft, one object; 1 its blades and flowering stems. A blade is flat: three triangles,
bent half-way. Where blades are gathered into fewer and larger shapes, two round sticks stand for
it, as thick as a blade looks on average as it is turned about its length, which is 2/π of its
width. Stems are round. Everything is rooted ROOT_M deep, so that nothing hangs in the air beside a
tuft on a slope. A part's origin is the middle of what it holds above the ground, the tuft's is its
foot.

Tufts thin out with distance, and have no appearance of their own. Each blade and stem has a rank u,
even over 0 to 1. At the distance d those with ranks below λ(d) are left, a random subset, and are
1/λ times as wide: a part stands for 1/u parts where it ends. So that each that is left covers
PIXELS of a pixel, P² is the area of 1/u blades over PIXELS, which gives λ ∝ 1/d²; below LINEAR P
is greater, so that λ ∝ 1/d, for very wide blades would be seen as such. At LEAST all end.
"""

from dataclasses import replace
from functools import lru_cache
from typing import NamedTuple, TypeVar

import numpy as np
from jaxtyping import Float64

from lod.arrays import Ints, Points, Reals
from lod.shapes import Mesh, MeshTable, StickTable
from scenes.rig.rigged_prototype import RiggedPrototype
from scenes.sticks.prototype import PartPlaces, Prototype, assemble_prototype, box_middles
from scenes.trees.species import CALM_SUMMER, SEASONS, Weather
from scenes.trees.tree import swaying

BLADES = 25
"""Blades of a tuft; flowering stems come on top."""

SHORTEST_M, MEDIAN_M, LONGEST_M = 0.04, 0.20, 0.48
"""Lengths of blades above the ground: log-normal about the median, cut at both ends [m]. Size
factors of 0.8 to 1.25 make them 3 to 60 cm."""

ROOT_M = 0.04
"""How deep everything is rooted [m]."""

_SPREAD, _TUFT_M, _SHOOT_M = 0.45, 0.045, 0.008
"""Standard deviations of the logarithm of lengths, of shoots about the middle of the tuft, and of
blades about their shoot [m]."""

_SHOOTS, _TWIST = 5, 0.6
"""Shoots of a tuft, from which blades grow; standard deviation of the angle between a blade's
face and the plane that it bends in, about a right angle [rad]."""

WIDTH_M = 0.005
"""Width of a blade of median length, half-way up [m]; broader ones by the power 0.4 of length."""

_STEMS = 1.0
"""Mean number of flowering stems of a tuft."""

_SHADES, _DRYNESS = 4, (0.0, 0.35, 1.0)
_GREEN = np.linspace((0.095, 0.185, 0.036), (0.215, 0.310, 0.085), _SHADES)
_STRAW = np.linspace((0.28, 0.25, 0.105), (0.46, 0.40, 0.20), _SHADES)
_FLOWERS = np.array(((0.62, 0.50, 0.04), (0.70, 0.69, 0.62), (0.30, 0.16, 0.42)))
_PALETTE = np.concatenate([*((1 - d) * _GREEN + d * _STRAW for d in _DRYNESS), _FLOWERS])
"""Linear Rec.709 albedo of blades in each shade, green, half dry and dry (as are
seed heads), and of flowers; chosen by eye."""

DRY = dict(zip(SEASONS, (0.04, 0.12, 0.3, 0.5), strict=True))
"""Share of the blades that are dry, and of those that are half dry, by season."""

BEND_DEG = 4.0, 14.0
"""Most that a tuft and a blade turn in the wind, as ``scenes.trees.tree`` takes them."""

_BLADE_FACES = np.array(((0, 1, 2), (0, 2, 3), (3, 2, 4)))
"""Corners of a blade's triangles: two at its root, two half-way up, and its tip."""

PIXELS = 0.36
"""Area of a pixel that each blade covers that is left, at a detail of one pixel [px]."""

LEAST = 0.01
"""Share of the blades at which the last of them end."""

SHADOW_M = 1.5
"""How far out of view tufts are displayed for the shadows that they cast into it [m]."""

RANKINGS = 25
"""Prototypes of each tuft, which differ in the ranks of its blades: each gets all ranks in turn."""

_STREAM = 0x54AD


Tuft = TypeVar("Tuft", bound=Prototype | RiggedPrototype)


class _Stalks(NamedTuple):
    """Blades or stems: base on the ground, points half-way and at the tip, (n, 3) [m]; their radii
    at those three as round ones, (n, 3) [m]; unit vectors across, level with the ground, (n, 3)."""

    base: Points
    middle: Points
    tip: Points
    radius: Float64[np.ndarray, "n 3"]
    across: Points

    def root(self) -> Points:
        """Continue each stalk down into the ground, (n, 3) [m]."""
        up = self.middle - self.base
        return self.base - ROOT_M * up / np.linalg.norm(up, axis=1)[:, None]


def swards(
    seed: int, count: int, weather: Weather = CALM_SUMMER
) -> tuple[Prototype, ...] | tuple[RiggedPrototype, ...]:
    """Make ``count`` tufts, still or moving in the wind; the k-th depends on seed, weather and k
    only."""
    if not weather.wind:
        return tuft_prototypes(seed, count, weather.season)
    return tuple(
        swaying(still, weather.wind, _rng(seed, k, 1), BEND_DEG, feet)
        for k, (still, feet) in enumerate(_tufts(seed, count, weather.season))
    )


def tuft_prototypes(seed: int, count: int, season: str = "summer") -> tuple[Prototype, ...]:
    """Make ``count`` still tufts."""
    return tuple(still for still, _ in _tufts(seed, count, season))


@lru_cache(maxsize=16)
def _tufts(seed: int, count: int, season: str) -> tuple[tuple[Prototype, Points], ...]:
    """Make still tufts, and the points on the ground from which their blades and stems grow."""
    return tuple(_tuft(f"sward {k}", _rng(seed, k, 0), DRY[season]) for k in range(count))


def _rng(seed: int, k: int, what: int) -> np.random.Generator:
    return np.random.Generator(np.random.Philox(np.random.SeedSequence((seed, _STREAM, k, what))))


def ranked(tuft: Tuft) -> tuple[Tuft, ...]:
    """Give the parts of a tuft the ranks by which they thin out, in RANKINGS ways."""
    h, n = tuft.hierarchy, len(tuft.hierarchy)
    area, half_width = float(np.mean(h.P[1:] ** 2)), np.zeros(n)
    np.maximum.at(half_width, tuft.leaf.owner, tuft.leaf.start_radius * np.pi / 2)
    # Evenly over all lengths, however few are left (a Weyl sequence).
    order = np.argsort(np.argsort(h.R[1:])) * (np.sqrt(5) - 1) / 2
    found = []
    for turn in range(RANKINGS):
        rank = np.maximum((order + turn / RANKINGS) % 1, LEAST)
        rank = np.append(rank.min(), rank)
        P = np.sqrt(area / (PIXELS * rank))
        # What is wider reaches farther, too: of the whole all of it.
        wider = half_width * (1 / rank - 1)
        wider[0] = (half_width * (1 / LEAST - 1)).max()
        reach = {"R": h.R + wider, "B": h.B + wider[0] + SHADOW_M}
        reach |= {"contrast_to_whole": np.ones(n)}  # a tuft shows nothing in place of a blade
        ranks = replace(h, P=P, **reach, stands_for=1 / rank)
        found.append(replace(tuft, hierarchy=ranks))
    return tuple(found)


def _tuft(name: str, rng: np.random.Generator, dry: float) -> tuple[Prototype, Points]:
    shoots = rng.normal(scale=_TUFT_M, size=(_SHOOTS, 2))
    of_stem = rng.permutation(_SHOOTS)[: min(rng.poisson(_STEMS), _SHOOTS)]
    blades = _blades(rng, shoots[np.arange(BLADES) % _SHOOTS])
    stems = _stems(rng, shoots[of_stem])
    rows = 1 + np.arange(BLADES), 1 + BLADES + np.arange(len(of_stem))
    n = 1 + BLADES + len(of_stem)
    parent = np.repeat((-1, 0), (1, n - 1))
    tint = _blade_tints(rng, dry)
    # Two sticks from which everything grows, below the ground and just above.
    ends = np.array(((0, 0, -ROOT_M), (0, 0, 0.0), (0, 0, 0.005)))
    thin, whole = np.full(2, 0.001), np.zeros(2, np.int64)  # too thin to outlast the blades
    crown = StickTable.of(n, whole, ends[:2], ends[1:], thin, thin, np.full(2, 2 * _SHADES))
    stalks = [*_sticks(n, rows[0], blades, tint), *_flowering(rng, n, rows[1], stems)]
    meshes = MeshTable.of([None, *_faces(rng, blades, tint), *[None] * len(of_stem)])
    own = StickTable.merge([crown, *stalks])
    # The tuft has no look of its own: it counts as large as all its sticks.
    leaf = StickTable.merge([own, *(each.with_owner(n, 0 * each.owner) for each in stalks)])
    # The middle of the box about what each part has above the ground; of the tuft its foot.
    ends, owner = own.spheres[0], np.tile(own.owner, 2)
    above = ends * (1, 1, 0) + np.maximum(ends, 0) * (0, 0, 1)
    middle = box_middles(parent, owner, above)
    middle[0] = 0.0
    places = PartPlaces(parent, np.minimum(np.arange(n), 1), middle)
    still = assemble_prototype(name, places, crown, leaf, _PALETTE, meshes=meshes)
    return still, np.concatenate((blades.base, stems.base))


def _blades(rng: np.random.Generator, at: Float64[np.ndarray, "n 2"]) -> _Stalks:
    """Grow blades about these places: they lean outward, and bend over under their weight."""
    n = len(at)
    length = np.clip(MEDIAN_M * np.exp(_SPREAD * rng.normal(size=n)), SHORTEST_M, LONGEST_M)
    width = WIDTH_M * (length / MEDIAN_M) ** 0.4 * np.exp(0.2 * rng.normal(size=n))
    lean = np.abs(rng.normal(np.radians(14), np.radians(12), n))
    bend = lean + np.radians(rng.uniform(10, 75, n)) * np.minimum(length / MEDIAN_M, 1.5)
    taper = np.array((0.8, 1.0, 0.2))
    return _grown(rng, at, length, (lean, bend), (width / np.pi)[:, None] * taper)


def _stems(rng: np.random.Generator, at: Float64[np.ndarray, "n 2"]) -> _Stalks:
    n = len(at)
    lean = np.abs(rng.normal(0, np.radians(7), n))
    bend = lean + np.radians(rng.uniform(0, 15, n))
    return _grown(rng, at, rng.uniform(0.25, LONGEST_M, n), (lean, bend), np.full((n, 3), 0.0011))


def _grown(
    rng: np.random.Generator,
    at: Float64[np.ndarray, "n 2"],
    length: Reals,
    leans: tuple[Reals, Reals],
    radius: Float64[np.ndarray, "n 3"],
) -> _Stalks:
    """Grow stalks whose lower and upper halves lean so far from upright [rad]."""
    out = np.arctan2(at[:, 1], at[:, 0]) + rng.normal(scale=1.0, size=len(at))
    base = np.zeros((len(at), 3))
    base[:, :2] = at + rng.normal(scale=_SHOOT_M, size=at.shape)
    halves = [
        length[:, None]
        / 2
        * np.stack((np.sin(a) * np.cos(out), np.sin(a) * np.sin(out), np.cos(a)), axis=1)
        for a in leans
    ]
    across = np.stack((-np.sin(out), np.cos(out), np.zeros(len(at))), axis=1)
    return _Stalks(base, base + halves[0], base + halves[0] + halves[1], radius, across)


def _sticks(n: int, rows: Ints, stalks: _Stalks, tint: Ints) -> list[StickTable]:
    radius = stalks.radius.T
    lower = stalks.root(), stalks.middle, radius[0], radius[1], tint
    upper = stalks.middle, stalks.tip, radius[1], radius[2], tint
    return [StickTable.of(n, rows, *columns) for columns in (lower, upper)]


def _faces(rng: np.random.Generator, blades: _Stalks, tint: Ints) -> list[Mesh]:
    """Make the three triangles of each blade, turned a little about it and pointed at its tip."""
    along = blades.middle - blades.base
    along /= np.linalg.norm(along, axis=1)[:, None]
    turn = _TWIST * rng.normal(size=len(along))[:, None]
    across = np.cos(turn) * blades.across + np.sin(turn) * np.cross(along, blades.across)
    half_width = np.pi / 2 * blades.radius
    low, middle = (half_width[:, k, None] * across for k in (0, 1))
    root, half = blades.root(), blades.middle
    corners = np.stack((root - low, root + low, half + middle, half - middle, blades.tip), axis=1)
    lower, upper = (np.cross(across, up) for up in (along, blades.tip - half))
    upper /= np.linalg.norm(upper, axis=1)[:, None]
    bent = (lower + upper) / np.linalg.norm(lower + upper, axis=1)[:, None]
    spines = np.stack((root, root, half, half, blades.tip), axis=1)
    normals = np.stack((lower, lower, bent, bent, upper), axis=1)
    return [
        Mesh(points, ahead, np.tile(_PALETTE[shade], (5, 1)), _BLADE_FACES, spine)
        for points, spine, ahead, shade in zip(corners, spines, normals, tint, strict=True)
    ]


def _flowering(rng: np.random.Generator, n: int, rows: Ints, stems: _Stalks) -> list[StickTable]:
    """Make the sticks of stems: stalks with a seed head, or a flower, about their tips."""
    flower, straw = rng.random(len(rows)) < 0.4, 2 * _SHADES
    colour = 3 * _SHADES + rng.integers(len(_FLOWERS), size=len(rows))
    tint = np.where(flower, colour, straw + rng.integers(_SHADES, size=len(rows)))
    long = np.where(flower, 0.10, 0.45)[:, None]
    below = stems.tip - long * (stems.tip - stems.middle)
    thick = np.where(flower, 0.009, 0.0035)
    head = StickTable.of(n, rows, below, stems.tip, thick, 0.6 * thick, tint)
    stalk = np.where(flower, 1, straw)
    return [*_sticks(n, rows, stems, stalk), head]


def _blade_tints(rng: np.random.Generator, dry: float) -> Ints:
    """Choose the tints of blades: a tuft has a shade of its own, and every blade one about that."""
    tone = _SHADES / 2 - 0.5 + 0.7 * rng.normal() + 0.7 * rng.normal(size=BLADES)
    shade = np.clip(np.rint(tone), 0, _SHADES - 1).astype(np.int64)
    dryness = np.searchsorted((1 - 2 * dry, 1 - dry), rng.random(BLADES), side="right")
    return dryness * _SHADES + shade
