"""A frame as plain data: nested dicts of numbers and arrays, checked, before any renderer sees it.

Sticks become chains of points with radii, batched for curve shapes, whichever representation they
come from. A batch is what one curve shape holds: the sticks of one tint, or those of all tints with
a table of their albedos. JIT variants want the latter: Embree's leaves hold up to eight curves of
one shape, and where tints lie among each other, as a tree's do, a shape for each tint leaves most
of those places empty: three times the memory, and slower to build and to trace. Triangles become
one mesh for each representation. Object ids are the frame's own: 0 is the sky, and each
representation has a range of its own, from 1 up.

With ``--haze medium`` a homogeneous medium, the physical reference for the closed forms of haze,
fills a finite box with the scene and the eye in it, from ``DEPTH_M`` below all that is displayed to
``HEIGHT_M`` above it, wide enough that nothing shows beyond (T < 2e-7). It scatters by Henyey &
Greenstein's phase function (Astrophys. J. 93, 1941). Its asymmetry and albedo are those of clean
continental air at 550 nm, all bands alike (OPAC: Hess, Koepke & Schult, Bull. Amer. Meteor. Soc.
79, 1998, table 4). Sun and sky light the box from without, and the model of the sky holds a whole
atmosphere already, so the box is a thin layer below it: the higher, the more light it takes from
the ground twice. The sun's disc is not drawn.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple

import numpy as np

from lod.air import Air, rgb_extinction
from lod.camera import GRID_M, Camera, Corner
from lod.errors import InputError
from lod.kernels import njit
from lod.pruner import Cut
from lod.shapes import Instanced, Sticks, Triangles, batches_of
from scenes.frame.frame_input import DisplayedRepresentation, FrameInput

Description = dict[str, Any]  # nested dicts of numbers, text and arrays (see ``describe_frame``)
MEDIUM = "medium"  # what the box of air is called, where the air is part of the scene

MOST_SEGMENTS = 2**23
"""Segments in one shape: the renderer hands back their numbers as float32, exact below 2**24."""

ALIGNMENT = 64  # bytes: a cache line, and the widest vector register

_SHORTEST = np.float32(1e-2)
"""A stick shorter than this share of its radius is drawn as long: the renderer drops points."""

_LEAST_M = np.float32(1e-4)
"""Nor is any drawn shorter than this: of balls of 2 mm, 0.02 mm long, Embree makes streaks that
cover half as much again, and of 0.2 mm long balls [m]."""


class PlacedSticks(NamedTuple):
    """Sticks of one representation in a frame.

    sticks     as they are at the frame's time
    first_row  row of the representation's first part in the table of all displayed parts
    later      the same sticks a frame later, where they move; None = as now
    """

    sticks: Sticks
    first_row: int
    later: Sticks | None


@dataclass(frozen=True, eq=False)
class Batch:
    """The sticks of one curve shape.

    tints     (k, 3) albedos; where batches are made by tint, k = 1
    counts    (k,) sticks of each tint; they lie tint by tint
    points    (p, 4) float32 x, y, z, radius
    segments  (s,) uint32 first point of each stick
    owners    (s,) uint32 row of the part that each stick belongs to, in a table of all
    moves     (s, 2, 3) float32 how far both ends go to the next frame [m]; None where none does
    """

    tints: np.ndarray
    counts: np.ndarray
    points: np.ndarray
    segments: np.ndarray
    owners: np.ndarray
    moves: np.ndarray | None


def batches(
    placed: Sequence[PlacedSticks], by_tint: bool, most_segments: int = MOST_SEGMENTS
) -> Iterator[Batch]:
    """Batch the sticks of a frame: one batch for each distinct tint, or one for all.

    A tint without sticks has its batch, or its row, too. Another batch begins whenever one has
    ``most_segments``.
    """
    if not placed:
        return
    own = [each.sticks.tints for each in placed]
    tints, numbers = np.unique(np.concatenate(own), axis=0, return_inverse=True)
    number_of = np.split(numbers.reshape(-1), np.cumsum([len(each) for each in own])[:-1])
    columns = [_Columns(*(getattr(p.sticks, k) for k in _Columns._fields)) for p in placed]
    count = np.zeros((2, len(tints)), np.int64)
    last = np.zeros((len(tints), 4), np.float32)
    for own_columns, number in zip(columns, number_of, strict=True):
        _count(own_columns, number, count, last)
    # Tints lie side by side, in exactly the room that their sticks and points take.
    rows = np.append(0, np.cumsum(count[0]))
    laid = np.stack((rows[:-1], np.cumsum(count[1]) - count[1]))
    begin = laid[1].copy()
    points = aligned((int(count[1].sum()), 4))
    segments, owners = (np.empty(int(rows[-1]), np.uint32) for _ in range(2))
    moving = any(each.later is not None for each in placed)
    moves = np.zeros((len(owners), 2, 3), np.float32) if moving else None
    for each, own_columns, number in zip(placed, columns, number_of, strict=True):
        place = _lay(own_columns, number, each.first_row, begin, laid, (points, segments, owners))
        if moves is not None and each.later is not None:
            moves[place, 0] = each.later.start - each.sticks.start
            moves[place, 1] = each.later.end - each.sticks.end
    for group in _groups(rows, by_tint, most_segments):
        (first_tint, first, _), (last_tint, _, end) = group[0], group[-1]
        chain = segments[first:end]
        low, high = (int(chain[0]), int(chain[-1]) + 2) if len(chain) else (0, 0)
        some = moves is not None and moves[first:end].any()
        yield Batch(
            tints=tints[first_tint : last_tint + 1],
            counts=np.array([end - begin for _, begin, end in group]),
            points=points[low:high],
            segments=chain - np.uint32(low) if low else chain,
            owners=owners[first:end],
            moves=moves[first:end] if moves is not None and some else None,
        )


def _groups(rows: np.ndarray, by_tint: bool, most: int) -> Iterator[list[tuple[int, int, int]]]:
    """Pieces (tint, first row, one past its last) of each batch; tint k's rows begin at rows[k]."""
    group: list[tuple[int, int, int]] = []
    for tint, (first, last) in enumerate(zip(rows[:-1].tolist(), rows[1:].tolist(), strict=True)):
        for begin in range(first, max(last, first + 1), most):
            end = min(begin + most, last)
            if group and (by_tint or end - group[0][1] > most):
                yield group
                group = []
            group.append((tint, begin, end))
    if group:
        yield group


