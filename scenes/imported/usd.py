"""Reading USD (.usda, .usdc, .usd, .usdz) into the nodes of a model.

Layers are composed as USD composes them: references, payloads and variants are those of the file,
and prims that are instances stand for themselves. Lengths are metres by ``metersPerUnit``, which is
0.01 where a file says nothing, and up is the file's ``upAxis``, y where it says nothing. What faces
+z with y up, or −y with z up, looks ahead. What varies in time is as it is in the file's first
frame. Materials are what the specification of UsdPreviewSurface 2.6 says of them.
"""

import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np

from lod.arrays import expand
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
from scenes.processes.streams import load_usd

MOST_TEXT_BYTES = 2**25  # of a layer that is text, which takes some 30 times as much memory
_MOST_FOLDED = 1e-3  # of the area of polygons, what their fans may cover beyond them

OBJECT_FROM_Z_UP = np.array([[0, -1, 0, 0], [1, 0, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1.0]])

_MOST_WORDS = 4 * MOST_NODES
"""``def`` in a text at most, before it is parsed: some stand for materials and not for nodes."""

_PARTS = ("", "Xform", "Scope", "Mesh", "PointInstancer")


def read_usd(path: Path, sidecar: Sidecar, note: Callable[[str], object]) -> list[Node]:
    """Read the nodes of a USD file, those above before those below.

    ``note`` is called with what is read otherwise than a renderer would. Raises InputError that
    names the prim and the rule.
    """
    load_usd()
    from pxr import Usd, UsdUtils

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
        _count_specs(path)
        stage = Usd.Stage.Open(str(path))
        if broken := stage.GetCompositionErrors():
            rule = "every layer and reference is there and none goes in a circle"
            where = f"{name}: node {broken[0].rootSite.path}" if broken[0].rootSite else name
            raise InputError(
                where, " ".join(str(broken[0]).split())[:200], rule, "flatten it: usdcat --flatten"
            )
        has_start, start_at = stage.HasAuthoredTimeCodeRange(), stage.GetStartTimeCode()
        time = Usd.TimeCode(start_at) if has_start else Usd.TimeCode.EarliestTime()
        if any(layer.ListAllTimeSamples() for layer in stage.GetUsedLayers()):
            note(f"{name}: of what varies in time, the first frame is read")
        world = _object_from_stage(name, stage, sidecar)
        return list(_walk(name, stage, world, time, note))
    finally:
        said.TakeUncoalescedDiagnostics()


def _count_specs(path: Path) -> None:
    """Refuse a layer of too many prims before it is composed, which takes memory for each."""
    from pxr import Sdf

    layer = Sdf.Layer.FindOrOpen(str(path))
    if layer is None:
        raise InputError(path.name, path.suffix, "a USD layer that can be read", "export it again")
    left, count, arcs = [layer.pseudoRoot], 0, bool(layer.subLayerPaths)
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


