"""The header of a glTF 2.0 file (.gltf, .glb): its nodes, checked before any mesh is decoded.

Everything is refused here that could take memory without bound or make a reader go in circles.
"""

import json
import struct
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Any

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from lod.errors import InputError
from scenes.model_files.build_tree import check_node_count, check_triangle_count

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
