"""Models with one thing wrong, each refused in a line that names the node, or honoured."""

import json
import os
import resource
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import psutil
import pytest

from bench.cli.commands import model
from lod.errors import InputError
from scenes.imported import part_tree
from scenes.imported import usd as usd_module
from scenes.imported.library import keep_model, read_model
from tests.said import said
from tests.scenes.imported.sample_models import glb, lamp_tree, lamp_tree_parts, mill

MOST_S, MOST_BYTES = 20.0, 2.5e9

Case = tuple[str, Callable[[Path], Path], str, str]


def gltf(change: Callable[[dict[str, Any]], None], name: str = "a.glb") -> Callable[[Path], Path]:
    """The lamp-post tree with its header changed."""

    def make(folder: Path) -> Path:
        header, data = lamp_tree_parts()
        change(header)
        path = folder / name
        path.write_bytes(glb(header, data))
        return path

    return make


def edited(index: int, **entries: Any) -> Callable[[dict[str, Any]], None]:
    """Change entries of a node."""
    return lambda header: header["nodes"][index].update(entries)


def raw(name: str, data: bytes) -> Callable[[Path], Path]:
    """A file of these bytes."""

    def make(folder: Path) -> Path:
        (folder / name).write_bytes(data)
        return folder / name

    return make


GREY = 'color3f[] primvars:displayColor = [(0.5,0.5,0.5)] (interpolation = "constant")'


def usda(text: str) -> Callable[[Path], Path]:
    """A USD text file; a triangle stands wherever it says TRIANGLE."""
    points = "point3f[] points = [(0,0,0),(1,0,0),(0,1,0)]"
    faces = "int[] faceVertexCounts = [3]\nint[] faceVertexIndices = [0,1,2]"
    text = text.replace("TRIANGLE", f"{points}\n{faces}\n{GREY}")
    return raw("a.usda", f"#usda 1.0\n{text}".replace("{", "{\n").replace("}", "\n}\n").encode())


def truncated(folder: Path) -> Path:
    """A .glb that ends too soon."""
    path = lamp_tree(folder / "a.glb")
    path.write_bytes(path.read_bytes()[:5000])
    return path


def truncated_usdc(folder: Path) -> Path:
    """A .usdc that ends too soon."""
    path = mill(folder / "a.usdc")
    path.write_bytes(path.read_bytes()[:2000])
    return path


def spoilt_data(accessor: int, value: float) -> Callable[[Path], Path]:
    """The lamp-post tree with the first number of an accessor replaced."""

    def make(folder: Path) -> Path:
        header, data = lamp_tree_parts()
        start = header["bufferViews"][header["accessors"][accessor]["bufferView"]]["byteOffset"]
        changed = data[:start] + np.float32(value).tobytes() + data[start + 4 :]
        (folder / "a.glb").write_bytes(glb(header, changed))
        return folder / "a.glb"

    return make


def without_buffer(folder: Path) -> Path:
    """A .gltf whose .bin is not there."""
    path = lamp_tree(folder / "a.gltf")
    path.with_suffix(".bin").unlink()
    return path


def with_texture(folder: Path) -> Path:
    """A .glb that names a picture which is not there."""
    header, data = lamp_tree_parts()
    header["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"] = {"index": 0}
    header |= {"textures": [{"source": 0}], "images": [{"uri": "bark.png"}]}
    (folder / "a.glb").write_bytes(glb(header, data))
    return folder / "a.glb"


def folder_as_model(folder: Path) -> Path:
    """A folder whose name ends as a file's."""
    (folder / "a.glb").mkdir()
    return folder / "a.glb"


def many_nodes(folder: Path) -> Path:
    """A .gltf of twice the nodes that are allowed."""
    nodes = '{"name":""},' * 99_999 + "{}"
    text = f'{{"asset":{{"version":"2.0"}},"nodes":[{nodes}]}}'
    (folder / "a.gltf").write_text(text)
    return folder / "a.gltf"


def many_prims(folder: Path) -> Path:
    """A .usda of twice the prims that are allowed."""
    text = "#usda 1.0\n" + "".join(f'def "n{k}"{{}}\n' for k in range(100_000))
    (folder / "a.usda").write_text(text)
    return folder / "a.usda"