def aligned(shape: tuple[int, ...]) -> np.ndarray:
    """Make room for float32 numbers where a vector register may load them from."""
    size = 4 * math.prod(shape)
    room = np.empty(size + ALIGNMENT, np.uint8)
    start = -room.ctypes.data % ALIGNMENT
    found: np.ndarray = room[start : start + size].view(np.float32).reshape(shape)
    return found


class _Columns(NamedTuple):
    """What of sticks makes points: ends (n, 3), radii, tints and owners (n,)."""

    start: Any
    end: Any
    start_radius: Any
    end_radius: Any
    tint: Any
    owner: Any


@njit(cache=True)
def _ends(sticks, m):  # type: ignore[no-untyped-def]
    """Both ends of a stick, each x, y, z and radius; none is too short for the renderer."""
    start, end = sticks.start, sticks.end
    x0, y0, z0 = np.float32(start[m, 0]), np.float32(start[m, 1]), np.float32(start[m, 2])
    x1, y1, z1 = np.float32(end[m, 0]), np.float32(end[m, 1]), np.float32(end[m, 2])
    a, b = np.float32(sticks.start_radius[m]), np.float32(sticks.end_radius[m])
    shortest = max(_SHORTEST * max(a, b), _LEAST_M)
    if max(abs(x1 - x0), abs(y1 - y0), abs(z1 - z0)) < shortest:
        coarse = 4 * np.spacing(max(abs(x1), abs(y1), abs(z1)))
        z1 = z1 + max(shortest, coarse)
    return (x0, y0, z0, a), (x1, y1, z1, b)


@njit(cache=True)
def _continues(point, first):  # type: ignore[no-untyped-def]
    same = point[0] == first[0] and point[1] == first[1] and point[2] == first[2]
    return same and point[3] == first[3]


@njit(cache=True)
def _count(sticks, number, count, last):  # type: ignore[no-untyped-def]
    """Add sticks to ``count`` (2, k): sticks and points of each tint; ``last`` (k, 4) is the point
    where each tint's chain ends so far."""
    for m in range(len(sticks.tint)):
        t = number[sticks.tint[m]]
        first, second = _ends(sticks, m)
        if count[0, t] == 0 or not _continues(last[t], first):
            count[1, t] += 1
        last[t, 0], last[t, 1], last[t, 2], last[t, 3] = second
        count[0, t] += 1
        count[1, t] += 1


