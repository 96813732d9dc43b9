"""What does the law predict for a case? P, R and D are derived without the pruner (§4.1)."""

from dataclasses import asdict, dataclass

import numpy as np

from bench.fields.cases import Case
from bench.fields.scene import KEPT, ground_of, prototypes_of, view_of
from lod.arrays import Reals
from lod.hierarchy import Hierarchy
from lod.law import (
    chained_limits,
    count_moments,
    count_variance,
    disc_areas,
    expected_count,
    ground_nodes,
)
from lod.metric import Metric
from lod.viewing import ViewingConditions
from scenes.plugins import metric_by_name
from scenes.sticks.prototype import Prototype

_NODES = 2**18
"""Nodes of the integral over hilly ground."""


@dataclass(frozen=True)
class Prediction:
    """Means and variances of what one field of a case displays.

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

    def as_json(self) -> dict[str, float]:
        """Return plain data."""
        return {name: float(value) for name, value in asdict(self).items()}


def predict(case: Case) -> Prediction:
    """Predict a case; each species and prototype has its share of the density."""
    kinds = [prototypes_of(name, case.size) for name in case.species.split("+")]
    means = _over_hills(case, kinds) if case.hills else _over_flat(case, kinds)
    trees = [each.hierarchy for kind in kinds for each in kind]
    whole = np.array([chained_limits(t, _metric(case), case.m, _sight(case))[0] for t in trees])
    clear = [np.mean([_bare(case, each.hierarchy) for each in kind]) for kind in kinds]
    objects, objects_variance, parts, parts_variance = (float(v) for v in means)
    return Prediction(
        objects,
        objects_variance,
        parts,
        parts_variance,
        P_plus_R=float(np.mean([tree.P[0] + tree.R[0] for tree in trees])),
        nearest_limit=float(whole.min()),
        farthest_limit=float(whole.max()),
        bare=case.density * float(np.mean(clear)),
    )


def _over_flat(case: Case, kinds: list[tuple[Prototype, ...]]) -> np.ndarray:
    """Return mean and variance of objects and of parts, (4,), in closed form."""
    means = np.zeros(4)
    for kind in kinds:
        K = case.density / len(kinds) / len(kind)
        for tree in (each.hierarchy for each in kind):
            D = chained_limits(tree, _metric(case), case.m, _sight(case))
            areas = shown_areas(D, case.eye_height - tree.position[:, 2], case.extent)
            if case.gathered == "clearing":
                areas = cleared(areas, case.scale)
            means += (
                expected_count(K, areas[:1]),
                0,
                expected_count(K, areas),
                count_variance(K, areas),
            )
    means[1] = means[0]
    means[[1, 3]] *= clumping(case)
    return means


def _over_hills(case: Case, kinds: list[tuple[Prototype, ...]]) -> np.ndarray:
    """Return mean and variance of objects and of parts, (4,), integrated over the hills."""
    view, ground, means = view_of(case), ground_of(case), np.zeros(4)
    for kind in kinds:
        trees = tuple(each.hierarchy for each in kind)
        net = ground_nodes(trees, view, _NODES)
        found = count_moments(trees, view, net, ground.height(view.camera.corner, net.xy))
        K = case.density / len(kinds)
        means += K * np.array(
            (found.objects, found.objects_variance, found.parts, found.parts_variance)
        )
    return means


def clumping(case: Case) -> float:
    """Return the variance ÷ that of an even field of K, in patches far smaller than the limit.

    Patches of side s are there with chance p, all their objects together: the counts have, beside
    K∫n² dA, the variance of K/p·s²·n over patches, which is K²s²(1 − p)/p·∫n² dA.
    """
    if case.gathered != "patches":
        return 1.0
    p = KEPT["patches"]
    return 1 + case.density * case.scale**2 * (1 - p) / p


def cleared(areas: Reals, scale: float) -> Reals:
    """Return ∫ min(1, r/scale) dA over discs of these areas about the eye [m²]."""
    radius = np.sqrt(areas / np.pi)
    within = 2 * np.pi * np.minimum(radius, scale) ** 3 / (3 * scale)
    return within + np.pi * np.maximum(radius**2 - scale**2, 0.0)


def _bare(case: Case, tree: Hierarchy) -> float:
    """Return the area of ground within the limit in clear air [m²]."""
    return float(np.pi * chained_limits(tree, _metric(case), case.m)[0] ** 2)


def _metric(case: Case) -> Metric:
    return metric_by_name(case.metric)


def _sight(case: Case) -> ViewingConditions | None:
    return view_of(case).conditions


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
