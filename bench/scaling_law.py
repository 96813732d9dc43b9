"""What the law predicts for a case; P, R and D are derived without the pruner (§4.1, DESIGN §1)."""

from dataclasses import asdict, dataclass
from functools import lru_cache

import numpy as np

from bench.scaling_cases import EYE_HEIGHT_M, Case
from lod.arrays import Reals
from lod.law import chained_limits, disc_areas, expected, variance
from scenes.figure import figure_prototypes
from scenes.plugins import metric_named
from scenes.prototype import Prototype
from scenes.tree import tree_prototypes

_STANDING = {"figure": lambda: figure_prototypes(0, 4), "tree": lambda: tree_prototypes(0, 2)}
"""The prototypes of each species, all equally likely; nothing moves."""


@lru_cache(maxsize=64)
def prototypes_of(species: str, size: float) -> tuple[Prototype, ...]:
    """The species' prototypes, ``size`` times as large."""
    return tuple(each.scaled(size) for each in _STANDING[species]())


@dataclass(frozen=True)
class Prediction:
    """For one field of a case: means and variances of what is displayed.

    P_plus_R  of the whole object, the prototypes' mean [m]
    nearest_limit, farthest_limit   limit distance of the whole, the prototypes' extremes [m]
    """

    objects: float
    objects_variance: float
    parts: float
    parts_variance: float
    P_plus_R: float
    nearest_limit: float
    farthest_limit: float

    def as_json(self) -> dict[str, float]:
        """Plain data."""
        return {name: float(value) for name, value in asdict(self).items()}


def predict(case: Case) -> Prediction:
    """The law, each prototype with its share of the density."""
    trees = [each.hierarchy for each in prototypes_of(case.species, case.size)]
    K = case.density / len(trees)
    limits = [chained_limits(tree, metric_named(case.metric), case.m) for tree in trees]
    areas = [
        shown_areas(D, EYE_HEIGHT_M - tree.position[:, 2], case.extent)
        for D, tree in zip(limits, trees, strict=True)
    ]
    whole = np.array([D[0] for D in limits])
    objects = sum(expected(K, each[:1]) for each in areas)
    return Prediction(
        objects=objects,
        objects_variance=objects,
        parts=sum(expected(K, each) for each in areas),
        parts_variance=sum(variance(K, each) for each in areas),
        P_plus_R=float(np.mean([tree.P[0] + tree.R[0] for tree in trees])),
        nearest_limit=float(whole.min()),
        farthest_limit=float(whole.max()),
    )


def shown_areas(D: Reals, h: Reals, extent: float | None) -> Reals:
    """Area of ground from which each part is displayed [m²]: a disc, or what the world has of it.

    The world's square is about the eye and of objects; that a part stands aside of its object
    changes the area by the order of (how far aside ÷ side)², which is left out.
    """
    discs = disc_areas(D, h)
    if extent is None:
        return discs
    return disc_in_square(np.sqrt(discs / np.pi), extent)


def disc_in_square(radius: Reals, side: float) -> Reals:
    """Area that a disc shares with a square of the same centre."""
    half = side / 2
    reach = np.clip(radius, half, half * np.sqrt(2))
    # Four segments stick out of the sides; in the clipped range no two of them meet.
    segment = reach**2 * np.arccos(half / reach) - half * np.sqrt(reach**2 - half**2)
    return np.where(radius <= half, np.pi * np.square(radius), np.pi * reach**2 - 4 * segment)
