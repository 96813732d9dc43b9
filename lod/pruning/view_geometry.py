"""Distance and visibility of points and spheres in a view: the arrays' form of the pruner's test.

``lod.pruning.compiled_test`` is the compiled form of the same arithmetic, in the same order.
"""

import math

import numpy as np

from lod.pruning.view import View


def dot(offset: np.ndarray, axis: np.ndarray) -> np.ndarray:
    """Compute the dot products of vectors (n, 3) with one axis (3,), (n,).

    The sum runs from x to z whatever n is: one point gives the same bits in any batch, and the bits
    of ``lod.pruning.compiled_test``.
    """
    return offset[:, 0] * axis[0] + offset[:, 1] * axis[1] + offset[:, 2] * axis[2]


def distance(view: View, position: np.ndarray) -> np.ndarray:
    """Compute d of points (n, 3) from the eye, or along the axis if the metric says so, (n,) [m].

    Never below 0, so that nothing passes a limit of 0; a point behind the eye has depth 0.
    """
    offset = position - view.camera.eye
    if view.metric.along_axis:
        return np.maximum(dot(offset, view.camera.forward), 0.0)
    return np.sqrt(offset[:, 0] ** 2 + offset[:, 1] ** 2 + offset[:, 2] ** 2)


def search_radius(view: View, limit: float, bound: float) -> float:
    """Compute the greatest true distance at which something in view can pass its test [m].

    Along the axis it can be D deep and still lie aside of it, by D·tan + B·√(1 + tan²) on each
    axis.
    """
    if not view.metric.along_axis:
        return limit
    aside = [limit * tan + bound * math.hypot(1.0, tan) for tan in view.camera.tan_half]
    return math.hypot(limit, *aside)


def in_view(view: View, centre: np.ndarray, radius: np.ndarray) -> np.ndarray:
    """Tell whether each sphere reaches into the pyramid of view, (n, 3), (n,) → (n,).

    Of two eyes it is the pyramid of the middle, which each sphere reaches that is half the
    baseline larger than one that reaches into an eye's own.

    Plane by plane, so a sphere beyond an edge of the pyramid may count as in view; never the
    reverse. A sphere inside another is in view only if the other is: with nested bounds, cuts stay
    connected.
    """
    if view.look_around:
        return np.ones(len(centre), bool)
    camera, offset = view.camera, centre - view.camera.eye
    radius = radius + camera.baseline_m / 2
    tan_x, tan_y = camera.tan_half
    ahead = dot(offset, camera.forward)
    seen = ahead > -radius
    for axis, tangent in ((camera.right, tan_x), (camera.up, tan_y)):
        aside, length = dot(offset, axis), math.hypot(1.0, tangent)
        seen &= (ahead * tangent - np.abs(aside)) / length > -radius
    return seen
