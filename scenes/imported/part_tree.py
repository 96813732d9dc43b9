"""The parts of an imported model: its node tree with a mesh for every end.

A file says of its nodes beyond their meshes what attributes named ``lod:level``, ``lod:albedo``,
``lod:axis``, ``lod:turns`` and ``lod:swing`` hold. ``oak.usda.toml`` beside ``oak.usda`` says the
same of nodes by their paths, and the unit and the period of the whole; what it says goes before the
file's own.
"""

import hashlib
import io
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Annotated, Any

import numpy as np
from PIL import Image
from pydantic import BaseModel, Field, ValidationError

from lod.arrays import ArrayData, FloatArray, IntArray
from lod.errors import InputError
from lod.shapes import Mesh, MeshTable, triangle_areas
from scenes.model_files import CLOSED, first_error

MOST_NODES, MOST_TRIANGLES = 50_000, 2_000_000
"""Nodes and triangles of one model at most: what a process can hold, prune and measure."""

MOST_BYTES = 2**29  # of a file, and of all that it names, at most

OBJECT_FROM_Y_UP = np.array([[0, 0, 1, 0], [1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 0, 1.0]])
"""x ahead, y left and z up, from x left, y up and z ahead."""

SMALLEST_M, LARGEST_M = 1e-3, 1e4
"""Sides of the box about a model, the longest of them, from a pebble's to a mountain's [m]."""

OWN_COLUMNS = ("parent", "level", "frame", "axis", "turns", "swing")
MESH_COLUMNS = ("first_vertex", "first_face", "vertices", "normals", "colours", "faces")

PREFIX = "lod:"

_Unit = Annotated[float, Field(ge=-1e6, le=1e6)]
_Share = Annotated[float, Field(ge=0, le=1)]


class NodeSettings(BaseModel):
    """What a file, or the table beside it, says of a node beyond its place and its mesh.

    level   detail level; None = one more than that of the node above
    albedo  linear Rec.709 albedo of all below it, 0 to 1; None = that of its materials
    axis    about which it turns, in its own frame; None = it does not turn
    turns   whole turns about the axis in one period of the model
    swing   it swings by so many degrees to either side, once in a period, and makes no turns
    """

    model_config = CLOSED

    level: Annotated[int, Field(ge=0, le=64)] | None = None
    albedo: tuple[_Share, _Share, _Share] | None = None
    axis: tuple[_Unit, _Unit, _Unit] | None = None
    turns: Annotated[int, Field(ge=-64, le=64)] = 1
    swing: Annotated[float, Field(ge=0, le=170)] = 0.0


class Sidecar(BaseModel):
    """The table beside a model.

    metres_per_unit  of the file's lengths; absent: what the file says itself [m]
    period           of all that turns or swings [s]
    parts            of nodes by their paths
    """

    model_config = CLOSED

    metres_per_unit: Annotated[float, Field(gt=0, le=1e6)] | None = None
    period: Annotated[float, Field(ge=0.01, le=1e6)] = 4.0
    parts: dict[str, NodeSettings] = Field(default_factory=dict)


@dataclass(frozen=True, eq=False)
class Node:
    """A node of a scene file, in the object's frame: metres, z up, x the way it faces.

    name    of the node alone; parent: number of the node above in their list, −1 for none
    frame   (4, 4) object from node; mesh: in the object's frame, None where it has none
    passed  it is no part, as a camera, nor is what holds nothing else
    unclear why the colours of its mesh are not known; raised unless an albedo is said
    """

    name: str
    parent: int
    frame: np.ndarray
    mesh: Mesh | None
    settings: NodeSettings
    passed: bool = False
    unclear: InputError | None = None


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
        columns = {name: getattr(self, name) for name in OWN_COLUMNS}
        return columns | {name: getattr(self.meshes, name) for name in MESH_COLUMNS}


def node_settings(where: str, attributes: Mapping[str, Any]) -> NodeSettings:
    """Read the settings of a node from the attributes of its file; others are not looked at."""
    ours = {
        name.rpartition(PREFIX)[2]: value for name, value in attributes.items() if PREFIX in name
    }
    try:
        return NodeSettings.model_validate_json(json.dumps(ours))
    except ValidationError as error:
        raise first_error(f"{where} {PREFIX}", error) from None
    except (TypeError, ValueError) as error:
        raise InputError(where, "attributes", f"plain numbers and lists ({error})") from None


def check_node_count(source: str, count: int) -> None:
    """Raise InputError for more nodes than a model may have."""
    if count > MOST_NODES:
        cure = "join meshes that are never seen apart"
        raise InputError(source, f"{count} nodes", f"a model has at most {MOST_NODES} nodes", cure)


