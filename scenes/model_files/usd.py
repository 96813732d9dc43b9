"""Reading USD (.usda, .usdc, .usd, .usdz) into the nodes of a model.

Layers are composed as USD composes them: references, payloads and variants are those of the file,
and prims that are instances stand for themselves. Lengths are metres by ``metersPerUnit``, which is
0.01 where a file says nothing, and up is the file's ``upAxis``, y where it says nothing. What faces
+z with y up, or −y with z up, looks ahead.
"""

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from lod.errors import InputError
from scenes.model_files.build_tree import check_node_count, check_triangle_count
from scenes.model_files.mesh import moved
from scenes.model_files.part_tree import MOST_NODES, Node
from scenes.model_files.sidecar import PREFIX, Sidecar, node_settings
from scenes.model_files.usd_mesh import read_mesh

if TYPE_CHECKING:
    from pxr import Usd, UsdGeom

MOST_BYTES, MOST_TEXT_BYTES = 2**29, 2**25
"""Of a layer at most, and of one that is text, which takes some 30 times as much memory."""

OBJECT_FROM_Y_UP = np.array([[0, 0, 1, 0], [1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 0, 1.0]])
OBJECT_FROM_Z_UP = np.array([[0, -1, 0, 0], [1, 0, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1.0]])

_MOST_WORDS = 4 * MOST_NODES
"""``def`` in a text at most, before it is parsed: some stand for materials and not for nodes."""

_PARTS = ("", "Xform", "Scope", "Mesh")
_NO_PARTS = ("Material", "Shader", "NodeGraph", "GeomSubset", "Camera", "SkelAnimation")


def read_usd(path: Path, sidecar: Sidecar) -> list[Node]:
    """Read the nodes of a USD file, those above before those below.

    Raises InputError that names the prim and the rule.
    """
    from pxr import Tf, Usd, UsdGeom, UsdUtils

    _check_bytes(path)
    said = UsdUtils.CoalescingDiagnosticDelegate()  # or USD would print warnings itself
    try:
        try:
            _count_specs(path)
            stage = Usd.Stage.Open(str(path))
        except Tf.ErrorException as error:
            raise InputError(path.name, "USD", f"can be read ({_first(error)})") from None
        _refuse_broken(path.name, stage, said)
        cache = UsdGeom.XformCache()
        prims = list(_prims(path.name, stage))
        _check_triangles(path.name, [prim for prim, _ in prims])
        world = _object_from_stage(path.name, stage, sidecar)
        return [_node(path.name, prim, parent, cache, world) for prim, parent in prims]
    finally:
        said.TakeUncoalescedDiagnostics()


def _check_bytes(path: Path) -> None:
    size, start = path.stat().st_size, path.open("rb").read(8)
    is_text = start != b"PXR-USDC" and start[:2] != b"PK"
    most = MOST_TEXT_BYTES if is_text else MOST_BYTES
    if size > most:
        raise InputError(path.name, f"{size} bytes", f"at most {most} bytes", "save it as .usdc")
    if is_text and path.read_bytes().count(b"def") > _MOST_WORDS:
        check_node_count(path.name, _MOST_WORDS)


def _count_specs(path: Path) -> None:
    """Refuse a layer of too many prims before it is composed, which takes memory for each."""
    from pxr import Sdf

    layer = Sdf.Layer.FindOrOpen(str(path))
    if layer is None:
        raise InputError(path.name, path.suffix, "a USD layer that can be read", "export it again")
    count = len(layer.rootPrims)
    check_node_count(path.name, count)
    left = list(layer.rootPrims)
    while left:
        spec = left.pop()
        count += len(spec.nameChildren)
        check_node_count(path.name, count)
        left += list(spec.nameChildren)


def _refuse_broken(name: str, stage: "Usd.Stage", said: Any) -> None:
    """Refuse a stage of which something is missing or goes in circles."""
    errors = stage.GetCompositionErrors()
    if errors:
        rule = "every layer and reference is there and none goes in a circle"
        where = f"{name}: node {errors[0].rootSite.path}" if errors[0].rootSite else name
        raise InputError(where, _line(str(errors[0])), rule, "flatten it: usdcat --flatten")


def _prims(name: str, stage: "Usd.Stage") -> Iterator[tuple["Usd.Prim", int]]:
    """Prims that are parts, and the place in this order of the one above."""
    from pxr import Usd, UsdGeom, UsdLux

    number: dict[Any, int] = {}
    every = Usd.PrimRange.Stage(stage, Usd.TraverseInstanceProxies(Usd.PrimDefaultPredicate))
    walk = iter(every)
    for prim in walk:
        kind = str(prim.GetTypeName())
        where = f"{name}: node {prim.GetPath()}"
        image = UsdGeom.Imageable(prim)
        hidden = image and (
            image.GetVisibilityAttr().Get() == "invisible"
            or image.GetPurposeAttr().Get() in ("proxy", "guide")
        )
        looks = kind == "Scope" and not _has_mesh(prim)
        if kind in _NO_PARTS or hidden or looks or _is_light(prim, UsdLux):
            walk.PruneChildren()
            continue
        if kind not in _PARTS:
            rule = "Xform, Scope and Mesh prims alone"
            raise InputError(where, kind, rule, "make instances, curves and surfaces real meshes")
        number[prim.GetPath()] = len(number)
        check_node_count(name, len(number))
        yield prim, number.get(prim.GetParent().GetPath(), -1)


def _has_mesh(prim: "Usd.Prim") -> bool:
    from pxr import Usd

    every = Usd.PrimRange(prim, Usd.TraverseInstanceProxies(Usd.PrimDefaultPredicate))
    return any(str(each.GetTypeName()) == "Mesh" for each in every)


def _is_light(prim: "Usd.Prim", lux: Any) -> bool:
    return prim.HasAPI(lux.LightAPI) or bool(prim.IsA(lux.BoundableLightBase))


def _check_triangles(name: str, prims: list["Usd.Prim"]) -> None:
    """Foretell the triangles of all meshes before any is read."""
    from pxr import UsdGeom

    total = 0
    for prim in prims:
        if prim.IsA(UsdGeom.Mesh):
            mesh = UsdGeom.Mesh(prim)
            counts = np.asarray(mesh.GetFaceVertexCountsAttr().Get() or (), np.int64)
            if len(counts) and counts.min() < 3:
                where = f"{name}: node {prim.GetPath()}"
                raise InputError(where, int(counts.min()), "faces have three corners or more")
            total += int((counts - 2).sum())
            check_triangle_count(name, total)


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
    if not np.isfinite(frame).all():
        raise InputError(where, "a place that is no number", "places and scales are finite")
    if abs(np.linalg.det(frame[:3, :3])) < 1e-30:
        raise InputError(where, "a scale of 0", "a scale above or below 0 along every axis")
    said = {
        str(each.GetName()): _plain(each.Get())
        for each in prim.GetAttributes()
        if PREFIX in str(each.GetName())
    }
    mesh = None
    if prim.IsA(UsdGeom.Mesh):
        mesh = moved(read_mesh(where, UsdGeom.Mesh(prim)), frame)
    return Node(prim.GetName(), parent, frame, mesh, node_settings(where, said))


def _plain(value: Any) -> Any:
    """A value of USD as a plain number, text or list."""
    try:
        return [float(each) for each in value] if not isinstance(value, str) else value
    except TypeError:
        return value


def _first(error: Any) -> str:
    errors = error.args[0] if error.args else ()
    return _line(errors.commentary if hasattr(errors, "commentary") else str(error))


def _line(text: str) -> str:
    return " ".join(text.split())[:200]