@njit(cache=True)
def _lay(sticks, number, first_row, begin, laid, found):  # type: ignore[no-untyped-def]
    """Lay sticks down behind those of their tint; a stick that goes on from the last one shares its
    point. Gives the row of each.

    begin (k,): where each tint's points begin; laid (2, k): where its next stick and point go.
    """
    points, segments, owners = found
    place = np.empty(len(sticks.tint), np.int64)
    for m in range(len(sticks.tint)):
        t = number[sticks.tint[m]]
        first, second = _ends(sticks, m)
        row, at = laid[0, t], laid[1, t]
        if at == begin[t] or not _continues(points[at - 1], first):
            points[at, 0], points[at, 1], points[at, 2], points[at, 3] = first
            at += 1
        points[at, 0], points[at, 1], points[at, 2], points[at, 3] = second
        segments[row] = at - 1
        owners[row] = sticks.owner[m] + first_row
        place[m] = row
        laid[0, t] = row + 1
        laid[1, t] = at + 1
    return place


ASYMMETRY, ALBEDO = 0.71, 0.97  # asymmetry and albedo of single scattering

HEIGHT_M, DEPTH_M = 10.0, 1.0
"""How far the box reaches above and below all that is displayed and the eye [m]."""

_FAR = 4.0  # the box reaches this many visibilities, at least


def with_medium(description: Description, air: Air) -> Description:
    """Put a description into a box of air, whose size and contents are its ``medium``."""
    if air.visibility_m is None:
        raise InputError("--haze", "medium", "haze to scatter light", "give it a --visibility")
    bottom, top, reach = extent(description)
    far = _FAR * air.visibility_m + float(np.abs(description["camera"]["eye"][:2]).max())
    box = {
        "side": 2 * max(reach + 1, far),
        "bottom": bottom,
        "top": top,
        "beta": rgb_extinction(air),
        "albedo": ALBEDO,
        "asymmetry": ASYMMETRY,
    }
    no_object = {MEDIUM: np.zeros(12, np.uint32)}
    return {**description, MEDIUM: box, "owners": {**description["owners"], **no_object}}


def extent(description: Description) -> tuple[float, float, float]:
    """Bottom and top of the box, and the greatest coordinate of anything in it [m]."""
    present = [description["camera"]["eye"][None]]
    for shape in description["shapes"].values():
        if shape["type"] == "mesh":
            present.append(shape["vertices"])
        else:
            centres, radii = shape["control_points"][:, :3], shape["control_points"][:, 3:]
            present += [centres - radii, centres + radii]
    present = [each for each in present if len(each)]
    lowest = min(float(each[:, 2].min()) for each in present)
    highest = max(float(each[:, 2].max()) for each in present)
    reach = max(float(np.abs(each).max()) for each in present)
    return lowest - DEPTH_M, highest + HEIGHT_M, reach


