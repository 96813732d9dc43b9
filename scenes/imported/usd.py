"""Reading USD (.usda, .usdc, .usd, .usdz) into the nodes of a model.

Layers are composed as USD composes them: references, payloads and variants are those of the file,
and prims that are instances stand for themselves. Lengths are metres by ``metersPerUnit``, which is
0.01 where a file says nothing, and up is the file's ``upAxis``, y where it says nothing. What faces
+z with y up, or −y with z up, looks ahead.
"""

import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from lod.errors import InputError
from lod.shapes import Mesh
from scenes.imported.part_tree import (
    MOST_BYTES,
    MOST_NODES,
    OBJECT_FROM_Y_UP,
    PREFIX,
    Node,
    Sidecar,
    check_frame,
    check_node_count,
    check_rows,
    check_triangle_count,
    checked_mesh,
    moved,
    node_settings,
    texture_colours,
)

if TYPE_CHECKING:
    from pxr import Usd, UsdGeom


MOST_TEXT_BYTES = 2**25
"""Of a layer that is text, which takes some 30 times as much memory."""

OBJECT_FROM_Z_UP = np.array([[0, -1, 0, 0], [1, 0, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1.0]])

_MOST_WORDS = 4 * MOST_NODES
"""``def`` in a text at most, before it is parsed: some stand for materials and not for nodes."""

_PARTS = ("", "Xform", "Scope", "Mesh")
_NO_PARTS = ("Material", "Shader", "NodeGraph", "GeomSubset", "Camera", "SkelAnimation")

GREY = (0.5, 0.5, 0.5)
"""Albedo where a file says none."""


def read_usd(path: Path, sidecar: Sidecar) -> list[Node]:
    """Read the nodes of a USD file, those above before those below.

    Raises InputError that names the prim and the rule.
    """
    from pxr import Tf, Usd, UsdGeom, UsdUtils

    name = path.name
    size, start = path.stat().st_size, path.open("rb").read(8)
    is_text = start != b"PXR-USDC" and start[:2] != b"PK"
    most = MOST_TEXT_BYTES if is_text else MOST_BYTES
    if size > most:
        raise InputError(name, f"{size} bytes", f"at most {most} bytes", "save it as .usdc")
    if is_text and path.read_bytes().count(b"def") > _MOST_WORDS:
        check_node_count(name, _MOST_WORDS)
    said = UsdUtils.CoalescingDiagnosticDelegate()  # or USD would print warnings itself
    try:
        try:
            _count_specs(path)
            stage = Usd.Stage.Open(str(path))
        except Tf.ErrorException as error:
            errors = error.args[0] if error.args else ()
            text = _line(getattr(errors, "commentary", str(error)))
            raise InputError(name, "USD", f"can be read ({text})") from None
        if broken := stage.GetCompositionErrors():
            rule = "every layer and reference is there and none goes in a circle"
            where = f"{name}: node {broken[0].rootSite.path}" if broken[0].rootSite else name
            raise InputError(where, _line(str(broken[0])), rule, "flatten it: usdcat --flatten")
        prims = list(_prims(name, stage))
        total = 0
        for prim, _ in prims:  # before any mesh is read
            if prim.IsA(UsdGeom.Mesh):
                faces = UsdGeom.Mesh(prim).GetFaceVertexCountsAttr().Get() or ()
                counts = np.asarray(faces, np.int64)
                if len(counts) and counts.min() < 3:
                    where = f"{name}: node {prim.GetPath()}"
                    raise InputError(where, int(counts.min()), "faces have three corners or more")
                total += int((counts - 2).sum())
                check_triangle_count(name, total)
        cache, world = UsdGeom.XformCache(), _object_from_stage(name, stage, sidecar)
        return [_node(name, prim, parent, cache, world) for prim, parent in prims]
    finally:
        said.TakeUncoalescedDiagnostics()


