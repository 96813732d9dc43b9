"""From the corners of a foreign mesh to one that can be measured and rendered."""

import io

import numpy as np
from PIL import Image

from lod.errors import InputError
from lod.shapes import Mesh, triangle_areas

TEXTURE_PIXELS = 64
"""A texture counts as it looks when averaged down to at most this on a side."""

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
    check_points(where, vertices)
    if len(faces) == 0:
        raise InputError(where, "no triangles", "a mesh has triangles", "take the node out")
    if faces.min() < 0 or faces.max() >= len(vertices):
        arrived = int(faces.max() if faces.max() >= len(vertices) else faces.min())
        raise InputError(where, arrived, f"faces name vertices, 0 to {len(vertices) - 1}")
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
        vertices, colours, normals, faces = _flat(vertices, colours, faces)
    used, rows = np.unique(faces, return_inverse=True)
    return Mesh(vertices[used], normals[used], colours[used], rows.reshape(-1, 3))


def check_points(where: str, vertices: np.ndarray) -> None:
    """Raise InputError for corners that are no finite points of space."""
    if vertices.ndim != 2 or vertices.shape[1:] != (3,):
        raise InputError(where, vertices.shape, "vertices have three coordinates")
    wrong = np.flatnonzero(~(np.abs(vertices) < _LARGEST_M).all(axis=1))
    if len(wrong):
        arrived = [float(x) for x in vertices[wrong[0]]]
        raise InputError(where, arrived, f"vertices are finite (vertex {int(wrong[0])} is not)")


def moved(mesh: Mesh, frame: np.ndarray) -> Mesh:
    """Return a mesh in another frame: (4, 4) that one from its own; a mirror turns faces over."""
    linear = frame[:3, :3]
    vertices = mesh.vertices @ linear.T + frame[:3, 3]
    normals = mesh.normals @ np.linalg.inv(linear)
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-300)
    faces = mesh.faces[:, ::-1] if np.linalg.det(linear) < 0 else mesh.faces
    return Mesh(vertices, normals, mesh.colours, faces)


def joined(meshes: list[Mesh]) -> Mesh:
    """Return several meshes as one."""
    starts = np.cumsum([0] + [len(each.vertices) for each in meshes])[:-1].tolist()
    columns = {
        key: np.concatenate([getattr(each, key) for each in meshes])
        for key in ("vertices", "normals", "colours")
    }
    faces = [each.faces + start for each, start in zip(meshes, starts, strict=True)]
    return Mesh(**columns, faces=np.concatenate(faces))


def texture_colours(where: str, image: Image.Image | bytes, uv: np.ndarray) -> np.ndarray:
    """Look up the linear albedo of corners (v, 2) in a texture, u right and v up, that repeats."""
    try:
        picture = Image.open(io.BytesIO(image)) if isinstance(image, bytes) else image
        if picture.width * picture.height > _LARGEST_TEXTURE:
            rule = f"a texture has at most {_LARGEST_TEXTURE} pixels"
            raise InputError(where, picture.size, rule)
        rgba = np.asarray(picture.convert("RGBA"), np.float64) / 255
    except InputError:
        raise
    except Exception as error:  # whatever a picture's reader meets in a broken file
        raise InputError(where, "its texture", f"a picture that can be read ({error})") from None
    rgb = srgb_to_linear(rgba[..., :3])
    for axis in (0, 1):
        edges = np.linspace(0, rgb.shape[axis], min(TEXTURE_PIXELS, rgb.shape[axis]) + 1)
        starts = edges[:-1].astype(int)
        sums = np.add.reduceat(rgb, starts, axis=axis)
        size = np.diff(np.append(starts, rgb.shape[axis]))
        rgb = sums / (size[:, None, None] if axis == 0 else size[None, :, None])
    if not np.isfinite(uv).all():
        raise InputError(where, "a texture coordinate that is no number", "coordinates are finite")
    column = np.minimum((uv[:, 0] % 1.0 * rgb.shape[1]).astype(int), rgb.shape[1] - 1)
    row = np.minimum(((1.0 - uv[:, 1]) % 1.0 * rgb.shape[0]).astype(int), rgb.shape[0] - 1)
    found: np.ndarray = rgb[row, column]
    return found


def srgb_to_linear(values: np.ndarray) -> np.ndarray:
    """Decode sRGB values from 0 to 1 (IEC 61966-2-1)."""
    return np.where(values <= 0.04045, values / 12.92, ((values + 0.055) / 1.055) ** 2.4)


def _flat(
    vertices: np.ndarray, colours: np.ndarray, faces: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Corners of their own for every face, with its normal."""
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    normal = np.cross(b - a, c - a)
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    rows = faces.reshape(-1)
    own = np.arange(len(rows)).reshape(-1, 3)
    return vertices[rows], colours[rows], np.repeat(normal, 3, axis=0), own