def many_triangles(header: dict[str, Any]) -> None:
    """Say that a mesh has thirty million corners, of which there are none."""
    header["accessors"][1]["count"] = 30_000_000


def sidecar(text: str) -> Callable[[Path], Path]:
    """The lamp-post tree with a table beside it."""

    def make(folder: Path) -> Path:
        path = lamp_tree(folder / "a.glb")
        (folder / "a.glb.toml").write_text(text)
        return path

    return make


def zero(header: dict[str, Any]) -> None:
    """All corners of the pane at one place."""
    header["accessors"][4] |= {"count": 8}
    header["nodes"][1] |= {"scale": [1.0, 0.0, 1.0]}


X = 'def Xform "whole" {'


def one_mesh(points: str, corners: int, indices: str) -> Callable[[Path], Path]:
    """A whole of one mesh of one face."""
    faces = f"int[] faceVertexCounts = [{corners}]\nint[] faceVertexIndices = [{indices}]"
    return usda(f'{X} def Mesh "c" {{point3f[] points = [{points}]\n{faces} }} }}')


REFUSED: tuple[Case, ...] = (
    ("truncated glb", truncated, "a.glb", "truncated"),
    ("truncated usdc", truncated_usdc, "a.usdc", "can be read"),
    ("binary garbage usd", raw("a.usdc", bytes(range(256)) * 40), "a.usdc", "can be read"),
    ("not a scene", raw("a.blend", b"BLENDER"), "a.blend", "a file that ends in"),
    ("text that is no USD", usda("def Xform {"), "a.usda", "can be read"),
    ("folder", folder_as_model, "a.glb", "a file that is there"),
    ("not there", lambda folder: folder / "none.glb", "none.glb", "a file that is there"),
    ("a node below itself", gltf(edited(3, children=[2])), "node branch 0", "never below itself"),
    ("a child that is not there", gltf(edited(2, children=[9999])), "node branch 0", "number of"),
    ("not a number", spoilt_data(0, np.nan), "node trunk", "vertices are finite"),
    ("too many empty nodes", many_nodes, "a.gltf", "at most 50000 nodes"),
    ("too many empty prims", many_prims, "a.usda", "at most 50000 nodes"),
    ("no meshes", usda(f'{X} def Xform "b" {{}} }}'), "a.usda", "ends of a model"),
    ("an empty node", gltf(edited(2, children=[])), "node lamp tree/branch 0", "has a mesh or"),
    (
        "an empty prim",
        usda(f'{X} def Xform "b" {{}} def Mesh "c" {{TRIANGLE}} }}'),
        "node whole/b",
        "has a mesh or",
    ),
    (
        "no unit",
        usda(f'(\nmetersPerUnit = 0\n)\n{X} def Mesh "c" {{TRIANGLE}} }}'),
        "metersPerUnit",
        "above 0 m",
    ),
    ("x up", usda(f'(\nupAxis = "X"\n)\n{X} def Mesh "c" {{TRIANGLE}} }}'), "a.usda", "Y or Z"),
    ("absurdly large", gltf(edited(0, scale=[1e6, 1e6, 1e6])), "a.glb", "0.001 to 10000 m"),
    ("flat scale", gltf(zero), "node trunk", "along every axis"),
    ("no buffer", without_buffer, "buffers.0", "a file that is there"),
    ("no texture", with_texture, "images.0", "a file that is there"),
    (
        "a file elsewhere",
        gltf(lambda h: h.update(images=[{"uri": "../../etc/passwd"}])),
        "images.0",
        "beside the model",
    ),
    ("too many triangles", gltf(many_triangles), "a.glb", "at most 2000000 triangles"),
    (
        "an unknown extension",
        gltf(lambda h: h.update(extensionsRequired=["KHR_draco_mesh_compression"])),
        "extensionsRequired",
        "without it",
    ),
    ("an old version", gltf(lambda h: h.update(asset={"version": "1.0"})), "asset", "glTF 2.0"),
    ("corners that are not there", one_mesh("(0,0,0)", 3, "0,1,2"), "node /whole/c", "0 to 0"),
    ("no area", one_mesh("(0,0,0),(1,0,0),(2,0,0)", 3, "0,1,2"), "node /whole/c", "has area"),
    (
        "a reference to itself",
        usda('def Xform "whole" (references = </whole>) {}'),
        "node /whole",
        "circle",
    ),
    (
        "a face that is not convex",
        one_mesh("(0,0,0),(1,0,0),(0.1,0,0.1),(0,0,1)", 4, "1,2,3,0"),
        "node /whole/c",
        "convex",
    ),
    (
        "a cage",
        usda(f'{X} def Mesh "c" {{TRIANGLE\nuniform token subdivisionScheme = "loop" }} }}'),
        "node /whole/c",
        "as it is seen",
    ),
    (
        "an instance of nothing",
        usda(f'{X} def PointInstancer "c" {{int[] protoIndices = [1]}} }}'),
        "node /whole/c",
        "a prototype",
    ),
    (
        "a material that is not there",
        gltf(lambda h: h["meshes"][0]["primitives"][0].update(material=99)),
        "a.glb",
        "; ",
    ),
    (
        "morph targets",
        gltf(lambda h: h["meshes"][0]["primitives"][0].update(targets=[{}])),
        "node trunk",
        "rigid",
    ),
    ("a skin", gltf(edited(1, skin=0)), "node trunk", "rigid"),
    (
        "see-through",
        gltf(
            lambda h: h["materials"][0].update(
                alphaMode="BLEND", pbrMetallicRoughness={"baseColorFactor": [1, 1, 1, 0.5]}
            )
        ),
        "node trunk",
        "opaque",
    ),
    (
        "an albedo of 2",
        gltf(
            lambda h: h["materials"][0].update(
                pbrMetallicRoughness={"baseColorFactor": [2, 1, 1, 1]}
            )
        ),
        "node trunk",
        "from 0 to 1",
    ),
    ("a level too high", gltf(edited(2, extras={"lod:level": 99})), "node branch 0", "64"),
    (
        "a level below its whole's",
        gltf(
            lambda h: (
                edited(2, extras={"lod:level": 3})(h),
                edited(4, extras={"lod:level": 2})(h),
            )[0]
        ),
        "branch 0/lamp 0 level",
        "at least 3",
    ),
    ("a table about nobody", sidecar("[parts.nobody]\nlevel = 1"), "parts.nobody", "the path of"),
)