def _count_specs(path: Path) -> None:
    """Refuse a layer of too many prims before it is composed, which takes memory for each."""
    from pxr import Sdf

    layer = Sdf.Layer.FindOrOpen(str(path))
    if layer is None:
        raise InputError(path.name, path.suffix, "a USD layer that can be read", "export it again")
    left = list(layer.rootPrims)
    count, arcs = len(left), bool(layer.subLayerPaths)
    check_node_count(path.name, count)
    while left:
        spec = left.pop()
        below = list(spec.nameChildren)
        count += len(below)
        check_node_count(path.name, count)
        left += below
        arcs = arcs or any(spec.HasInfo(key) for key in _ARCS)
    if arcs:
        _try_to_compose(path)


_ARCS = ("references", "payload", "inheritPaths", "specializes", "variantSetNames", "clips")
MOST_COMPOSED_BYTES, MOST_COMPOSED_S = 2**32, 20
_COMPOSE = """
import resource, sys
for kind, most in zip((resource.RLIMIT_AS, resource.RLIMIT_CPU), map(int, sys.argv[2:])):
    resource.setrlimit(kind, (most, most))
from pxr import Usd
Usd.Stage.Open(sys.argv[1])
"""


def _try_to_compose(path: Path) -> None:
    """Refuse layers that become too much together: ten times ten times ten, and so on.

    A process with limits composes them, which ends as it must; what else it finds is found again.
    """
    words = sys.executable, "-c", _COMPOSE, path, f"{MOST_COMPOSED_BYTES}", f"{MOST_COMPOSED_S}"
    ended = subprocess.run(words, stdin=subprocess.DEVNULL, capture_output=True, check=False)
    if ended.returncode < 0 or b"MemoryError" in ended.stderr:
        rule = f"composes within {MOST_COMPOSED_BYTES} bytes and {MOST_COMPOSED_S} s"
        raise InputError(path.name, "its references", rule, "take some away, or flatten it")


def _prims(name: str, stage: "Usd.Stage") -> Iterator[tuple["Usd.Prim", int]]:
    """Prims that are parts, and the place in this order of the one above."""
    from pxr import Usd, UsdGeom, UsdLux

    number: dict[Any, int] = {}
    instances_too = Usd.TraverseInstanceProxies(Usd.PrimDefaultPredicate)
    walk = iter(Usd.PrimRange.Stage(stage, instances_too))
    for prim in walk:
        kind = str(prim.GetTypeName())
        where = f"{name}: node {prim.GetPath()}"
        image = UsdGeom.Imageable(prim)
        hidden = image and (
            image.GetVisibilityAttr().Get() == "invisible"
            or image.GetPurposeAttr().Get() in ("proxy", "guide")
        )
        below = (str(each.GetTypeName()) for each in Usd.PrimRange(prim, instances_too))
        looks = kind == "Scope" and "Mesh" not in below
        light = prim.HasAPI(UsdLux.LightAPI) or prim.IsA(UsdLux.BoundableLightBase)
        if kind in _NO_PARTS or hidden or looks or light:
            walk.PruneChildren()
            continue
        if kind not in _PARTS:
            rule = "Xform, Scope and Mesh prims alone"
            raise InputError(where, kind, rule, "make instances, curves and surfaces real meshes")
        number[prim.GetPath()] = len(number)
        check_node_count(name, len(number))
        yield prim, number.get(prim.GetParent().GetPath(), -1)


def _object_from_stage(name: str, stage: "Usd.Stage", sidecar: Sidecar) -> np.ndarray:
    """(4, 4) metres, z up and x ahead, from the units and axes of a stage."""
    from pxr import UsdGeom

    unit = sidecar.metres_per_unit or UsdGeom.GetStageMetersPerUnit(stage)
    if not (np.isfinite(unit) and unit > 0):
        cure = "mend it, or say metres_per_unit in FILE.toml"
        raise InputError(f"{name}: metersPerUnit", unit, "a length above 0 m, finite", cure)
    up = str(UsdGeom.GetStageUpAxis(stage))
    if up not in ("Y", "Z"):
        raise InputError(f"{name}: upAxis", up, "Y or Z", "export it again")
    turn = OBJECT_FROM_Y_UP if up == "Y" else OBJECT_FROM_Z_UP
    return turn @ np.diag([unit, unit, unit, 1.0])


