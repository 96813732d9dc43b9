"""What the parts of a model look like as sticks: fitted ones for those that own parts, and ends.

Leaf appearances are fitted as for any other object (``scenes.sticks.appearance.fit``), with balls
in the place of pieces of surface where they are gathered, and the meshes themselves where anything
is seen or lit. Ends show their meshes; far cover (``scenes.far_cover``) is worked out from a few
sticks in their place, as thick as makes them cover, on average over directions, what the mesh does.
"""

from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float64
from PIL import Image

from lod.arrays import Points, Reals
from lod.shapes import StickTable
from scenes.model_files.part_tree import PartTree
from scenes.models.imported.surface import surface_balls
from scenes.sticks.appearance.fit import fit_appearances
from scenes.sticks.appearance.part_sticks import PartSticks
from scenes.sticks.appearance.simplification import cluster, error_diffusion, fit_radii
from scenes.sticks.view_dependence import ViewDependence

Tints = Float64[np.ndarray, "t 3"]

END_STICKS = 3
"""Sticks of one end at most."""

TINTS = 24
"""Tints of a model at most."""


@dataclass(frozen=True, eq=False)
class ModelAppearances:
    """The sticks of all n parts of a model, as it rests.

    leaf, view_dependence, overlap (n,)  as in FittedAppearances; tints (t, 3) linear albedo
    """

    leaf: StickTable
    view_dependence: ViewDependence
    overlap: Reals
    tints: Tints


def model_appearances(tree: PartTree, area: Reals) -> ModelAppearances:
    """Fit the sticks of all parts of a model.

    area (n,): mean projected area over directions of all that hangs on each part [m²]
    """
    balls, albedo = surface_balls(tree.meshes)
    tints = few_tints(albedo)
    weight, every = balls.start_radius**2, np.arange(len(tints))
    tint = error_diffusion(weight, albedo, tints, every)
    own = replace(balls, tint=tint)
    fitted = fit_appearances(PartSticks(tree.parent, tree.level, own, tints, tree.meshes))
    owns = np.bincount(tree.parent[1:], minlength=len(tree)) > 0
    ends = _end_sticks(own.of_parts(~owns), albedo, tints, area[~owns])
    ends = ends.with_owner(len(tree), np.flatnonzero(~owns)[ends.owner])
    inner, views = owns[fitted.leaf.owner], fitted.view_dependence
    rows = np.concatenate((views.table_row[inner], np.full(len(ends), -1)))
    owner = np.concatenate((fitted.leaf.owner[inner], ends.owner))
    leaf = StickTable.merge([fitted.leaf.take(inner), ends])
    in_order = rows[np.argsort(owner, kind="stable")]
    by_view = ViewDependence.of_area(in_order, views.area_share)
    return ModelAppearances(leaf, by_view, fitted.overlap, tints)


def few_tints(colours: Points) -> Tints:
    """Choose at most TINTS albedos for all of these (k, 3), in order."""
    exact = np.unique(np.round(colours, 6), axis=0)
    if len(exact) <= TINTS:
        return exact
    coded = np.rint(255 * np.sqrt(colours)).astype(np.uint8)
    picture = Image.fromarray(coded[None]).quantize(TINTS, Image.Quantize.MEDIANCUT)
    _, row = np.unique(np.asarray(picture)[0], return_inverse=True)
    count = np.bincount(row)
    return np.stack([np.bincount(row, c) / count for c in colours.T], axis=1)


def _end_sticks(balls: StickTable, albedo: Points, tints: Tints, area: np.ndarray) -> StickTable:
    """Sticks in the place of the balls of m ends, which cover these areas (m,) [m²] on average."""
    groups, group = cluster(balls, np.full(len(area), END_STICKS))
    factor = fit_radii(groups, balls.take(np.zeros(0, np.int64)), area)
    weight = balls.start_radius**2
    total = np.bincount(group, weight, len(groups.part))
    sums = [np.bincount(group, weight * c, len(total)) for c in albedo.T]
    wanted = np.stack(sums, axis=1) / total[:, None]
    tint = error_diffusion(total, wanted, tints, np.arange(len(tints)))
    return groups.table(len(area), factor, tint)
