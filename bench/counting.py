"""A field of a case is counted by the real pruner, and predicted without it (§4.1).

A case says what stands on which ground and through what it is seen; sweeps vary one quantity of it.
``count_field`` builds one random field of a case and prunes it; ``predict`` derives P, R and D on
its own and gives the law's means and variances. ``pierced`` counts the sticks along rays.
"""

import hashlib
import json
import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from jaxtyping import Float64

from bench.records.provenance import scene_digest
from lod.air import Air, least_extinction
from lod.arrays import Ints, Reals
from lod.camera import Corner, camera_from_heading
from lod.kernels import njit
from lod.law import (
    chained_limits,
    count_moments,
    count_variance,
    disc_areas,
    expected_count,
    ground_nodes,
)
from lod.pruner import Cut, prune
from lod.shapes import Sticks
from lod.view import View
from lod.viewing import BlurWidths, ViewingConditions
from scenes.field.species_field import Species, SpeciesField
from scenes.figures.animal_file import standing_people
from scenes.grass.sward import tuft_prototypes
from scenes.ground.mesh import Terrain
from scenes.models.stone import boulder_prototypes
from scenes.plugins import metric_by_name
from scenes.sticks.prototype import Prototype
from scenes.trees.species import tree_species
from scenes.trees.tree import tree_prototypes

EYE_HEIGHT_M = 1.6

FLAT = Terrain(seed=0, amplitude=0.0, wavelength=1024.0, hurst=1.0, reach=1000.0)

HILLS_M = 512.0  # the longest wave of hilly ground [m]

KEPT = {"evenly": 1.0, "patches": 0.25, "slope": 0.5, "clearing": 1.0}
"""The share of an even field that is left: of patches, at the eye, or at a clearing's edge."""

COLUMNS = ("objects", "parts", "objects_examined", "parts_examined")
"""What is counted in a field, displayed and examined, in the order of a row."""

Row = tuple[int, ...]

_NODES = 2**18  # nodes of the integral over hilly ground

_STANDING = {
    "figure": lambda: standing_people(0, 4),
    "tree": lambda: tree_prototypes(0, 2, tree_species("tree")),
    "boulder": lambda: boulder_prototypes(0, 2),
    "sward": lambda: tuft_prototypes(0, 2),
}
"""The prototypes of each species, all equally likely; nothing moves."""


@dataclass(frozen=True)
class Case:
    """One point of a sweep of one species, or of several as ``figure+rabbit``.

    density     K [1/m²]
    size        factor on every length of the species
    detail      τ [px]
    width       width of the picture [px]
    fov         its horizontal field of view [degrees]
    extent      side of the world [m]; None = endless
    eye_height  height of the eye above the ground under it [m]
    hills       amplitude of the ground [m]; 0 = flat
    visibility  V [m]; None = clear air
    gathered    how K varies: ``evenly``, the same everywhere; ``patches``, in one of four squares
                of side ``scale``; ``slope``, growing evenly to the east, K at the eye and twice
                that ``scale`` away; ``clearing``, growing with the distance from the eye as far as
                ``scale``, K at its edge
    scale       the length over which K varies [m]
    """

    sweep: str
    species: str
    metric: str
    density: float
    size: float = 1.0
    detail: float = 1.0
    width: int = 640
    fov: float = 60.0
    extent: float | None = None
    eye_height: float = EYE_HEIGHT_M
    hills: float = 0.0
    visibility: float | None = None
    gathered: str = "evenly"
    scale: float = 0.0

    @property
    def label(self) -> str:
        """Name the case for progress."""
        return f"{self.species}, {self.metric}, sweep of {self.sweep}"

    @property
    def m(self) -> float:
        """The detail angle m = τ·2·tan(fov/2)/width [rad]."""
        return self.detail * 2 * math.tan(math.radians(self.fov) / 2) / self.width

    def view(self) -> View:
        """Return the view from the middle of the world, all round."""
        ground = float(self.ground().height(Corner(0, 0), np.zeros((1, 2)))[0])
        eye = np.array((0.0, 0.0, ground + self.eye_height))
        camera = camera_from_heading(Corner(0, 0), eye, 0.0, 0.0, self.fov, (self.width, 1))
        seen = None
        if self.visibility is not None:
            extinction = least_extinction(Air(self.visibility))
            seen = ViewingConditions(BlurWidths(camera.pixel_angle), extinction)
        metric = metric_by_name(self.metric)
        return View(camera, metric, self.detail, look_around=True, conditions=seen)

    def ground(self) -> Terrain:
        """Return flat ground, or the same hills for all fields of a case."""
        return replace(FLAT, amplitude=self.hills, wavelength=HILLS_M, hurst=0.8)

    def kinds(self) -> list[tuple[Prototype, ...]]:
        """Return the prototypes of each species of the case."""
        return [prototypes_of(name, self.size) for name in self.species.split("+")]


