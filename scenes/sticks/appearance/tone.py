"""How brightly leaf appearances shine: the multiple of their albedo that what they hide asks for.

Hidden parts shade one another, and a few smooth shapes do not. For every level of detail, elevation
of the eye and azimuth between eye and sun the tone T is found with which the object, displayed down
to that level, sends as much light as in full detail: Σ Lₛ·Tˢ = L, where Lₛ is the light of paths
that meet s of the shapes. Light comes from sun and sky, among the object's parts and once by way of
the ground. The object stands alone. All that is needed is geometry and albedo.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64

from lod.arrays import Flags, Reals
from scenes.processes.content_cache import kept
from scenes.processes.content_key import content_key
from scenes.processes.progress import tell
from scenes.sticks.appearance.fit import CODE
from scenes.sticks.appearance.light_paths import lone_object, outgoing_light
from scenes.sticks.appearance.sky import sky_at
from scenes.sticks.appearance.sun_and_sky import SunAndSky
from scenes.sticks.prototype import Prototype
from scenes.sticks.shapes import Shapes
from scenes.sticks.view_angles import AZIMUTHS_DEG, ELEVATIONS_DEG
from scenes.sticks.view_dependent_area import with_area_share
from scenes.terrain.colour import GROUND_MATERIALS

LINES = 80_000
"""Lines of sight from each elevation, over all objects that are fitted together."""

SIZE_M = 10.0
"""Range R that objects are scaled to, so that rays go through boxes of a like size [m]."""

BOUNDS = 0.05, 2.5
"""Least and greatest tone."""

FAINT = 0.03
"""Share of an object's light below which shapes keep their own albedo."""

_SEED = 0x70E
_NEWTON_STEPS = 12
_CIRCLE = np.array((0.5, *(1.0,) * (len(AZIMUTHS_DEG) - 2), 0.5)) / (len(AZIMUTHS_DEG) - 1)
"""Share of the circle that each of AZIMUTHS_DEG stands for."""


@dataclass(frozen=True)
class Illumination:
    """The light that leaf appearances are fitted in.

    sun_elevation_deg, turbidity  as a preset has them; max_depth: longest path, in segments
    """

    sun_elevation_deg: float
    turbidity: float = 3.0
    max_depth: int = 4


def fit_tone(
    objects: Sequence[Prototype], illumination: Illumination, lines: int = LINES
) -> Float64[np.ndarray, "c h t"]:
    """Fit one table of tones for objects of a kind, or find it where it is kept.

    It is (levels, elevations, azimuths + 1) in size. The last column holds the mean over all
    azimuths (``scenes.sticks.view_dependence``).
    """
    shapes = [each.scaled(SIZE_M / float(each.hierarchy.R[0])) for each in objects]
    key = content_key([_rounded(each) for each in shapes], illumination, lines)
    return kept("tone", key, lambda: {"tone": _fit(shapes, illumination, lines)}, CODE)["tone"]


def _rounded(one: Prototype) -> list[np.ndarray]:
    """Round what the light of an object depends on, so that its size does not tell."""
    tables = [column for each in (one.inner, one.leaf) for column in (each.first, *each.columns)]
    views, h = one.view_dependence, one.hierarchy
    if one.meshes is not None:
        tables += one.meshes.surface
    return [np.round(each, 6) for each in (*tables, one.tints, views.area_share, h.level)]


def _fit(
    objects: Sequence[Prototype], illumination: Illumination, lines: int
) -> Float64[np.ndarray, "c h t"]:
    """Fit the tones of objects whose range is SIZE_M."""
    levels = max(len(each.view_dependence.area_share) for each in objects)
    tell()
    full = _light(objects, None, illumination, lines).sum(axis=1)
    tones = np.empty((levels, len(ELEVATIONS_DEG), len(AZIMUTHS_DEG) + 1))
    for level in range(levels):
        tell(1 / (levels + 1))
        parts = _light(objects, level, illumination, lines)
        wanted = np.concatenate((full, (full @ _CIRCLE)[:, None]), axis=1)
        around = (parts @ _CIRCLE)[:, :, None]
        tones[level] = _solve(np.concatenate((parts, around), axis=2), wanted)
    return tones


def _solve(parts: Float64[np.ndarray, "h s t"], wanted: Float64[np.ndarray, "h t"]) -> np.ndarray:
    """Find T with Σ Lₛ·Tˢ = L by Newton's method, kept within BOUNDS.

    It is 1 where the shapes send less than FAINT of the light, and no T could make up for the rest.
    """
    powers = np.arange(parts.shape[1])[:, None]
    tone = np.ones_like(wanted)
    for _ in range(_NEWTON_STEPS):
        value = (parts * tone[:, None] ** powers).sum(axis=1) - wanted
        slope = (parts * powers * tone[:, None] ** np.maximum(powers - 1, 0)).sum(axis=1)
        tone = np.clip(tone - value / np.maximum(slope, 1e-12), *BOUNDS)
    return np.where(parts[:, 1:].sum(axis=1) < FAINT * wanted, 1.0, tone)


def _light(
    objects: Sequence[Prototype], level: int | None, illumination: Illumination, lines: int
) -> Float64[np.ndarray, "h s t"]:
    """Light that objects send down to a level, or in full detail, in the sum over them.

    The shapes of the level show the share of their area that they do from each elevation.
    """
    sky = sky_at(illumination.sun_elevation_deg, illumination.turbidity)
    light = SunAndSky.at_azimuths(illumination.sun_elevation_deg, AZIMUTHS_DEG, sky)
    grass = GROUND_MATERIALS["grassy"]
    ground = (np.array(grass.moist) + np.array(grass.dry)) / 2
    rng = np.random.Generator(np.random.Philox(_SEED))
    surfaces = max(illumination.max_depth - 1, 1)
    total = np.zeros((len(ELEVATIONS_DEG), surfaces + 1, len(AZIMUTHS_DEG)))
    for each in objects:
        randoms = rng.random((max(lines // len(objects), 1), 2 * surfaces + 2))
        for row in range(len(ELEVATIONS_DEG)):
            shown, shape = displayed_to(each, level, row)
            alone = lone_object(shown, shown.albedos(each.tints), shape, ground)
            total[row] += outgoing_light(alone, light, ELEVATIONS_DEG[row], randoms)
    return total


def displayed_to(one: Prototype, level: int | None, elevation: int) -> tuple[Shapes, Flags]:
    """Collect what an object displays down to a level; None: in full detail.

    Returns it as it looks from a row of ELEVATIONS_DEG, and which of its shapes (k,) stand for
    hidden parts.
    """
    h, views = one.hierarchy, one.view_dependence
    finest = int(h.level.max())
    level = finest if level is None else level
    ends = (h.level == level) | ((h.level < level) & (h.part_count == 0))
    inner = one.inner.only((h.level < level) & ~ends)
    rows = views.rows(len(one.leaf))
    shares: Reals = np.append(views.area_share[:, elevation], 1.0)[rows]
    leaf = with_area_share(one.leaf, np.maximum(shares, 1e-6))
    shown = (ends & ~one.has_mesh)[leaf.owner]
    meshes = one.meshes.only(ends) if one.meshes is not None else None
    found = Shapes.of(inner, meshes).with_sticks(leaf.take(shown))
    hides = np.zeros(len(found), np.bool_)
    hides[len(inner) : len(found.sticks)] = rows[shown] >= 0
    return found, hides