@pytest.fixture
def run(tmp_path: Path, capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> Any:
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path / "data"))
    return partial(said, capfd)


@pytest.mark.parametrize(
    ("make", "where", "rule"), [c[1:] for c in REFUSED], ids=[c[0] for c in REFUSED]
)
def test_a_broken_model_is_refused_in_one_line(
    make: Callable[[Path], Path], where: str, rule: str, tmp_path: Path, run: Any
) -> None:
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024
    path, start = make(tmp_path), time.process_time()
    code, out, err = run("model", "add", str(path), "--name", "broken")
    assert code == 2, err
    assert time.process_time() - start < MOST_S
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024 - before < MOST_BYTES
    assert out == ""
    assert len(err.splitlines()) == 1, err
    assert where in err and rule in err, err
    assert "; " in err, f"names no cure: {err}"
    assert not (tmp_path / "data/lodbench/models/broken.npz").exists()


def digest(path: Path) -> str:
    return read_model(path).digest


TENFOLD = {
    "by references": lambda k, n: f'def Xform "c{n}" (references = @l{k}.usda@) {{}}',
    "by payloads": lambda k, n: f'def Xform "c{n}" (payload = @l{k}.usda@) {{}}',
    "in variants": lambda k, n: (
        f'def Xform "c{n}" (\nvariants = {{\nstring v = "a"\n}}\nprepend variantSets = "v"\n) '
        f'{{\nvariantSet "v" = {{\n"a" (references = @l{k}.usda@) {{\n}}\n}}\n}}'
    ),
}


