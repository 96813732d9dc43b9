"""A frame's cut as USD, for other programs: what is displayed, and where the camera stands.

Sticks become linear curves with a width at every point, terrain a mesh, both with displayColor in
linear Rec.709; metres, z up, the origin at the frame's grid corner. Light, haze and materials are
not USD's here: the haze is noted in the layer's metadata. The extra ``usd`` brings pxr.
"""

import math
import shutil
from pathlib import Path
from typing import Any

import numpy as np

from lod.camera import Camera
from lod.errors import InputError
from scenes.files import check_free, check_name, whole_file
from scenes.frame.frame_input import FrameInput
from scenes.processes.streams import load_usd
from scenes.render.description import FAR_M, NEAR_M, Description, chains, describe_frame
from scenes.render.exr.header import camera_from_world, software

SUFFIXES = (".usda", ".usdc", ".usd")
_APERTURE = 0.36  # of 36 mm, in tenths of a scene unit, which is a metre


def check_usd(path: str | Path, overwrite: bool = False) -> None:
    """Raise InputError where USD is not installed, or the file's name is none of its, or taken."""
    if Path(path).suffix not in SUFFIXES:
        rule = f"a file that ends in {', '.join(SUFFIXES)}"
        raise InputError("-o", str(path), rule, "write NAME.usda")
    check_name(path)
    try:
        load_usd()
    except ImportError:
        rule, cure = "needs usd-core", "pip install 'lodbench[usd]'"
        raise InputError("-o", str(path), rule, cure) from None
    check_free(path, overwrite)


def write_usd(
    path: str | Path, frame_input: FrameInput, notes: dict[str, str], overwrite: bool = False
) -> dict[str, int]:
    """Write a frame's cut under its name or not at all; gives how many prims of each kind.

    Curves have one colour each, so the input's variant must be scalar (its sticks are by tint).

    notes: more to say in the layer's metadata. Raises InputError for a file that is there already,
    unless ``overwrite``, and OSError where the disk refuses.
    """
    from pxr import Tf, Usd, UsdGeom

    stage = Usd.Stage.CreateInMemory()
    UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.z)
    UsdGeom.SetStageMetersPerUnit(stage, 1.0)
    root = UsdGeom.Xform.Define(stage, "/frame")
    stage.SetDefaultPrim(root.GetPrim())
    corner = frame_input.camera.corner
    about = {"software": software(), "lod:corner": f"{corner.x},{corner.y}", **notes}
    stage.GetRootLayer().customLayerData = about
    set_camera(UsdGeom.Camera.Define(stage, "/frame/camera"), frame_input.camera)
    counts = {"curves": 0, "sticks": 0, "meshes": 0, "triangles": 0, "cameras": 1}
    for name, shape in describe_frame(frame_input)["shapes"].items():
        if shape["type"] == "mesh":
            set_mesh(stage, f"/frame/{name}", shape)
            counts["meshes"] += 1
            counts["triangles"] += len(shape["faces"])
        elif len(shape["segment_indices"]):
            set_curves(stage, f"/frame/{name}", shape)
            counts["curves"] += 1
            counts["sticks"] += len(shape["segment_indices"])
    with whole_file(path, overwrite) as temporary:
        temporary.touch()  # the system's own error, where it cannot be
        try:
            stage.Export(str(temporary))
        except Tf.ErrorException:
            free = shutil.disk_usage(temporary.parent).free
            raise OSError(f"{path}: USD cannot write it; {free} bytes are free there") from None
    return counts


def set_camera(prim: Any, camera: Camera, time: Any = None) -> None:
    """Give a camera's prim apertures and a focal length of its field of view, and its place.

    It looks along −z, as USD's do. ``time`` is a time code; None = at all times.
    """
    from pxr import Gf, Usd

    prim.CreateHorizontalApertureAttr(_APERTURE)
    prim.CreateVerticalApertureAttr(_APERTURE * camera.height / camera.width)
    focal = _APERTURE / (2 * math.tan(camera.fov_x / 2))
    prim.CreateFocalLengthAttr(focal)
    if camera.lens:
        # Of the same angles on this sensor: the opening, not the number, is what counts.
        prim.CreateFStopAttr(focal / 10 / camera.lens.diameter_m)
        prim.CreateFocusDistanceAttr(camera.lens.focus_m)
    prim.CreateClippingRangeAttr(Gf.Vec2f(NEAR_M, FAR_M))
    world_from_camera = np.linalg.inv(camera_from_world(camera))
    place = Gf.Matrix4d(world_from_camera.T.tolist())
    (prim.GetOrderedXformOps() or [prim.AddTransformOp()])[0].Set(
        place, Usd.TimeCode.Default() if time is None else time
    )


def set_curves(stage: Any, path: str, shape: Description) -> Any:
    """Define one linear curve for each chain of a described shape's sticks, and return the prim."""
    from pxr import UsdGeom, Vt

    points, counts, tints = chains(shape)
    prim = UsdGeom.BasisCurves.Define(stage, path)
    prim.CreateTypeAttr(UsdGeom.Tokens.linear)
    prim.CreateWrapAttr(UsdGeom.Tokens.nonperiodic)
    prim.CreateCurveVertexCountsAttr(Vt.IntArray.FromNumpy(counts.astype(np.int32)))
    _set_points(prim, points[:, :3], float(points[:, 3].max(initial=0.0)))
    prim.CreateWidthsAttr(Vt.FloatArray.FromNumpy(np.ascontiguousarray(2 * points[:, 3])))
    prim.SetWidthsInterpolation(UsdGeom.Tokens.vertex)
    if len(shape.get("tints", (None,))) == 1:
        _set_colour(prim, tints[:1], UsdGeom.Tokens.constant)
    else:
        _set_colour(prim, tints, UsdGeom.Tokens.uniform)
    return prim


def set_mesh(stage: Any, path: str, shape: Description) -> Any:
    """Define the prim of a described mesh, triangles with normals and colours, and return it."""
    from pxr import UsdGeom, Vt

    prim = UsdGeom.Mesh.Define(stage, path)
    faces = shape["faces"].astype(np.int32)
    prim.CreateFaceVertexCountsAttr(Vt.IntArray.FromNumpy(np.full(len(faces), 3, np.int32)))
    prim.CreateFaceVertexIndicesAttr(Vt.IntArray.FromNumpy(faces.reshape(-1)))
    prim.CreateSubdivisionSchemeAttr(UsdGeom.Tokens.none)
    prim.CreateDoubleSidedAttr(True)
    _set_points(prim, shape["vertices"], 0.0)
    prim.CreateNormalsAttr(Vt.Vec3fArray.FromNumpy(shape["normals"]))
    prim.SetNormalsInterpolation(UsdGeom.Tokens.vertex)
    _set_colour(prim, shape["colours"], UsdGeom.Tokens.vertex)
    return prim


def _set_points(prim: Any, points: np.ndarray, margin: float) -> None:
    from pxr import Vt

    points = np.ascontiguousarray(points, np.float32)
    extent = np.stack((points.min(axis=0) - margin, points.max(axis=0) + margin))
    prim.CreatePointsAttr(Vt.Vec3fArray.FromNumpy(points))
    prim.CreateExtentAttr(Vt.Vec3fArray.FromNumpy(extent.astype(np.float32)))


def _set_colour(prim: Any, colours: np.ndarray, interpolation: str) -> None:
    from pxr import Vt

    made = prim.CreateDisplayColorPrimvar(interpolation)
    made.Set(Vt.Vec3fArray.FromNumpy(np.ascontiguousarray(colours, np.float32)))
