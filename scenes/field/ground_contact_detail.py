"""How finely is the ground's height taken under each object: per sole, per print, or per body?

    SOLE       height and slope under each sole: where a foot could be displayed
    FOOTPRINT  height under each footprint: where any part besides the whole could be
    BODY       height under the body alone: where the whole is all that could be

``scenes.rig.foot_placement`` then places bodies and feet. What decides is the distance in plan,
less what a part's origin can be away from where its object stands, against the limit distances of
the parts: a function of the eye and the object alone, and never coarser than the cut. Feet are then
off the ground by less than a quarter of m·d (which a test repeats, on the presets' hills).
"""

import numpy as np
from jaxtyping import Float64

from lod.arrays import Ints
from lod.pruning.view import View
from scenes.field.posed_species import SpeciesPrototypes


def ground_contact_detail(
    prototypes: SpeciesPrototypes, view: View, xy: Float64[np.ndarray, "n 2"], prototype: Ints
) -> Ints:
    """Choose SOLE, FOOTPRINT or BODY for objects at xy (n, 2) [m] of the frame, (n,).

    prototype  (n,) row of each in ``prototypes``
    """
    nodes = prototypes.traversal_tables
    offset = nodes.extent[:, 0] + np.hypot(nodes.rest[:, 0], nodes.rest[:, 1])
    near = np.hypot(*(xy - view.camera.eye[:2]).T) - offset[prototype]
    limits = _greatest_limits(prototypes, view)[prototype]
    return np.count_nonzero(limits - near[:, None] > 0, axis=1)


def _greatest_limits(prototypes: SpeciesPrototypes, view: View) -> Float64[np.ndarray, "v 2"]:
    """Greatest limit distance of the parts besides the whole, and of the parts of feet, of each
    prototype [m]; where no part is a foot's, that of all parts stands for it.
    """
    tables = prototypes.part_tables
    if view.metric.along_axis:
        return np.full((len(tables.root), 2), np.inf)  # what is far can be of little depth
    limit = np.maximum(*tables.limits(view))
    limit[tables.root] = -np.inf
    parts = np.maximum.reduceat(limit, tables.root)
    soles = np.maximum.reduceat(np.where(prototypes.foot_parts, limit, -np.inf), tables.root)
    return np.column_stack((parts, np.where(soles > -np.inf, soles, parts)))