def check_triangle_count(source: str, count: int) -> None:
    """Raise InputError for more triangles than a model may have, before any is read."""
    if count > MOST_TRIANGLES:
        rule = f"a model has at most {MOST_TRIANGLES} triangles"
        raise InputError(source, f"{count} triangles", rule, "decimate its meshes")


def check_frame(where: str, frame: np.ndarray, scale: object) -> None:
    """Raise InputError for a frame (4, 4) that is not finite or flat; ``scale``: what made it."""
    if not np.isfinite(frame).all():
        raise InputError(where, "a place that is no number", "places and scales are finite")
    if abs(np.linalg.det(frame[:3, :3])) < 1e-30:
        raise InputError(where, scale, "a scale above or below 0 along every axis")


def check_rows(where: str, rows: np.ndarray, count: int) -> None:
    """Raise InputError where triangles name other rows than those of ``count`` vertices."""
    if len(rows) and (rows.min() < 0 or rows.max() >= count):
        arrived = int(rows.max() if rows.max() >= count else rows.min())
        raise InputError(where, arrived, f"faces name vertices, 0 to {count - 1}")


def build_tree(source: str, nodes: Sequence[Node], sidecar: Sidecar) -> PartTree:
    """Make the parts of a model from its nodes, those above before those below.

    A node with a mesh and nodes below it has its mesh as a part of its own. A node with nothing but
    one node below is one part with that. Several topmost nodes become parts of one whole.

    source: what errors call the file. Raises InputError that names the node and the rule.
    """
    nodes = _without_passed(nodes)
    check_node_count(source, len(nodes))
    if not any(node.mesh is not None for node in nodes):
        raise InputError(source, "no meshes", "the ends of a model are meshes", "add one")
    if sum(node.parent < 0 for node in nodes) == 1:
        nodes = list(nodes)
    else:
        whole = Node("whole", -1, np.eye(4), None, NodeSettings())
        nodes = [whole, *(replace(node, parent=node.parent + 1) for node in nodes)]
    paths = _paths(nodes)
    said = _settings(source, nodes, paths, sidecar)
    inner = {node.parent for node in nodes}
    for row in range(len(nodes)):
        node = nodes[row]
        if row in inner and node.mesh is not None:
            nodes[row] = replace(node, mesh=None)
            nodes.append(replace(node, name="mesh", parent=row))
            paths.append(f"{paths[row]} mesh")
            said.append(NodeSettings(albedo=said[row].albedo))
        elif row not in inner and node.mesh is None:
            rule = "every node has a mesh or nodes below it"
            raise InputError(f"{source}: node {paths[row]}", "empty", rule, "take it out")
    return _tree(source, nodes, paths, said, sidecar.period)


def _without_passed(nodes: Sequence[Node]) -> list[Node]:
    """Nodes without those that are passed over, and without those that are left empty by that."""
    kept, passed = [node.mesh is not None for node in nodes], [node.passed for node in nodes]
    for row in reversed(range(len(nodes))):  # those below first
        kept[row] |= not passed[row]
        if (above := nodes[row].parent) >= 0:
            kept[above] |= kept[row]
            passed[above] |= passed[row]
    number = dict(zip(np.flatnonzero(kept).tolist(), range(len(nodes)), strict=False))
    return [replace(nodes[row], parent=number.get(nodes[row].parent, -1)) for row in number]


def _paths(nodes: Sequence[Node]) -> list[str]:
    """Names from the whole to every node; namesakes are numbered from 2."""
    paths: list[str] = []
    seen: dict[str, int] = {}
    for node in nodes:
        lead = f"{paths[node.parent]}/" if node.parent >= 0 else ""
        path = f"{lead}{node.name.replace('/', '|')}"
        seen[path] = seen.get(path, 0) + 1
        paths.append(path if seen[path] == 1 else f"{path} ({seen[path]})")
    return paths


def _settings(
    source: str, nodes: Sequence[Node], paths: Sequence[str], sidecar: Sidecar
) -> list[NodeSettings]:
    """What is said of every node; the albedo of a node holds below it, too."""
    unknown = sidecar.parts.keys() - set(paths)
    if unknown:
        where = f"{source}.toml: parts.{min(unknown)}"
        some = ", ".join(list(paths)[:4])
        raise InputError(where, "no such node", "the path of a node", f"as {some} …")
    said: list[NodeSettings] = []
    for node, path in zip(nodes, paths, strict=True):
        own = sidecar.parts.get(path, node.settings)
        if own.axis is not None and not np.any(own.axis):
            raise InputError(f"{source}: {path} axis", own.axis, "not zero", "try [0, 0, 1]")
        if own.albedo is None and node.parent >= 0:
            own = own.model_copy(update={"albedo": said[node.parent].albedo})
        said.append(own)
    return said


