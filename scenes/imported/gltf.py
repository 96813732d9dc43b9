"""Reading glTF 2.0 (.gltf, .glb) into the nodes of a model.

The node graph, and everything in the header that could take memory without bound or make a reader
go in circles, is checked here before any mesh is decoded; trimesh then decodes the accessors, which
are the part of the format with many cases. It is handed a header without nodes, in which each
primitive is a mesh of its own, and the bytes of every buffer. glTF has metres, y up and +z ahead.
"""

import base64
import binascii
import io
import json
import struct
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any
from urllib.parse import unquote

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, ValidationError
from scipy.spatial.transform import Rotation

from lod.errors import InputError
from lod.shapes import Mesh, MeshTable
from scenes.imported.part_tree import (
    MOST_BYTES,
    OBJECT_FROM_Y_UP,
    Node,
    Sidecar,
    check_frame,
    check_node_count,
    check_triangle_count,
    checked_mesh,
    moved,
    node_settings,
    texture_colours,
)
from scenes.model_files import first_error

MOST_JSON_BYTES = 2**24
"""Of a header at most: what it says is read into Python objects, some 30 times as large."""

_HARMLESS = ("KHR_materials_", "KHR_texture_transform", "KHR_lights_punctual", "KHR_xmp")
_GLOSS = "anisotropy clearcoat dispersion emissive_strength ior iridescence sheen specular unlit"
_SAME = {f"KHR_materials_{name}" for name in _GLOSS.split()}
"""Extensions of a material that leave its base colour as it is."""

_TRIANGLES, _STRIP, _REPEAT = 4, 5, 10497

_DATA = ("accessors", "bufferViews", "materials", "textures", "images", "samplers")
"""Tables of a header that trimesh is handed as they are."""

_Row = Annotated[int, Field(ge=0)]


class _Entry(BaseModel):
    model_config = ConfigDict(extra="allow", strict=False)


class _Node(_Entry):
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


class _Primitive(_Entry):
    attributes: dict[str, _Row]
    indices: _Row | None = None
    material: _Row | None = None
    mode: int = _TRIANGLES
    targets: list[Any] = Field(default_factory=list)
    extensions: dict[str, Any] | None = None


class _Mesh(_Entry):
    primitives: list[_Primitive]


class _Accessor(_Entry):
    count: Annotated[int, Field(ge=0)]
    sparse: Any = None
    bufferView: Any = None


class _Header(_Entry):
    """What of a header says how many of what there are, and where."""

    nodes: list[_Node] = Field(default_factory=list)
    meshes: list[_Mesh] = Field(default_factory=list)
    accessors: list[_Accessor] = Field(default_factory=list)
    scenes: list[dict[str, Any]] = Field(default_factory=list)
    scene: _Row = 0

    def name_of(self, row: int) -> str:
        return self.nodes[row].name or f"node {row}"


def read_gltf(path: Path, sidecar: Sidecar) -> list[Node]:
    """Read the nodes of a .gltf or .glb file, those above before those below.

    Raises InputError that names the node and the rule.
    """
    raw, chunk = _read_header(path)
    header = _checked(path.name, raw)
    order = _walk(path.name, header)
    total = sum(_triangles(path.name, header, row) for row, _ in order)
    check_triangle_count(path.name, total)
    decoded = _decode(path, raw, chunk)
    unit = np.diag([*[sidecar.metres_per_unit or 1.0] * 3, 1.0])
    frames: list[np.ndarray] = []
    nodes = []
    for row, parent in order:
        entry, name = header.nodes[row], header.name_of(row)
        where = f"{path.name}: node {name}"
        above = OBJECT_FROM_Y_UP @ unit if parent < 0 else frames[parent]
        frames.append(above @ _local(where, entry))
        mesh = unclear = None
        if entry.mesh is not None:
            pieces = []
            found = header.meshes[entry.mesh].primitives, decoded[entry.mesh]
            for primitive, made in zip(*found, strict=True):
                vertices = np.asarray(made["vertices"], np.float64)
                faces = np.asarray(made["faces"], np.int64).reshape(-1, 3)
                normals = made.get("vertex_normals")
                normals = None if normals is None else np.asarray(normals, np.float64)
                try:
                    colours = _colours(where, raw, primitive, made, len(vertices))
                except InputError as error:
                    colours, unclear = np.zeros_like(vertices), error
                piece = checked_mesh(where, vertices, faces, colours, normals)
                pieces.append(moved(piece, frames[-1]))
            if not pieces:
                raise InputError(where, "no primitives", "a mesh has triangles", "take it out")
            whole = MeshTable.of(pieces)
            mesh = Mesh(whole.vertices, whole.normals, whole.colours, whole.faces)
        extras = entry.extras if isinstance(entry.extras, Mapping) else {}
        passed = entry.camera is not None or "KHR_lights_punctual" in entry.extensions
        said = node_settings(where, extras)
        nodes.append(Node(name, parent, frames[-1], mesh, said, passed, unclear))
    return nodes


