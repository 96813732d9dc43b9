"""Motion vectors: how far what a pixel shows is from there in the next frame [px].

The point that the pixel's sample met is carried along with its stick: both ends of the axis go
where the next frame has them, the point of the axis nearest to the hit between them, and what
stands off the axis turns as the axis does. Turns of a stick about its own axis are not seen: it is
round. What is met on a mesh that moves goes with the three corners of its triangle. Both points are
then projected, each by its frame's camera. What owns no moving stick
(terrain, trees) moves by the camera alone, the sky by its turn alone.
"""

import math

import numpy as np

from scenes.frame.frame_input import Window
from scenes.render.build import BuiltScene
from scenes.render.camera_rays import pixel_directions
from scenes.render.description import NEAR_M, Description
from scenes.rig.rotations import rotate_vectors, shortest_arc


def motion_vectors(hit: np.ndarray, built: BuiltScene, window: Window) -> np.ndarray:
    """Compute the motion of every pixel to the next frame, x right and y up, (h, w, 2) [px].

    hit: (h, w, 9) as in Samples, of a window of the picture. 0 where the point is behind the next
    camera.
    """
    camera, after = built.description["camera"], built.description["after"]
    met = hit[..., 0] > 0
    rows = pixel_directions(camera, 1, (window.top, window.bottom)).astype(np.float64)
    ahead = rows[:, window.left : window.right][~met]
    before, now = np.empty((2, *hit.shape[:2], 2))
    before[met] = project(camera, hit[met][:, 6:9] - camera["eye"])
    now[met] = project(after, next_positions(built, hit[met]) - after["eye"])
    before[~met], now[~met] = project(camera, ahead), project(after, ahead)
    moved = np.nan_to_num(now - before, nan=0.0)
    if camera["panorama"]:  # the shorter way round
        width = camera["size"][0]
        moved[..., 0] -= width * np.round(moved[..., 0] / width)
    return moved


def project(camera: Description, offset: np.ndarray) -> np.ndarray:
    """Project points into the picture, from their offsets to the eye (n, 3) [m].

    Gives x right and y up from the picture's middle, (n, 2) [px]; NaN behind the near plane.
    """
    depth = offset @ camera["forward"]
    right = np.cross(camera["forward"], camera["up"])
    if camera["panorama"]:
        aside, above = offset @ right, offset @ camera["up"]
        turn, rise = np.arctan2(aside, depth), np.arctan2(above, np.hypot(aside, depth))
        per_turn = np.array(camera["size"]) / (2 * math.pi, math.pi)
        return np.stack((turn, rise), axis=1) * per_turn
    aside = np.stack((offset @ right, offset @ camera["up"]), axis=1)
    scale = camera["size"][0] / (2 * math.tan(math.radians(camera["fov_x_deg"]) / 2))
    return scale * aside / np.where(depth > NEAR_M, depth, np.nan)[:, None]


def next_positions(built: BuiltScene, hit: np.ndarray) -> np.ndarray:
    """Find the points of hits (n, 9) in the next frame, in this one's coordinates, (n, 3)."""
    point = hit[:, 6:9].astype(np.float64)
    shape, primitive = hit[:, 4].astype(int), hit[:, 5].astype(int)
    for name, moves in built.description["moves"].items():
        rows = np.flatnonzero(shape == built.names.index(name))
        sticks = built.description["shapes"][name]
        if sticks["type"] == "mesh":
            corners = sticks["faces"][primitive[rows]].astype(int)
            places = sticks["vertices"][corners].astype(float)
            point[rows] = carry_with_triangle(point[rows], places, moves[corners].astype(float))
            continue
        first = sticks["segment_indices"][primitive[rows]].astype(int)
        start, end = (sticks["control_points"][first + k][:, :3].astype(float) for k in (0, 1))
        point[rows] = carry_with_stick(
            point[rows], start, end, moves[primitive[rows]].astype(float)
        )
    return point


def carry_with_triangle(point: np.ndarray, corners: np.ndarray, moves: np.ndarray) -> np.ndarray:
    """Carry points (n, 3) on triangles (n, 3, 3) along, whose corners move by ``moves`` (n, 3, 3).

    By barycentric coordinates (Ericson, "Real-Time Collision Detection", 2005, §3.4).
    """
    a, b, c = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0], point - corners[:, 0]
    aa, ab, bb = (np.sum(x * y, axis=1) for x, y in ((a, a), (a, b), (b, b)))
    ca, cb = np.sum(c * a, axis=1), np.sum(c * b, axis=1)
    scale = np.maximum(aa * bb - ab * ab, 1e-300)
    v, w = (bb * ca - ab * cb) / scale, (aa * cb - ab * ca) / scale
    shares = np.clip(np.stack((1 - v - w, v, w), axis=1), 0, 1)
    return point + np.einsum("nk,nkx->nx", shares, moves)


def carry_with_stick(
    point: np.ndarray, start: np.ndarray, end: np.ndarray, moves: np.ndarray
) -> np.ndarray:
    """Carry points (n, 3) along with sticks whose ends (n, 3) move by ``moves`` (n, 2, 3).

    A stick without length, or one that turns by more than 90° a frame, is not turned.
    """
    axis, moved = end - start, end + moves[:, 1] - start - moves[:, 0]
    squared = np.maximum(np.sum(axis**2, axis=1), 1e-300)
    along = np.clip(np.sum((point - start) * axis, axis=1) / squared, 0, 1)[:, None]
    offset = point - start - along * axis
    has_axis = ((axis * moved).sum(axis=1, keepdims=True) > 0) & (squared[:, None] > 1e-20)
    turns = shortest_arc(np.where(has_axis, axis, 1.0), np.where(has_axis, moved, 1.0))
    return start + moves[:, 0] + along * moved + rotate_vectors(turns, offset)
