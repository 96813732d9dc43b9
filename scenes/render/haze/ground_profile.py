"""The ground's height around the eye by azimuth and distance, from the displayed meshes."""

import numpy as np
from jaxtyping import Float64

from lod.plane_parallel import SPOKES
from scenes.render.description.scene_description import Description

DISTANCES_M = np.concatenate(([0.0], np.geomspace(5.0, 4e4, 24)))
"""Horizontal distances from the eye at which a profile has heights [m]."""

Profile = Float64[np.ndarray, "spokes distances"]
"""Heights [m], at SPOKES azimuths clockwise from north and at DISTANCES_M."""


def ground_points(description: Description) -> np.ndarray | None:
    """Collect the vertices of all meshes that give no light, (n, 3); None where there are none."""
    meshes = [s for s in description["shapes"].values() if s["type"] == "mesh" and "glow" not in s]
    points = [each["vertices"] for each in meshes]
    return np.concatenate(points).astype(np.float64) if points else None


def ground_profile(points: np.ndarray, eye: np.ndarray) -> Profile:
    """Average the heights of points (n, 3) about an eye (3,), interpolated where there are none."""
    away = points[:, :2] - eye[:2]
    spoke = np.rint(np.arctan2(away[:, 0], away[:, 1]) / (2 * np.pi) * SPOKES).astype(np.int64)
    middles = np.sqrt(DISTANCES_M[1:-1] * DISTANCES_M[2:])
    step = 1 + np.searchsorted(middles, np.hypot(away[:, 0], away[:, 1]))
    count = len(DISTANCES_M)
    place = spoke % SPOKES * count + step
    held = np.bincount(place, minlength=SPOKES * count).reshape(SPOKES, count)
    summed = np.bincount(place, points[:, 2], minlength=SPOKES * count).reshape(SPOKES, count)
    nearest = points[np.argmin((away**2).sum(axis=1)), 2]
    held[:, 0], summed[:, 0] = 1, nearest
    every = np.arange(count)
    rows = [
        np.interp(every, np.flatnonzero(n), s[n > 0] / n[n > 0])
        for n, s in zip(held, summed, strict=True)
    ]
    return np.array(rows)


def heights_at(profile: Profile, distance: np.ndarray) -> Float64[np.ndarray, "n spokes"]:
    """Interpolate the ground's height [m] at horizontal distances (n,) [m], in every azimuth."""
    known = np.log1p(DISTANCES_M)
    place = np.interp(np.log1p(distance), known, np.arange(len(known)))
    nearer = np.minimum(place.astype(np.int64), len(known) - 2)
    share = (place - nearer)[:, None]
    return profile[:, nearer].T * (1 - share) + profile[:, nearer + 1].T * share
