"""Meshes of USD, with the colours of their materials."""

from typing import TYPE_CHECKING, Any

import numpy as np

from lod.errors import InputError
from lod.shapes import Mesh
from scenes.model_files.mesh import checked_mesh, texture_colours

if TYPE_CHECKING:
    from pxr import UsdGeom

GREY = (0.5, 0.5, 0.5)
"""Albedo where a file says none."""


def read_mesh(where: str, mesh: "UsdGeom.Mesh") -> Mesh:
    """Read a mesh in its own frame; polygons become fans of triangles about their first corner.

    Raises InputError that names the prim: ``where``.
    """
    points = np.array(mesh.GetPointsAttr().Get() or (), np.float64).reshape(-1, 3)
    counts = np.array(mesh.GetFaceVertexCountsAttr().Get() or (), np.int64)
    corners = np.array(mesh.GetFaceVertexIndicesAttr().Get() or (), np.int64)
    if counts.sum() != len(corners):
        rule = f"as many corners as its faces have, {int(counts.sum())}"
        raise InputError(where, f"{len(corners)} corners", rule, "export it again")
    if len(corners) and (corners.min() < 0 or corners.max() >= len(points)):
        arrived = int(corners.max() if corners.max() >= len(points) else corners.min())
        raise InputError(where, arrived, f"faces name vertices, 0 to {len(points) - 1}")
    fans = _fans(counts)
    if str(mesh.GetOrientationAttr().Get()) == "leftHanded":
        fans = fans[:, ::-1]
    # Every corner has a vertex of its own where colours or normals change from face to face.
    colours, uneven = _colours(where, mesh, points, corners, counts)
    normals, bent = _per_corner(
        mesh.GetNormalsAttr().Get(), mesh.GetNormalsInterpolation(), *(len(points), corners, counts)
    )
    if not uneven and not bent:
        return checked_mesh(where, points, corners[fans], colours, normals)
    if not uneven:
        colours = colours[corners]
    if normals is not None and not bent:
        normals = normals[corners]
    return checked_mesh(where, points[corners], fans, colours, normals)


def _fans(counts: np.ndarray) -> np.ndarray:
    """Rows of the corners of each triangle (t, 3) of polygons with so many corners each."""
    face = np.repeat(np.arange(len(counts)), np.maximum(counts - 2, 0))
    first = np.cumsum(counts) - counts
    number = np.arange(len(face)) - np.repeat(
        np.cumsum(counts - 2) - (counts - 2), np.maximum(counts - 2, 0)
    )
    start = first[face]
    return np.stack((start, start + number + 1, start + number + 2), axis=1)


def _per_corner(
    values: Any, interpolation: Any, points: int, corners: np.ndarray, counts: np.ndarray
) -> tuple[np.ndarray | None, bool]:
    """Values by vertex, or by corner (the second result says so); None where there are none."""
    if values is None or len(values) == 0:
        return None, False
    rows = np.array(values, np.float64).reshape(len(values), -1)
    kind = str(interpolation)
    if kind == "constant" or len(rows) == 1:
        return np.repeat(rows[:1], points, axis=0), False
    if kind in ("vertex", "varying") and len(rows) == points:
        return rows, False
    if kind == "faceVarying" and len(rows) == len(corners):
        return rows, True
    if kind == "uniform" and len(rows) == len(counts):
        return np.repeat(rows, counts, axis=0), True
    return None, False


def _colours(
    where: str, mesh: "UsdGeom.Mesh", points: np.ndarray, corners: np.ndarray, counts: np.ndarray
) -> tuple[np.ndarray, bool]:
    """Linear albedo by vertex or by corner: of its material, or its displayColor."""
    from pxr import UsdGeom, UsdShade

    count = len(points), corners, counts
    material = UsdShade.MaterialBindingAPI(mesh.GetPrim()).ComputeBoundMaterial()[0]
    found = _material_colour(where, material) if material else None
    if isinstance(found, bytes):
        st = UsdGeom.PrimvarsAPI(mesh.GetPrim()).GetPrimvar("st")
        uv, uneven = (
            _per_corner(st.ComputeFlattened(), st.GetInterpolation(), *count)
            if st
            else (None, False)
        )
        if uv is None:
            raise InputError(where, "a texture", "texture coordinates primvars:st", "unwrap it")
        return texture_colours(where, found, uv), uneven
    if found is not None:
        return np.tile(found, (len(points), 1)), False
    shown = mesh.GetDisplayColorPrimvar()
    colours, uneven = _per_corner(shown.ComputeFlattened(), shown.GetInterpolation(), *count)
    return (np.tile(GREY, (len(points), 1)), False) if colours is None else (colours, uneven)


def _material_colour(where: str, material: Any) -> np.ndarray | bytes | None:
    """Diffuse colour of a UsdPreviewSurface, or the bytes of its texture; None for no colour."""
    from pxr import Ar, UsdShade

    surface = material.ComputeSurfaceSource()[0]
    if not surface or surface.GetIdAttr().Get() != "UsdPreviewSurface":
        return None
    opacity = surface.GetInput("opacity")
    if opacity and (opacity.HasConnectedSource() or (opacity.Get() or 1.0) < 1.0):
        rule, cure = "opaque materials alone", "model leaves as meshes, or take opacity out"
        raise InputError(f"{where} material", "opacity", rule, cure)
    diffuse = surface.GetInput("diffuseColor")
    if not diffuse:
        return None
    for source in UsdShade.Utils.GetValueProducingAttributes(diffuse):
        shader = UsdShade.Shader(source.GetPrim())
        if shader.GetIdAttr().Get() != "UsdUVTexture":
            return np.array(source.Get(), np.float64)
        asset = shader.GetInput("file").Get()
        opened = Ar.GetResolver().OpenAsset(Ar.ResolvedPath(asset.resolvedPath)) if asset else None
        if opened is None:
            arrived = asset.path if asset else "no file"
            raise InputError(
                f"{where} texture", arrived, "a picture that is there", "copy it there"
            )
        return bytes(opened.GetBuffer())
    return None