def _tree(
    source: str,
    nodes: Sequence[Node],
    paths: Sequence[str],
    said: Sequence[NodeSettings],
    period: float,
) -> PartTree:
    """The parts: all nodes but those that have one node below and nothing else, which takes their
    place."""
    below = np.bincount([node.parent for node in nodes if node.parent >= 0], minlength=len(nodes))
    depth: list[int] = []
    for node in nodes:  # those above come before those below
        depth.append(depth[node.parent] + 1 if node.parent >= 0 else 0)
    wholes_first = sorted(range(len(nodes)), key=depth.__getitem__)
    rows = [row for row in wholes_first if below[row] != 1 or said[row].axis is not None]
    number = {row: part for part, row in enumerate(rows)}
    parent: list[int] = []
    level: list[int] = []
    meshes = []
    for row in rows:
        above = nodes[row].parent
        while above >= 0 and above not in number:
            above = nodes[above].parent
        parent.append(number[above] if above >= 0 else -1)
        least = level[parent[-1]] if parent[-1] >= 0 else 0
        asked = said[row].level
        if asked is not None and (asked < least or (parent[-1] < 0 and asked > 0)):
            where, rule = f"{source}: node {paths[row]} level", f"at least {least}, its whole's"
            raise InputError(where, asked, rule if parent[-1] >= 0 else "0 for the whole")
        level.append(asked if asked is not None else (least + 1 if parent[-1] >= 0 else 0))
        mesh, albedo, unclear = nodes[row].mesh, said[row].albedo, nodes[row].unclear
        if unclear is not None and albedo is None:
            raise unclear
        if mesh is not None and albedo is not None:
            mesh = replace(mesh, colours=np.tile(albedo, (len(mesh.vertices), 1)))
        meshes.append(mesh)
    table = MeshTable.of(meshes)
    check_triangle_count(source, len(table))
    _check_size(source, table)
    return PartTree(
        tuple(paths[row] for row in rows),
        np.array(parent),
        np.array(level),
        np.array([nodes[row].frame for row in rows]),
        table,
        axis=np.array([said[row].axis or (0.0, 0.0, 0.0) for row in rows]),
        turns=np.array([0 if said[row].swing else said[row].turns for row in rows]),
        swing=np.array([said[row].swing for row in rows]),
        period=period,
    )


def _check_size(where: str, meshes: MeshTable) -> None:
    low, high = meshes.vertices.min(axis=0), meshes.vertices.max(axis=0)
    longest = float((high - low).max())
    if not SMALLEST_M <= longest <= LARGEST_M:
        rule = f"a model is {SMALLEST_M:g} to {LARGEST_M:g} m long"
        cure = "mend the file's unit, or say metres_per_unit in FILE.toml"
        raise InputError(where, f"{longest:.3g} m", rule, cure)
    farthest = float(np.abs(meshes.vertices).max())
    if farthest > 2 * LARGEST_M:
        rule = f"a model stands within {2 * LARGEST_M:g} m of its origin"
        raise InputError(where, f"{farthest:.3g} m", rule, "move it to the origin")


TEXTURE_PIXELS = 64  # a texture counts as it looks when averaged down to at most this on a side

_LARGEST_TEXTURE = 2**26
_LARGEST_M = 1e15


