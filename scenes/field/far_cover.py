"""Cover of undisplayed objects: the ground takes their colour, shade and height.

It is the ``AggregateCover`` of ``scenes.ground.shading`` for species that stand all over the
ground.

How much objects too small to display cover of the ground, by the gap fraction of a stand.

Objects stand at random (Poisson), K of them to the square metre, each of mean outline A(δ) along a
line that comes down at δ to the horizon. Of such lines exp(−K·A/sin δ) reach the ground: the gap
fraction of a random stand (Nilson 1971, "A theoretical analysis of the frequency of gaps in plant
stands", Agricultural Meteorology 8; of whole crowns Li & Strahler 1985, "Geometric-optical
modeling of a conifer forest canopy", IEEE Trans. Geoscience and Remote Sensing 23). The rest meets
objects, of each kind in proportion to its K·A.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from jaxtyping import Float64

from lod.arrays import Points, Reals
from lod.hierarchy import Hierarchy
from lod.kernels import njit
from lod.motion import motion_steps
from lod.view import View, distance
from scenes.appearance.sky import Sky
from scenes.field.prototypes import species_prototypes
from scenes.field.species_field import Species
from scenes.ground.stand import (
    AZIMUTHS_DEG,
    DEPRESSIONS_DEG,
    MAX_DEPTH,
    StandAppearance,
    measure_stand,
)
from scenes.processes.cache import content_key
from scenes.rig.rigged_prototype import RiggedPrototype
from scenes.sticks.prototype import Prototype

Shares = Float64[np.ndarray, "n k"]  # shares by point and species

Kinds = Float64[np.ndarray, " k"]
Triple = Float64[np.ndarray, "3"]


def undisplayed_share(
    d: Reals, limits: Float64[np.ndarray, "#n p"], areas: Float64[np.ndarray, " p"], fade: float
) -> Reals:
    """Compute the share of the objects' cover that is not displayed at distance ``d`` (n,), (n,).

    Equally many have each of ``limits`` (n or 1, p), and outlines in proportion to ``areas``; over
    the band of fading it is what they no longer cover.
    """
    missing: Reals = _missing_share(d, np.minimum(limits, 1e30), areas / areas.sum(), fade)
    return missing


@njit(cache=True, nogil=True)
def _missing_share(d, limits, weight, fade):  # type: ignore[no-untyped-def]
    missing = np.empty(len(d))
    for i in range(len(d)):
        limit = limits[min(i, len(limits) - 1)]
        shown = 0.0
        for k in range(len(weight)):
            band = max(fade * limit[k], 1e-12)
            shown += weight[k] * min(max((limit[k] - d[i]) / band, 0.0), 1.0)
        missing[i] = max(1.0 - shown, 0.0)
    return missing


def cover_depths(missing: Shares, density: Kinds, area: Shares, sine: Reals) -> Shares:
    """Compute K·A/sin δ, the mean number of objects of each kind (k,) on each line (n,)."""
    return missing * density * area / sine[:, None]


def covered_share(depths: Shares) -> Reals:
    """Compute the share of lines that meet any object, 1 − exp(−Σ depth), (n,)."""
    return -np.expm1(-depths.sum(axis=1))


def first_hit_shares(depths: Shares) -> Shares:
    """Compute the share of each kind in first hits, (n, k), 0 where no line meets anything."""
    total = depths.sum(axis=1, keepdims=True)
    return np.divide(depths, total, out=np.zeros_like(depths), where=total > 0)


LEAST_LIGHT = 0.05
"""Share of the sun's light on level ground that no surface counts below, so that none asks for an
albedo without end."""


def surface_irradiance(
    normals: Float64[np.ndarray, "n 3"], to_sun: Triple, sky_share: Triple
) -> Points:
    """Compute the irradiance of unshadowed surfaces relative to that of level ground, (n, 3)."""
    sun = np.maximum(normals @ to_sun / to_sun[2], LEAST_LIGHT)[:, None]
    sky = (1 + normals[:, 2:3]) / 2
    return (1 - sky_share) * sun + sky_share * sky


LOWEST_DEG = DEPRESSIONS_DEG[0]
"""Least depression of lines of sight [degrees]: flatter lines nearly all meet something."""


@dataclass(frozen=True, eq=False)
class AggregateCover:
    """Species that stand all over the ground, and the light on them.

    to_sun (3,)  unit vector to the sun
    max_depth    longest path of light among them, in segments
    """

    species: tuple[Species, ...]
    to_sun: np.ndarray
    sky: Sky
    max_depth: int = MAX_DEPTH

    @cached_property
    def stand(self) -> StandAppearance:
        """Return the appearance of the stand, measured when it is first needed."""
        elevation = math.degrees(math.asin(self.to_sun[2]))
        kinds = tuple((_distinct(each.prototypes), each.density) for each in self.species)
        return measure_stand(kinds, round(elevation, 3), self.sky, self.max_depth)

    @cached_property
    def highest(self) -> float:
        """Return the largest height above the ground that anything of the species reaches [m]."""
        prototypes = [p for each in self.species for p in each.prototypes]
        return max((float(p.hierarchy.B[0]) for p in prototypes), default=0.0)

    def undisplayed(self, view: View, points: Points) -> tuple[Shares, Shares]:
        """Compute, at points of the ground, which share of the cover of what grows is undisplayed.

        Small objects stop being displayed first, and cover less. The second result is which share
        of its density each species has there, (n, k) each.
        """
        d, gone = distance(view, points), np.empty((len(points), len(self.species)))
        grown = np.ones_like(gone)
        for k, each in enumerate(self.species):
            trees, own = [p.hierarchy for p in each.prototypes], each.seen_in(view)
            if any(tree.is_thinned for tree in trees):
                gone[:, k] = _missing(own, each, points, d)
            else:
                outlines = np.array([float(tree.P[0]) ** 2 for tree in trees])
                limits = _limits_at(own, trees, points, d)
                gone[:, k] = undisplayed_share(d, limits, outlines, view.fade)
            if each.habitat is not None:
                grown[:, k] = each.habitat.share(view.camera.corner, points[:, :2])
        return gone, grown

    def residual(
        self, view: View, points: Points, slopes: Float64[np.ndarray, "n 2"] | None = None
    ) -> "ResidualCover":
        """Compute what the species leave at points (n, 3) of the ground, as the eye sees it.

        slopes (n, 2)  of the ground without its small bumps; None = it is level
        """
        slopes = np.zeros((len(points), 2)) if slopes is None else slopes
        gone, grown = self.undisplayed(view, points)
        rows = np.flatnonzero((gone * grown).any(axis=1))
        lift, covered = np.zeros((2, len(points)))
        look = None
        if len(rows):
            at, gone, grown = points[rows], gone[rows], grown[rows]
            level = SightLines.of(self, view, at, slopes[rows], gone, grown)
            height = self.stand.height[:, None, None]
            lift[rows] = interpolate_table(height, level.row, 0 * level.row)[:, 0] * level.share
            # Lines meet the ground where it is drawn, and what is displayed is buried so deep.
            drawn = at + lift[rows, None] * np.array((0.0, 0.0, 1.0))
            above = np.interp(lift[rows], self.stand.levels, self.stand.above)[:, None]
            look = SightLines.of(self, view, drawn, slopes[rows], 1 - (1 - gone) * above, grown)
            covered[rows] = covered_share(look.depths)
        return ResidualCover(self, lift, covered, rows, look)


@dataclass(frozen=True, eq=False)
class ResidualCover:
    """Cover of undisplayed objects at n points of the ground.

    lift, covered (n,)  height by which it raises the ground [m], share of the ground that it hides
    rows, lines         points where anything is undisplayed, and the lines of sight down to them
    """

    cover: AggregateCover
    lift: np.ndarray
    covered: np.ndarray
    rows: np.ndarray
    lines: "SightLines | None"

    def colours(self, normals: Points, bare: Points) -> Points:
        """Compute albedos by which the ground sends to the eye what stand and ground would.

        It is ``bare`` where nothing is undisplayed. The normals are without the small bumps of the
        ground: stands are as bright on all sides of those, and an albedo that makes up for one side
        would shine out beside it.
        """
        colours, rows, cover = bare.copy(), self.rows, self.cover
        if self.lines is not None:
            light = surface_irradiance(normals[rows], cover.to_sun, cover.sky.share)
            colours[rows] = np.clip(self._outgoing(self.lines, bare[rows], light), 0.0, 1.0)
        return colours

    def _outgoing(self, look: "SightLines", bare: Points, light: Points) -> Points:
        """Radiance toward the eye over that of white ground in the same light, (n, 3)."""
        stand, kinds = self.cover.stand, first_hit_shares(look.depths)
        covered = self.covered[self.rows, None]
        radiance, ground_bounce = (
            sum(kinds[:, k, None] * look.at(table[k]) for k in range(len(table)))
            for table in (stand.radiance, stand.ground_bounce)
        )
        # What is displayed shades all that is painted on the ground: of the ground only the rest of
        # the shade is missing, and what stands there is shaded already by all of the stand.
        shade = np.maximum(look.at(stand.ground), LEAST_LIGHT)
        stands = (radiance + bare * ground_bounce) / (light * shade ** look.rest[:, None])
        ground = bare * shade ** look.share[:, None]
        found: Points = (1 - covered) * ground + covered * stands
        return found


def _distinct(
    prototypes: tuple[Prototype | RiggedPrototype, ...],
) -> tuple[Prototype | RiggedPrototype, ...]:
    looks = [content_key(each.inner, each.leaf) for each in prototypes]
    return tuple(dict(zip(looks, prototypes, strict=True)).values())


def _missing(view: View, species: Species, points: Points, d: Reals) -> Reals:
    """Share of the cover of a species that thins out which is left to the ground, (n,)."""
    tables, motion = species_prototypes(species.prototypes).part_tables, np.zeros(len(points))
    if view.shutter is not None and view.metric.finite:
        bound, ends = np.full(len(points), tables.bound.max()), (points, points)
        corner, theta = view.camera.corner, view.theta
        motion = motion_steps(view.shutter, corner, theta, *ends, bound, 0 * bound)
    return tables.missing_cover(d, view, motion)


def _limits_at(
    view: View, trees: Sequence[Hierarchy], points: Points, d: Reals
) -> Float64[np.ndarray, "#n t"]:
    """Limit distances of whole objects that stand still at points of the ground, (n or 1, t) [m].

    There is one row where they are the same everywhere. Motion blurs all of them as it does the
    largest. The blur is smoothed over neighbouring frames only where that can make a difference: it
    is never more than the frame's own.
    """
    limits = np.array([[float(view.limits(tree)[0][0]) for tree in trees]])
    if view.shutter is None or not view.metric.finite:
        return limits
    limits = np.repeat(limits, len(points), axis=0)
    radius = max(float(tree.B[0]) for tree in trees)
    rows = np.flatnonzero(d < limits[0].max())
    for shutter in (replace(view.shutter, neighbour=None), view.shutter):
        still, bound = np.zeros(len(rows)), np.full(len(rows), radius)
        ends = points[rows], points[rows]
        motion_step = motion_steps(shutter, view.camera.corner, view.theta, *ends, bound, still)
        steps = np.arange(int(motion_step.max(initial=0.0)) + 2)
        tables = [[float(view.limits(tree, int(step))[0][0]) for step in steps] for tree in trees]
        columns = [np.interp(motion_step, steps, table) for table in tables]
        limits[rows] = np.stack(columns, axis=1)
        rows = rows[d[rows] > (1 - view.fade) * limits[rows].min(axis=1)]
    return limits


@dataclass(frozen=True, eq=False)
class SightLines:
    """Lines of sight that come down to n points of the ground.

    On a slope a line meets as many objects as one that comes down to level ground at such a
    depression that it passes over as little of it: of K objects on a square metre of the map it
    meets K·A/(sin δ − s·cos δ), where the ground falls by s along the way to the eye.

    row, column (n,)  of their depressions and azimuths in the tables of a stand, with fractions
    depths (n, k)     optical depth of each species' undisplayed cover
    share (n,)        undisplayed share of the cover that the stand has where all species grow
    rest (n,)         displayed share of it
    """

    row: np.ndarray
    column: np.ndarray
    depths: np.ndarray
    share: np.ndarray
    rest: np.ndarray

    @staticmethod
    def of(
        cover: AggregateCover,
        view: View,
        points: Points,
        slopes: Float64[np.ndarray, "n 2"],
        gone: Shares,
        grown: Shares,
    ) -> "SightLines":
        to_eye = view.camera.eye - points
        rise = to_eye[:, 2] - (slopes * to_eye[:, :2]).sum(axis=1)
        sine = rise / np.maximum(np.sqrt((to_eye**2).sum(axis=1)), 1e-9)
        depression = np.degrees(np.arcsin(np.clip(sine, -1.0, 1.0)))
        depression = np.maximum(depression, LOWEST_DEG)
        sun = math.atan2(cover.to_sun[1], cover.to_sun[0])
        turn = np.degrees(np.arctan2(to_eye[:, 1], to_eye[:, 0]) - sun)
        turn = np.abs((turn + 180.0) % 360.0 - 180.0)
        row = np.interp(depression, DEPRESSIONS_DEG, np.arange(len(DEPRESSIONS_DEG)))
        column = np.interp(turn, AZIMUTHS_DEG, np.arange(len(AZIMUTHS_DEG)))
        area = interpolate_table(cover.stand.area.T[:, None], row, np.zeros(len(row)))
        density = np.array([each.density for each in cover.species])
        sine = np.sin(np.radians(depression))
        whole = cover_depths(np.ones_like(grown), density, area, sine)
        there, depths = whole * grown, whole * grown * gone
        share, rest = (each.sum(axis=1) / whole.sum(axis=1) for each in (depths, there - depths))
        return SightLines(row, column, depths, share, rest)

    def at(self, table: Float64[np.ndarray, "d p 3"]) -> Points:
        """Compute the entries of a table (δ, φ, 3) at each line, (n, 3), linear in both angles."""
        found: Points = interpolate_table(table, self.row, self.column)
        return found


@njit(cache=True, nogil=True)
def interpolate_table(table, row, column):  # type: ignore[no-untyped-def]
    """Interpolate a table (a, b, c) bilinearly at fractional rows and columns (n,), (n, c)."""
    found = np.empty((len(row), table.shape[2]))
    last_row, last_column = table.shape[0] - 1, table.shape[1] - 1
    for p in range(len(row)):
        i, j = int(row[p]), int(column[p])
        u, v = row[p] - i, column[p] - j
        below, beside = min(i + 1, last_row), min(j + 1, last_column)
        for c in range(table.shape[2]):
            low = (1 - v) * table[i, j, c] + v * table[i, beside, c]
            high = (1 - v) * table[below, j, c] + v * table[below, beside, c]
            found[p, c] = (1 - u) * low + u * high
    return found