@pytest.mark.parametrize("arc", TENFOLD)
def test_layers_that_grow_tenfold_are_refused_in_time(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, arc: str
) -> None:
    """Twelve small files are 10¹² nodes; where each refers to the next once, they are twelve."""
    monkeypatch.setattr(usd_module, "MOST_COMPOSED_S", 2)
    for times in (1, 10):
        folder = tmp_path / f"{times}"
        folder.mkdir()
        with pytest.raises(InputError) as refused:
            read_model(tenfold(folder, times, arc))
        assert ("composes within" in str(refused.value)) == (times == 10), refused.value


def tenfold(folder: Path, times: int, arc: str) -> Path:
    for k in range(13):
        below = "\n".join(TENFOLD[arc](k + 1, n) for n in range(times)) if k < 12 else ""
        text = f'#usda 1.0\n(defaultPrim = "r")\ndef Xform "r" {{\n{below}\n}}\n'
        (folder / f"l{k}.usda").write_text(text)
    return folder / "l0.usda"


def test_nodes_are_counted_after_composition(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(part_tree, "MOST_NODES", 500)
    many = "".join(f'def "n{k}"{{}}\n' for k in range(300))
    (tmp_path / "l.usda").write_text(f'#usda 1.0\n(defaultPrim = "r")\ndef "r" {{\n{many}}}\n')
    twice = "".join(f'def "{k}" (references = @l.usda@) {{}}\n' for k in "ab")
    with pytest.raises(InputError, match="at most 500 nodes"):
        read_model(usda(f"{X} {twice} }}")(tmp_path))


def test_ctrl_c_ends_layers_that_grow_tenfold(tmp_path: Path) -> None:
    words = [sys.executable, "-m", "bench.cli.main", "model", "show"]
    words.append(str(tenfold(tmp_path, 10, "by references")))
    program = subprocess.Popen(words, stderr=subprocess.PIPE, text=True, start_new_session=True)
    whole = psutil.Process(program.pid)
    while not (composing := whole.children()):
        assert program.poll() is None
        time.sleep(0.05)
    time.sleep(1)
    os.killpg(program.pid, signal.SIGINT)  # as a terminal does
    _, err = program.communicate(timeout=10)
    assert (program.returncode, err) == (130, "lodbench: interrupted\n")
    assert not any(each.is_running() for each in composing)


def test_namesakes_are_numbered(tmp_path: Path) -> None:
    names = read_model(lamp_tree(tmp_path / "a.glb")).names
    assert len(set(names)) == len(names)
    assert {"lamp tree/branch 0/leaf", "lamp tree/branch 0/leaf (2)"} <= set(names)


def test_a_mirror_keeps_faces_outwards(tmp_path: Path) -> None:
    plain = read_model(lamp_tree(tmp_path / "a.glb")).meshes
    mirrored = read_model(gltf(edited(0, scale=[-1.0, 1.0, 1.0]))(tmp_path)).meshes
    assert signed_volume(mirrored) == pytest.approx(signed_volume(plain))
    assert signed_volume(plain) > 0
    np.testing.assert_allclose(mirrored.vertices[:, 1], -plain.vertices[:, 1], atol=1e-12)


def signed_volume(meshes: Any) -> float:
    a, b, c = (meshes.vertices[meshes.faces[:, k]] for k in range(3))
    return float(np.einsum("ij,ij->", a, np.cross(b, c))) / 6


def test_triangles_without_area_are_left_out(tmp_path: Path) -> None:
    make = usda(
        f'{X} def Mesh "c" {{point3f[] points = [(0,0,0),(1,0,0),(0,1,0),(2,0,0)]\n'
        f"int[] faceVertexCounts = [3,3]\nint[] faceVertexIndices = [0,1,2,0,1,3]\n{GREY} }} }}"
    )
    assert len(read_model(make(tmp_path)).meshes) == 1


def test_polygons_are_fans(tmp_path: Path) -> None:
    meshes = read_model(mill(tmp_path / "a.usda")).meshes
    assert len(meshes) == 2 * (12 * 2 + 10) + 4 * (8 * 2 + 6) + 12 + 72 * 12


def test_instances_stand_for_themselves(tmp_path: Path) -> None:
    make = usda(
        'class Xform "proto" { def Mesh "c" {TRIANGLE} def Mesh "d" {TRIANGLE} }\n'
        f'{X} def Xform "a" (instanceable = true\nreferences = </proto>) {{}}\n'
        'def Xform "b" (instanceable = true\nreferences = </proto>) {} }'
    )
    tree = read_model(make(tmp_path))
    assert sorted(tree.names) == [
        "whole",
        *(f"whole/{k}{rest}" for k in "ab" for rest in ("", "/c", "/d")),
    ]


@pytest.mark.parametrize(("unit", "up"), [(0.01, "Y"), (1.0, "Z"), (0.0254, "Y")])
def test_units_and_up_are_honoured(tmp_path: Path, unit: float, up: str) -> None:
    make = usda(f'(\nmetersPerUnit = {unit}\nupAxis = "{up}"\n)\n{X} def Mesh "c" {{TRIANGLE}} }}')
    high = read_model(make(tmp_path)).meshes.vertices.max(axis=0)
    # The triangle reaches 1 along x, to the left of its front, and 1 along y: up, or behind it.
    expected = (0.0, 1.0, 1.0) if up == "Y" else (0.0, 1.0, 0.0)
    np.testing.assert_allclose(high, np.multiply(expected, unit), atol=1e-9)


def test_the_same_scene_in_four_files_is_one_model(tmp_path: Path) -> None:
    assert digest(mill(tmp_path / "a.usda")) == digest(mill(tmp_path / "b.usdc"))
    assert digest(lamp_tree(tmp_path / "a.gltf")) == digest(lamp_tree(tmp_path / "b.glb"))


def test_every_change_makes_it_another_model(tmp_path: Path) -> None:
    found = [
        digest(gltf(change)(tmp_path))
        for change in (
            lambda h: None,
            edited(1, name="stem"),
            edited(1, translation=[0.0, 1e-6, 0.0]),
            edited(2, extras={"lod:level": 2}),
            edited(2, extras={"lod:albedo": [0.5, 0.5, 0.5]}),
            edited(2, extras={"lod:axis": [0, 1, 0]}),
        )
    ]
    found.append(digest(sidecar("period = 3.0")(tmp_path)))
    found.append(digest(sidecar("metres_per_unit = 0.5")(tmp_path)))
    assert len(set(found)) == len(found)


def test_a_sidecar_goes_before_the_file(tmp_path: Path) -> None:
    path = sidecar('[parts."lamp tree/branch 0"]\nalbedo = [0.5, 0.25, 0.125]')(tmp_path)
    tree = read_model(path)
    own = [k for k, name in enumerate(tree.names) if name.startswith("lamp tree/branch 0")]
    inside = np.isin(tree.meshes.vertex_owner, own)
    assert inside.any() and not inside.all()
    expected = np.all(tree.meshes.colours == (0.5, 0.25, 0.125), axis=1)
    np.testing.assert_array_equal(expected, inside)


def test_models_are_kept_listed_and_removed(
    tmp_path: Path, run: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(model, "_picture", lambda *_: None)
    path = str(lamp_tree(tmp_path / "lamps.glb"))
    assert run("model", "add", path)[0] == 0
    code, _, err = run("model", "add", path)
    assert (code, "a new name" in err) == (2, True)
    keep_model("lamps", read_model(Path(path)), overwrite=True)
    code, _, err = run("model", "add", path, "--name", "tree")
    assert (code, "built-in" in err) == (2, True)
    code, out, _ = run("model", "list", "--json")
    listed = json.loads(out)["models"]
    assert code == 0 and list(listed) == ["lamps"]
    code, out, _ = run("model", "show", "lamps", "--json")
    assert json.loads(out)["sha256"] == listed["lamps"]["sha256"] == digest(Path(path))
    assert run("model", "remove", "lamps")[0] == 0
    assert run("model", "remove", "lamps")[0] == 2
    kept = tmp_path / "data/lodbench/models/lamps.npz"
    kept.write_bytes(b"PK not an archive")
    code, _, err = run("model", "show", "lamps")
    assert (code, len(err.splitlines())) == (2, 1)