class Sweep(NamedTuple):
    """One sweep: its axis and its title in words, and the key of a case that it varies.

    exponent  of objects displayed against what is swept, by the law, and its margin
    symbol    of what is swept, in the law
    far       whether the exponent is claimed only of limits that are far from the eye
    """

    axis: str
    title: str
    key: str
    exponent: tuple[float, float] = (0, 0)
    symbol: str = ""
    far: bool = False


SWEEPS = {
    "density": Sweep("K, objects per m²", "More objects per area", "density", (1, 0.02), "K"),
    "size": Sweep(
        "P + R of the whole object (m)", "Larger objects", "size", (2, 0.02), "P + R", True
    ),
    "detail": Sweep("m (rad), by detail threshold", "Coarser detail", "m", (-2, 0.02), "m", True),
    "resolution": Sweep("m (rad), by picture width", "Fewer pixels", "m", (-2, 0.02), "m", True),
    "magnification": Sweep("m (rad), by field of view", "Wider view", "m", (-2, 0.02), "m", True),
    "world": Sweep("L, side of the world (m)", "A larger world", "extent", (0, 0.005), "L"),
}
"""Sweeps of the quantities of the law, on flat ground, in clear air, all round."""

BEYOND = {
    "mixed": Sweep("K, objects per m²", "Mixed species: people, trees and boulders", "density"),
    "hills": Sweep("amplitude of the ground (m)", "Hills", "hills"),
    "patches": Sweep("side of a patch (m)", "Clustered: objects in patches", "scale"),
    "slope": Sweep("where K is twice that at the eye (m)", "Graded: K grows one way", "scale"),
    "clearing": Sweep("radius of the clearing (m)", "Graded: an eye in a clearing", "scale"),
    "near": Sweep("m (rad), the limit near the eye", "The near field", "m"),
    "height": Sweep("height of the eye (m)", "A higher eye", "eye_height"),
    "haze": Sweep("m (rad), V = 2 km", "Haze", "m"),
}
"""Sweeps of what the flat-ground model leaves out, the mildest case first."""

_DECADES = 2.02  # a little more than two decades, so that whole pixels do not fall short of two


@dataclass(frozen=True)
class Setup:
    """What is swept for one species and metric, and how finely.

    Densities are chosen per metric, so that fields hold about as many objects whatever the metric's
    limit distance is.

    density   K of every sweep [1/m²]; the sweep of K has it in its middle
    coarsest  largest m [rad]; the sweeps of m go two decades down from there
    world     a side of the world [m], about twice the limit distance in the world sweep
    steps     points in that many decades
    decades   of K, in the sweep of K
    """

    species: str
    metric: str
    sweeps: tuple[str, ...]
    density: float
    coarsest: float
    world: float
    steps: int
    decades: float = _DECADES

    def cases(self) -> list[Case]:
        """Return the cases of all its sweeps."""
        return [case for sweep in self.sweeps for case in self._sweep(sweep)]

    def _sweep(self, sweep: str) -> list[Case]:
        middle = _at(Case(sweep, self.species, self.metric, self.density), self.coarsest / 10)
        finer = np.geomspace(1.0, 10**-_DECADES, self.steps) * self.coarsest
        spread = self.decades if sweep == "density" else _DECADES
        factors = np.geomspace(10 ** (-spread / 2), 10 ** (spread / 2), self.steps)
        match sweep:
            case "density":
                return [replace(middle, density=float(self.density * f)) for f in factors]
            case "size":
                return [replace(middle, size=float(f)) for f in factors]
            case "detail":
                return [_at(middle, m) for m in finer]
            case "resolution":
                pixel = replace(middle, detail=1.0)
                return [replace(pixel, width=round(_theta(1, middle.fov) / m)) for m in finer]
            case "magnification":  # a narrower field of view, like a magnifying glass
                detail = float(self.coarsest / _theta(middle.width, 120.0))
                halves = [math.atan(m * middle.width / (2 * detail)) for m in finer]
                return [replace(middle, detail=detail, fov=math.degrees(2 * h)) for h in halves]
            case "world":
                return [replace(middle, extent=float(self.world * side)) for side in WORLD_SIDES]
        raise ValueError(sweep)


_SOME = ("density", "size", "detail", "world")