@dataclass(eq=False)
class Copies:
    """Copies of models, all of a frame; shapes of models are no shapes of the frame.

    models  of each the shapes in its own frame, and of each shape the owner of every primitive
    which, place, turn, object  of each copy: its model, and as in ``lod.shapes.Instanced``; its id
    """

    models: list[list[tuple[Description, np.ndarray]]] = field(default_factory=list)
    which: np.ndarray = field(default_factory=lambda: np.zeros(0, np.int64))
    place: np.ndarray = field(default_factory=lambda: np.zeros((0, 3)))
    turn: np.ndarray = field(default_factory=lambda: np.zeros((0, 2)))
    object: np.ndarray = field(default_factory=lambda: np.zeros(0, np.int64))

    def __len__(self) -> int:
        return len(self.which)

    def add(
        self,
        copies: Instanced,
        looks: Sequence[Sticks | Triangles],
        first_row: int,
        objects: np.ndarray,
    ) -> None:
        """Add copies that look so, whose parts begin in a row of the frame's ids."""
        _check_range("places of copies", copies.place, -3e38, 3e38)
        columns = copies.which + len(self.models), copies.place, copies.turn, objects
        for name, values in zip(("which", "place", "turn", "object"), columns, strict=True):
            setattr(self, name, np.concatenate((getattr(self, name), values)))
        for number in range(int(copies.model.max(initial=-1)) + 1):
            made = []
            for shape in looks:
                rows = np.flatnonzero(copies.model[shape.owner] == number)
                if isinstance(shape, Triangles):
                    corners, faces = np.unique(shape.faces[rows], return_inverse=True)
                    mesh = _mesh(shape, corners, faces.reshape(-1, 3))
                    made += [(mesh, shape.owner[rows] + first_row)] if len(rows) else []
                    continue
                own = {k: getattr(shape, k)[rows] for k in _Columns._fields}
                one = PlacedSticks(replace(shape, **own), first_row, None)
                made += [(_curve(b, False), b.owners) for b in batches([one], by_tint=False)]
            self.models.append([each for each in made if len(each[1])])

    def joined(self) -> tuple[list[Description], np.ndarray, np.ndarray]:
        """Join the shapes of all models: into one of sticks and one of triangles, or fewer.

        Gives those; of each model's shapes, model by model, which of them has its primitives, where
        they begin there, and where among all, (k, 3); and the owners of all.
        """
        every = [each for model in self.models for each in model]
        kinds = sorted({shape["type"] for shape, _ in every})
        where, shapes, owners = np.zeros((len(every), 3), np.int64), [], [np.zeros(0, np.uint32)]
        for number, kind in enumerate(kinds):
            rows = [row for row, (shape, _) in enumerate(every) if shape["type"] == kind]
            own = [every[row][0] for row in rows]
            points, index = ("vertices", "faces")
            if kind == "linearcurve":
                points, index = ("control_points", "segment_indices")
            shifted = {index: points, "tint": "tints"}
            names = [name for name in own[0] if name != "type"]
            columns = {name: [shape[name] for shape in own] for name in names}
            for name in shifted.keys() & columns.keys():
                shift = np.cumsum([0, *map(len, columns[shifted[name]])], dtype=np.uint32)
                columns[name] = [c + s for c, s in zip(columns[name], shift[:-1], strict=True)]
            shapes.append({"type": kind, **{k: np.concatenate(c) for k, c in columns.items()}})
            where[rows, 0] = number
            where[rows, 1] = np.cumsum([0, *(len(shape[index]) for shape in own)])[:-1]
            where[rows, 2] = where[rows, 1] + sum(map(len, owners))
            owners += [every[row][1] for row in rows]
        return shapes, where, np.concatenate(owners)


NEAR_M, FAR_M = 0.05, 1e7
"""What the camera sees: from 5 cm to farther than any ground that is built."""

_ID_LIMIT = 2**32


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
    copies = Copies()
    first = np.cumsum([1] + [_count_parts(each) for each in displayed])[:-1].tolist()
    objects = object_ids([each.cut for each in displayed])
    for each, row, object_id in zip(displayed, first, objects, strict=True):
        looks = batches_of(each.shape)
        later = () if each.later is None else batches_of(each.later)
        for shape in looks:
            _check(each.name, shape, len(each.cut))
        if each.copies is not None:
            models = batches_of(each.copies.shape)
            for shape in models:
                _check(f"{each.name} copies", shape, len(each.copies.part))
            copies.add(each.copies, models, row + len(each.cut), each.copies.object + object_id)
        for shape, then in zip(looks, (*later, None, None), strict=False):
            if each.copies is not None and not len(shape):
                continue
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
        },
        "integrator": {"max_depth": quality.max_depth},
        "shapes": shapes,
        "ids": _global_ids(displayed),
        "owners": owners,
        "after": _camera(after, camera.corner) if after else None,
        "moves": moves,
        "copies": copies,
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
    curve = {"control_points": batch.points, "segment_indices": batch.segments}
    colour: Description = {"albedo": batch.tints[0]}
    if not by_tint:
        tint = np.repeat(np.arange(len(batch.counts), dtype=np.uint32), batch.counts)
        colour = {"tints": batch.tints, "tint": tint}
    return {"type": "linearcurve", **curve, **colour}


