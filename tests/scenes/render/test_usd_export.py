"""A frame's cut as USD: every stick and triangle, the camera's view, and nothing half written."""

import math
import sys

import numpy as np
import pytest

from lod.errors import InputError
from scenes.frame.frame_input import FrameInput
from scenes.render.description import describe_frame
from scenes.render.usd_export import check_usd, write_usd

pxr = pytest.importorskip("pxr")


@pytest.fixture
def made(make):
    centres = [(x, 8.0, 1.0) for x in range(-3, 4)]
    visible = (make.balls(centres), make.ground())
    camera = make.camera((16, 9), heading=40.0, pitch=-5.0, fov=50.0)
    return FrameInput(camera, visible, make.clear, make.light, make.quality("scalar_rgb"))


@pytest.mark.parametrize("suffix", ["usda", "usdc"])
def test_everything_displayed_is_there_again(made, tmp_path, suffix):
    from pxr import Usd, UsdGeom

    path = tmp_path / f"a.{suffix}"
    counts = write_usd(path, made, {"lod:air": "clear"})
    assert [p.name for p in tmp_path.iterdir()] == [path.name]
    stage = Usd.Stage.Open(str(path))
    prims = list(stage.Traverse())
    shapes = describe_frame(made)["shapes"]
    (curves,) = (UsdGeom.BasisCurves(p) for p in prims if p.IsA(UsdGeom.BasisCurves))
    (mesh,) = (UsdGeom.Mesh(p) for p in prims if p.IsA(UsdGeom.Mesh))
    assert counts == {"curves": 1, "sticks": 7, "meshes": 1, "triangles": 2, "cameras": 1}
    per_curve = np.array(curves.GetCurveVertexCountsAttr().Get())
    points = np.array(curves.GetPointsAttr().Get())
    stick = next(s for s in shapes.values() if s["type"] == "linearcurve")
    assert (per_curve - 1).sum() == 7 and per_curve.sum() == len(points)
    assert np.array_equal(points, stick["control_points"][:, :3])
    assert np.allclose(curves.GetWidthsAttr().Get(), 1.0)
    assert curves.GetWidthsInterpolation() == "vertex"
    assert np.allclose(curves.GetDisplayColorAttr().Get(), 0.5)
    assert len(mesh.GetFaceVertexIndicesAttr().Get()) == 6
    low, high = curves.GetExtentAttr().Get()
    assert low[0] <= -3.5 and high[0] >= 3.5
    assert UsdGeom.GetStageUpAxis(stage) == "Z" and UsdGeom.GetStageMetersPerUnit(stage) == 1
    assert stage.GetRootLayer().customLayerData["lod:air"] == "clear"


def test_the_camera_sees_what_ours_sees(made, tmp_path):
    from pxr import Gf, Usd, UsdGeom

    write_usd(tmp_path / "a.usda", made, {})
    stage = Usd.Stage.Open(str(tmp_path / "a.usda"))
    frustum = UsdGeom.Camera.Get(stage, "/frame/camera").GetCamera().frustum
    assert np.allclose(frustum.GetPosition(), made.camera.eye)
    assert np.allclose(frustum.ComputeViewDirection(), made.camera.forward)
    assert np.allclose(frustum.ComputeUpVector(), made.camera.up)
    assert math.isclose(frustum.ComputeAspectRatio(), 16 / 9, rel_tol=1e-6)
    window = frustum.window.GetMax()
    assert math.isclose(window[0], math.tan(math.radians(25)), rel_tol=1e-6)
    assert isinstance(frustum, Gf.Frustum)
    camera = UsdGeom.Camera.Get(stage, "/frame/camera")  # in tenths of a unit, which is 1 m
    assert math.isclose(camera.GetHorizontalApertureAttr().Get() / 10, 0.036, rel_tol=1e-6)
    focal = camera.GetFocalLengthAttr().Get() / 10
    assert math.isclose(focal, 0.018 / math.tan(math.radians(25)), rel_tol=1e-6)


def test_every_validator_is_content(made, tmp_path):
    from pxr import Usd, UsdValidation

    write_usd(tmp_path / "a.usdc", made, {})
    validators = UsdValidation.ValidationRegistry().GetOrLoadAllValidators()
    stage = Usd.Stage.Open(str(tmp_path / "a.usdc"))
    errors = UsdValidation.ValidationContext(validators).Validate(stage)
    assert len(validators) > 10
    assert [error.GetMessage() for error in errors] == []


def test_a_name_or_an_installation_that_will_not_do(monkeypatch, tmp_path):
    with pytest.raises(InputError, match="usda"):
        check_usd(tmp_path / "a.obj")
    monkeypatch.setitem(sys.modules, "pxr", None)
    with pytest.raises(InputError, match=r"lodbench\[usd\]"):
        check_usd(tmp_path / "a.usda")


def test_a_disk_that_is_full_says_so_and_leaves_nothing(made, tmp_path, monkeypatch):
    from pxr import Tf as tf
    from pxr import Usd as usd

    monkeypatch.setattr(usd.Stage, "Export", lambda *_: tf.RaiseRuntimeError("full"))
    with pytest.raises(OSError, match=r"a\.usda: USD cannot write it; \d+ bytes are free there"):
        write_usd(tmp_path / "a.usda", made, {})
    assert list(tmp_path.iterdir()) == []
