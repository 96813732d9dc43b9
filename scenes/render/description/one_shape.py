"""Sticks of all tints in one curve shape, each coloured by its number; for JIT variants.

Embree's leaves hold up to eight curves of one shape. Where tints lie among each other, as a tree's
do, a shape for each tint leaves most of those places empty: three times the memory, and slower to
build and to trace.
"""

from collections.abc import Iterator

import numpy as np

from scenes.render.description.describe import Description
from scenes.render.description.stick_batches import MOST_SEGMENTS, aligned


def in_one_shape(description: Description) -> Description:
    """The same frame with as few curve shapes as hold its sticks.

    Such a shape has ``tints`` (k, 3), and ``tint`` (s,) uint32 of each segment.
    """
    shapes, owners, moves = (dict(description[name]) for name in ("shapes", "owners", "moves"))
    for number, names in enumerate(list(_groups(shapes))):
        curves = {name: shapes.pop(name) for name in names}
        owned = [owners.pop(name) for name in names]
        moved = {name: moves.pop(name) for name in names if name in moves}
        whole = f"sticks{number:03d}"
        shapes[whole], owners[whole] = _joined(list(curves.values())), np.concatenate(owned)
        if moved:
            counts = {name: len(curves[name]["segment_indices"]) for name in names}
            still = {name: np.zeros((n, 2, 3), np.float32) for name, n in counts.items()}
            moves[whole] = np.concatenate([(still | moved)[name] for name in names])
    return {**description, "shapes": shapes, "owners": owners, "moves": moves}


def _groups(shapes: Description) -> Iterator[list[str]]:
    """Names of curves that fit into one shape together."""
    names: list[str] = []
    held = 0
    for name, shape in shapes.items():
        if shape["type"] == "linearcurve":
            count = len(shape["segment_indices"])
            if names and held + count > MOST_SEGMENTS:
                yield names
                names, held = [], 0
            names.append(name)
            held += count
    if names:
        yield names


def _joined(curves: list[Description]) -> Description:
    points = [curve["control_points"] for curve in curves]
    counts = [len(curve["segment_indices"]) for curve in curves]
    first = np.cumsum([0] + [len(each) for each in points])[:-1]
    segments = [
        curve["segment_indices"] + np.uint32(start)
        for curve, start in zip(curves, first, strict=True)
    ]
    return {
        "type": "linearcurve",
        "control_points": np.concatenate(points, out=aligned((sum(map(len, points)), 4))),
        "segment_indices": np.concatenate(segments),
        "tints": np.array([curve["albedo"] for curve in curves]),
        "tint": np.repeat(np.arange(len(curves), dtype=np.uint32), counts),
    }