def chains(curve: Description) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the points, their numbers and the albedos of a curve's chains of joined sticks."""
    first = curve["segment_indices"].astype(np.int64).ravel()
    tint = curve.get("tint", np.zeros(len(first), np.uint32))
    tints = curve.get("tints", np.atleast_2d(curve.get("albedo", np.zeros(3))))
    if not len(first):
        return np.zeros((0, 4), np.float32), np.zeros(0, np.int64), np.zeros((0, 3))
    joined = (np.diff(first) == 1) & (np.diff(tint.astype(np.int64)) == 0)
    begins = np.concatenate(([0], np.flatnonzero(~joined) + 1))
    sticks = np.diff(np.concatenate((begins, [len(first)])))
    counts = sticks + 1
    offset = np.cumsum(counts) - counts
    row = np.repeat(first[begins] - offset, counts) + np.arange(counts.sum())
    points = np.asarray(curve["control_points"]).reshape(-1, 4)[row]
    return points, counts, np.asarray(tints)[tint[begins]]


def _mesh(triangles: Triangles, corners: np.ndarray | slice, faces: np.ndarray) -> Description:
    columns = ("vertices", "normals", "colours")
    arrays = {k: getattr(triangles, k)[corners].astype(np.float32, copy=False) for k in columns}
    return {"type": "mesh", **arrays, "faces": faces.astype(np.uint32)}


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


def _global_ids(visible: Sequence[DisplayedRepresentation]) -> np.ndarray:
    """Object, part and level of every displayed part, with the sky in row 0, (p + 1, 3) uint32.

    Parts of models have the model in place of the object, which the copy tells.
    """
    ids, row = np.zeros((1 + sum(map(_count_parts, visible)), 3), np.uint32), 1
    for v, first in zip(visible, object_ids([v.cut for v in visible]), strict=True):
        tables = [(v.cut.object, first, v.cut.part, v.cut.level)]
        if v.copies is not None:
            tables.append((v.copies.model, 0, v.copies.part, v.copies.level))
        for numbers, start, part, level in tables:
            own = ids[row : row + len(part)]
            for column, (values, shift) in enumerate(((numbers, start), (part, 0), (level, 0))):
                _check_range(f"{v.name} ids", values, 0, _ID_LIMIT - 1 - shift)
                np.add(values, shift, out=own[:, column], dtype=np.int64, casting="unsafe")
            row += len(own)
    return ids


def object_ids(cuts: Sequence[Cut]) -> list[int]:
    """Number of each cut's object 0 in the frame: every cut has a range of its own, from 1."""
    firsts = [1]
    for cut in cuts:
        firsts.append(firsts[-1] + (int(cut.object.max()) + 1 if len(cut) else 0))
    return firsts[:-1]


def _count_parts(v: DisplayedRepresentation) -> int:
    return len(v.cut) + (0 if v.copies is None else len(v.copies.part))


def _check(name: str, shape: Sticks | Triangles, parts: int) -> None:
    """Refuse what the renderer would accept silently: NaN, rows that are not there, albedo > 1."""
    if isinstance(shape, Sticks):
        numbers = {k: getattr(shape, k) for k in ("start", "end", "start_radius", "end_radius")}
        rows = {"tint": (shape.tint, len(shape.tints)), "owner": (shape.owner, parts)}
        colours = shape.tints
        _check_range(f"{name} radius", shape.start_radius, 0, np.inf)
        _check_range(f"{name} radius", shape.end_radius, 0, np.inf)
    else:
        numbers = {"vertices": shape.vertices, "normals": shape.normals}
        rows = {"faces": (shape.faces, len(shape.vertices)), "owner": (shape.owner, parts)}
        colours = shape.colours
        if len(shape.glows):
            rows["glow"] = (shape.glow, len(shape.glows))
            _check_range(f"{name} glow", shape.glows, 0, 1e6)
    for column, values in numbers.items():
        _check_range(f"{name} {column}", values, -3e38, 3e38)
    _check_range(f"{name} albedo", colours, 0, 1)
    for column, (values, count) in rows.items():
        _check_range(f"{name} {column}", values, 0, count - 1)


def _check_range(where: str, values: np.ndarray, low: float, high: float) -> None:
    if not len(values):
        return
    smallest, largest = values.min(), values.max()  # NaN where any is
    if not (np.isfinite(smallest) and low <= smallest and largest <= high and np.isfinite(largest)):
        arrived = smallest if not smallest >= low else largest
        raise InputError(where, float(arrived), f"finite, from {low:g} to {high:g}")