def _node(
    name: str, prim: "Usd.Prim", parent: int, cache: "UsdGeom.XformCache", world: np.ndarray
) -> Node:
    from pxr import UsdGeom

    where = f"{name}: node {prim.GetPath()}"
    frame = world @ np.array(cache.GetLocalToWorldTransform(prim)).T
    check_frame(where, frame, "a scale of 0")
    said = {
        str(each.GetName()): _plain(each.Get())
        for each in prim.GetAttributes()
        if PREFIX in str(each.GetName())
    }
    mesh = None
    if prim.IsA(UsdGeom.Mesh):
        mesh = moved(_read_mesh(where, UsdGeom.Mesh(prim)), frame)
    return Node(prim.GetName(), parent, frame, mesh, node_settings(where, said))


def _plain(value: Any) -> Any:
    try:
        return [float(each) for each in value] if not isinstance(value, str) else value
    except TypeError:
        return value


def _line(text: str) -> str:
    return " ".join(text.split())[:200]


def _read_mesh(where: str, mesh: "UsdGeom.Mesh") -> Mesh:
    """Read a mesh in its own frame; polygons become fans of triangles about their first corner.

    Raises InputError that names the prim: ``where``.
    """
    points = np.array(mesh.GetPointsAttr().Get() or (), np.float64).reshape(-1, 3)
    counts = np.array(mesh.GetFaceVertexCountsAttr().Get() or (), np.int64)
    corners = np.array(mesh.GetFaceVertexIndicesAttr().Get() or (), np.int64)
    if counts.sum() != len(corners):
        rule = f"as many corners as its faces have, {int(counts.sum())}"
        raise InputError(where, f"{len(corners)} corners", rule, "export it again")
    check_rows(where, corners, len(points))
    # Fans: rows of the corners of each triangle (t, 3).
    triangles = np.maximum(counts - 2, 0)
    face = np.repeat(np.arange(len(counts)), triangles)
    start = (np.cumsum(counts) - counts)[face]
    number = np.arange(len(face)) - np.repeat(np.cumsum(counts - 2) - (counts - 2), triangles)
    fans = np.stack((start, start + number + 1, start + number + 2), axis=1)
    if str(mesh.GetOrientationAttr().Get()) == "leftHanded":
        fans = fans[:, ::-1]
    # Every corner has a vertex of its own where colours or normals change from face to face.
    shape = len(points), corners, counts
    colours, uneven = _colours(where, mesh, *shape)
    normals, bent = _per_corner(mesh.GetNormalsAttr().Get(), mesh.GetNormalsInterpolation(), *shape)
    if not uneven and not bent:
        return checked_mesh(where, points, corners[fans], colours, normals)
    if not uneven:
        colours = colours[corners]
    if normals is not None and not bent:
        normals = normals[corners]
    return checked_mesh(where, points[corners], fans, colours, normals)


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
    where: str, mesh: "UsdGeom.Mesh", points: int, corners: np.ndarray, counts: np.ndarray
) -> tuple[np.ndarray, bool]:
    """Linear albedo by vertex or by corner: of its material, or its displayColor."""
    from pxr import UsdGeom, UsdShade

    shape = points, corners, counts
    material = UsdShade.MaterialBindingAPI(mesh.GetPrim()).ComputeBoundMaterial()[0]
    found = _material_colour(where, material) if material else None
    if isinstance(found, bytes):
        st = UsdGeom.PrimvarsAPI(mesh.GetPrim()).GetPrimvar("st")
        uv, uneven = None, False
        if st:
            uv, uneven = _per_corner(st.ComputeFlattened(), st.GetInterpolation(), *shape)
        if uv is None:
            raise InputError(where, "a texture", "texture coordinates primvars:st", "unwrap it")
        return texture_colours(where, found, uv), uneven
    if found is not None:
        return np.tile(found, (points, 1)), False
    shown = mesh.GetDisplayColorPrimvar()
    colours, uneven = _per_corner(shown.ComputeFlattened(), shown.GetInterpolation(), *shape)
    return (np.tile(GREY, (points, 1)), False) if colours is None else (colours, uneven)


def _material_colour(where: str, material: Any) -> np.ndarray | bytes | None:
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
            rule = "a picture that is there"
            raise InputError(f"{where} texture", arrived, rule, "copy it there")
        return bytes(opened.GetBuffer())
    return None
