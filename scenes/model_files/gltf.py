"""Reading glTF 2.0 (.gltf, .glb) into the nodes of a model.

The node graph, and everything in the header that memory could be taken by, is checked here; trimesh
then decodes the accessors, which are the part of the format with many cases. It is handed a header
without nodes, in which each primitive is a mesh of its own, and the bytes of every buffer. glTF has
metres, y up and +z ahead.
"""

import base64
import binascii
import io
import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any
from urllib.parse import unquote

import numpy as np
from scipy.spatial.transform import Rotation

from lod.errors import InputError
from lod.shapes import Mesh
from scenes.model_files.gltf_header import (
    MeshEntry,
    NodeEntry,
    Primitive,
    check_counts,
    checked_header,
    node_name,
    read_header,
    walk,
)
from scenes.model_files.mesh import checked_mesh, joined, moved, texture_colours
from scenes.model_files.part_tree import Node
from scenes.model_files.sidecar import Sidecar, node_settings

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
