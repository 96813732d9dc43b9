"""How do two batches of parts or appearances differ, and which of their rows are faulty?"""

from collections.abc import Callable, Iterator
from dataclasses import fields

import numpy as np

from lod.pruning.crossfade import blend_weights
from lod.pruning.parts import BlendWeights, Parts
from lod.pruning.pruner import prune
from lod.pruning.representation import Representation
from lod.pruning.shapes import Appearance, Sticks, Triangles, batches_of
from lod.pruning.view import View

Batched = Sticks | Triangles

_WIDTHS = {"position": 3, "centre": 3, "start": 3, "end": 3, "tints": 3}
_WIDTHS |= {"vertices": 3, "normals": 3, "colours": 3, "faces": 3, "glows": 3}
_ROUNDING = 1e-6


def report_rows(what: str, wrong: np.ndarray) -> Iterator[str]:
    """Yield one line where any row is wrong: what, how many of how many, and the first row."""
    rows = np.flatnonzero(wrong)
    if len(rows):
        yield f"{what}: {len(rows)} of {len(wrong)}, the first at {rows[0]}"


def full_weights(parts: Parts) -> BlendWeights:
    """Give weights that show both appearances of every part in full."""
    return BlendWeights(np.ones(len(parts)), np.ones(len(parts)))


def part_keys(parts: Parts) -> np.ndarray:
    """Give level, number and place of each part, sorted, (n, 5) int64, to compare traversals."""
    place = np.ascontiguousarray(parts.position + 0.0).view(np.int64)
    rows = np.column_stack((parts.level, parts.part, place))
    return rows[np.lexsort(rows.T)]


def shared_rows(one: Parts, other: Parts) -> tuple[np.ndarray, np.ndarray]:
    """Give the rows of the parts that two batches share, by object and number, in one order."""
    row = {key: i for i, key in enumerate(_keys(other))}
    pairs = [(i, row[key]) for i, key in enumerate(_keys(one)) if key in row]
    rows = np.array(pairs, np.int64).reshape(-1, 2)
    return rows[:, 0], rows[:, 1]


def _keys(parts: Parts) -> list[tuple[int, int, int]]:
    columns = parts.object, parts.level, parts.part
    return list(zip(*(column.tolist() for column in columns), strict=True))


def owner_distances(shape: Appearance, centre: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Give the owner of every stick end or corner, (k,), and its distance from that centre [m]."""
    pairs = [_owner_distances(each, centre) for each in batches_of(shape)]
    owners, reaches = zip(*pairs, strict=True)
    return np.concatenate(owners), np.concatenate(reaches)


def _owner_distances(
    shape: Sticks | Triangles, centre: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    if isinstance(shape, Sticks):
        owner = np.concatenate((shape.owner, shape.owner))
        point = np.concatenate((shape.start, shape.end))
        radius = np.concatenate((shape.start_radius, shape.end_radius))
    else:
        owner, point = np.repeat(shape.owner, 3), shape.vertices[shape.faces.ravel()]
        radius = np.zeros(len(owner))
    return owner, np.linalg.norm(point - centre[owner], axis=1) + radius


def frame_bytes(representation: Representation, view: View) -> dict[str, bytes]:
    """Give the bytes of every array of a frame: of its cut, and of the cut's appearance."""
    cut = prune(representation, view)
    shape = representation.appearance(cut.parts, blend_weights(cut, view))
    looks = [(type(each).__name__, each) for each in batches_of(shape)]
    both = (("parts", cut.parts), *looks)
    return {
        f"{where}.{field.name}": np.ascontiguousarray(getattr(each, field.name)).tobytes()
        for where, each in both
        for field in fields(each)
        if field.name != "state"
    }


def unequal_columns(one: Appearance, other: Appearance) -> list[str]:
    """Name the columns in which two appearances are not equal."""
    return _columns_that(_unequal, one, other)


def differing_columns(one: Appearance, other: Appearance) -> list[str]:
    """Name the columns in which two appearances differ by more than rounding."""
    return _columns_that(_differing, one, other)


def _columns_that(
    test: Callable[[Batched, Batched], list[str]], one: Appearance, other: Appearance
) -> list[str]:
    pairs = zip(batches_of(one), batches_of(other), strict=False)
    return ["their kind"] if type(one) is not type(other) else [n for p in pairs for n in test(*p)]


def _unequal(one: Batched, other: Batched) -> list[str]:
    if type(one) is not type(other):
        return ["their kind"]
    pairs = {f.name: (getattr(one, f.name), getattr(other, f.name)) for f in fields(one)}
    return [name for name, (a, b) in pairs.items() if not np.array_equal(a, b)]


def _differing(one: Batched, other: Batched) -> list[str]:
    return [
        name
        for name in _unequal(one, other)
        if name == "their kind"
        or getattr(one, name).shape != getattr(other, name).shape
        or not np.allclose(getattr(one, name), getattr(other, name), rtol=0, atol=_ROUNDING)
    ]


def column_faults(batch: Parts | Appearance) -> Iterator[str]:
    """Yield columns that are not read-only arrays of finite numbers; limits may be infinite."""
    for each in (batch,) if isinstance(batch, Parts) else batches_of(batch):
        yield from _column_faults(each)


def _column_faults(batch: Parts | Sticks | Triangles) -> Iterator[str]:
    for field in fields(batch):
        column, name = getattr(batch, field.name), f"{type(batch).__name__}.{field.name}"
        if field.name == "state":
            continue
        if not isinstance(column, np.ndarray) or column.dtype == object:
            yield f"{name} is no array of numbers"
            continue
        if column.flags.writeable:
            yield f"{name} can be written to"
        if column.shape[1:] != ((_WIDTHS[field.name],) if field.name in _WIDTHS else ()):
            yield f"{name} has shape {column.shape}"
        good = ~np.isnan(column) if field.name.startswith("limit") else np.isfinite(column)
        yield from report_rows(f"{name} is not finite", ~good)
    if isinstance(batch, Parts) and {len(getattr(batch, f.name)) for f in fields(batch)
                                     if f.name != "state"} - {len(batch)}:  # fmt: skip
        yield "columns of Parts have different lengths"


def appearance_faults(shape: Appearance, parts: int) -> Iterator[str]:
    """Yield rows that do not exist, radii or albedo out of range, and normals that are not unit."""
    for each in batches_of(shape):
        yield from _batch_faults(each, parts)


def _batch_faults(shape: Sticks | Triangles, parts: int) -> Iterator[str]:
    if isinstance(shape, Sticks):
        for name in ("start_radius", "end_radius"):
            yield from report_rows(f"{name} not above 0", ~(getattr(shape, name) > 0))
        rows, colours = {"tint": (shape.tint, len(shape.tints))}, shape.tints
    else:
        length = np.linalg.norm(shape.normals, axis=1)
        yield from report_rows("a normal that is not unit", abs(length - 1) > _ROUNDING)
        rows, colours = {"faces": (shape.faces, len(shape.vertices))}, shape.colours
    yield from report_rows("albedo outside 0 to 1", np.max(abs(colours - 0.5), axis=1) > 0.5)
    for name, (row, count) in (rows | {"owner": (shape.owner, parts)}).items():
        yield from report_rows(f"{name} of no such row", (row < 0) | (row >= count))
