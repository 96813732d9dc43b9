"""The header of a glTF 2.0 file (.gltf, .glb): its nodes, checked before any mesh is decoded.

Everything is refused here that could take memory without bound or make a reader go in circles.

Reading glTF 2.0 (.gltf, .glb) into the nodes of a model.

The node graph, and everything in the header that memory could be taken by, is checked here; trimesh
then decodes the accessors, which are the part of the format with many cases. It is handed a header
without nodes, in which each primitive is a mesh of its own, and the bytes of every buffer. glTF has
metres, y up and +z ahead.
"""

import base64
import binascii
import io
import json
import struct
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any
from urllib.parse import unquote

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, ValidationError
from scipy.spatial.transform import Rotation

from lod.errors import InputError
from lod.shapes import Mesh
from scenes.imported.part_tree import (
    Node,
    Sidecar,
    check_node_count,
    check_triangle_count,
    checked_mesh,
    joined,
    moved,
    node_settings,
    texture_colours,
)

MOST_JSON_BYTES = 2**24
"""Of a header at most: what it says is read into Python objects, some 30 times as large."""

_HARMLESS = ("KHR_materials_", "KHR_lights_punctual", "KHR_xmp")
_TRIANGLES, _STRIP = 4, 5

_Row = Annotated[int, Field(ge=0)]


class _Entry(BaseModel):
    model_config = ConfigDict(extra="allow", strict=False)


class NodeEntry(_Entry):
    """A node: its place in the one above, and what hangs on it."""

    name: str = ""
    children: list[_Row] = Field(default_factory=list)
    matrix: Annotated[list[float], Field(min_length=16, max_length=16)] | None = None
    translation: tuple[float, float, float] = (0.0, 0.0, 0.0)
    rotation: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 1.0)
    scale: tuple[float, float, float] = (1.0, 1.0, 1.0)
    mesh: _Row | None = None
    skin: int | None = None
    camera: int | None = None
    extensions: dict[str, Any] = Field(default_factory=dict)
    extras: Any = None


class Primitive(_Entry):
    """Triangles of one material."""

    attributes: dict[str, _Row]
    indices: _Row | None = None
    material: _Row | None = None
    mode: int = _TRIANGLES
    targets: list[Any] = Field(default_factory=list)


class MeshEntry(_Entry):
    """A mesh of one or more primitives."""

    primitives: list[Primitive]


class _Accessor(_Entry):
    count: Annotated[int, Field(ge=0)]
    sparse: Any = None


class Header(_Entry):
    """What of a header says how many of what there are, and where."""

    nodes: list[NodeEntry] = Field(default_factory=list)
    meshes: list[MeshEntry] = Field(default_factory=list)
    accessors: list[_Accessor] = Field(default_factory=list)
    scenes: list[dict[str, Any]] = Field(default_factory=list)
    scene: _Row = 0


def read_header(path: Path) -> tuple[dict[str, Any], bytes]:
    """The JSON of a file, and the binary chunk of a .glb."""
    data, chunk = path.read_bytes(), b""
    if data[:4] == b"glTF":
        data, chunk = _chunks(path.name, data)
    if len(data) > MOST_JSON_BYTES:
        rule = f"a header of at most {MOST_JSON_BYTES} bytes"
        raise InputError(path.name, f"{len(data)} bytes", rule, "join nodes, save it as .glb")
    try:
        raw = json.loads(data)
    except (ValueError, RecursionError) as error:
        raise InputError(path.name, data[:24], f"glTF is JSON or GLB ({error})") from None
    if not isinstance(raw, dict):
        raise InputError(path.name, type(raw).__name__, "a glTF header is a JSON object")
    return raw, chunk


def _chunks(name: str, data: bytes) -> tuple[bytes, bytes]:
    """The JSON and the binary chunk of a .glb file, whose lengths must fit."""
    try:
        _, version, length = struct.unpack_from("<4sII", data)
        size, kind = struct.unpack_from("<I4s", data, 12)
    except struct.error:
        raise InputError(name, f"{len(data)} bytes", "a whole GLB header") from None
    if version != 2:
        raise InputError(name, f"GLB version {version}", "glTF 2.0", "export it again")
    if length > len(data) or kind != b"JSON" or 20 + size > len(data):
        rule = f"a GLB file of the {length} bytes that it names, JSON first"
        raise InputError(name, f"{len(data)} bytes", rule, "it is truncated: copy it again")
    rest = data[20 + size :]
    return data[20 : 20 + size], rest[8 : 8 + int.from_bytes(rest[:4], "little")]