def _read_header(path: Path) -> tuple[dict[str, Any], bytes]:
    data, chunk = path.read_bytes(), b""
    if data[:4] == b"glTF":
        try:
            _, version, length = struct.unpack_from("<4sII", data)
            size, kind = struct.unpack_from("<I4s", data, 12)
        except struct.error:
            raise InputError(path.name, f"{len(data)} bytes", "a whole GLB header") from None
        if version != 2:
            raise InputError(path.name, f"GLB version {version}", "glTF 2.0", "export it again")
        if length > len(data) or kind != b"JSON" or 20 + size > len(data):
            rule = f"a GLB file of the {length} bytes that it names, JSON first"
            cure = "it is truncated: copy it again"
            raise InputError(path.name, f"{len(data)} bytes", rule, cure)
        rest = data[20 + size :]
        data, chunk = data[20 : 20 + size], rest[8 : 8 + int.from_bytes(rest[:4], "little")]
    if len(data) > MOST_JSON_BYTES:
        rule = f"a header of at most {MOST_JSON_BYTES} bytes"
        raise InputError(path.name, f"{len(data)} bytes", rule, "join nodes, save it as .glb")
    try:
        raw = json.loads(data.rstrip(b"\0"))  # some writers fill a chunk up with zeros
    except (ValueError, RecursionError) as error:
        raise InputError(path.name, data[:24], f"glTF is JSON or GLB ({error})") from None
    if not isinstance(raw, dict):
        raise InputError(path.name, type(raw).__name__, "a glTF header is a JSON object")
    return raw, chunk


def _checked(name: str, raw: dict[str, Any]) -> _Header:
    """The header with its types checked, and nothing that changes what a reader must do."""
    version = raw.get("asset", {}).get("version") if isinstance(raw.get("asset"), dict) else None
    if not str(version).startswith("2."):
        raise InputError(f"{name}: asset.version", version, "glTF 2.0", "export it again")
    for each in map(str, raw.get("extensionsRequired") or ()):
        if not each.startswith(_HARMLESS):
            rule = "no extension that meshes cannot be read without"
            raise InputError(f"{name}: extensionsRequired", each, rule, "export without it")
    entries = raw.get("nodes")
    check_node_count(name, len(entries) if isinstance(entries, list) else 0)
    try:
        return _Header.model_validate(raw)
    except ValidationError as error:
        raise first_error(f"{name}: ", error) from None


def _walk(name: str, header: _Header) -> list[tuple[int, int]]:
    """Each node of the scene and the place in this list of the one above, that one first.

    Raises InputError for a node that is not there, or below itself or two others.
    """
    if header.scenes:
        if header.scene >= len(header.scenes):
            raise InputError(f"{name}: scene", header.scene, "the number of a scene")
        roots = header.scenes[header.scene].get("nodes", [])
        if not isinstance(roots, list) or not all(isinstance(r, int) and r >= 0 for r in roots):
            raise InputError(f"{name}: scenes.{header.scene}.nodes", roots, "numbers of nodes")
    else:
        below = {child for entry in header.nodes for child in entry.children}
        roots = [row for row in range(len(header.nodes)) if row not in below]
    order: list[tuple[int, int]] = []
    seen: set[int] = set()
    left = [(row, -1) for row in reversed(roots)]
    while left:
        row, parent = left.pop()
        above = header.name_of(order[parent][0]) if parent >= 0 else "scene"
        if row >= len(header.nodes):
            raise InputError(f"{name}: node {above} children", row, "the number of a node")
        entry = header.nodes[row]
        if row in seen:
            where = f"{name}: node {header.name_of(row)}"
            rule = "a node stands below one node alone and never below itself"
            raise InputError(where, "a cycle", f"{rule} (again below {above})", "export a tree")
        seen.add(row)
        order.append((row, parent))
        left += [(child, len(order) - 1) for child in reversed(entry.children)]
    if not order and header.nodes:
        raise InputError(f"{name}: node {header.name_of(0)}", "a cycle", "a scene has roots")
    return order


def _triangles(name: str, header: _Header, row: int) -> int:
    """How many triangles a node has by the header; what is not read is refused."""
    entry = header.nodes[row]
    where = f"{name}: node {header.name_of(row)}"
    if entry.skin is not None:
        raise InputError(where, "a skin", "rigid meshes alone", "apply the armature")
    if "EXT_mesh_gpu_instancing" in entry.extensions:
        raise InputError(where, "EXT_mesh_gpu_instancing", "one node each", "make them real")
    if entry.mesh is None:
        return 0
    if entry.mesh >= len(header.meshes):
        raise InputError(where, entry.mesh, "the number of a mesh")
    total = 0
    for each in header.meshes[entry.mesh].primitives:
        if each.targets:
            raise InputError(where, "morph targets", "rigid meshes alone", "apply the shape keys")
        for extension in each.extensions or ():
            if not extension.startswith(_HARMLESS):
                raise InputError(where, extension, "plain triangles", "export without compression")
        if each.mode not in (_TRIANGLES, _STRIP):
            raise InputError(where, f"mode {each.mode}", "triangles, or strips of them")
        if "POSITION" not in each.attributes:
            raise InputError(where, sorted(each.attributes), "a primitive has positions")
        used = [*each.attributes.values(), *([] if each.indices is None else [each.indices])]
        for accessor in used:
            if accessor >= len(header.accessors):
                raise InputError(where, f"accessor {accessor}", "the number of an accessor")
            found = header.accessors[accessor]
            if found.sparse is not None or found.bufferView is None:
                rule, cure = "accessors with data", "export without"
                raise InputError(where, "a sparse accessor", rule, cure)
        listed = each.attributes["POSITION"] if each.indices is None else each.indices
        corners = header.accessors[listed].count
        total += corners // 3 if each.mode == _TRIANGLES else max(corners - 2, 0)
    return total


