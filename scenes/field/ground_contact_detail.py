"""How closely a body minds the ground: no closer than what could be displayed of it can tell.

    SOLE   under each sole, its height and slope: where a foot could be displayed
    FOOTPRINT  under each print, its height: where any part besides the whole could be
    BODY   under the body alone: where the whole is all that could be

What decides is the distance in plan, less what a part's origin can be away from where its object
stands, against the limit distances of the parts: a function of the eye and the object alone, and
never less close than the cut. What that leaves feet off the ground by is less than a quarter of
m·d (which a test repeats, on the presets' hills).
"""

import numpy as np
from jaxtyping import Float64

from lod.arrays import Ints
from lod.pruning.view import View
from scenes.field.part_tables import PartTables
from scenes.field.traversal_tables import TraversalTables
from scenes.rig.rigged_prototype import RiggedPrototype


def foot_parts(prototypes: tuple[RiggedPrototype, ...]) -> np.ndarray:
    """Whether each part of all prototypes rides on an ankle, or below it, (m,)."""
    flags = []
    for prototype in prototypes:
        under = np.zeros(len(prototype.rig) + 1, bool)
        under[prototype.motion.feet.legs[:, 2] + 1] = True
        for row, parent in enumerate(prototype.rig.parent):
            under[row + 1] |= under[parent + 1]
        flags.append(under[prototype.joint + 1])
    return np.concatenate(flags)


def heed(
    part_tables: PartTables,
    slots: TraversalTables,
    feet: np.ndarray,
    view: View,
    xy: Float64[np.ndarray, "n 2"],
    prototype: Ints,
) -> Ints:
    """SOLE, FOOTPRINT or BODY of bodies at xy (n, 2) [m] of the frame.

    feet (m,): as ``foot_parts`` gives them, of the rows of the part tables
    """
    return np.count_nonzero(_within(part_tables, slots, feet, view, xy, prototype) > 0, axis=1)


def _within(
    part_tables: PartTables,
    slots: TraversalTables,
    feet: np.ndarray,
    view: View,
    xy: Float64[np.ndarray, "n 2"],
    prototype: Ints,
) -> Float64[np.ndarray, "n 2"]:
    """How far each body is within the two distances [m]."""
    root = slots.rest[:, :2]
    away = slots.spread[:, 0] + np.hypot(root[:, 0], root[:, 1])
    near = np.hypot(*(xy - view.camera.eye[:2]).T) - away[prototype]
    return _farthest(part_tables, feet, view)[prototype] - near[:, None]


def _farthest(part_tables: PartTables, feet: np.ndarray, view: View) -> Float64[np.ndarray, "v 2"]:
    """Limit distance of the farthest part besides the whole, and of the farthest of the feet, of
    each prototype [m]; those of all parts where it has no part that is a foot.
    """
    if view.metric.along_axis:
        return np.full((len(part_tables.root), 2), np.inf)  # what is far can be of little depth
    limit = np.maximum(*part_tables.limits(view))
    limit[part_tables.root] = -np.inf
    parts = np.maximum.reduceat(limit, part_tables.root)
    soles = np.maximum.reduceat(np.where(feet, limit, -np.inf), part_tables.root)
    return np.column_stack((parts, np.where(soles > -np.inf, soles, parts)))