def checked_header(name: str, raw: dict[str, Any]) -> Header:
    """The header with its types checked, and nothing that changes what a reader must do."""
    version = raw.get("asset", {}).get("version") if isinstance(raw.get("asset"), dict) else None
    if not str(version).startswith("2."):
        raise InputError(f"{name}: asset.version", version, "glTF 2.0", "export it again")
    required = [str(each) for each in raw.get("extensionsRequired") or ()]
    for each in required:
        if not each.startswith(_HARMLESS):
            rule = "no extension that meshes cannot be read without"
            raise InputError(f"{name}: extensionsRequired", each, rule, "export without it")
    entries = raw.get("nodes")
    check_node_count(name, len(entries) if isinstance(entries, list) else 0)
    try:
        return Header.model_validate(raw)
    except ValidationError as error:
        first = error.errors(include_url=False)[0]
        key = ".".join(map(str, first["loc"]))
        raise InputError(f"{name}: {key}", first["input"], first["msg"]) from None


def walk(name: str, header: Header) -> list[tuple[int, int]]:
    """Each node of the scene and the place in this list of the one above, that one first.

    Cameras and lights are passed over. Raises InputError for a node that is not there, and for one
    that is below itself or below two others.
    """
    roots = _roots(name, header)
    order: list[tuple[int, int]] = []
    seen: set[int] = set()
    left = [(row, -1) for row in reversed(roots)]
    while left:
        row, parent = left.pop()
        above = (
            node_name(header.nodes[order[parent][0]], order[parent][0]) if parent >= 0 else "scene"
        )
        if row >= len(header.nodes):
            raise InputError(f"{name}: node {above} children", row, "the number of a node")
        entry = header.nodes[row]
        if row in seen:
            rule = (
                f"a node stands below one node alone and never below itself (again below {above})"
            )
            raise InputError(
                f"{name}: node {node_name(entry, row)}", "a cycle", rule, "export a tree"
            )
        seen.add(row)
        if entry.mesh is None and not entry.children and _is_no_part(entry):
            continue
        order.append((row, parent))
        left += [(child, len(order) - 1) for child in reversed(entry.children)]
    if not order and header.nodes:
        raise InputError(
            f"{name}: node {node_name(header.nodes[0], 0)}", "a cycle", "a scene has roots"
        )
    return order


def _roots(name: str, header: Header) -> list[int]:
    if not header.scenes:
        below = {child for entry in header.nodes for child in entry.children}
        return [row for row in range(len(header.nodes)) if row not in below]
    if header.scene >= len(header.scenes):
        raise InputError(f"{name}: scene", header.scene, "the number of a scene")
    roots = header.scenes[header.scene].get("nodes", [])
    if not isinstance(roots, list) or not all(isinstance(r, int) and r >= 0 for r in roots):
        raise InputError(f"{name}: scenes.{header.scene}.nodes", roots, "numbers of nodes")
    return roots


def _is_no_part(entry: NodeEntry) -> bool:
    return entry.camera is not None or "KHR_lights_punctual" in entry.extensions


def node_name(entry: NodeEntry, row: int) -> str:
    """Return the name of a node, or its number where it has none."""
    return entry.name or f"node {row}"


def check_counts(name: str, header: Header, order: Sequence[tuple[int, int]]) -> None:
    """Foretell the triangles of all nodes, and refuse what is not read, before anything is."""
    total = 0
    for row, _ in order:
        entry = header.nodes[row]
        where = f"{name}: node {node_name(entry, row)}"
        if entry.skin is not None:
            raise InputError(where, "a skin", "rigid meshes alone", "apply the armature")
        if "EXT_mesh_gpu_instancing" in entry.extensions:
            raise InputError(where, "EXT_mesh_gpu_instancing", "one node each", "make them real")
        if entry.mesh is None:
            continue
        if entry.mesh >= len(header.meshes):
            raise InputError(where, entry.mesh, "the number of a mesh")
        for each in header.meshes[entry.mesh].primitives:
            total += _triangles(where, header, each)
    check_triangle_count(name, total)


def _triangles(where: str, header: Header, each: Primitive) -> int:
    """How many triangles a primitive has."""
    if each.targets:
        raise InputError(where, "morph targets", "rigid meshes alone", "apply the shape keys")
    for extension in (each.model_extra or {}).get("extensions") or ():
        if not extension.startswith(_HARMLESS):
            raise InputError(where, extension, "plain triangles", "export without compression")
    if each.mode not in (_TRIANGLES, _STRIP):
        raise InputError(where, f"mode {each.mode}", "triangles, or strips of them")
    if "POSITION" not in each.attributes:
        raise InputError(where, sorted(each.attributes), "a primitive has positions")
    used = [*each.attributes.values(), *([] if each.indices is None else [each.indices])]
    for row in used:
        if row >= len(header.accessors):
            raise InputError(where, f"accessor {row}", "the number of an accessor")
        found = header.accessors[row]
        if found.sparse is not None or (found.model_extra or {}).get("bufferView") is None:
            raise InputError(where, "a sparse accessor", "accessors with data", "export without")
    corners = header.accessors[used[-1] if each.indices is not None else used[0]].count
    if each.indices is None:
        corners = header.accessors[each.attributes["POSITION"]].count
    return corners // 3 if each.mode == _TRIANGLES else max(corners - 2, 0)