SETUPS = (
    Setup("figure", "blake", tuple(SWEEPS), 3.6e-3, 0.045, 800.0, 7),
    # Parts of trees are so clumped that a point takes two million trees: one sweep.
    Setup("tree", "blake", ("density",), 5e-5, 0.045, 8800.0, 3),
    Setup("figure", "bounded", _SOME, 2.1e-2, 0.045, 340.0, 4),
    Setup("figure", "solid_angle", _SOME, 2.1e-2, 0.045, 340.0, 4),
    # Tufts of grass, from 10⁻⁴ to 10³ on a square metre, that are seen as far as 10 m.
    Setup("sward", "blake", ("density",), 10**-0.5, 0.62, math.inf, 5, 7.0),
    Setup("sward", "bounded", ("density",), 10**-0.5, 0.13, math.inf, 5, 7.0),
    Setup("sward", "solid_angle", ("density",), 10**-0.5, 0.13, math.inf, 5, 7.0),
)

WORLD_SIDES = (0.1, 0.25, 0.5, 0.75, 1.0, 1.5, 3, 10, 100, 1e3, 1e4, 1e6)
"""Sides of the world in units of ``Setup.world``, from well inside the limit to far outside."""


def scaling_grid(metric: str | None = None) -> list[Case]:
    """Return every case of ``scaling``; an installed metric is swept as `bounded` is."""
    grid = [case for setup in SETUPS for case in setup.cases()] + beyond_grid()
    more = Setup("figure", metric, _SOME, 2.1e-2, 0.045, 340.0, 4).cases() if metric else []
    return grid + more


def beyond_grid() -> list[Case]:
    """Return the cases of every sweep of BEYOND."""
    # Detail angle [rad], the limit distance of a person at it, roughly [m], and a K [1/m²] at which
    # some 1800 people are within that distance.
    m, reach, density = 0.0045, 400.0, 3.6e-3
    person = _at(Case("", "figure", "blake", density), m)
    several = replace(person, species="figure+tree+boulder")

    def reaching(far: float) -> Case:
        """Return the case whose people are displayed up to about a distance, and are as many."""
        nearer = reach / far
        detail = person.detail * (m * nearer) / person.m
        return replace(person, detail=detail, density=density * nearer**2)

    def gathered(how: str, scales: Sequence[float]) -> list[Case]:
        return [replace(person, gathered=how, scale=scale) for scale in scales]

    made = {
        "mixed": [replace(several, density=k * 1e-4) for k in (2.0, 8.0, 32.0)],
        "hills": [replace(person, hills=a) for a in (2.0, 8.0, 32.0, 128.0)],
        "patches": gathered("patches", (5.0, 20.0, 60.0)),
        "slope": gathered("slope", [far * reach for far in (10.0, 3.0, 1.2)]),
        "clearing": gathered("clearing", (20.0, 80.0, 320.0, 1280.0)),
        "near": [reaching(far) for far in (32.0, 16.0, 8.0, 4.0, 2.5)],
        "height": [replace(person, eye_height=h) for h in (5.0, 40.0, 120.0, 240.0, 360.0)],
        "haze": [replace(reaching(far * reach), visibility=2e3) for far in (0.5, 2.0, 8.0, 32.0)],
    }
    return [replace(case, sweep=sweep) for sweep, found in made.items() for case in found]


def _at(case: Case, m: float) -> Case:
    return replace(case, detail=float(m / _theta(case.width, case.fov)))


def _theta(width: int, fov: float) -> float:
    return 2 * math.tan(math.radians(fov) / 2) / width


@lru_cache(maxsize=64)
def prototypes_of(species: str, size: float) -> tuple[Prototype, ...]:
    """Return the species' prototypes, ``size`` times as large."""
    return tuple(each.scaled(size) for each in _STANDING[species]())


@lru_cache(maxsize=16)
def shapes_digest(species: str) -> str:
    """Return the SHA-256 of the hierarchies of one species' prototypes, or of several's."""
    names = ("parent", "level", "position", "P", "R", "B", "separation")
    kinds = sorted(species.split("+"))
    trees = [each.hierarchy for kind in kinds for each in prototypes_of(kind, 1.0)]
    return scene_digest(kinds, (getattr(tree, name) for tree in trees for name in names))


def field_seed(*words: object) -> int:
    """Return the seed, in 63 bits, of a field that is named by plain data."""
    text = json.dumps(words, sort_keys=True)
    return int.from_bytes(hashlib.sha256(text.encode()).digest()[:8], "big") >> 1


