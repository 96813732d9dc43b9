"""Packs: what other programs read of them is what the reference was rendered from."""

import hashlib
import json
import math
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from bench.methods.environments import CYCLES
from bench.packs import make, part_file, pbrt
from bench.packs.content import SIZES, WORLDS, settings_of
from bench.packs.kept import read_kept
from bench.packs.reference import errors_between
from bench.submissions.executable import run_program
from bench.submissions.score import WITHIN
from lod.errors import InputError
from scenes.presets.load import load_preset
from scenes.render.exr.layer_file import read_pixels
from tests.bench.packs import pbrt_text

ROOT = Path(__file__).resolve().parents[3]
NO_CYCLES = pytest.mark.skipif(
    CYCLES.python() is None, reason="`lodbench environments cycles` makes it"
)


@pytest.mark.parametrize("name", ["crowd", "crowd-tiny", "sea-small", ""])
def test_other_names_are_refused(name: str) -> None:
    with pytest.raises(InputError, match="WORLD-SIZE"):
        settings_of(name)


@pytest.mark.parametrize("world", WORLDS)
@pytest.mark.parametrize("size", SIZES)
def test_a_window_holds_as_many_objects_as_the_name_says(world: str, size: str) -> None:
    preset = load_preset(*settings_of(f"{world}-{size}"))
    density = sum(each.density for each in preset.species.values()) * WORLDS[world].grown
    assert density * preset.world.extent**2 == pytest.approx(SIZES[size], rel=1e-3)
    assert preset.camera.speed > 0 and not any(s.patrol for s in preset.species.values())