MOST_BYTES = 2**29
"""Of a file and all that it names at most."""

_DATA = ("accessors", "bufferViews", "materials", "textures", "images", "samplers")
"""Tables of a header that trimesh is handed as they are."""

OBJECT_FROM_GLTF = np.array([[0, 0, 1, 0], [1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 0, 1.0]])
"""x ahead, y left and z up, from x left, y up and z ahead."""


def read_gltf(path: Path, sidecar: Sidecar) -> list[Node]:
    """Read the nodes of a .gltf or .glb file, those above before those below.

    Raises InputError that names the node and the rule.
    """
    raw, chunk = read_header(path)
    header = checked_header(path.name, raw)
    order = walk(path.name, header)
    check_counts(path.name, header, order)
    decoded = _decode(path, raw, chunk)
    unit = np.diag([*[sidecar.metres_per_unit or 1.0] * 3, 1.0])
    frames: list[np.ndarray] = []
    nodes = []
    for row, parent in order:
        entry = header.nodes[row]
        where = f"{path.name}: node {node_name(entry, row)}"
        above = OBJECT_FROM_GLTF @ unit if parent < 0 else frames[parent]
        frames.append(above @ _local(where, entry))
        mesh = None
        if entry.mesh is not None:
            mesh = _mesh(where, raw, header.meshes[entry.mesh], decoded[entry.mesh], frames[-1])
        extras = entry.extras if isinstance(entry.extras, Mapping) else {}
        settings = node_settings(where, extras)
        nodes.append(Node(node_name(entry, row), parent, frames[-1], mesh, settings))
    return nodes


def _decode(path: Path, raw: dict[str, Any], chunk: bytes) -> list[list[dict[str, Any]]]:
    """What trimesh makes of every primitive of every mesh."""
    from trimesh.exchange.gltf import load_gltf

    entries = raw.get("meshes", [])
    single = [
        {"name": f"{m}.{p}", "primitives": [{k: v for k, v in each.items() if k != "extensions"}]}
        for m, entry in enumerate(entries)
        for p, each in enumerate(entry["primitives"])
    ]
    buffers, files = _buffers(path, raw, chunk)
    plain = {key: raw[key] for key in _DATA if key in raw}
    plain |= {"meshes": single, "buffers": buffers, "asset": {"version": "2.0"}}
    try:
        made = load_gltf(io.BytesIO(json.dumps(plain).encode()), resolver=files)["geometry"]
    except Exception as error:  # whatever trimesh meets in a broken file
        text = " ".join(f"{type(error).__name__} {error}".split())
        rule = f"accessors within their buffers ({text})"
        raise InputError(
            path.name, "its meshes", rule, "it may be truncated: export again"
        ) from None
    return [
        [made[f"{m}.{p}"] for p in range(len(entry["primitives"]))]
        for m, entry in enumerate(entries)
    ]


def _buffers(
    path: Path, raw: dict[str, Any], chunk: bytes
) -> tuple[list[dict[str, Any]], dict[str, bytes]]:
    """The buffers, each by a name of its own, and the bytes of these and of pictures by name."""
    files: dict[str, bytes] = {}
    buffers = []
    for number, entry in enumerate(raw.get("buffers", [])):
        uri, size = entry.get("uri"), int(entry.get("byteLength", 0))
        data = chunk if uri is None else _fetch(path, f"buffers.{number}", str(uri))
        if len(data) < size:
            where, rule = f"{path.name}: buffers.{number}", f"the {size} bytes that it names"
            raise InputError(where, f"{len(data)} bytes", rule, "it is truncated: copy it again")
        files[f"buffer{number}"] = data[:size]
        buffers.append({"uri": f"buffer{number}", "byteLength": size})
    for number, entry in enumerate(raw.get("images", [])):
        uri = entry.get("uri") if isinstance(entry, dict) else None
        if uri is not None and not str(uri).startswith("data:"):
            files[str(uri)] = _fetch(path, f"images.{number}", str(uri))
    if sum(map(len, files.values())) > MOST_BYTES:
        raise InputError(path.name, "its buffers", f"at most {MOST_BYTES} bytes in all")
    return buffers, files