def count_field(case: Case, seed: int) -> Row:
    """Count one field, in the order of COLUMNS."""
    cuts = [prune(each, case.view()) for each in fields_of(case, seed)]
    kept = [_left(case, cut, seed) for cut in cuts]
    objects, parts = (sum(each) for each in zip(*kept, strict=True))
    examined = [(cut.examined_objects, cut.examined_parts) for cut in cuts]
    return objects, parts, *(sum(each) for each in zip(*examined, strict=True))


def fields_of(case: Case, seed: int) -> list[SpeciesField]:
    """Build a field for each species of a case; its density is shared evenly among them.

    Where objects are gathered unevenly the fields are denser, because some objects are dropped
    after pruning.
    """
    names, ground = case.species.split("+"), case.ground()
    K = case.density / KEPT[case.gathered] / len(names)
    return [
        SpeciesField(Species(name, kind, K), seed, ground, case.extent)
        for name, kind in zip(names, case.kinds(), strict=True)
    ]


def _left(case: Case, cut: Cut, seed: int) -> tuple[int, int]:
    if case.gathered == "evenly":
        return cut.displayed_objects, cut.displayed_parts
    parts = cut.parts
    roots = np.flatnonzero(parts.parent < 0)
    keep = np.zeros(int(parts.object.max(initial=-1)) + 1, bool)
    keep[parts.object[roots]] = stands(case, parts.position[roots, :2], seed)
    return int(keep.sum()), int(keep[parts.object].sum())


def stands(case: Case, xy: np.ndarray, seed: int) -> np.ndarray:
    """Say which objects at these places [m] remain after thinning, (n,).

    The choice is independent for each object, or for each patch. A Poisson field may be thinned
    after pruning as well as before.
    """
    rng = np.random.Generator(np.random.Philox(seed))
    if case.gathered == "patches":
        cell = np.floor(xy / case.scale + rng.random(2)).astype(np.int64)
        return _chance(seed, cell) < KEPT["patches"]
    if case.gathered == "slope":
        share = (1 + np.clip(xy[:, 0] / case.scale, -1, 1)) / 2
    else:
        share = np.minimum(np.hypot(xy[:, 0], xy[:, 1]) / case.scale, 1.0)
    return rng.random(len(xy)) < share


