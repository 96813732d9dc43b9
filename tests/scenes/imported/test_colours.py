"""The way from a mesh to its colour: followed to its end, or refused by name."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

from bench.cli.main import main
from lod.errors import InputError
from scenes.imported.library import read_model
from scenes.imported.part_tree import texture_colours
from tests.scenes.imported.sample_models import glb, lamp_tree_parts
from tests.scenes.imported.test_broken_models import GREY, X, edited, usda

RED, GREEN = (230, 0, 0), (0, 200, 0)
LINEAR_RED, LINEAR_GREEN = (0.7913, 0.0, 0.0), (0.0, 0.5776, 0.0)
HALF_RED = tuple(x / 2 for x in LINEAR_RED)

MESH = """
point3f[] points = [(0,0,0),(1,0,0),(1,0,1),(0,0,1)]
int[] faceVertexCounts = [4]
int[] faceVertexIndices = [0,1,2,3]
uniform token subdivisionScheme = "none"
texCoord2f[] primvars:st = [(0.25,0.5)] (interpolation = "constant")
texCoord2f[] primvars:st1 = [(0.75,0.5)] (interpolation = "constant")
texCoord2f[] primvars:far = [(1.25,0.5)] (interpolation = "constant")
"""
SEEN = f"{MESH}{GREY}\n"


def picture(folder: Path, mode: str = "RGB") -> Path:
    """A picture whose left half is red and whose right half is green."""
    pixels = np.zeros((4, 4, 3), np.uint8)
    pixels[:, :2], pixels[:, 2:] = RED, GREEN
    image = Image.fromarray(pixels)
    if mode == "I;16":
        image = Image.fromarray(np.full((4, 4), 30_000, np.uint16))
    elif mode != "RGB":
        image = image.convert(mode)
    image.save(folder / "redgreen.png")
    return folder / "redgreen.png"


def textured(
    more: str = "", st: str = "</whole/m/reader.outputs:result>", varname: str = '"st"'
) -> str:
    """A quad whose material has a texture, by a reader of texture coordinates."""
    return f"""{X} def Mesh "c" (prepend apiSchemas = ["MaterialBindingAPI"]) {{{MESH}
rel material:binding = </whole/m> }}
def Material "m" {{ string inputs:frame = "st1"
token outputs:surface.connect = </whole/m/pbr.outputs:surface>
def Shader "pbr" {{ uniform token info:id = "UsdPreviewSurface"
color3f inputs:diffuseColor.connect = </whole/m/tex.outputs:rgb>
token outputs:surface }}
def Shader "tex" {{ uniform token info:id = "UsdUVTexture"
asset inputs:file = @./redgreen.png@
float2 inputs:st.connect = {st}
{more}
float3 outputs:rgb }}
def Shader "turn" {{ uniform token info:id = "UsdTransform2d"
float2 outputs:result }}
def Shader "reader" {{ uniform token info:id = "UsdPrimvarReader_float2"
string inputs:varname{".connect" if varname.startswith("<") else ""} = {varname}
float2 outputs:result }} }} }}"""


def surface(text: str, kind: str = "UsdPreviewSurface", mesh: str = "") -> str:
    """A quad whose material is a surface of these inputs."""
    return f"""{X} def Mesh "c" (prepend apiSchemas = ["MaterialBindingAPI"]) {{{MESH}{mesh}
rel material:binding = </whole/m> }}
def Material "m" {{ token outputs:surface.connect = </whole/m/pbr.outputs:surface>
def Shader "pbr" {{ uniform token info:id = "{kind}"
{text}
token outputs:surface }} }} }}"""


def plain(text: str, above: str = "") -> str:
    """A quad without a material."""
    return f'{X[:-1]} {{ {above}\ndef Mesh "c" {{{MESH}{text} }} }}'


FOLLOWED = {
    "a texture": (textured(), LINEAR_RED),
    "a set that the material names": (textured(varname="</whole/m.inputs:frame>"), LINEAR_GREEN),
    "scale": (textured("float4 inputs:scale = (0.5,0.5,0.5,1)"), HALF_RED),
    "bias": (textured("float4 inputs:bias = (0.1,0.1,0,0)"), (0.8913, 0.1, 0.0)),
    "repeat": (
        textured('token inputs:wrapS = "repeat"\ntoken inputs:wrapT = "repeat"', varname='"far"'),
        LINEAR_RED,
    ),
    "the surface's own default": (surface("float inputs:roughness = 1"), (0.18,) * 3),
    "points in time": (
        textured().replace("points = ", "points.timeSamples = { 3: ").replace(",1)]", ",1)] }", 1),
        LINEAR_RED,
    ),
    "displayColor from above": (
        plain("", 'color3f[] primvars:displayColor = [(0.1,0.4,0.2)] (interpolation = "constant")'),
        (0.1, 0.4, 0.2),
    ),
}


def albedo(path: Path) -> list[tuple[float, ...]]:
    """The distinct colours of a model."""
    found = np.unique(read_model(path).meshes.colours.round(4), axis=0)
    return [tuple(each) for each in found.tolist()]


@pytest.mark.parametrize(("text", "expected"), FOLLOWED.values(), ids=FOLLOWED)
def test_a_way_that_is_known_is_followed(text: str, expected: Any, tmp_path: Path) -> None:
    picture(tmp_path)
    (found,) = albedo(usda(text)(tmp_path))
    np.testing.assert_allclose(found, expected, atol=1e-4)


REFUSED = {
    "a transform": (textured(st="</whole/m/turn.outputs:result>"), "UsdTransform2d"),
    "coordinates of three numbers": (
        textured(varname='"three"').replace(
            "rel mat",
            'texCoord3f[] primvars:three = [(0,0,0)] (interpolation = "constant")\nrel mat',
        ),
        "numbers",
    ),
    "no coordinates": (textured(varname='"st7"'), "primvars:st7"),
    "a connection to nothing": (textured(st="</whole/m/gone.outputs:result>"), "tex.st"),
    "beyond a texture": (textured(varname='"far"'), "beyond its texture"),
    "a texture of numbers": (textured('token inputs:sourceColorSpace = "raw"'), "raw"),
    "another surface": (surface("", "ND_standard_surface"), "ND_standard_surface"),
    "a surface that is seen through": (surface("float inputs:opacity = 0"), "opacity"),
    "a mesh that is seen through": (
        plain('float[] primvars:displayOpacity = [0.5] (interpolation = "constant")'),
        "displayOpacity",
    ),
    "too few colours": (
        plain('color3f[] primvars:displayColor = [(0,0,0),(1,1,1)] (interpolation = "vertex")'),
        "primvars:displayColor, vertex",
    ),
    "no colour at all": (plain(""), "no colour"),
    "colours that nothing reads": (
        surface(
            "color3f inputs:diffuseColor = (0.2,0.4,0.1)",
            mesh='color4f[] primvars:Col = [(1,0,0,1)] (interpolation = "constant")',
        ),
        "primvars:Col",
    ),
    "another surface beside": (
        surface("color3f inputs:diffuseColor = (0.2,0.4,0.1)").replace(
            "token outputs:surface.connect",
            "token outputs:mtlx:surface.connect = </whole/m/pbr.outputs:surface>\n"
            "token outputs:surface.connect",
        ),
        "outputs:mtlx:surface",
    ),
    "no such material": (textured().replace("binding = </whole/m>", "binding = </no>"), "material"),
}


@pytest.mark.parametrize(("text", "said"), REFUSED.values(), ids=REFUSED)
def test_any_other_is_refused_by_name(text: str, said: str, tmp_path: Path) -> None:
    picture(tmp_path)
    path = usda(text)(tmp_path)
    with pytest.raises(InputError, match=said.replace(".", r"\.")) as refused:
        read_model(path)
    assert "node /whole/c" in str(refused.value)
    # What the table beside it says of the part goes before all of that.
    Path(f"{path}.toml").write_text('parts."whole/c".albedo = [0.5, 0.25, 0.125]')
    assert albedo(path) == [(0.5, 0.25, 0.125)]


@pytest.mark.parametrize("mode", ["I;16", "L", "CMYK"])
def test_a_picture_that_is_no_srgb_is_refused(mode: str, tmp_path: Path) -> None:
    if mode == "CMYK":
        picture(tmp_path)
        with Image.open(tmp_path / "redgreen.png") as image:
            image.convert(mode).save(tmp_path / "redgreen.png", "TIFF")
    else:
        picture(tmp_path, mode)
    with pytest.raises(InputError, match=f"mode {mode}"):
        read_model(usda(textured())(tmp_path))
    if mode == "I;16":
        path = lamp(lambda h: h.update(images=[{"uri": "deep.png"}]))(tmp_path)
        picture(tmp_path, mode).rename(tmp_path / "deep.png")
        with pytest.raises(InputError, match=f"mode {mode}"):
            read_model(path)
    if mode == "L":  # of one channel, but said to be coded
        (tmp_path / "b").mkdir()
        picture(tmp_path / "b", mode)
        read_model(usda(textured('token inputs:sourceColorSpace = "sRGB"'))(tmp_path / "b"))


def test_subsets_have_materials_of_their_own(tmp_path: Path) -> None:
    shader = 'uniform token info:id = "UsdPreviewSurface"\ntoken outputs:surface'
    materials = "".join(
        f"""def Material "{name}" {{
token outputs:surface.connect = </whole/{name}/s.outputs:surface>
def Shader "s" {{ {shader}
color3f inputs:diffuseColor = {colour} }} }}
"""
        for name, colour in (("red", (1, 0, 0)), ("green", (0, 1, 0)))
    )
    bound = '(prepend apiSchemas = ["MaterialBindingAPI"])'
    text = f"""{X} {materials} def Mesh "c" {bound} {{
point3f[] points = [(0,0,0),(1,0,0),(1,0,1),(0,0,1)]
int[] faceVertexCounts = [3,3]
int[] faceVertexIndices = [0,1,2,0,2,3]
rel material:binding = </whole/red>
def GeomSubset "some" {bound} {{ uniform token elementType = "face"
uniform token familyName = "materialBind"
int[] indices = [1]
rel material:binding = </whole/green> }} }} }}"""
    meshes = read_model(usda(text)(tmp_path)).meshes
    found = meshes.colours[meshes.faces]
    assert (found[0] == (1, 0, 0)).all() and (found[1] == (0, 1, 0)).all()


def lamp(change: Callable[[dict[str, Any]], object], u: float = 0.25) -> Callable[[Path], Path]:
    """The lamp-post tree, a texture on its trunk, all of it at (u, 0.5), then changed."""

    def make(folder: Path) -> Path:
        header, data = lamp_tree_parts()
        own = header["meshes"][0]["primitives"][0]["attributes"]
        count = header["accessors"][own["POSITION"]]["count"]
        uv = np.tile(np.array([u, 0.5], np.float32), (count, 1)).tobytes()
        view = {"buffer": 0, "byteOffset": len(data), "byteLength": len(uv)}
        header["bufferViews"].append(view)
        row = len(header["bufferViews"]) - 1
        entry = {"bufferView": row, "componentType": 5126, "count": count, "type": "VEC2"}
        header["accessors"].append(entry)
        own["TEXCOORD_0"] = own["TEXCOORD_1"] = len(header["accessors"]) - 1
        data += uv
        header["buffers"] = [{"byteLength": len(data)}]
        header |= {"textures": [{"source": 0, "sampler": 0}], "samplers": [{}]}
        header["images"] = [{"uri": picture(folder).name}]
        header["meshes"][0]["primitives"][0]["material"] = len(header["materials"])
        textured = {"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}
        header["materials"].append(textured)
        change(header)
        (folder / "a.glb").write_bytes(glb(header, data))
        return folder / "a.glb"

    return make


def texture(**entries: Any) -> Callable[[dict[str, Any]], object]:
    """Change what a material says of its texture."""
    return lambda h: h["materials"][-1]["pbrMetallicRoughness"]["baseColorTexture"].update(entries)


def material(**entries: Any) -> Callable[[dict[str, Any]], object]:
    """Change a material."""
    return lambda h: h["materials"][-1].update(entries)


@pytest.mark.parametrize(("u", "expected"), [(0.25, LINEAR_RED), (1.75, LINEAR_GREEN)])
def test_gltf_has_the_colour_of_its_texture(u: float, expected: Any, tmp_path: Path) -> None:
    tree = read_model(lamp(lambda h: None, u)(tmp_path))
    trunk = tree.meshes.colours[tree.meshes.vertex_owner == tree.names.index("lamp tree/trunk")]
    np.testing.assert_allclose(trunk, np.tile(expected, (len(trunk), 1)), atol=1e-4)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (texture(extensions={"KHR_texture_transform": {"offset": [0.5, 0]}}), "texture_transform"),
        (texture(texCoord=1), "TEXCOORD_1"),
        (material(extensions={"KHR_materials_pbrSpecularGlossiness": {}}), "SpecularGlossiness"),
        (material(extensions={"KHR_materials_transmission": {}}), "transmission"),
        (lambda h: h.update(samplers=[{"wrapS": 33071}]), "beyond its texture"),
        (material(pbrMetallicRoughness={}), "no colour"),
        (lambda h: h["meshes"][0]["primitives"][0].pop("material"), "no colour"),
    ],
)
def test_gltf_is_refused_by_name_as_well(change: Any, said: str, tmp_path: Path) -> None:
    path = lamp(change, 1.25)(tmp_path)
    with pytest.raises(InputError, match=said):
        read_model(path)
    Path(f"{path}.toml").write_text('parts."lamp tree".albedo = [0.5, 0.25, 0.125]')
    assert albedo(path) == [(0.5, 0.25, 0.125)]


def test_gltf_knows_what_leaves_the_colour_alone(tmp_path: Path) -> None:
    same = read_model(lamp(lambda h: None)(tmp_path)).digest
    sheen = {"KHR_materials_clearcoat": {"clearcoatFactor": 1.0}, "KHR_materials_ior": {}}
    assert read_model(lamp(material(extensions=sheen))(tmp_path)).digest == same


def test_the_first_frame_is_read_and_said(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    at = "xformOp:translate.timeSamples = { 1: (0,0,2), 9: (0,0,5) }"
    order = 'uniform token[] xformOpOrder = ["xformOp:translate"]'
    ghost = 'token visibility.timeSamples = { 1: "invisible", 9: "inherited" }'
    body = f"""{X} def Mesh "c" {{{SEEN}double3 {at}
{order} }}
def Mesh "ghost" {{{SEEN}{ghost} }} }}"""
    low = read_model(usda(f'(\nupAxis = "Z"\nmetersPerUnit = 1\n){body}')(tmp_path)).meshes.vertices
    assert low[:, 2].min() == 2 and low[:, 2].max() == 3
    head = '(\nupAxis = "Z"\nmetersPerUnit = 1\nstartTimeCode = 9\nendTimeCode = 9\n)'
    path = usda(f"{head}{body}")(tmp_path)
    tree = read_model(path)
    assert tree.meshes.vertices[:, 2].max() == 6 and len(tree.meshes) == 4
    with pytest.raises(SystemExit):
        main(("model", "show", str(path), "--json"))
    out, err = capfd.readouterr()
    assert "the first frame is read" in err
    assert json.loads(out)["high"][2] == 6


def test_cages_are_said_and_holes_are_left_out(tmp_path: Path) -> None:
    said: list[str] = []
    points = "point3f[] points = [(0,0,0),(1,0,0),(1,0,1),(0,0,1)]"
    faces = "int[] faceVertexCounts = [3,3]\nint[] faceVertexIndices = [0,1,2,0,2,3]"
    text = f'{X} def Mesh "c" {{{points}\n{faces}\n{GREY}\nint[] holeIndices = [1] }} }}'
    assert len(read_model(usda(text)(tmp_path), said.append).meshes) == 1
    assert "1 meshes do not say subdivisionScheme none: their cage is read" in said[0]


def test_what_an_instancer_places_stands_there(tmp_path: Path) -> None:
    text = f"""(
upAxis = "Z"
metersPerUnit = 1
){X} def PointInstancer "many" {{ int[] protoIndices = [0,1,0,0]
int64[] invisibleIds = [3]
point3f[] positions = [(0,0,0),(10,0,0),(20,0,0),(90,0,0)]
quath[] orientations = [(1,0,0,0),(1,0,0,0),(0,0,0,1),(1,0,0,0)]
float3[] scales = [(1,1,1),(2,2,2),(1,1,1),(1,1,1)]
rel prototypes = [</whole/many/leaf>, </whole/many/bough>]
def Mesh "leaf" {{{SEEN}double3 xformOp:translate = (0,0,5)
uniform token[] xformOpOrder = ["xformOp:translate"] }}
def Xform "bough" {{ def Mesh "c" {{{SEEN} }} def Mesh "d" {{{SEEN} }} }} }} }}"""
    tree = read_model(usda(text)(tmp_path))
    names = ("", "/leaf_0", "/leaf_2", "/bough_1", "/bough_1/c", "/bough_1/d")
    assert sorted(tree.names) == sorted(f"whole/many{each}" for each in names)
    assert len(tree.meshes) == 8
    own = tree.meshes.vertices[tree.meshes.vertex_owner == tree.names.index("whole/many/leaf_2")]
    # A half turn about z; x of the file is to the left of the model, its y behind it.
    np.testing.assert_allclose(own.max(axis=0), (0, 20, 6), atol=1e-3)
    np.testing.assert_allclose(own.min(axis=0), (0, 19, 5), atol=1e-3)


@pytest.mark.parametrize("above", ["over", "class"])
def test_prototypes_need_not_be_seen(above: str, tmp_path: Path) -> None:
    instancer = """def PointInstancer "many" { int[] protoIndices = [0,0]
point3f[] positions = [(0,0,0),(10,0,0)]
rel prototypes = </store/bough> }"""
    store = f'{above} "store" {{ def Xform "bough" {{ def Mesh "c" {{{SEEN} }} }} }}'
    tree = read_model(usda(f"{X} {instancer} }}\n{store}")(tmp_path))
    assert len(tree.meshes) == 4


def test_what_a_camera_leaves_empty_is_passed_over(tmp_path: Path) -> None:
    text = f"""{X} def Xform "rig" {{ def Xform "arm" {{ def Camera "eye" {{}} }} }}