def _walk(
    name: str, stage: Any, world: np.ndarray, time: Any, note: Callable[[str], object]
) -> Iterator[Node]:
    """Nodes of the prims in the order of the file; below a point instancer, what it places."""
    from pxr import Gf, Usd, UsdGeom, UsdLux

    active = Usd.TraverseInstanceProxies(Usd.PrimIsActive & Usd.PrimIsLoaded)
    here = Gf.Matrix4d(1)
    left = [(stage.GetPseudoRoot(), "", -2, here)]
    nodes = triangles = smooth = 0
    row = -2
    while left:
        row += 1
        prim, called, parent, at = left.pop()
        kind, where = str(prim.GetTypeName()), f"{name}: node {prim.GetPath()}"
        image, xform, shape = UsdGeom.Imageable(prim), UsdGeom.Xformable(prim), UsdGeom.Mesh(prim)
        mesh = unclear = None
        passed = (
            kind == "Camera"
            or (prim.IsA(Usd.Typed) and not image)
            or (image and image.GetVisibilityAttr().Get(time) == "invisible")
            or (image and image.GetPurposeAttr().Get() in ("proxy", "guide"))
            or prim.HasAPI(UsdLux.LightAPI)
            or prim.IsA(UsdLux.BoundableLightBase)
        )
        if xform:
            at = xform.GetLocalTransformation(time) * (here if xform.GetResetXformStack() else at)
        frame = world @ np.array(at).T
        if not passed:
            check_node_count(name, nodes)
            nodes += 1
            if kind not in _PARTS:
                rule, cure = f"one of {', '.join(_PARTS[1:])}", "make curves and such real meshes"
                raise InputError(where, kind, rule, cure)
            check_frame(where, frame, "a scale of 0")
            if shape:
                scheme = shape.GetSubdivisionSchemeAttr()
                smooth += scheme.Get() != "none"
                if scheme.HasAuthoredValue() and scheme.Get() != "none":
                    rule, cure = "a mesh as it is seen", "tessellate it as you export"
                    raise InputError(where, f"a subdivision surface, {scheme.Get()}", rule, cure)
                mesh, unclear = _read_mesh(where, shape, time)
                mesh, triangles = moved(mesh, frame), triangles + len(mesh.faces)
                check_triangle_count(name, triangles)
            below = prim.GetFilteredChildren(active)  # in a prototype, those of a class as well
            status = prim.IsDefined(), prim.IsAbstract()
            same = [each for each in below if (each.IsDefined(), each.IsAbstract()) == status]
            placed = [(each, each.GetName(), here) for each in same]
            if kind == "PointInstancer":
                placed = _instances(where, UsdGeom.PointInstancer(prim), time)
                check_node_count(name, nodes + len(placed))
            left += [(each, called, row, place * at) for each, called, place in reversed(placed)]
        said = {each.GetName(): each for each in prim.GetAttributes() if PREFIX in each.GetName()}
        plain = {key: np.array(each.Get(time)).tolist() for key, each in said.items()}
        settings = node_settings(where, plain)
        if row >= 0:
            passed |= kind == "Scope"
            yield Node(called, parent, frame, mesh, settings, bool(passed), unclear)
    if smooth:
        note(f"{name}: {smooth} meshes do not say subdivisionScheme none: their cage is read")


def _instances(where: str, prim: Any, time: Any) -> list[tuple[Any, str, Any]]:
    """Prototype, name and matrix in the instancer's of each instance that is not masked."""
    targets = prim.GetPrototypesRel().GetForwardedTargets()
    made = [prim.GetPrim().GetStage().GetPrimAtPath(each) for each in targets]
    which = list(prim.GetProtoIndicesAttr().Get(time) or ())
    rule = prim.ExcludeProtoXform, prim.IgnoreMask
    places = prim.ComputeInstanceTransformsAtTime(time, time, *rule)
    if not all(made) or len(places) != len(which) or not set(which) <= set(range(len(made))):
        raise InputError(where, "protoIndices", "a place and a prototype for each instance")
    seen = prim.ComputeMaskAtTime(time) or [True] * len(which)
    rows = enumerate(zip(which, places, seen, strict=True))
    return [(made[k], f"{made[k].GetName()}_{n}", at) for n, (k, at, shown) in rows if shown]


def _object_from_stage(name: str, stage: Any, sidecar: Sidecar) -> np.ndarray:
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