def _chance(seed: int, cells: np.ndarray) -> np.ndarray:
    """Return a number in [0, 1) for each cell (n, 2), always the same for a seed and a cell.

    It is SplitMix64 (Steele, Lea & Flood, "Fast splittable pseudorandom number generators", OOPSLA
    2014).
    """
    word = np.full(len(cells), seed, np.uint64)
    with np.errstate(over="ignore"):
        for column in cells.T:
            word = (word ^ column.astype(np.uint64)) + np.uint64(0x9E3779B97F4A7C15)
            word = (word ^ (word >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
            word = (word ^ (word >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
            word ^= word >> np.uint64(31)
    return np.asarray((word >> np.uint64(11)) * 2.0**-53)


@dataclass(frozen=True)
class FieldMoments:
    """Means and variances of what one field of a case displays, by the law.

    P_plus_R       P + R of the whole object, the prototypes' mean [m]
    nearest_limit, farthest_limit   limit distance of the whole, the prototypes' extremes [m]
    bare           objects by πK((P + R)/m)² alone: even, flat ground, clear air, eye on the ground
    """

    objects: float
    objects_variance: float
    parts: float
    parts_variance: float
    P_plus_R: float
    nearest_limit: float
    farthest_limit: float
    bare: float


def predict(case: Case) -> FieldMoments:
    """Predict a case; each species and prototype has its share of the density."""
    kinds, view = case.kinds(), case.view()
    trees = [each.hierarchy for kind in kinds for each in kind]
    limits = {id(t): chained_limits(t, view.metric, case.m, view.conditions) for t in trees}
    means = np.zeros(4)  # mean and variance of objects, and of parts
    for kind in kinds:
        K = case.density / len(kinds)
        if case.hills:
            own = tuple(each.hierarchy for each in kind)
            net = ground_nodes(own, view, _NODES)
            height = case.ground().height(view.camera.corner, net.xy)
            m = count_moments(own, view, net, height)
            moments = m.objects, m.objects_variance, m.parts, m.parts_variance
            means += K * np.array(moments)
            continue
        for tree in (each.hierarchy for each in kind):
            areas = shown_areas(
                limits[id(tree)], case.eye_height - tree.position[:, 2], case.extent
            )
            if case.gathered == "clearing":
                areas = cleared(areas, case.scale)
            share = K / len(kind)
            objects, parts = expected_count(share, areas[:1]), expected_count(share, areas)
            means += objects, objects, parts, count_variance(share, areas)
    if case.gathered == "patches":
        # In patches of side s that are there with chance p, all their objects together, counts
        # have, beside K∫n² dA, the variance of K/p·s²·n over patches: K²s²(1 − p)/p·∫n² dA. The
        # patches are far smaller than the limit.
        p = KEPT["patches"]
        means[[1, 3]] *= 1 + case.density * case.scale**2 * (1 - p) / p
    whole = np.array([limits[id(tree)][0] for tree in trees])
    clear = [
        np.mean([np.pi * chained_limits(e.hierarchy, view.metric, case.m)[0] ** 2 for e in kind])
        for kind in kinds
    ]
    objects, objects_variance, parts, parts_variance = map(float, means)
    return FieldMoments(
        objects,
        objects_variance,
        parts,
        parts_variance,
        P_plus_R=float(np.mean([tree.P[0] + tree.R[0] for tree in trees])),
        nearest_limit=float(whole.min()),
        farthest_limit=float(whole.max()),
        bare=case.density * float(np.mean(clear)),
    )


def cleared(areas: Reals, scale: float) -> Reals:
    """Return ∫ min(1, r/scale) dA over discs of these areas about the eye [m²]."""
    radius = np.sqrt(areas / np.pi)
    within = 2 * np.pi * np.minimum(radius, scale) ** 3 / (3 * scale)
    return within + np.pi * np.maximum(radius**2 - scale**2, 0.0)


def shown_areas(D: Reals, h: Reals, extent: float | None) -> Reals:
    """Return the area of ground from which each part is displayed [m²].

    It is a disc, or what the world has of the disc. The world's square is about the eye and is of
    objects; that a part stands aside of its object changes the area by the order of (how far aside
    ÷ side)², which is left out.
    """
    discs = disc_areas(D, h)
    if extent is None:
        return discs
    return disc_in_square(np.sqrt(discs / np.pi), extent)


def disc_in_square(radius: Reals, side: float) -> Reals:
    """Return the area that a disc shares with a square about its centre."""
    half = side / 2
    reach = np.clip(radius, half, half * np.sqrt(2))
    # Four segments stick out of the sides; in the clipped range no two of them meet.
    segment = reach**2 * np.arccos(half / reach) - half * np.sqrt(reach**2 - half**2)
    return np.where(radius <= half, np.pi * np.square(radius), np.pi * reach**2 - 4 * segment)


def pierced(shape: Sticks, eye: Float64[np.ndarray, "3"], rays: Float64[np.ndarray, "r 3"]) -> Ints:
    """Count the sticks that each ray from the eye pierces, (r,)."""
    each = shape.start - eye, shape.end - eye, shape.start_radius, shape.end_radius
    return _pierced(*(np.ascontiguousarray(column) for column in each), rays)


@njit(cache=True)
def _pierced(start, end, r0, r1, rays):  # type: ignore[no-untyped-def]
    found = np.zeros(len(rays), np.int64)
    for i in range(len(r0)):
        ax, ay, az = start[i, 0], start[i, 1], start[i, 2]
        ux, uy, uz = end[i, 0] - ax, end[i, 1] - ay, end[i, 2] - az
        k = r1[i] - r0[i]
        # All of it lies within a sphere about its middle.
        mx, my, mz = ax + ux / 2, ay + uy / 2, az + uz / 2
        reach = math.sqrt(ux * ux + uy * uy + uz * uz) / 2 + max(r0[i], r1[i])
        away = mx * mx + my * my + mz * mz - reach * reach
        for j in range(len(rays)):
            dx, dy, dz = rays[j, 0], rays[j, 1], rays[j, 2]
            ahead = mx * dx + my * dy + mz * dz
            if ahead + reach < 0 or away > ahead * ahead:
                continue
            # |w + t·v|² − (r₀ + t·k)² across the ray is least at t, 0 to 1.
            a, u = ax * dx + ay * dy + az * dz, ux * dx + uy * dy + uz * dz
            wx, wy, wz = ax - a * dx, ay - a * dy, az - a * dz
            vx, vy, vz = ux - u * dx, uy - u * dy, uz - u * dz
            square = vx * vx + vy * vy + vz * vz - k * k
            slope = wx * vx + wy * vy + wz * vz - r0[i] * k
            t = min(max(-slope / square, 0.0), 1.0) if square > 0 else (1.0 if k > 0 else 0.0)
            off = (wx + t * vx) ** 2 + (wy + t * vy) ** 2 + (wz + t * vz) ** 2
            if off <= (r0[i] + t * k) ** 2 and a + t * u > 0:
                found[j] += 1
    return found
