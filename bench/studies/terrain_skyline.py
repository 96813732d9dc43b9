"""Triangles that the ground takes, and how true its skyline is.

The ground of a preset at τ = 1 in pictures of growing size, on one core: tiles, triangles, seconds
of the processor from nothing to the mesh, and the share of the picture's columns in which the
skyline is within a pixel of that at τ = ¼, which is built in slices of the picture, one at a time.
The air is clear: haze would leave some of it out.
"""

import math
import time
from dataclasses import replace
from itertools import product

import click
import numba
import numpy as np
from numba import njit

from bench.cli.output import counted, table
from lod.camera import Camera
from lod.crossfade import blend_weights
from lod.metric import METRICS
from lod.pruner import prune
from lod.shapes import Triangles
from lod.view import View
from scenes.ground.terrain import Terrain
from scenes.presets.load import load_preset
from scenes.world.camera_path import camera_at

SIZES = ("320x180", "640x360", "1280x720")
PRESETS = ("meadow", "mountain")
REFERENCE = 0.25
"""τ of what the skyline is held against [px]."""

SLICE = 20
"""Columns of the reference that are built at once [px]."""

_NEAREST_M = 0.1


def ground_mesh(terrain: Terrain, view: View) -> tuple[int, Triangles]:
    """Prune the ground for a view: number of tiles displayed, and their mesh."""
    cut = prune(terrain, view)
    return len(cut), terrain.appearance(cut.parts, blend_weights(cut, view))


def skyline(triangles: Triangles, camera: Camera) -> np.ndarray:
    """Find the highest ground over each column's middle, (width,) [px from the axis]."""
    offset = triangles.vertices - camera.eye
    depth, across, up = (offset @ axis for axis in (camera.forward, camera.right, camera.up))
    scale = camera.width / (2 * camera.tan_half[0])
    with np.errstate(divide="ignore", invalid="ignore"):
        x = camera.width / 2 + scale * across / depth - 0.5
        y = scale * up / depth
    return _highest_edges(x, y, depth > _NEAREST_M, triangles.faces, camera.width)


@njit(cache=True)
def _highest_edges(x, y, ahead, faces, width):  # type: ignore[no-untyped-def]
    """Find the highest edge over each column; edges that reach behind the eye are left out."""
    top = np.full(width, -np.inf)
    for f in range(len(faces)):
        for k in range(3):
            i, j = faces[f, k], faces[f, (k + 1) % 3]
            if not (ahead[i] and ahead[j]):
                continue
            if x[i] > x[j]:
                i, j = j, i
            first, last = max(0, int(np.ceil(x[i]))), min(width - 1, int(np.floor(x[j])))
            for column in range(first, last + 1):
                share = (column - x[i]) / (x[j] - x[i]) if x[j] > x[i] else 0.0
                top[column] = max(top[column], y[i] + share * (y[j] - y[i]))
    return top


def reference_skyline(terrain: Terrain, view: View) -> tuple[np.ndarray, int]:
    """Build the skyline at REFERENCE, (width,) [px from the axis], and count its triangles."""
    camera, triangles = view.camera, 0
    top = np.full(camera.width, -np.inf)
    for first in range(0, camera.width, SLICE):
        columns = slice(first, min(first + SLICE, camera.width))
        part = slice_camera(camera, columns)
        detail = REFERENCE * camera.pixel_angle / part.pixel_angle
        finer = replace(view, camera=part, detail=detail, offscreen_detail=0.01, fade=0.0)
        _, mesh = ground_mesh(terrain, finer)
        top[columns] = skyline(mesh, camera)[columns]
        triangles += len(mesh)
    return top, triangles


def slice_camera(camera: Camera, columns: slice) -> Camera:
    """Make a camera at the same place whose pyramid of view holds those columns of the picture."""
    tan_x, tan_y = camera.tan_half
    ends = [math.atan(tan_x * (2 * c / camera.width - 1)) for c in (columns.start, columns.stop)]
    turn, fov = sum(ends) / 2, ends[1] - ends[0]
    forward = math.cos(turn) * camera.forward + math.sin(turn) * camera.right
    width = columns.stop - columns.start
    height = math.ceil(1.2 * width * tan_y / math.tan(fov / 2))
    return replace(camera, forward=forward, fov_x=fov, width=width, height=height)


def table_row(name: str, size: str) -> tuple[object, ...]:
    """Measure one preset at one size, as a row of the table."""
    preset = load_preset(name, [f"render.size={size}"])
    terrain = Terrain(seed=preset.seed, **preset.terrain.model_dump())
    camera = camera_at(preset.camera, preset.render.size, 1, terrain)
    view = View(camera, METRICS["blake"], fade=preset.view.fade)
    ground_mesh(terrain, view)  # compiles
    start = time.process_time()
    tiles, mesh = ground_mesh(terrain, view)
    took = time.process_time() - start
    columns = (name, size, tiles, f"{len(mesh):,}", f"{took:.2f} s")
    finer, triangles = reference_skyline(terrain, view)
    apart = abs(skyline(mesh, view.camera) - finer)
    return (*columns, f"{np.mean(apart <= 1):.2%}", f"{apart.max():.2f} px", f"{triangles:,}")


@click.command()
@click.argument("presets", nargs=-1)
@click.option("--quick", is_flag=True, help="The smallest picture alone.")
def command(presets: tuple[str, ...], quick: bool) -> None:
    """Print the table of these PRESETS."""
    numba.set_num_threads(1)
    names = ("preset", "size", "tiles", "triangles", "took", "within 1 px", "most", "at τ = ¼")
    sizes = SIZES[:1] if quick else SIZES
    cases = counted([*product(presets or PRESETS, sizes)], "picture", ", ".join)
    rows = [table_row(name, size) for name, size in cases]
    click.echo(table([names, *rows]))