def Scope "Looks" {{}} def Xform "lamps" {{ def SphereLight "sun" {{}} }}
def Mesh "c" {{TRIANGLE}} def Mesh "d" {{TRIANGLE}} }}"""
    assert sorted(read_model(usda(text)(tmp_path)).names) == ["whole", "whole/c", "whole/d"]
    header, data = lamp_tree_parts()
    edited(2, children=[len(header["nodes"]), len(header["nodes"]) + 1])(header)
    lamp = {"name": "lamp", "extensions": {"KHR_lights_punctual": {"light": 0}}}
    header["nodes"] += [{"name": "eye", "camera": 0}, lamp]
    (tmp_path / "a.glb").write_bytes(glb(header, data))
    assert "lamp tree/branch 0" not in read_model(tmp_path / "a.glb").names


def test_show_tells_colours_and_bounds(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    path = usda(surface("color3f inputs:diffuseColor = (0.25, 0.5, 0.125)"))(tmp_path)
    with pytest.raises(SystemExit):
        main(("model", "show", str(path), "--json"))
    found = json.loads(capfd.readouterr().out)
    assert found["colours"] == [{"albedo": [0.25, 0.5, 0.125], "triangles": 2}]
    assert (found["triangles"], found["low"]) == (2, [0.0, 0.0, 0.0])
    np.testing.assert_allclose(found["high"], (0.01, 0.01, 0.0), atol=1e-9)


def test_edges_of_a_texture_are_its_own() -> None:
    pixels = np.arange(48, dtype=np.uint8).reshape(4, 4, 3) * 5
    image = Image.fromarray(pixels)
    at = np.array([[0, 1], [1, 1], [0, 0], [1, 0], [0.5, 0.5]])  # v is up
    found = texture_colours("it", image, at, repeats=False)
    centres = np.array([[0.1, 0.9], [0.9, 0.9], [0.1, 0.1], [0.9, 0.1], [0.6, 0.4]])
    np.testing.assert_array_equal(found, texture_colours("it", image, centres, repeats=False))
    assert len(np.unique(found, axis=0)) == 5
    shifted = texture_colours("it", image, centres + np.array([3, -2]), repeats=True)
    np.testing.assert_array_equal(found, shifted)