def _read_mesh(where: str, mesh: Any, time: Any) -> tuple[Mesh, InputError | None]:
    """Read a mesh in its own frame; polygons become fans of triangles about their first corner.

    The second result says why its colours are not known. Raises InputError that names the prim.
    """
    from pxr import UsdGeom, UsdShade

    points = np.array(mesh.GetPointsAttr().Get(time) or (), np.float64).reshape(-1, 3)
    counts = np.array(mesh.GetFaceVertexCountsAttr().Get(time) or (), np.int64)
    corners = np.array(mesh.GetFaceVertexIndicesAttr().Get(time) or (), np.int64)
    if counts.sum() != len(corners):
        rule = f"as many corners as its faces have, {int(counts.sum())}"
        raise InputError(where, f"{len(corners)} corners", rule, "export it again")
    if len(counts) and counts.min() < 3:
        raise InputError(where, int(counts.min()), "faces have three corners or more")
    check_triangle_count(where, int((counts - 2).sum()))
    check_rows(where, corners, len(points))
    # Fans: rows of the corners of each triangle (t, 3).
    face, number = expand(counts - 2)
    start = (np.cumsum(counts) - counts)[face]
    fans = np.stack((start, start + number + 1, start + number + 2), axis=1)
    many = counts[face] > 3
    a, b, c = (points[corners[fans[many, k]]] for k in range(3))
    with np.errstate(over="ignore", invalid="ignore"):  # what is not finite is refused below
        normal = np.cross(b - a, c - a)
        total = np.stack([np.bincount(face[many], x, len(counts)) for x in normal.T], axis=1)
        turned = (normal * total[face[many]]).sum(axis=1) < 0
        area = np.linalg.norm(normal, axis=1)
    if area[turned].sum() > _MOST_FOLDED * area.sum():
        rule, cure = "convex polygons, or triangles", "triangulate it as you export"
        raise InputError(where, "faces that are not convex", rule, cure)
    fans = fans[~np.isin(face, mesh.GetHoleIndicesAttr().Get(time) or ())]
    if str(mesh.GetOrientationAttr().Get()) == "leftHanded":
        fans = fans[:, ::-1]
    around, _ = expand(counts)
    rows = {
        "constant": (1, np.zeros(len(corners), np.int64)),
        "uniform": (len(counts), around),
        "vertex": (len(points), corners),
        "varying": (len(points), corners),
        "faceVarying": (len(corners), np.arange(len(corners))),
    }

    def by_corner(values: Any, kind: object) -> np.ndarray | None:
        values = np.array(() if values is None else values, np.float64)
        size, row = rows.get("constant" if len(values) == 1 else str(kind), (0, corners))
        return values.reshape(size, -1)[row] if 0 < len(values) == size else None

    def primvar(name: str, needed: bool = True) -> np.ndarray | None:
        found = UsdGeom.PrimvarsAPI(mesh.GetPrim()).FindPrimvarWithInheritance(name)
        if not needed and not (found and found.HasValue()):
            return None
        kind = found.GetInterpolation() if found else "absent"
        made = by_corner(found.ComputeFlattened(time), kind) if found else None
        if made is None:
            rule = "as many values as its interpolation needs"
            raise InputError(where, f"primvars:{name}, {kind}", rule, "export it again")
        return made

    colours, bound, unclear = np.zeros((len(corners), 3)), np.zeros(len(corners), bool), None
    try:
        for each in (*UsdShade.MaterialBindingAPI(mesh).GetMaterialBindSubsets(), mesh):
            own = ~bound if each is mesh else np.isin(around, each.GetIndicesAttr().Get(time))
            bound |= own
            if own.any():
                colours[own] = _albedo(where, each.GetPrim(), primvar, colours, time)[own]
    except InputError as error:
        unclear = error
    except ValueError as error:
        unclear = InputError(where, f"its colours ({error})", "numbers, three of each colour")
    normals = by_corner(mesh.GetNormalsAttr().Get(time), mesh.GetNormalsInterpolation())
    # Corners of a point share a vertex unless colours or normals change from face to face.
    _, first, row = np.unique(corners, return_index=True, return_inverse=True)
    columns: list[Any] = [points[corners], colours, normals]
    if all(each is None or np.array_equal(each, each[first][row]) for each in columns):
        columns, fans = [None if each is None else each[first] for each in columns], row[fans]
    return checked_mesh(where, columns[0], fans, *columns[1:]), unclear