def _fetch(path: Path, key: str, uri: str) -> bytes:
    """The bytes that a URI names: of itself, or of a file beside the model."""
    where = f"{path.name}: {key}"
    if uri.startswith("data:"):
        try:
            return base64.b64decode(uri.partition(",")[2], validate=True)
        except (binascii.Error, ValueError) as error:
            raise InputError(where, uri[:40], f"base64 data ({error})") from None
    folder = path.resolve().parent
    file = (folder / unquote(uri)).resolve()
    if not file.is_relative_to(folder):
        raise InputError(where, uri, "a file beside the model", "copy it there")
    if not file.is_file():
        raise InputError(where, uri, "a file that is there", "copy it beside the model")
    if file.stat().st_size > MOST_BYTES:
        raise InputError(where, uri, f"at most {MOST_BYTES} bytes")
    return file.read_bytes()


def _local(where: str, entry: NodeEntry) -> np.ndarray:
    """Frame of a node in that above it."""
    if entry.matrix is not None:
        frame = np.array(entry.matrix, np.float64).reshape(4, 4).T
    else:
        frame = np.eye(4)
        frame[:3, :3] = _rotation(where, entry.rotation) * np.array(entry.scale)
        frame[:3, 3] = entry.translation
    if not np.isfinite(frame).all():
        raise InputError(where, "a place that is no number", "places and scales are finite")
    if abs(np.linalg.det(frame[:3, :3])) < 1e-30:
        rule = "a scale above or below 0 along every axis"
        raise InputError(where, entry.scale if entry.matrix is None else "a flat matrix", rule)
    return frame


def _rotation(where: str, quaternion: tuple[float, ...]) -> np.ndarray:
    """The matrix of a rotation (x, y, z, w)."""
    if not np.isfinite(quaternion).all() or not any(quaternion):
        raise InputError(f"{where} rotation", quaternion, "a quaternion, finite and not zero")
    return Rotation.from_quat(quaternion).as_matrix()


def _mesh(
    where: str,
    raw: dict[str, Any],
    entry: MeshEntry,
    decoded: Sequence[dict[str, Any]],
    frame: np.ndarray,
) -> Mesh:
    """The mesh of a node in the object's frame, all primitives together."""
    found = []
    for primitive, made in zip(entry.primitives, decoded, strict=True):
        vertices = np.asarray(made["vertices"], np.float64)
        faces = np.asarray(made["faces"], np.int64).reshape(-1, 3)
        normals = made.get("vertex_normals")
        normals = None if normals is None else np.asarray(normals, np.float64)
        colours = _colours(where, raw, primitive, made, len(vertices))
        mesh = checked_mesh(where, vertices, faces, colours, normals)
        found.append(moved(mesh, frame))
    if not found:
        raise InputError(where, "no primitives", "a mesh has triangles", "take the node out")
    return joined(found)


def _colours(
    where: str, raw: dict[str, Any], primitive: Primitive, made: dict[str, Any], count: int
) -> np.ndarray:
    """Linear albedo of each vertex: factor × texture × vertex colour, as glTF has it."""
    materials = raw.get("materials", [])
    material = materials[primitive.material] if primitive.material is not None else {}
    pbr = material.get("pbrMetallicRoughness", {})
    factor = np.array([*pbr.get("baseColorFactor", (1.0, 1.0, 1.0, 1.0))], np.float64)
    if material.get("alphaMode", "OPAQUE") != "OPAQUE" and (
        factor[3] < 1 or "baseColorTexture" in pbr
    ):
        rule, cure = "opaque materials alone", "model leaves as meshes, or set alphaMode OPAQUE"
        raise InputError(f"{where} material", material.get("alphaMode"), rule, cure)
    colours = np.tile(factor[:3], (count, 1))
    visual = made.get("visual")
    uv = getattr(visual, "uv", None)
    image = getattr(getattr(visual, "material", None), "baseColorTexture", None)
    if "baseColorTexture" in pbr:
        if uv is None or image is None:
            rule = "a texture that can be read, with coordinates TEXCOORD_0"
            raise InputError(f"{where} material", "a texture", rule, "export it as PNG or JPEG")
        colours = colours * texture_colours(where, image, np.asarray(uv, np.float64))
    painted = made.get("vertex_colors")
    if painted is None and visual is not None:
        painted = getattr(visual, "vertex_attributes", {}).get("color")
    if painted is not None:
        painted = np.asarray(painted)
        scale = np.iinfo(painted.dtype).max if painted.dtype.kind == "u" else 1.0
        colours = colours * (painted[:, :3] / scale)
    return colours