def _decode(path: Path, raw: dict[str, Any], chunk: bytes) -> list[list[dict[str, Any]]]:
    from trimesh.exchange.gltf import load_gltf

    entries = raw.get("meshes", [])
    single = [
        {"name": f"{m}.{p}", "primitives": [{k: v for k, v in each.items() if k != "extensions"}]}
        for m, entry in enumerate(entries)
        for p, each in enumerate(entry["primitives"])
    ]
    # Each buffer gets a name of its own; pictures keep theirs.
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
    if (held := sum(map(len, files.values()))) > MOST_BYTES:
        rule = f"buffers and images of at most {MOST_BYTES} bytes in all"
        raise InputError(path.name, f"{held} bytes", rule, "split the scene, or export it smaller")
    plain = {key: raw[key] for key in _DATA if key in raw}
    plain |= {"meshes": single, "buffers": buffers, "asset": {"version": "2.0"}}
    try:
        made = load_gltf(io.BytesIO(json.dumps(plain).encode()), resolver=files)["geometry"]
    except Exception as error:  # whatever trimesh meets in a broken file
        text = " ".join(f"{type(error).__name__} {error}".split())
        rule, cure = f"accessors within their buffers ({text})", "it may be truncated: export again"
        raise InputError(path.name, "its meshes", rule, cure) from None
    return [
        [made[f"{m}.{p}"] for p in range(len(entry["primitives"]))]
        for m, entry in enumerate(entries)
    ]


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


def _local(where: str, entry: _Node) -> np.ndarray:
    if entry.matrix is not None:
        frame = np.array(entry.matrix, np.float64).reshape(4, 4).T
        check_frame(where, frame, "a flat matrix")
        return frame
    if not np.isfinite(entry.rotation).all() or not any(entry.rotation):
        rule = "a quaternion, finite and not zero"
        raise InputError(f"{where} rotation", entry.rotation, rule)
    frame = np.eye(4)
    frame[:3, :3] = Rotation.from_quat(entry.rotation).as_matrix() * np.array(entry.scale)
    frame[:3, 3] = entry.translation
    check_frame(where, frame, entry.scale)
    return frame


def _colours(
    where: str, raw: dict[str, Any], primitive: _Primitive, made: dict[str, Any], count: int
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
    texture = pbr.get("baseColorTexture", {})
    strange = sorted({*material.get("extensions", ()), *texture.get("extensions", ())} - _SAME)
    strange += [f"TEXCOORD_{texture['texCoord']}"] if texture.get("texCoord") else []
    if strange:
        rule, cure = "a base colour of core glTF alone", "bake it, or say albedo in FILE.toml"
        raise InputError(f"{where} material {material.get('name', '')}", strange[0], rule, cure)
    colours = np.tile(factor[:3], (count, 1))
    visual = made.get("visual")
    uv = getattr(visual, "uv", None)
    image = getattr(getattr(visual, "material", None), "baseColorTexture", None)
    if texture:
        if uv is None or image is None:
            rule = "a texture that can be read, with coordinates TEXCOORD_0"
            raise InputError(f"{where} material", "a texture", rule, "export it as PNG or JPEG")
        sampler = raw["textures"][texture["index"]].get("sampler")
        wraps = raw["samplers"][sampler] if sampler is not None else {}
        repeats = {wraps.get(f"wrap{k}", _REPEAT) for k in "ST"} == {_REPEAT}
        colours = colours * texture_colours(where, image, np.asarray(uv, np.float64), repeats)
    painted = made.get("vertex_colors")
    if painted is None and visual is not None:
        painted = getattr(visual, "vertex_attributes", {}).get("color")
    if painted is not None:
        painted = np.asarray(painted)
        scale = np.iinfo(painted.dtype).max if painted.dtype.kind == "u" else 1.0
        colours = colours * (painted[:, :3] / scale)
    elif not texture and "baseColorFactor" not in pbr:  # glTF's own default is a white metal
        rule, cure = "a material with a base colour, or vertex colours", "say albedo in FILE.toml"
        raise InputError(f"{where} material {material.get('name', '')}", "no colour", rule, cure)
    return colours
