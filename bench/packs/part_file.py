"""The part hierarchy of a pack as one flat binary file, ``parts.bin``, and parts that come back.

Numbers are little-endian, without padding, in the order of the header; ``docs/packs.md`` has the
layout for a reader in another language. A method that prunes by its own rule writes ``kept.bin``:
the numbers of the parts it keeps, each with how much wider it is drawn.
"""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from bench.packs.content import Content, looks_of, whole_view
from lod.errors import InputError
from lod.shapes import Sticks, Triangles, batches_of

MAGIC, KEPT_MAGIC, VERSION = b"LODPARTS", b"LODKEPT1", 1

_I, _U, _F = "<i4", "<u4", "<f4"

HEADER = np.dtype(
    [("magic", "S8"), ("version", _U)]
    + [(n, _U) for n in ("models", "parts", "sticks", "triangles", "tints", "instances", "unused")]
)
MODEL = np.dtype([(n, _U) for n in ("first_part", "parts", "species", "thins")])
PART = np.dtype(
    [("parent", _I), ("level", _I), ("origin", _F, 3), ("P", _F), ("R", _F), ("B", _F)]
    + [(f"{k}{n}", _U) for n in ("inner", "leaf", "triangles") for k in ("first_", "")]
)
STICK = np.dtype(
    [("start", _F, 3), ("start_radius", _F), ("end", _F, 3), ("end_radius", _F), ("tint", _U)]
)
TRIANGLE = np.dtype([("corners", _F, (3, 3)), ("albedo", _F, 3)])
TINT = np.dtype((_F, 3))
INSTANCE = np.dtype([("model", _U), ("first", _U), ("place", _F, 3), ("turn", _F, 2)])
KEPT = np.dtype([("part", _U), ("width", _F)])

TABLES = {
    "models": MODEL,
    "parts": PART,
    "sticks": STICK,
    "triangles": TRIANGLE,
    "tints": TINT,
    "instances": INSTANCE,
}
"""The tables of the file in their order, by their names in the header."""


def hierarchy_tables(content: Content) -> dict[str, np.ndarray]:
    """Lay out a pack's hierarchy as the tables of its file.

    Raises InputError where its parts cannot be numbered in 32 bits.
    """
    found = {name: [np.zeros(0, kind)] for name, kind in TABLES.items()}

    def size(name: str) -> int:
        return sum(map(len, found[name]))

    for species, field in enumerate(content.scene.world.fields):
        looks, trees = (
            looks_of(field, whole_view(content.view)),
            field.prototypes.part_tables.hierarchies,
        )
        first = np.cumsum([0, *map(len, trees)])[:-1] + size("parts")
        thins = [each.is_thinned for each in trees]
        found["models"].append(_table(MODEL, first, list(map(len, trees)), species, thins))
        lengths = [np.concatenate([getattr(each, k) for each in trees]) for k in ("P", "R", "B")]
        parent = np.concatenate([each.parent for each in trees])
        own = parent, looks.parts.level, looks.parts.position, *lengths, *[0] * 6
        parts = _table(PART, *own)
        for column, look in (("inner", looks.inner), ("leaf", looks.leaf)):
            for batch in batches_of(look):
                name = column if isinstance(batch, Sticks) else "triangles"
                if name == "triangles" and column == "inner":
                    continue  # a mesh is a leaf appearance
                if isinstance(batch, Sticks):
                    into, rows = "sticks", _sticks(batch, size("tints"))
                    found["tints"].append(batch.tints.astype(TINT.base))
                else:
                    into, rows = "triangles", _triangles(batch)
                count = np.bincount(batch.owner, minlength=len(parts))
                parts[name], parts[f"first_{name}"] = count, size(into) + np.cumsum(count) - count
                found[into].append(rows[np.argsort(batch.owner, kind="stable")])
        found["parts"].append(parts)
    tables = {name: np.concatenate(rows) for name, rows in found.items()}
    copies = content.copies
    of_copy = tables["models"]["parts"][copies.which].astype(np.int64)
    if of_copy.sum() >= 2**32:
        raise InputError("NAME", int(of_copy.sum()), "fewer than 2³² parts", "take a smaller size")
    first = np.cumsum(of_copy) - of_copy
    return {**tables, "instances": _table(INSTANCE, copies.which, first, copies.place, copies.turn)}


def write_tables(path: Path, tables: Mapping[str, np.ndarray]) -> None:
    """Write the tables of a hierarchy to a file."""
    counts = [len(tables[name]) for name in TABLES]
    with path.open("wb") as file:
        file.write(np.array((MAGIC, VERSION, *counts, 0), HEADER).tobytes())
        for name in TABLES:
            file.write(tables[name].tobytes())


def read_tables(path: Path) -> dict[str, np.ndarray]:
    """Read the tables of ``parts.bin``. Raises InputError for what is none."""
    data = path.read_bytes()
    head = np.frombuffer(data[: HEADER.itemsize].ljust(HEADER.itemsize, b"\0"), HEADER)[0]
    at, found = HEADER.itemsize, {}
    size = at + sum(int(head[name]) * kind.itemsize for name, kind in TABLES.items())
    if head["magic"] != MAGIC or head["version"] != VERSION or size != len(data):
        raise InputError("pack", str(path), f"a part hierarchy of version {VERSION}, whole")
    for name, kind in TABLES.items():
        found[name] = np.frombuffer(data, kind, int(head[name]), at)
        at += found[name].nbytes
    return found


def _table(kind: np.dtype, *columns: Any) -> np.ndarray:
    table = np.zeros(max(np.size(each) and len(np.atleast_1d(each)) for each in columns), kind)
    for name, column in zip(kind.names or (), columns, strict=True):
        table[name] = column
    return table


def _sticks(sticks: Sticks, first_tint: int) -> np.ndarray:
    ends = sticks.start, sticks.start_radius, sticks.end, sticks.end_radius
    return _table(STICK, *ends, sticks.tint + first_tint)


def _triangles(triangles: Triangles) -> np.ndarray:
    corners = triangles.vertices[triangles.faces]
    return _table(TRIANGLE, corners, triangles.colours[triangles.faces].mean(axis=1))