def checked_mesh(
    where: str,
    vertices: np.ndarray,
    faces: np.ndarray,
    colours: np.ndarray,
    normals: np.ndarray | None = None,
) -> Mesh:
    """Make the mesh of a node from corners (v, 3) [m], triangles (f, 3) of rows and colours (v, 3).

    Normals (v, 3) are those of the faces where none are given. Triangles without area are left out.
    Raises InputError that names the node: ``where``.
    """
    if vertices.ndim != 2 or vertices.shape[1:] != (3,):
        raise InputError(where, vertices.shape, "vertices have three coordinates")
    wrong = np.flatnonzero(~(np.abs(vertices) < _LARGEST_M).all(axis=1))
    if len(wrong):
        point = [float(x) for x in vertices[wrong[0]]]
        raise InputError(where, point, f"vertices are finite (vertex {int(wrong[0])} is not)")
    if len(faces) == 0:
        raise InputError(where, "no triangles", "a mesh has triangles", "take the node out")
    check_rows(where, faces, len(vertices))
    if not np.isfinite(colours).all() or colours.min() < 0 or colours.max() > 1:
        raise InputError(where, "an albedo outside 0 to 1", "colours are linear, from 0 to 1")
    areas = triangle_areas(vertices, faces)
    reach = float(np.ptp(vertices[faces.reshape(-1)], axis=0).max())
    kept = areas > 1e-14 * reach * reach
    if not kept.any():
        rule, cure = "a mesh has area", "take the node out, or mend its scale"
        raise InputError(where, f"{len(faces)} triangles without area", rule, cure)
    faces = faces[kept]
    smooth = normals is not None and normals.shape == vertices.shape
    if smooth and normals is not None:
        length = np.linalg.norm(normals, axis=1, keepdims=True)
        smooth = bool(np.isfinite(length).all() and (length[faces] > 1e-6).all())
        normals = normals / np.maximum(length, 1e-12)
    if not smooth or normals is None:
        # Every face has corners of its own, with its normal.
        a, b, c = (vertices[faces[:, k]] for k in range(3))
        normal = np.cross(b - a, c - a)
        normal /= np.linalg.norm(normal, axis=1, keepdims=True)
        normals, rows = np.repeat(normal, 3, axis=0), faces.reshape(-1)
        vertices, colours = vertices[rows], colours[rows]
        faces = np.arange(len(rows)).reshape(-1, 3)
    used, rows = np.unique(faces, return_inverse=True)
    return Mesh(vertices[used], normals[used], colours[used], rows.reshape(-1, 3))


def moved(mesh: Mesh, frame: np.ndarray) -> Mesh:
    """Return a mesh in another frame: (4, 4) that one from its own; a mirror turns faces over."""
    linear = frame[:3, :3]
    vertices = mesh.vertices @ linear.T + frame[:3, 3]
    normals = mesh.normals @ np.linalg.inv(linear)
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-300)
    faces = mesh.faces[:, ::-1] if np.linalg.det(linear) < 0 else mesh.faces
    return Mesh(vertices, normals, mesh.colours, faces)


def texture_colours(
    where: str, image: Image.Image | bytes, uv: np.ndarray, repeats: bool, grey: bool = True
) -> np.ndarray:
    """Look up the linear albedo of corners (v, 2) in a texture, u right and v up.

    Raises InputError for a picture without 8 bits a channel, of one channel unless ``grey``, and
    for coordinates beyond 0 to 1 unless it ``repeats``.
    """
    try:
        picture = Image.open(io.BytesIO(image)) if isinstance(image, bytes) else image
        if picture.width * picture.height > _LARGEST_TEXTURE:
            rule = f"a texture has at most {_LARGEST_TEXTURE} pixels"
            raise InputError(where, picture.size, rule)
        if picture.mode not in ("RGB", "RGBA", "P", *(("1", "L", "LA") if grey else ())):
            rule = "a picture of three channels of 8 bits, in sRGB"
            raise InputError(where, f"a picture of mode {picture.mode}", rule, "save it as RGB PNG")
        rgba = np.asarray(picture.convert("RGBA"), np.float64) / 255
    except InputError:
        raise
    except Exception as error:  # whatever a picture's reader meets in a broken file
        rule = f"a picture that can be read ({type(error).__name__})"
        raise InputError(where, "its texture", rule, "save it as RGB PNG") from None
    coded = rgba[..., :3]  # decoded as by IEC 61966-2-1
    rgb = np.where(coded <= 0.04045, coded / 12.92, ((coded + 0.055) / 1.055) ** 2.4)
    for axis in (0, 1):
        edges = np.linspace(0, rgb.shape[axis], min(TEXTURE_PIXELS, rgb.shape[axis]) + 1)
        starts = edges[:-1].astype(int)
        sums = np.add.reduceat(rgb, starts, axis=axis)
        size = np.diff(np.append(starts, rgb.shape[axis]))
        rgb = sums / (size[:, None, None] if axis == 0 else size[None, :, None])
    if not np.isfinite(uv).all():
        raise InputError(where, "a texture coordinate that is no number", "coordinates are finite")
    st = uv * (1, -1) + (0, 1)  # from the left, and from above
    if np.abs(st - 0.5).max(initial=0.0) > 0.5 + 1e-6:
        if not repeats:
            rule, cure = "a texture that repeats, or coordinates from 0 to 1", "unwrap it within"
            raise InputError(where, "coordinates beyond its texture", rule, cure)
        st = st % 1.0
    size = np.array([rgb.shape[1], rgb.shape[0]])
    column, row = np.clip((st * size).astype(int), 0, size - 1).T
    found: np.ndarray = rgb[row, column]
    return found
