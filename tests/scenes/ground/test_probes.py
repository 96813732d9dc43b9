"""A million rays from above, plumb and oblique, and none escapes through the ground."""

from dataclasses import replace

import numpy as np
import pytest
from numba import njit

from scenes.ground.terrain import Terrain
from tests.scenes.ground.grounds import HILLS, LACUNAR, ROUGH, cut_and_mesh, sides, view_of

MOUNTAIN = Terrain(2, 260.0, 4096.0, 0.95, reach=20_000.0, finest=0.5, ridged=True)
GROUNDS = {"hills": HILLS, "rough": ROUGH, "mountain": MOUNTAIN, "lacunar": LACUNAR}
SLANTS = ((0.0, 0.0), (0.6, -0.3), (-1.5, 2.0))
"""Metres east and north that a ray goes for each metre up."""

RAYS = 84_000
"""Of each slant over each ground: a million in all."""

CELLS = 400


@njit(cache=True)
def side_of(xy, i, j, x, y):
    """On which side of the line from i to j a point is; of j to i exactly the other."""
    a, b = min(i, j), max(i, j)
    double = (xy[b, 0] - xy[a, 0]) * (y - xy[a, 1]) - (xy[b, 1] - xy[a, 1]) * (x - xy[a, 0])
    return double if a == i else -double


@njit(cache=True)
def listed(xy, faces, low, side):
    """Faces by the cells of a grid that their boxes touch: where each list starts, and them."""
    count = np.zeros(CELLS * CELLS + 1, np.int64)
    for fill in range(2):
        if fill:
            start = np.cumsum(count)
            found, count = np.empty(start[-1], np.int64), start.copy()
        for f in range(len(faces)):
            x, y = xy[faces[f], 0], xy[faces[f], 1]
            first_x, last_x = int((x.min() - low[0]) / side), int((x.max() - low[0]) / side)
            first_y, last_y = int((y.min() - low[1]) / side), int((y.max() - low[1]) / side)
            if x.max() < low[0] or y.max() < low[1]:
                continue
            for i in range(max(first_x, 0), min(last_x, CELLS - 1) + 1):
                for j in range(max(first_y, 0), min(last_y, CELLS - 1) + 1):
                    cell = i * CELLS + j
                    if fill:
                        found[count[cell]] = f
                        count[cell] += 1
                    else:
                        count[cell + 1] += 1
    return start, found


@njit(cache=True)
def met(xy, faces, probes, low, side):
    """How many faces each probe inside the grid meets."""
    start, found = listed(xy, faces, low, side)
    hits = np.zeros(len(probes), np.int64)
    for p in range(len(probes)):
        x, y = probes[p]
        cell = int((x - low[0]) / side) * CELLS + int((y - low[1]) / side)
        for f in found[start[cell] : start[cell + 1]]:
            a, b, c = faces[f]
            # Seen along the ray a face may be turned over, so both senses are inside.
            s, t, u = side_of(xy, a, b, x, y), side_of(xy, b, c, x, y), side_of(xy, c, a, x, y)
            hits[p] += (s >= 0 and t >= 0 and u >= 0) or (s <= 0 and t <= 0 and u <= 0)
    return hits


def hits_along(vertices, faces, slant, about, away):
    """Faces that rays of this slant meet, which pass at 0 m height ``away`` from ``about``."""
    xy = vertices[:, :2] - vertices[:, 2:] * np.array(slant)
    hits, near = np.zeros(len(away), int), 2.0
    distance = np.abs(away).max(axis=1)
    while (distance >= near / 2).any():  # in rings, each with a grid as fine as its faces
        ring = (distance < near) & ((distance >= near / 2) | (near == 2.0))
        hits[ring] = met(xy, faces, about + away[ring], about - near, 2 * near / CELLS)
        near *= 2
    return hits


def rays(terrain, view, parts, slant, count):
    """Where rays of this slant pass 0 m, about the eye, (count, 2); all cross ground of its own."""
    southwest, side = sides(terrain, parts.take(parts.parent < 0))
    rng = np.random.default_rng(7)
    turn, far = 2 * np.pi * rng.random(count), terrain.reach * 10 ** rng.uniform(-3, 0, count)
    away = far[:, None] * np.stack((np.cos(turn), np.sin(turn)), axis=1)
    covered = np.ones(count, bool)
    for height in terrain.bounds():
        at = view.camera.eye[:2] + away + height * np.array(slant)
        inside = (at[:, None] > southwest) & (at[:, None] < southwest + side[:, None])
        covered &= inside.all(axis=2).any(axis=1)
    return away[covered]


def probed(name, slant, count, size):
    terrain = GROUNDS[name]
    view = replace(view_of(terrain, above=4.0, size=size), fade=0.3)
    cut, mesh = cut_and_mesh(terrain, view)
    assert len(np.unique(cut.level)) > 2
    away = rays(terrain, view, cut.parts, slant, count)
    assert len(away) > 0.8 * count
    return mesh, view, away


@pytest.mark.parametrize("name", GROUNDS)
def test_a_hole_is_found(name):
    mesh, view, away = probed(name, SLANTS[1], 4000, (64, 36))
    eye = view.camera.eye[:2]
    assert hits_along(mesh.vertices, mesh.faces, SLANTS[1], eye, away).min() >= 1
    rows = np.random.default_rng(3).random(len(mesh.faces)) > 0.02
    hits = hits_along(mesh.vertices, mesh.faces[rows], SLANTS[1], eye, away)
    assert 0.005 < np.mean(hits == 0) < 0.05


@pytest.mark.slow
@pytest.mark.parametrize("name", GROUNDS)
def test_no_ray_from_above_escapes(name):
    for slant in SLANTS:
        mesh, view, away = probed(name, slant, int(1.1 * RAYS), (160, 90))
        hits = hits_along(mesh.vertices, mesh.faces, slant, view.camera.eye[:2], away)
        assert hits.min() >= 1
        if slant == (0.0, 0.0):
            assert hits.max() == 1
