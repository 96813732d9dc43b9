"""A frame as plain data: nested dicts of numbers and arrays, checked, before any renderer sees it.

Sticks become batched curve shapes, whichever representation they come from: one for each tint, or
one for all where a JIT variant renders in colours. Triangles become one mesh for each
representation. Object ids are the frame's own: 0 is the sky, and each representation has a range of
its own, from 1 up.
"""

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from lod.camera import GRID_M, Camera, Corner
from lod.errors import InputError
from lod.pruner import Cut
from lod.shapes import Sticks, Triangles, batches_of
from lod.threads import map_chunks
from scenes.frame.displayed import DisplayedRepresentation
from scenes.frame.frame_input import FrameInput
from scenes.render.description.medium_box import with_medium
from scenes.render.description.scene_description import Description
from scenes.render.description.stick_batches import Batch, PlacedSticks, batches

NEAR_M, FAR_M = 0.05, 1e7
"""What the camera sees: from 5 cm to farther than any ground that is built."""

_ID_LIMIT = 2**32

_SHORTEST_RUN = 65536
"""Rows of numbers for whose check another thread is worth its start."""


def describe_frame(frame_input: FrameInput) -> Description:
    """Describe the whole frame: ``camera``, ``light``, ``integrator``; ``shapes`` by name.

    ``ids`` (p + 1, 3) are object, part and level of all that is displayed, the sky in row 0;
    ``owners`` by name of a shape: the row of each primitive's part there.

    Where motion is asked for, also ``after``, the next frame's camera in this one's coordinates,
    and ``moves`` by name of those shapes that move; None and empty otherwise. Where haze is a
    medium, also ``medium``, the box that holds it.

    Raises InputError for numbers that the renderer would accept silently (NaN, albedo above 1).
    """
    displayed, quality = frame_input.displayed, frame_input.quality
    shapes: dict[str, Description] = {}
    owners: dict[str, np.ndarray] = {}
    moves: dict[str, np.ndarray] = {}
    placed = []
    first = np.cumsum([1] + [len(each.cut) for each in displayed])[:-1].tolist()
    for each, row in zip(displayed, first, strict=True):
        _check(each)
        later = (None, None) if each.later is None else (*batches_of(each.later), None)
        for shape, then in zip(batches_of(each.shape), later, strict=False):
            if isinstance(shape, Sticks):
                placed.append(PlacedSticks(shape, row, then if isinstance(then, Sticks) else None))
                continue
            for mesh, faces in _meshes(shape):
                name = f"mesh{len(shapes):03d}"
                shapes[name], owners[name] = mesh, (shape.owner[faces] + row).astype(np.uint32)
                if isinstance(then, Triangles):
                    moves[name] = (then.vertices - shape.vertices).astype(np.float32)
    by_tint = not quality.is_jit or quality.is_spectral
    for number, batch in enumerate(batches(placed, by_tint), len(shapes) if by_tint else 0):
        name = f"sticks{number:03d}"
        shapes[name], owners[name] = _curve(batch, by_tint), batch.owners
        if batch.moves is not None:
            moves[name] = batch.moves
    camera, after = frame_input.camera, frame_input.after
    description = {
        "camera": _camera(camera, camera.corner),
        "light": {
            "to_sun": frame_input.light.to_sun,
            "turbidity": frame_input.light.turbidity,
            "weight": quality.sun_sampling,
            "canopy": frame_input.light.canopy,
        },
        "integrator": {"max_depth": quality.max_depth},
        "shapes": shapes,
        "ids": _global_ids(displayed),
        "owners": owners,
        "after": _camera(after, camera.corner) if after else None,
        "moves": moves,
    }
    return with_medium(description, frame_input.air) if quality.haze == "medium" else description


def with_camera(description: Description, camera: Camera, after: Camera | None) -> Description:
    """Describe the same things from another camera, in coordinates of the same corner."""
    places = {"camera": camera, "after": after}
    return {
        **description,
        **{k: _camera(c, camera.corner) if c else None for k, c in places.items()},
    }


def _camera(camera: Camera, corner: Corner) -> Description:
    away = camera.corner.x - corner.x, camera.corner.y - corner.y, 0
    return {
        "eye": camera.eye + GRID_M * np.array(away, np.float64),
        "forward": camera.forward,
        "up": camera.up,
        "fov_x_deg": float(np.degrees(camera.fov_x)),
        "size": (camera.width, camera.height),
        "clip": (NEAR_M, FAR_M),
        "lens": camera.lens,
        "panorama": camera.panorama,
    }


