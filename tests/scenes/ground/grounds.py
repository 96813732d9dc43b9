"""Grounds and views of them that the tests of the terrain share."""

import numpy as np
import pytest
from hypothesis import strategies as st
from numba import njit

from lod.camera import Corner, camera_from_heading
from lod.metric import METRICS
from lod.pruner import Cut, Parts, blend_weights, prune
from lod.shapes import Triangles
from lod.view import View
from lod.viewing import BlurWidths, ViewingConditions
from scenes.ground.mesh import Terrain, tile_xy
from scenes.ground.quadtree import Patches, uncovered_quarters

FAR = Corner(62_500_000_123, -62_499_999_877)  # 10^12 m from home

HILLS = Terrain(seed=3, amplitude=30.0, wavelength=2048.0, hurst=0.95, reach=3000.0)

RIDGED = Terrain(7, 8.0, 256.0, 0.8, reach=400.0, ridged=True)

ROUGH = Terrain(seed=4, amplitude=0.4, wavelength=16.0, hurst=0.6, reach=150.0)

FLAT = Terrain(seed=5, amplitude=0.0, wavelength=1024.0, hurst=0.8, reach=3000.0)


def view_of(
    terrain: Terrain,
    corner: Corner = FAR,
    above: float = 1.7,
    heading: float = 20.0,
    pitch: float = 0.0,
    metric: str = "blake",
    xy: tuple[float, float] = (3.0, 14.0),
    size: tuple[int, int] = (64, 36),
    air: float = 0.0,
    **settings: float,
) -> View:
    ground = terrain.height(corner, np.array([xy]))[0]
    eye = np.array((*xy, ground + above))
    camera = camera_from_heading(corner, eye, heading, pitch, 60.0, size)
    sight = ViewingConditions(BlurWidths(camera.pixel_angle), air, acuity=False) if air else None
    return View(camera, METRICS[metric], conditions=sight, **settings)


def cut_and_mesh(terrain: Terrain, view: View) -> tuple[Cut, Triangles]:
    cut = prune(terrain, view)
    return cut, terrain.appearance(cut.parts, blend_weights(cut, view))


views = st.fixed_dictionaries(
    {
        "corner": st.sampled_from([Corner(0, 0), FAR, Corner(-1, 10**15)]),
        "above": st.floats(-5, 300),
        "heading": st.floats(0, 360),
        "pitch": st.floats(-90, 90),
        "metric": st.sampled_from(sorted(METRICS)),
        "xy": st.tuples(st.floats(0, 16), st.floats(0, 16)),
        "detail": st.floats(1, 8),
        "offscreen_detail": st.sampled_from([0.01, 0.25, 1.0]),
        "air": st.sampled_from([0.0, 0.003, 0.1]),
    }
)


grounds = st.sampled_from([HILLS, ROUGH, FLAT, RIDGED])


def sides(terrain: Terrain, parts: Parts) -> tuple[np.ndarray, np.ndarray]:
    """South-west corners (n, 2) and sides (n,) of tiles [m]."""
    grid = parts.state
    side = grid.root_side / 2.0**parts.level
    return np.array((grid.west, grid.south)) + side[:, None] * np.stack(
        tile_xy(parts.part), 1
    ), side


def assert_watertight(terrain: Terrain, view: View, cut: Cut, mesh: Triangles) -> None:
    # Only the outer rim is open: its edges have ground on one side and no root tile on the other.
    ends = mesh.vertices[rim_edges(mesh.faces)][:, :, :2]
    middle, along = ends.mean(axis=1), ends[:, 1] - ends[:, 0]
    across = np.stack((-along[:, 1], along[:, 0]), axis=1)
    across /= np.linalg.norm(across, axis=1, keepdims=True)
    southwest, side = sides(terrain, cut.parts.take(cut.parts.parent < 0))
    covered = [
        ((p[:, None] > southwest) & (p[:, None] < southwest + side[:, None]))
        .all(axis=2)
        .any(axis=1)
        for p in (middle + 1e-3 * across, middle - 1e-3 * across)
    ]
    assert np.all(covered[0] != covered[1])
    # Every triangle faces up, and together they are as large as the roots: a tiling.
    area = map_areas(mesh.vertices[:, :2], mesh.faces)
    assert np.all(area > 0)
    assert area.sum() == pytest.approx(np.sum(side**2), rel=1e-12)


@njit(cache=True)
def probe_count(vertices: np.ndarray, faces: np.ndarray, probes: np.ndarray):
    """How many triangles each probe meets, and the height of the last."""
    hits, z = np.zeros(len(probes), np.int64), np.zeros(len(probes))
    for f in range(len(faces)):
        a, b, c = vertices[faces[f, 0]], vertices[faces[f, 1]], vertices[faces[f, 2]]
        low_x, high_x = min(a[0], b[0], c[0]), max(a[0], b[0], c[0])
        first = np.searchsorted(probes[:, 0], low_x)
        double = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
        for i in range(first, len(probes)):
            x, y = probes[i]
            if x > high_x:
                break
            u = ((x - a[0]) * (c[1] - a[1]) - (y - a[1]) * (c[0] - a[0])) / double
            v = ((b[0] - a[0]) * (y - a[1]) - (b[1] - a[1]) * (x - a[0])) / double
            if u >= 0 and v >= 0 and u + v <= 1:
                hits[i] += 1
                z[i] = a[2] + u * (b[2] - a[2]) + v * (c[2] - a[2])
    return hits, z


def random_patches(seed: int) -> Patches:
    """A quadtree over 3 x 2 roots, split at random, so that neighbours differ a lot."""
    rng = np.random.default_rng(seed)
    tiles = [(0, x, y) for x in range(3) for y in range(2)]
    for level, x, y in tiles:
        for i, j in ((0, 0), (1, 0), (0, 1), (1, 1)):
            if level < 7 and rng.random() < (0.3 if level else 0.6):
                tiles.append((level + 1, 2 * x + i, 2 * y + j))
    return uncovered_quarters(*np.array(tiles).T)


def rim_edges(faces: np.ndarray) -> np.ndarray:
    """Edges of one triangle only, (n, 2); all others must have exactly two, in opposite senses."""
    edges = faces[:, ((0, 1), (1, 2), (2, 0))].reshape(-1, 2)
    ways = [edges[:, 0] << 32 | edges[:, 1], edges[:, 1] << 32 | edges[:, 0]]
    assert len(np.unique(ways[0])) == len(edges), "an edge is walked twice in one direction"
    return edges[~np.isin(ways[0], ways[1])]


def map_areas(xy: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Signed area of triangles on the map, positive counter-clockwise."""
    a, b, c = (xy[faces[:, k]] for k in range(3))
    ab, ac = b - a, c - a
    return (ab[:, 0] * ac[:, 1] - ab[:, 1] * ac[:, 0]) / 2
