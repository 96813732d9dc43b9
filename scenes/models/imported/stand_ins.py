"""Sticks in the place of meshes: of the ends of a model, and of each part that owns parts.

Pictures show the meshes of ends. Far cover and the light in a stand are worked out from sticks
(``scenes.far_cover``), and a part whose own parts are hidden shows sticks. The surface below a part
is gathered into a few groups, and each becomes one stick along its longest spread, as thick as
makes all of them cover, on average over directions, what the meshes cover. Albedo is that of the
surface, which shades nothing here.
"""

import numpy as np
from jaxtyping import Float64
from PIL import Image

from lod.arrays import Ints, Points, Reals
from lod.mesh_table import MeshTable
from lod.stick_table import StickTable
from scenes.models.imported.surface import balls_below, surface_balls
from scenes.sticks.appearance.simplification import cluster, error_diffusion, fit_radii

Tints = Float64[np.ndarray, "t 3"]

END_STICKS, INNER_STICKS = 3, 8
"""Sticks of one end, and of one part that owns parts, at most."""

TINTS = 24
"""Tints of a model at most."""

_MOST_BALLS = 300_000


def stand_ins(parent: Ints, meshes: MeshTable, area: Reals) -> tuple[StickTable, Tints]:
    """Make the sticks of all parts, and their tints (t, 3).

    parent (n,) as in Hierarchy; meshes: of the n parts
    area (n,): mean projected area over directions of all that hangs on each part [m²]
    """
    balls, albedo = surface_balls(meshes)
    tints = few_tints(albedo)
    owns = np.bincount(parent[1:], minlength=len(parent)) > 0
    tables = []
    for rows, most in (
        (np.flatnonzero(~owns), END_STICKS),
        (np.flatnonzero(owns), INNER_STICKS),
    ):
        if len(rows):
            hidden, ball = balls_below(parent, balls, rows, _MOST_BALLS)
            table = _sticks(hidden, albedo[ball], tints, area[rows], most)
            tables.append(table.with_owner(len(parent), rows[table.owner]))
    return StickTable.merge(tables), tints


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


def _sticks(
    hidden: StickTable, albedo: Points, tints: Tints, area: np.ndarray, most: int
) -> StickTable:
    """Sticks in the place of the balls of m parts, which cover these areas (m,) [m²] on average."""
    groups, group = cluster(hidden, np.full(len(area), most))
    factor = fit_radii(groups, hidden.take(np.zeros(0, np.int64)), area)
    weight = hidden.start_radius**2
    total = np.bincount(group, weight, len(groups.part))
    sums = [np.bincount(group, weight * c, len(total)) for c in albedo.T]
    wanted = np.stack(sums, axis=1) / total[:, None]
    tint = error_diffusion(total, wanted, tints, np.arange(len(tints)))
    return groups.table(len(area), factor, tint)