def _curve(batch: Batch, by_tint: bool) -> Description:
    """A curve of one albedo, or with the number of each segment's own in a table of albedos."""
    numbers = np.arange(len(batch.counts), dtype=np.uint32)
    colour = {"tints": batch.tints, "tint": np.repeat(numbers, batch.counts)}
    return {
        "type": "linearcurve",
        "control_points": batch.points,
        "segment_indices": batch.segments,
        **({"albedo": batch.tints[0]} if by_tint else colour),
    }


def _meshes(triangles: Triangles) -> Iterator[tuple[Description, np.ndarray | slice]]:
    """A mesh of all faces, or one of each radiance, and which faces are in it."""
    if not len(triangles.glows):
        if len(triangles):
            yield _mesh(triangles, slice(None), triangles.faces), slice(None)
        return
    for number, glow in enumerate(triangles.glows):
        rows = np.flatnonzero(triangles.glow == number)
        if len(rows):
            corners, faces = np.unique(triangles.faces[rows], return_inverse=True)
            yield {**_mesh(triangles, corners, faces.reshape(-1, 3)), "glow": glow}, rows


def _mesh(triangles: Triangles, corners: np.ndarray | slice, faces: np.ndarray) -> Description:
    return {
        "type": "mesh",
        "vertices": triangles.vertices[corners].astype(np.float32),
        "normals": triangles.normals[corners].astype(np.float32),
        "colours": triangles.colours[corners].astype(np.float32),
        "faces": faces.astype(np.uint32),
    }


def _global_ids(visible: Sequence[DisplayedRepresentation]) -> np.ndarray:
    """Object, part and level of every displayed part, with the sky in row 0, (p + 1, 3) uint32."""
    cuts = [v.cut for v in visible]
    ids, row = np.zeros((1 + sum(map(len, cuts)), 3), np.uint32), 1
    for v, first in zip(visible, object_ids(cuts), strict=True):
        own = ids[row : row + len(v.cut)]
        columns = (v.cut.object, first), (v.cut.part, 0), (v.cut.level, 0)
        for column, (numbers, start) in enumerate(columns):
            _check_range(f"{v.name} ids", numbers, 0, _ID_LIMIT - 1 - start)
            np.add(numbers, start, out=own[:, column], dtype=np.int64, casting="unsafe")
        row += len(own)
    return ids


def object_ids(cuts: Sequence[Cut]) -> list[int]:
    """Number of each cut's object 0 in the frame: every cut has a range of its own, from 1."""
    firsts = [1]
    for cut in cuts:
        firsts.append(firsts[-1] + (int(cut.object.max()) + 1 if len(cut) else 0))
    return firsts[:-1]


def _check(v: DisplayedRepresentation) -> None:
    """Refuse what the renderer would accept silently: NaN, rows that are not there, albedo > 1."""
    for shape in batches_of(v.shape):
        _check_batch(v, shape)


def _check_batch(v: DisplayedRepresentation, shape: Sticks | Triangles) -> None:
    parts = len(v.cut)
    if isinstance(shape, Sticks):
        numbers = {k: getattr(shape, k) for k in ("start", "end", "start_radius", "end_radius")}
        rows = {"tint": (shape.tint, len(shape.tints)), "owner": (shape.owner, parts)}
        colours = shape.tints
        _check_range(f"{v.name} radius", shape.start_radius, 0, np.inf)
        _check_range(f"{v.name} radius", shape.end_radius, 0, np.inf)
    else:
        numbers = {"vertices": shape.vertices, "normals": shape.normals}
        rows = {"faces": (shape.faces, len(shape.vertices)), "owner": (shape.owner, parts)}
        colours = shape.colours
        if len(shape.glows):
            rows["glow"] = (shape.glow, len(shape.glows))
            _check_range(f"{v.name} glow", shape.glows, 0, 1e6)
    for name, values in numbers.items():
        _check_range(f"{v.name} {name}", values, -3e38, 3e38)
    _check_range(f"{v.name} albedo", colours, 0, 1)
    for name, (values, count) in rows.items():
        _check_range(f"{v.name} {name}", values, 0, count - 1)


def _check_range(where: str, values: np.ndarray, low: float, high: float) -> None:
    if not len(values):
        return

    def ends(first: int, last: int) -> tuple[Any, Any]:
        return values[first:last].min(), values[first:last].max()

    lows, highs = zip(*map_chunks(ends, len(values), _SHORTEST_RUN), strict=True)
    smallest, largest = np.min(lows), np.max(highs)  # NaN where any is
    if not (np.isfinite(smallest) and low <= smallest and largest <= high and np.isfinite(largest)):
        arrived = smallest if not smallest >= low else largest
        raise InputError(where, float(arrived), f"finite, from {low:g} to {high:g}")