def _albedo(where: str, prim: Any, primvar: Any, like: np.ndarray, time: Any) -> np.ndarray:
    """Linear albedo (c, 3) of corners: of the material that is bound to a prim, or displayColor.

    Raises InputError where the way from the mesh to its colour is not one that is known here.
    """
    from pxr import Ar, UsdGeom, UsdShade

    def refuse(good: object, arrived: str, rule: str) -> None:
        if not good:
            cure = "bake the colour into one texture, or say albedo in FILE.toml"
            raise InputError(where, arrived, rule, cure)

    def end(shader: Any, name: str) -> Any:
        """The attribute that an input has its value from; None where there is none."""
        found = shader.GetInput(name)
        ends = UsdShade.Utils.GetValueProducingAttributes(found) if found else ()
        one = len(ends) == 1 or not (found and found.GetAttr().HasAuthoredConnections())
        refuse(one, f"{shader.GetPrim().GetName()}.{name}", "connected to one output that is there")
        return ends[0] if ends else None

    def constant(shader: Any, name: str, default: Any) -> Any:
        found = end(shader, name)
        network = found and UsdShade.Output.IsOutput(found)
        refuse(not network, f"{name} by a network", "a constant value")
        value = found.Get(time) if found else None
        return default if value is None else value

    def kind(shader: Any) -> str:
        return str(shader.GetIdAttr().Get()) if shader else "nothing"

    api = UsdShade.MaterialBindingAPI(prim)
    bound = [api.ComputeBoundMaterial(purpose) for purpose in ("preview", "full")]
    material = next((each for each, _ in bound if each), None)
    if material is None:
        refuse(not any(rel for _, rel in bound), "a material that is not there", "one that is")
        opacity, shown = primvar("displayOpacity", False), primvar("displayColor", False)
        refuse(opacity is None or opacity.min() >= 1, "displayOpacity", "opaque meshes alone")
        refuse(shown is not None, "no colour", "a material, or displayColor")
        return shown
    where = f"{where} material {material.GetPrim().GetName()}"
    surface = material.ComputeSurfaceSource()[0]
    refuse(kind(surface) == "UsdPreviewSurface", kind(surface), "a UsdPreviewSurface")
    refuse(constant(surface, "opacity", 1.0) >= 1, "opacity", "opaque materials alone")
    diffuse = end(surface, "diffuseColor")
    if diffuse is None or not UsdShade.Output.IsOutput(diffuse):
        mesh = UsdGeom.PrimvarsAPI(prim if prim.IsA(UsdGeom.Mesh) else prim.GetParent())
        painted = [each for each in mesh.GetPrimvars() if each.GetTypeName().role == "Color"]
        beside = {each.GetName() for each in painted} - {"primvars:displayColor"}
        beside |= {each.GetFullName() for each in material.GetSurfaceOutputs()[1:]}
        refuse(not beside, min(beside, default=""), "a plain colour and no others beside it")
        return np.full_like(like, constant(surface, "diffuseColor", (0.18,) * 3))  # its default
    texture = UsdShade.Shader(diffuse.GetPrim())
    if kind(texture) == "UsdPrimvarReader_float3":
        read: np.ndarray = primvar(constant(texture, "varname", ""))
        return read
    ways = kind(texture), diffuse.GetName()
    refuse(ways == ("UsdUVTexture", "outputs:rgb"), " ".join(ways), "a UsdUVTexture's rgb")
    reader = UsdShade.Shader(st.GetPrim()) if (st := end(texture, "st")) else None
    rule = "texture coordinates straight from a UsdPrimvarReader_float2"
    refuse(kind(reader) == "UsdPrimvarReader_float2", f"st of {kind(reader)}", rule)
    uv = primvar(constant(reader, "varname", ""))
    space = constant(texture, "sourceColorSpace", "auto")
    refuse(space in ("auto", "sRGB"), f"sourceColorSpace {space}", "a texture in sRGB")
    asset = constant(texture, "file", None)
    place = Path(asset.resolvedPath if asset and asset.resolvedPath else "no picture")
    refuse(place.is_file() or not place.exists(), str(place), "a picture that is a file")
    opened: Any = Ar.GetResolver().OpenAsset(Ar.ResolvedPath(asset.resolvedPath)) if asset else None
    refuse(opened, asset.path if asset else "no file", "a picture that is there")
    repeats = all(constant(texture, f"wrap{k}", "") == "repeat" for k in "ST")
    found = texture_colours(where, bytes(opened.GetBuffer()), uv, repeats, grey=space == "sRGB")
    scale = np.array(constant(texture, "scale", (1.0,) * 4))[:3]
    return found * scale + np.array(constant(texture, "bias", (0.0,) * 4))[:3]
