"""What lies beyond the limit, left on the land: the ground takes its colour, shade and height."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from jaxtyping import Float64

from lod.arrays import Points, Reals
from lod.cover import (
    albedo_under,
    cover_depths,
    covered_share,
    irradiance_on,
    kinds_met,
    missing_share,
)
from lod.hierarchy import Hierarchy
from lod.smear import smears
from lod.view import View, distance
from scenes.field import Species
from scenes.stand import DEPRESSIONS_DEG, TURNS_DEG, Stand, stand_of

LOWEST_DEG = DEPRESSIONS_DEG[0]
"""No line counts as coming down flatter: there nearly every line meets something in any case."""


@dataclass(frozen=True, eq=False)
class FarCover:
    """Species that stand all over the ground, and the light on them.

    to_sun (3,) unit vector; sky_share (3,) of the light on level ground
    """

    species: tuple[Species, ...]
    to_sun: np.ndarray
    sky_share: np.ndarray

    @cached_property
    def stand(self) -> Stand:
        """Its looks, measured when first something is missing."""
        elevation = math.degrees(math.asin(self.to_sun[2]))
        kinds = tuple((each.prototypes, each.density) for each in self.species)
        red, green, blue = self.sky_share.tolist()
        return stand_of(kinds, round(elevation, 3), (red, green, blue))

    @cached_property
    def highest(self) -> float:
        """What nothing that stands reaches above the ground [m]."""
        prototypes = [p for each in self.species for p in each.prototypes]
        return max((float(p.hierarchy.B[0]) for p in prototypes), default=0.0)

    def missing(self, view: View, points: Points) -> Float64[np.ndarray, "n k"]:
        """Share of each species that is not displayed at points of the ground."""
        d = distance(view, points)
        columns = []
        for each in self.species:
            trees = [p.hierarchy for p in each.prototypes]
            column = missing_share(d, _limits_at(view, trees, points, d), view.fade)
            if each.habitat is not None:
                column *= each.habitat.share(view.camera.corner, points[:, :2])
            columns.append(column)
        return np.stack(columns, axis=1) if columns else np.zeros((len(points), 0))

    def lift(self, view: View, points: Points) -> Reals:
        """Height above the ground at which lines from the eye first meet what is missing [m]."""
        missing = self.missing(view, points)
        lift, rows = np.zeros(len(points)), np.flatnonzero(missing.any(axis=1))
        if len(rows):
            look = _Lines.of(self, view, points[rows], missing[rows])
            lift[rows] = look.at_depression(self.stand.height) * look.share
        return lift

    def colours(self, view: View, points: Points, normals: Points, bare: Points) -> Points:
        """Albedo of the ground, ``bare`` where nothing is missing, so that it sends to the eye what
        the stand and the ground below it would. ``normals`` are those it is shaded with."""
        missing = self.missing(view, points)
        colours, rows = bare.copy(), np.flatnonzero(missing.any(axis=1))
        if len(rows):
            look = _Lines.of(self, view, points[rows], missing[rows])
            light = irradiance_on(normals[rows], self.to_sun, self.sky_share)
            sent = self._sent(look, bare[rows], light)
            colours[rows] = albedo_under(sent, normals[rows], self.to_sun, self.sky_share)
        return colours

    def _sent(self, look: "_Lines", bare: Points, light: Points) -> Points:
        """Radiance toward the eye over that of unshadowed white level ground, (n, 3)."""
        stand, kinds = self.stand, kinds_met(look.depths)
        covered = covered_share(look.depths)[:, None]
        sent, lifted = (
            sum(kinds[:, k, None] * look.at(table[k]) for k in range(len(table)))
            for table in (stand.sent, stand.lifted)
        )
        # What is displayed shades the ground by itself: only the rest of the shade is missing.
        ground = bare * light * look.at(stand.ground) ** look.share[:, None]
        found: Points = (1 - covered) * ground + covered * (sent + bare * lifted)
        return found


def _limits_at(
    view: View, trees: Sequence[Hierarchy], points: Points, d: Reals
) -> Float64[np.ndarray, "n t"]:
    """Limit distances of wholes that stand still at points of the ground, d away [m].

    Motion hides of all of them what it hides of the largest. What it hides is eased only where that
    can make a difference: it is never more than the frame's own.
    """
    limits = np.tile([float(view.limits(tree)[0][0]) for tree in trees], (len(points), 1))
    if view.exposure is None or not view.metric.finite:
        return limits
    radius = max(float(tree.B[0]) for tree in trees)
    rows = np.flatnonzero(d < limits[0].max())
    for exposure in (replace(view.exposure, near=None), view.exposure):
        still, bound = np.zeros(len(rows)), np.full(len(rows), radius)
        ends = points[rows], points[rows]
        smear = smears(exposure, view.camera.corner, view.theta, *ends, bound, still)
        limits[rows] = _smeared(view, trees, smear)
        rows = rows[d[rows] > (1 - view.fade) * limits[rows].min(axis=1)]
    return limits


def _smeared(view: View, trees: Sequence[Hierarchy], smear: Reals) -> Float64[np.ndarray, "n t"]:
    """Limit distances of wholes of which motion hides so much [m]."""
    steps = np.arange(int(smear.max(initial=0.0)) + 2)
    tables = [[float(view.limits(tree, int(step))[0][0]) for step in steps] for tree in trees]
    return np.stack([np.interp(smear, steps, table) for table in tables], axis=1)


@dataclass(frozen=True, eq=False)
class _Lines:
    """Lines of sight that come down to points of the ground.

    depression, turn (n,) [degrees]; depths (n, k) of each species' cover; share (n,): of the whole
    stand's cover that is missing
    """

    depression: np.ndarray
    turn: np.ndarray
    depths: np.ndarray
    share: np.ndarray

    @staticmethod
    def of(cover: FarCover, view: View, points: Points, missing: np.ndarray) -> "_Lines":
        to_eye = view.camera.eye - points
        flat = np.hypot(to_eye[:, 0], to_eye[:, 1])
        depression = np.degrees(np.arctan2(to_eye[:, 2], flat))
        depression = np.maximum(depression, LOWEST_DEG)
        sun = math.atan2(cover.to_sun[1], cover.to_sun[0])
        turn = np.degrees(np.arctan2(to_eye[:, 1], to_eye[:, 0]) - sun)
        turn = np.abs((turn + 180.0) % 360.0 - 180.0)
        table = cover.stand.area.T
        area = np.stack([np.interp(depression, DEPRESSIONS_DEG, row) for row in table.T], axis=1)
        density = np.array([each.density for each in cover.species])
        sine = np.sin(np.radians(depression))
        depths = cover_depths(missing, density, area, sine)
        whole = cover_depths(np.ones_like(missing), density, area, sine)
        return _Lines(depression, turn, depths, depths.sum(axis=1) / whole.sum(axis=1))

    def at_depression(self, table: Float64[np.ndarray, " d"]) -> Reals:
        """A table (δ,) at each line, (n,)."""
        return np.interp(self.depression, DEPRESSIONS_DEG, table)

    def at(self, table: np.ndarray) -> np.ndarray:
        """A table (δ, φ) or (δ, φ, 3) at each line, (n,) or (n, 3): linear in both angles."""
        row = np.interp(self.depression, DEPRESSIONS_DEG, np.arange(len(DEPRESSIONS_DEG)))
        column = np.interp(self.turn, TURNS_DEG, np.arange(len(TURNS_DEG)))
        i = np.minimum(row.astype(np.int64), len(DEPRESSIONS_DEG) - 2)
        j = np.minimum(column.astype(np.int64), len(TURNS_DEG) - 2)
        u, v = row - i, column - j
        if table.ndim == 3:
            u, v = u[:, None], v[:, None]
        low = (1 - v) * table[i, j] + v * table[i, j + 1]
        high = (1 - v) * table[i + 1, j] + v * table[i + 1, j + 1]
        return (1 - u) * low + u * high
