"""How many parts of each size does one field display, and how many does the law predict?

It serves the experiments on haze and eye. The ground is flat, an eye 1.6 m up looks all round, and
the picture is 60° wide. Fields are the denser the coarser the detail, with K·m² constant, so that
all hold about as many objects.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import lru_cache

import numpy as np

from bench.counting import EYE_HEIGHT_M, FLAT, field_seed, prototypes_of
from bench.records.records import Column, Key, Point, Prediction
from bench.statistics.estimates import Estimate, two_sided_share
from lod.arrays import Reals
from lod.camera import Camera, Corner, camera_from_heading
from lod.eye import CONTRAST_CLASSES
from lod.law import chained_limits, disc_areas
from lod.metric import METRICS
from lod.pruner import prune
from lod.view import View, distance
from lod.viewing import ViewingConditions
from scenes.field.species_field import Species, SpeciesField
from scenes.sticks.prototype import Prototype

BOUNDS_M = (0.1, 0.3, 1.0, 3.0)
SIZES = ("under 0.1 m", "0.1 to 0.3 m", "0.3 to 1 m", "1 to 3 m", "over 3 m")
"""The names of the classes of P, from the first, which is below the first bound."""

DENSITY = {"figure": 2e-3, "tree": 1e-5}
"""K of each species [1/m²] at COARSE_M: a field has thousands of objects."""

COARSE_M = 2 * math.tan(math.radians(30)) / 640  # m of one pixel of 640 across 60° [rad]


def camera(width: int) -> Camera:
    """Make the camera of every field, for a picture so many pixels wide."""
    eye = np.array((0.0, 0.0, EYE_HEIGHT_M))
    return camera_from_heading(Corner(0, 0), eye, 0.0, 0.0, 60.0, (width, 360))


def view_through(sight: ViewingConditions, width: int) -> View:
    """Make a view all round through that air, display and eye, at a detail threshold of 1."""
    return View(camera(width), METRICS["blake"], look_around=True, conditions=sight)


def density_of(species: str, m: float) -> float:
    """Return K of fields that are measured at a detail angle m [1/m²]."""
    return DENSITY[species] * (m / COARSE_M) ** 2


def count_sizes(
    prototypes: tuple[Prototype, ...],
    density: float,
    view: View,
    seed: int,
    near_m: Sequence[float] = (),
) -> tuple[list[int], list[int]]:
    """Count the parts of each size in one real field, by the real pruner.

    Gives a number for each size, and for each of the distances ``near_m`` [m] that of nearer parts.
    """
    field = SpeciesField(Species("sight", prototypes, density), seed, FLAT)
    parts = prune(field, view).parts
    size = np.concatenate([tree.P for tree in field.prototypes.part_tables.hierarchies])[parts.part]
    far = distance(view, parts.position)
    by_size: list[int] = np.bincount(size_class(size), minlength=len(SIZES)).tolist()
    return by_size, [int(np.count_nonzero(far < near)) for near in near_m]


def predicted_sizes(prototypes: tuple[Prototype, ...], density: float, view: View) -> Reals:
    """Predict the mean number of parts of each size, (sizes,), without the pruner (§4.1)."""
    total = np.zeros(len(SIZES))
    for tree in (each.hierarchy for each in prototypes):
        limits = chained_limits(tree, view.metric, view.m, view.conditions)
        areas = disc_areas(limits, EYE_HEIGHT_M - tree.position[:, 2])
        total += np.bincount(size_class(tree.P), areas, len(SIZES))
    return total * density / len(prototypes)


def size_columns(fields: Sequence[Sequence[int]], **keys: Key) -> tuple[Column, ...]:
    """Make one column of parts for each size, a number for each field, with further keys."""
    rows = zip(SIZES, *fields, strict=True)
    return tuple(Column("parts", row, {**keys, "size": size}) for size, *row in rows)


def size_predictions(means: Reals, **keys: Key) -> tuple[Prediction, ...]:
    """Make one prediction of parts for each size, of (sizes,) means, with further keys."""
    return tuple(
        Prediction("parts", float(mean), {**keys, "size": size})
        for size, mean in zip(SIZES, means, strict=True)
    )


def part_counts(point: Point, sizes: Sequence[str] = SIZES, **keys: Key) -> Reals:
    """Return the parts of these sizes that every field displays, (fields,), by further keys."""
    rows = [point.values("parts", **keys, size=size) for size in sizes]
    return np.asarray(np.sum(rows, axis=0))


def predicted_parts(point: Point, sizes: Sequence[str] = SIZES, **keys: Key) -> float:
    """Return the number of parts of these sizes that the law predicts for a field."""
    return sum(point.prediction("parts", **keys, size=size) for size in sizes)


def shares_kept(
    points: Sequence[Point],
    kept: Mapping[str, Key],
    whole: Mapping[str, Key],
    sizes: Sequence[str] = SIZES,
) -> tuple[Estimate, float]:
    """Estimate the share of parts that is left, over all points; and predict it by the law.

    The row of a field is its sum over points. ``kept`` and ``whole`` are the keys of the parts that
    are left, and of those that they are left of.
    """
    counts = [
        np.sum([part_counts(p, sizes, **keys) for p in points], axis=0) for keys in (kept, whole)
    ]
    law = [sum(predicted_parts(p, sizes, **keys) for p in points) for keys in (kept, whole)]
    return two_sided_share(counts[0], counts[1]), law[0] / law[1]


def size_class(P: Reals) -> np.ndarray:
    """Return the row of SIZES in which each priority falls, (n,)."""
    return np.searchsorted(BOUNDS_M, P, side="right")


@lru_cache(maxsize=16)
def prototypes_with(species: str, contrast: float | None) -> tuple[Prototype, ...]:
    """Return a species' prototypes with one contrast for all parts; None = each part's own."""
    usual = prototypes_of(species, 1.0)
    if contrast is None:
        return usual
    row = CONTRAST_CLASSES.index(contrast)
    trees = [replace(p.hierarchy, contrast=np.full(len(p.hierarchy), row)) for p in usual]
    return tuple(replace(p, hierarchy=tree) for p, tree in zip(usual, trees, strict=True))


def seed_of(what: str, seed: int, index: int) -> int:
    """Return a field's own seed, in 63 bits."""
    return field_seed("sight", what, seed, index)
