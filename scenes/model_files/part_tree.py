"""The parts of an imported model: its node tree with a mesh for every end, and what may be said of
each node.
"""

import hashlib
import json
from dataclasses import dataclass

import numpy as np

from lod.arrays import ArrayData, FloatArray, IntArray
from lod.errors import InputError
from lod.shapes import Mesh, MeshTable

MOST_NODES, MOST_TRIANGLES = 50_000, 2_000_000
"""Nodes and triangles of one model at most: what a process can hold, prune and measure."""

SMALLEST_M, LARGEST_M = 1e-3, 1e4
"""Sides of the box about a model, the longest of them, from a pebble's to a mountain's [m]."""


@dataclass(frozen=True)
class NodeSettings:
    """What a file, or the table beside it, says of a node beyond its place and its mesh.

    level   detail level; None = one more than that of the node above
    albedo  linear Rec.709 albedo of all below it, 0 to 1; None = that of its materials
    axis    about which it turns, in its own frame; None = it does not turn
    turns   whole turns about the axis in one period of the model
    swing   it swings by so many degrees to either side, once in a period, and makes no turns
    """

    level: int | None = None
    albedo: tuple[float, float, float] | None = None
    axis: tuple[float, float, float] | None = None
    turns: int = 1
    swing: float = 0.0


@dataclass(frozen=True, eq=False)
class Node:
    """A node of a scene file, in the object's frame: metres, z up, x the way it faces.

    name    of the node alone; parent: number of the node above in their list, −1 for none
    frame   (4, 4) object from node; mesh: in the object's frame, None where it has none
    """

    name: str
    parent: int
    frame: np.ndarray
    mesh: Mesh | None
    settings: NodeSettings


@dataclass(frozen=True, eq=False)
class PartTree(ArrayData):
    """The parts of a model, wholes before parts; every part without parts has a mesh.

    names   (n) path of each from the whole, with / between
    parent  (n,) part that owns each, −1 for the whole; level (n,) detail level
    frame   (n, 4, 4) object from part
    meshes  in the object's frame
    axis (n, 3), turns (n,), swing (n,)  as in NodeSettings, in the part's frame; a zero axis turns
            not
    period  of all that turns [s]
    """

    names: tuple[str, ...]
    parent: IntArray
    level: IntArray
    frame: FloatArray
    meshes: MeshTable
    axis: FloatArray
    turns: IntArray
    swing: FloatArray
    period: float = 4.0

    def __len__(self) -> int:
        return len(self.names)

    @property
    def turning(self) -> bool:
        """Tell whether anything of it turns or swings."""
        return bool(np.any(self.axis))

    @property
    def digest(self) -> str:
        """Compute the SHA-256 of all that decides how the model looks, in hexadecimal."""
        found = hashlib.sha256(json.dumps((self.names, self.period)).encode())
        for name, column in self.columns().items():
            found.update(f"{name} {column.shape}".encode())
            found.update(column.astype(f"<{column.dtype.kind}8").tobytes())
        return found.hexdigest()

    def columns(self) -> dict[str, np.ndarray]:
        """Return every array of the tree by name, those of its meshes too."""
        own = ("parent", "level", "frame", "axis", "turns", "swing")
        meshes = ("first_vertex", "first_face", "vertices", "normals", "colours", "faces")
        columns = {name: getattr(self, name) for name in own}
        return columns | {name: getattr(self.meshes, name) for name in meshes}


def check_size(where: str, meshes: MeshTable, cure: str) -> None:
    """Raise InputError for a model so small or so large that its units must be wrong."""
    low, high = meshes.vertices.min(axis=0), meshes.vertices.max(axis=0)
    longest = float((high - low).max())
    if not SMALLEST_M <= longest <= LARGEST_M:
        rule = f"a model is {SMALLEST_M:g} to {LARGEST_M:g} m long"
        raise InputError(where, f"{longest:.3g} m", rule, cure)
    farthest = float(np.abs(meshes.vertices).max())
    if farthest > 2 * LARGEST_M:
        rule = f"a model stands within {2 * LARGEST_M:g} m of its origin"
        raise InputError(where, f"{farthest:.3g} m", rule, "move it to the origin")