def test_directions_of_the_sky_are_where_usd_and_pbrt_look() -> None:
    latlong = make._latlong()
    rows, columns = latlong.shape[:2]
    # OpenEXR: longitude falls from +π to −π, 0 is +z and π/2 is +x, +y is up; USD turns y to z.
    row, column = 37, 1234
    lat, lon = (math.pi * (k - (n + 0.5) / m) for k, n, m in ((0.5, row, rows), (1, column, rows)))
    x, y, z = math.sin(lon) * math.cos(lat), math.sin(lat), math.cos(lon) * math.cos(lat)
    np.testing.assert_allclose(latlong[row, column], (x, -z, y), atol=1e-12)
    assert columns == 2 * rows
    square = make._equal_area()
    np.testing.assert_allclose(np.linalg.norm(square, axis=-1), 1.0, atol=1e-12)
    # Equal areas: of the pixels as many lie above z as of the sphere; the middle is up.
    for z in (-0.7, 0.0, 0.2, 0.9):
        assert (square[..., 2] > z).mean() == pytest.approx((1 - z) / 2, abs=2e-3)
    assert square[len(square) // 2, len(square) // 2, 2] > 0.999
    assert square[len(square) // 2, -len(square) // 3, 0] > 0.4  # u to the right is east


@given(st.integers(1, 40), st.integers(0, 2**32 - 1))
def test_the_atlas_is_exact_between_its_texels(faces: int, seed: int) -> None:
    rng = np.random.default_rng(seed)
    colours = rng.uniform(0, 1, (faces, 3, 3))
    picture, places = pbrt.atlas_of(colours)
    weights = rng.dirichlet(np.ones(3), faces)
    side = len(picture)
    uv = np.einsum("fk,fkc->fc", weights, places)
    x, y = uv[:, 0] * side - 0.5, (1 - uv[:, 1]) * side - 0.5
    i, j = np.floor(y + 1e-9).astype(int), np.floor(x + 1e-9).astype(int)
    u, v = (x - j)[:, None], (y - i)[:, None]
    i1, j1 = np.minimum(i + 1, side - 1), np.minimum(j + 1, side - 1)
    top = (1 - u) * picture[i, j] + u * picture[i, j1]
    low = (1 - u) * picture[i1, j] + u * picture[i1, j1]
    wanted = np.einsum("fk,fkc->fc", weights, colours)
    np.testing.assert_allclose((1 - v) * top + v * low, wanted, atol=1e-5)


def small_tables() -> dict[str, np.ndarray]:
    """Two copies of a model of three parts, one below the other, which does not thin out."""
    tables = {
        name: np.zeros(n, kind)
        for (name, kind), n in zip(part_file.TABLES.items(), (1, 3, 0, 0, 0, 2), strict=True)
    }
    tables["models"]["parts"], tables["parts"]["parent"] = 3, (-1, 0, 1)
    tables["instances"]["first"] = (0, 3)
    return tables


def test_a_hierarchy_reads_back_and_one_cut_short_is_refused(tmp_path: Path) -> None:
    path, tables = tmp_path / "parts.bin", small_tables()
    part_file.write_tables(path, tables)
    for name, table in part_file.read_tables(path).items():
        assert np.array_equal(table, tables[name]), name
    path.write_bytes(path.read_bytes()[:-1])
    with pytest.raises(InputError, match="whole"):
        part_file.read_tables(path)


@pytest.mark.parametrize(
    ("rows", "rule"),
    [
        ([(0, 1), (4, 1)], "its owner is kept"),
        ([(0, 1), (6, 1)], "below 6"),
        ([(3, 1), (0, 1)], "numbers rise"),
        ([(0, math.nan)], "above 0"),
        ([(0, 2)], "does not thin out"),
        (None, "LODKEPT1"),
    ],
)
def test_what_cannot_have_been_kept_is_refused(tmp_path: Path, rows: list, rule: str) -> None:
    path = tmp_path / "kept.bin"
    path.write_bytes(
        b"nothing"
        if rows is None
        else part_file.KEPT_MAGIC + np.array(rows, part_file.KEPT).tobytes()
    )
    with pytest.raises(InputError, match=rule):
        read_kept(path, small_tables())


def test_kept_parts_read_back(tmp_path: Path) -> None:
    path = tmp_path / "kept.bin"
    rows = np.array([(0, 1), (3, 1), (4, 1), (5, 1)], part_file.KEPT)
    path.write_bytes(part_file.KEPT_MAGIC + rows.tobytes())
    part, width = read_kept(path, small_tables())
    assert part.tolist() == [0, 3, 4, 5] and width.tolist() == [1, 1, 1, 1]
    path.write_bytes(part_file.KEPT_MAGIC)  # a method may keep nothing
    assert not len(read_kept(path, small_tables())[0])


@pytest.fixture(scope="module")
def pack(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A small crowd with a small picture."""
    folder = tmp_path_factory.mktemp("pack") / "crowd"
    make.make_pack(folder, RECIPE, False, None, lambda *_: None)
    return folder


RECIPE = make.Recipe("crowd-small", (96, 54), 64)


def sums(folder: Path) -> dict[str, str]:
    lines = (folder / make.SUMS).read_text().splitlines()
    return dict(reversed(line.split("  ")) for line in lines)


@pytest.mark.slow
def test_a_stopped_command_goes_on_and_another_is_refused(pack: Path) -> None:
    before = sums(pack)
    for name, digest in before.items():
        assert hashlib.sha256((pack / name).read_bytes()).hexdigest() == digest
    for name in ("geometry.usdc", "scene.usda", "geometry.pbrt.gz", "parts.bin", "sky/latlong.exr"):
        (pack / name).unlink()
    (pack / "reference" / "still.exr").unlink()
    make.make_pack(pack, RECIPE, False, None, lambda *_: None)
    assert sums(pack) == before
    with pytest.raises(InputError, match="another folder"):
        make.make_pack(pack, RECIPE._replace(spp=128), False, None, lambda *_: None)


@pytest.mark.slow
def test_usd_has_all_there_is(pack: Path) -> None:
    from pxr import Usd, UsdGeom, UsdValidation

    told = make.read_pack(pack)
    stage = Usd.Stage.Open(str(pack / "scene.usda"))
    every = UsdValidation.ValidationRegistry().GetOrLoadAllValidators()
    assert not [e.GetMessage() for e in UsdValidation.ValidationContext(every).Validate(stage)]
    instancer = UsdGeom.PointInstancer(stage.GetPrimAtPath("/pack/instances"))
    which = np.array(instancer.GetProtoIndicesAttr().Get())
    assert len(which) == told["instances"]
    prims = [stage.GetPrimAtPath(p) for p in instancer.GetPrototypesRel().GetTargets()]
    curves, meshes = (
        [[kind(c) for c in p.GetChildren() if c.IsA(kind)] for p in prims]
        for kind in (UsdGeom.Curves, UsdGeom.Mesh)
    )
    sticks = [sum(n - 1 for c in row for n in c.GetCurveVertexCountsAttr().Get()) for row in curves]
    assert np.array(sticks)[which].sum() == told["sticks"]
    leaves = [sum(len(c.GetFaceVertexCountsAttr().Get()) for c in row) for row in meshes]
    (ground,) = (p for p in stage.Traverse() if p.IsA(UsdGeom.Mesh) and "ground" in p.GetName())
    level = len(UsdGeom.Mesh(ground).GetFaceVertexCountsAttr().Get())
    assert np.array(leaves)[which].sum() + level == told["triangles"] and level < told["triangles"]
    box = UsdGeom.BBoxCache(1, ["default"]).ComputeWorldBound(stage.GetPseudoRoot())
    found = box.ComputeAlignedRange()
    np.testing.assert_allclose([found.GetMin(), found.GetMax()], told["bounds_m"], atol=1e-3)
    choices = prims[0].GetVariantSets().GetVariantSet("LOD")
    assert choices.GetVariantSelection() == "LOD0"
    parts = []
    for name in choices.GetVariantNames():
        choices.SetVariantSelection(name)
        parts.append(
            sum(len(UsdGeom.PointBased(c).GetPointsAttr().Get()) for c in prims[0].GetChildren())
        )
    assert len(parts) > 2 and parts == sorted(parts, reverse=True) and parts[-1] < parts[0] / 4
    camera = UsdGeom.Camera(stage.GetPrimAtPath("/pack/walk")).GetCamera(24)
    eye = camera.transform.ExtractTranslation()
    np.testing.assert_allclose(eye, told["camera"]["walk"]["frames"][23]["eye"], atol=1e-9)
    assert camera.GetFieldOfView(camera.FOVHorizontal) == pytest.approx(60, abs=1e-4)


@pytest.mark.slow
def test_pbrt_has_all_there_is(pack: Path) -> None:
    from pxr import Usd, UsdGeom

    told, scene = make.read_pack(pack), pbrt_text.parse(pack / "still.pbrt")
    assert len(scene.instances) == told["instances"] and len(scene.objects) == told["prototypes"]
    sticks = {name: sum(s.kind == "curve" for s in o) for name, o in scene.objects.items()}
    assert sum(sticks[name] for name, _ in scene.instances) == told["sticks"]
    (ground,) = scene.shapes
    corners = {k: sum(len(s.given.get("indices", ())) for s in o) for k, o in scene.objects.items()}
    leaves = sum(corners[name] for name, _ in scene.instances)
    assert len(ground.given["indices"]) + leaves == 3 * told["triangles"] and leaves
    low, high = pbrt_text.points(ground)
    boxes = {k: np.array([pbrt_text.points(s) for s in o]) for k, o in scene.objects.items()}
    for name, place in scene.instances:
        box = np.stack((boxes[name][:, 0].min(axis=0), boxes[name][:, 1].max(axis=0)))
        at = place[:3, 3]
        reach = np.abs(box[:, :2]).max() * math.sqrt(2)
        low = np.minimum(low, (*(at[:2] - reach), at[2] + box[0, 2]))
        high = np.maximum(high, (*(at[:2] + reach), at[2] + box[1, 2]))
    # Boxes of curves in USD are as wide as their widest stick on all sides.
    np.testing.assert_allclose([low, high], told["bounds_m"], atol=0.5)
    stage = Usd.Stage.Open(str(pack / "geometry.usdc"))
    for name, shapes in scene.objects.items():
        prim = stage.GetPrimAtPath(f"/pack/instances/prototypes/{name}")
        usd = np.concatenate(
            [
                np.array(UsdGeom.Gprim(c).GetDisplayColorAttr().Get())
                for c in prim.GetChildren()
                if c.IsA(UsdGeom.Curves)
            ]
        )
        text = {tuple(s.material["reflectance"]) for s in shapes if s.kind == "curve"}
        assert text == {tuple(float(f"{x:.6g}") for x in each) for each in usd.tolist()}
    atlas, _ = read_pixels(pack / pbrt.ATLAS)
    picture = np.stack([atlas[c] for c in "RGB"], axis=-1)
    mesh = UsdGeom.Mesh(stage.GetPrimAtPath("/pack/ground"))
    colours = np.array(mesh.GetDisplayColorAttr().Get())[
        np.array(mesh.GetFaceVertexIndicesAttr().Get())
    ]
    uv = ground.given["uv"].reshape(-1, 2) * (1, -1) + (0, 1)
    x, y = np.floor(uv * len(picture)).astype(int).T
    np.testing.assert_allclose(picture[y, x], colours, rtol=1e-3)
    numbers = next(s[1] for s in scene.said if s[0] == "LookAt")
    np.testing.assert_allclose(numbers[:3], told["camera"]["still"]["eye"], atol=1e-6)


@pytest.mark.slow
def test_the_reference_says_how_noisy_it_is(pack: Path) -> None:
    still = make.read_pack(pack)["references"]["still"]
    channels, _ = read_pixels(pack / make.STILL)
    halves = [np.stack([channels[f"{h}.{c}"] for c in "RGB"], -1).astype(float) for h in "ab"]
    mean = np.stack([channels[c] for c in "RGB"], axis=-1)
    np.testing.assert_allclose(np.mean(halves, axis=0), mean, rtol=2e-3, atol=1e-5)
    again = errors_between(*halves)
    assert again["relmse"] == pytest.approx(still["noise"]["relmse"], rel=0.05)
    assert -1.6 < still["relmse_slope"] < -0.5
    assert sum(each["coverage"] for each in still["bands"]) == pytest.approx(1.0)
    shares = [float(channels[f"cover.{k}"].astype(float).mean()) for k in range(4)]
    np.testing.assert_allclose(shares, [b["coverage"] for b in still["bands"][:4]], atol=1e-3)


@pytest.mark.slow
@pytest.mark.skipif(shutil.which("cc") is None, reason="no C compiler here")
def test_a_method_in_c_enters(pack: Path, tmp_path: Path) -> None:
    from bench.packs.kept import render_kept

    told, method = make.read_pack(pack), tmp_path / "prune"
    source = ROOT / "examples" / "method_c" / "prune.c"
    assert source.read_text().count("\n") <= 80
    flags = ("-O2", "-std=c99", "-Wall", "-Wextra", "-Werror")
    subprocess.run(["cc", *flags, "-o", str(method), str(source), "-lm"], check=True)
    still = told["camera"]["still"]
    pixel = 2 * math.tan(math.radians(told["camera"]["fov_deg"] / 2)) / still["size"][0]
    channels, _ = read_pixels(pack / make.STILL)
    reference = np.stack([channels[c] for c in "RGB"], axis=-1).astype(float)
    errors, kept = [], []
    for knob in (0, 16):
        words = [pack / "parts.bin", *still["eye"], pixel, knob, tmp_path / "kept.bin"]
        done = subprocess.run([method, *map(str, words)], check=True, capture_output=True)
        kept.append(json.loads(done.stdout)["kept"])
        layers, counts = render_kept(pack, tmp_path / "kept.bin", spp=64)
        assert counts["parts"] == kept[-1]
        errors.append(errors_between(layers.rgb.astype(float), reference)["relmse"])
    assert kept[0] == told["parts"] > 10 * kept[1] > 0
    assert errors[0] < 2 * told["references"]["still"]["noise"]["relmse"] < errors[1]


@pytest.mark.slow
@NO_CYCLES
def test_blender_has_all_there_is(pack: Path) -> None:
    script = Path(__file__).parent / "blender_counts.py"
    words = [str(CYCLES.python()), str(script), str(pack / "scene.usda")]
    done = subprocess.run(words, check=True, capture_output=True, text=True)
    found, told = json.loads(done.stdout.splitlines()[-1]), make.read_pack(pack)
    assert {k: found[k] for k in ("instances", "sticks", "triangles")} == {
        k: told[k] for k in ("instances", "sticks", "triangles")
    }
    np.testing.assert_allclose(found["bounds_m"], told["bounds_m"], atol=1e-3)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "python", "knob"),
    [
        ("mitsuba", Path(sys.executable), 8),
        pytest.param("cycles", CYCLES.python(), 64, marks=NO_CYCLES),
    ],
)
def test_renderers_of_others_show_the_same_land(
    pack: Path, tmp_path: Path, name: str, python: Path, knob: float
) -> None:
    script = ROOT / "examples" / "runners" / f"{name}_runner.py"
    command = f"{python} {script} {{scene}} {{camera}} -o {{exr}} --knob {{knob}}"
    given = [knob], 1, tmp_path, "me", name, None, False, lambda *_: None
    still = run_program(pack, command, *given)[1]["settings"][0]["pictures"]["still"]
    assert still["void"] == ""
    assert still["land"] == pytest.approx(1, abs=WITHIN)
    assert still["coverage"] == pytest.approx(1, abs=WITHIN)
