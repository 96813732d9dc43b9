"""A pack as USD: prototypes and a point instancer, curves, cameras, sun and sky.

``geometry.usdc`` has what stands there. Each prototype has a variant set ``LOD`` in the order of
the level-of-detail proposal (OpenUSD-proposals 81): LOD0, which is chosen, is everything, the next
leave out the finest level of parts, and the last is one blob. Its custom data says what the largest
part is that each leaves out. ``scene.usda`` adds the light and the cameras.
"""

from pathlib import Path
from typing import Any

import numpy as np

from bench.packs.content import WALK_FRAMES, Content
from scenes.processes.streams import load_usd
from scenes.render.description import Description
from scenes.render.usd_export import set_camera, set_curves, set_mesh

_ROOT = "/pack"


def write_geometry(path: Path, content: Content) -> None:
    """Write the ground, the prototypes with their levels, and where their copies stand."""
    load_usd()
    from pxr import Gf, UsdGeom, UsdShade, Vt

    stage = _stage(str(path))
    matte = _matte(stage)
    ground = set_mesh(stage, f"{_ROOT}/ground", content.ground)
    instancer = UsdGeom.PointInstancer.Define(stage, f"{_ROOT}/instances")
    models, which = content.distinct
    shelf = UsdGeom.Scope.Define(stage, f"{_ROOT}/instances/prototypes").GetPath()
    for row, model in enumerate(models):
        place = f"{shelf}/m{row:03d}"
        prim = UsdGeom.Xform.Define(stage, place).GetPrim()
        choices = prim.GetVariantSets().AddVariantSet("LOD")
        levels = [[shape for shape, _ in content.copies.models[model]], *content.levels[model]]
        for level, shapes in enumerate(levels):
            choices.AddVariant(f"LOD{level}")
            choices.SetVariantSelection(f"LOD{level}")
            with choices.GetVariantEditContext():
                _shapes(stage, place, shapes)
        choices.SetVariantSelection("LOD0")
        instancer.GetPrototypesRel().AddTarget(place)
    copies = content.copies
    half = np.arctan2(copies.turn[:, 1], copies.turn[:, 0]) / 2
    turn = np.stack((np.cos(half), 0 * half, 0 * half, np.sin(half)), axis=1)
    exact = [Gf.Quatf(w, Gf.Vec3f(x, y, z)) for w, x, y, z in turn.tolist()]
    instancer.CreateProtoIndicesAttr(Vt.IntArray.FromNumpy(which.astype(np.int32)))
    instancer.CreatePositionsAttr(Vt.Vec3fArray.FromNumpy(copies.place.astype(np.float32)))
    instancer.CreateOrientationsAttr(Vt.QuathArray([Gf.Quath(each) for each in exact]))
    instancer.CreateOrientationsfAttr(Vt.QuatfArray(exact))
    low, high = content.bounds()
    instancer.CreateExtentAttr(Vt.Vec3fArray([Gf.Vec3f(low), Gf.Vec3f(high)]))
    for each in (ground, instancer):
        UsdShade.MaterialBindingAPI.Apply(each.GetPrim()).Bind(matte)
    stage.GetRootLayer().Save()


def write_scene(path: Path, content: Content, light: dict[str, Any], notes: dict[str, str]) -> None:
    """Write the stage that has the geometry, the cameras, the sun and the sky."""
    from pxr import Gf, Usd, UsdGeom, UsdLux

    stage = _stage(str(path))
    root = stage.GetRootLayer()
    root.subLayerPaths.append("./geometry.usdc")
    root.customLayerData = notes
    stage.SetStartTimeCode(1)
    stage.SetEndTimeCode(WALK_FRAMES)
    stage.SetTimeCodesPerSecond(24)
    set_camera(UsdGeom.Camera.Define(stage, f"{_ROOT}/still"), content.made.camera)
    walk = UsdGeom.Camera.Define(stage, f"{_ROOT}/walk")
    for frame in range(1, WALK_FRAMES + 1):
        set_camera(walk, content.camera(frame), Usd.TimeCode(frame))
    sun = UsdLux.DistantLight.Define(stage, f"{_ROOT}/sun")
    strength = max(light["sun_irradiance"])
    sun.CreateAngleAttr(0.0)
    sun.CreateIntensityAttr(strength)
    sun.CreateColorAttr(Gf.Vec3f(*(each / strength for each in light["sun_irradiance"])))
    # It shines along its own −z.
    turn = Gf.Matrix4d().SetRotate(Gf.Rotation(Gf.Vec3d(0, 0, 1), Gf.Vec3d(*light["to_sun"])))
    sun.AddTransformOp().Set(turn)
    dome = UsdLux.DomeLight.Define(stage, f"{_ROOT}/sky")
    dome.CreateTextureFileAttr("./sky/latlong.exr")
    dome.CreateTextureFormatAttr(UsdLux.Tokens.latlong)
    dome.OrientToStageUpAxis()
    root.Save()


def _stage(path: str) -> Any:
    from pxr import Usd, UsdGeom

    stage = Usd.Stage.CreateNew(path)
    UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.z)
    UsdGeom.SetStageMetersPerUnit(stage, 1.0)
    stage.SetDefaultPrim(UsdGeom.Xform.Define(stage, _ROOT).GetPrim())
    return stage


def _shapes(stage: Any, place: str, shapes: list[Description]) -> None:
    for number, shape in enumerate(shapes):
        if shape["type"] == "mesh":
            set_mesh(stage, f"{place}/mesh{number}", shape)
            continue
        set_curves(stage, f"{place}/sticks{number}", shape)


def _matte(stage: Any) -> Any:
    from pxr import Sdf, UsdShade

    material = UsdShade.Material.Define(stage, f"{_ROOT}/matte")
    surface = UsdShade.Shader.Define(stage, f"{_ROOT}/matte/surface")
    reader = UsdShade.Shader.Define(stage, f"{_ROOT}/matte/albedo")
    reader.CreateIdAttr("UsdPrimvarReader_float3")
    reader.CreateInput("varname", Sdf.ValueTypeNames.String).Set("displayColor")
    result = reader.CreateOutput("result", Sdf.ValueTypeNames.Float3)
    surface.CreateIdAttr("UsdPreviewSurface")
    colour = surface.CreateInput("diffuseColor", Sdf.ValueTypeNames.Color3f)
    colour.ConnectToSource(result)
    surface.CreateInput("roughness", Sdf.ValueTypeNames.Float).Set(1.0)
    surface.CreateInput("useSpecularWorkflow", Sdf.ValueTypeNames.Int).Set(1)
    surface.CreateInput("specularColor", Sdf.ValueTypeNames.Color3f).Set((0.0, 0.0, 0.0))
    out = surface.CreateOutput("surface", Sdf.ValueTypeNames.Token)
    material.CreateSurfaceOutput().ConnectToSource(out)
    return material
