"""Where the law is integrated over the ground: nodes about the eye, dense where much is displayed.

As many nodes stand in a ring for its area as for its logarithmic width, since the rim of each disc
decides how many objects there are and every octave of distance has parts of its own; half of them
stand where the camera looks.
"""

import math
from dataclasses import dataclass

import numpy as np

from lod.arrays import ArrayData, FloatArray, Reals
from lod.law.flat_ground import whole_limit
from lod.metric.hierarchy import Hierarchy
from lod.pruning.view import View

_INNER_M = 0.25
"""Radius of the one disc about the eye that is not divided further."""

_RINGS = 1024
"""Rings in each of which nodes are spread evenly."""

_BY_AREA = 0.7
"""Share of the nodes that is spread over rings by their area, the rest by width in log r."""

_PLASTIC = 1.32471795724474602596
_START = 0.5
_STEPS = (1 / _PLASTIC, 1 / _PLASTIC**2, math.sqrt(2.0))
"""From node to node: of the shares of radius and of angle, by the root of x³ = x + 1, and of turns
of the heading."""


@dataclass(frozen=True, eq=False)
class GroundQuadrature(ArrayData):
    """Quadrature nodes on the ground around the eye, at which objects are tested.

    Kinds of objects take turns: of k kinds the i-th is tested at the nodes i, i + k, i + 2k, …

    xy    (n, 2) position relative to the frame's corner [m]
    area  (n,) area that stands for the node; that of each kind's nodes is a k-th of its disc's [m²]
    turn  (n,) heading of the object that is tested there [rad]
    """

    xy: FloatArray
    area: FloatArray
    turn: FloatArray


def max_ground_distance(hierarchies: tuple[Hierarchy, ...], view: View) -> float:
    """Compute the greatest horizontal distance of an object that has a part displayed [m]."""
    return max(
        whole_limit(h, view.metric, view.m, view.conditions)
        + view.camera.baseline_m / 2
        + float(np.hypot(*h.position[0, :2]))
        for h in hierarchies
    )


def ground_quadrature(
    hierarchies: tuple[Hierarchy, ...], view: View, nodes: int, farthest_m: float = math.inf
) -> GroundQuadrature:
    """Lay about so many nodes over the discs in which objects of these kinds may be displayed.

    Every kind has as many nodes in its own disc, none of which reaches beyond ``farthest_m``. One
    kind after the other they follow Roberts's sequence R₂ ("The unreasonable effectiveness of
    quasirandom sequences", 2018) in the plane of the shares that radius and angle are chosen by,
    and multiples of √2 by heading.
    """
    kinds = len(hierarchies)
    of_kind = max(nodes // kinds, 1)
    place = np.arange(kinds * of_kind).reshape(kinds, of_kind).T.ravel()
    shares = (_START + np.multiply.outer(place, _STEPS)) % 1.0
    reach = np.array([min(max_ground_distance((h,), view), farthest_m) for h in hierarchies])
    reach = np.tile(reach, of_kind)
    radius, spread = _radii(shares[:, 0], _INNER_M / max(float(reach.max()), 2 * _INNER_M))
    angle, width = _angles(shares[:, 1], *_seen_sector(view))
    around = (radius * reach)[:, None] * np.stack((np.cos(angle), np.sin(angle)), axis=-1)
    area = spread * np.square(reach) * width / len(reach)
    return GroundQuadrature(view.camera.eye[:2] + around, area, 2 * np.pi * shares[:, 2])


def _radii(share: Reals, inner: float) -> tuple[Reals, Reals]:
    """Radii in a unit disc that have these shares of the nodes within, and r·dr ÷ d share there.

    inner  radius of the disc that is the first ring
    """
    edges = np.concatenate(([0.0], np.geomspace(inner, 1.0, _RINGS)))
    within = _BY_AREA * np.square(edges) + (1 - _BY_AREA) * np.linspace(0.0, 1.0, len(edges))
    ring = np.searchsorted(within[1:-1], share, side="right")
    widths, areas = np.diff(within), np.diff(np.square(edges))
    spread = (areas / widths)[ring]
    squared = np.square(edges[ring]) + (share - within[ring]) * spread
    return np.sqrt(squared), spread / 2


def _angles(share: Reals, heading: float, half: float) -> tuple[Reals, Reals]:
    """Angles that have these shares of the nodes before them [rad], and d angle ÷ d share there.

    Half of the nodes are spread over the whole turn, half over the sector about the heading.
    """
    seen = 0.5 + 0.5 * half / np.pi
    inside = share < seen
    width = np.where(inside, 2 * half / seen, 4 * np.pi)
    return heading + half + (share - seen) * width, width


def _seen_sector(view: View) -> tuple[float, float]:
    """Heading of the view and half the angle of ground that may be in the picture [rad].

    It is the whole turn where the picture may hold the nadir or the zenith.
    """
    camera = view.camera
    forward, steep = camera.forward, abs(float(camera.forward[2])) * camera.corner_secant >= 1
    if view.look_around or camera.panorama or steep:
        return 0.0, math.pi
    across, upward = (
        tan * axis for tan, axis in zip(camera.tan_half, (camera.right, camera.up), strict=True)
    )
    corners = np.array([forward + x * across + y * upward for x in (-1, 1) for y in (-1, 1)])
    ahead = corners[:, :2] @ forward[:2]
    aside = corners[:, 1] * forward[0] - corners[:, 0] * forward[1]
    half = float(np.abs(np.arctan2(aside, ahead)).max())
    return math.atan2(forward[1], forward[0]), half
