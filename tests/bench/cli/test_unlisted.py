"""Cases that nobody had reported, ten of each class: hostile files, bad luck, other habits."""

import gzip
import json
import os
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from bench import runs
from bench.records.records import Column, content_sha256, read_record, write_record
from bench.report.write import write_report
from lod.errors import InputError
from scenes.imported.library import read_model, unpack
from scenes.presets.load import load_preset
from scenes.processes.cache import kept
from scenes.processes.ownership import owned
from tests.said import said
from tests.scenes.imported.sample_models import glb, lamp_tree_parts, mill
from tests.scenes.imported.test_broken_models import edited, gltf, usda
from tests.scenes.imported.test_colours import textured

ARRAY = {"a": np.arange(3.0)}


def picture_uri(uri: str) -> Callable[[Path], Path]:
    """A model whose texture is that file."""

    def change(header: dict[str, Any]) -> None:
        header |= {"images": [{"uri": uri}], "textures": [{"source": 0}]}
        textured = {"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}
        header["materials"][0] |= textured

    return gltf(change)


def pipe(place: Path) -> Path:
    os.mkfifo(place)
    return place


def pickled(place: Path) -> Path:
    with place.open("wb") as file:
        np.savez(file, about=np.array([os.system], object), a=np.array([os.system], object))
    return place


def usd_picture_is_a_pipe(folder: Path) -> Path:
    pipe(folder / "redgreen.png")
    return usda(textured())(folder)


def picture_by_a_link(folder: Path) -> Path:
    (folder / "in").mkdir()
    (folder / "secret.png").write_bytes(b"secret")
    (folder / "in" / "a.png").symlink_to(folder / "secret.png")
    return picture_uri("a.png")(folder / "in")


def picture_is_a_pipe(folder: Path) -> Path:
    return picture_uri(pipe(folder / "a.png").name)(folder)


HOSTILE = {
    "a texture that never ends, USD": (usd_picture_is_a_pipe, "a picture that is a file"),
    "a texture that never ends, glTF": (picture_is_a_pipe, "a file that is there"),
    "a file elsewhere, encoded": (picture_uri("%2e%2e/%2e%2e/etc/passwd"), "beside the model"),
    "a file elsewhere, by a link": (picture_by_a_link, "beside the model"),
    "a file elsewhere, by a scheme": (picture_uri("file:///etc/passwd"), "images.0"),
    "a model that is a pipe": (lambda folder: pipe(folder / "a.glb"), "a file that is there"),
    "commands to a terminal": (gltf(edited(2, name="\x1b[2Jx", scale=[0, 1, 1])), r"\\x1b\[2Jx"),
}


@pytest.mark.parametrize("case", HOSTILE)
def test_a_hostile_model_is_refused(tmp_path: Path, case: str) -> None:
    make, rule = HOSTILE[case]
    with pytest.raises(InputError, match=rule) as refused:
        read_model(make(tmp_path))
    assert "\x1b" not in str(refused.value)


def test_a_model_or_an_entry_of_objects_is_never_run(tmp_path: Path, monkeypatch: Any) -> None:
    with pytest.raises(InputError, match="add it again"):
        unpack(pickled(tmp_path / "a.npz").read_bytes(), "a")
    monkeypatch.setenv("LODBENCH_CACHE", str(tmp_path / "cache"))
    kept("tree", "a", lambda: ARRAY, ("lod.errors",))
    (entry,) = (tmp_path / "cache").glob("arrays/*/*")
    pickled(entry)
    assert kept("tree", "a", lambda: ARRAY, ("lod.errors",))["a"].tolist() == [0, 1, 2]


def test_a_report_stays_in_its_folder_and_calculates_nothing(record: Any, tmp_path: Path) -> None:
    (tmp_path / "in").mkdir()
    (tmp_path / "out").mkdir()
    first, *others = record.points
    formula = replace(first, samples=(Column("=1+1", [1, 2]), *first.samples))
    changed = replace(record, points=(formula, *others))
    write_record(changed, tmp_path / "in")
    write_report(tmp_path / "in")
    (table,) = (tmp_path / "in" / "tables").iterdir()
    assert ",'=1+1," in table.read_text() and ",=1+1," not in table.read_text()
    table.unlink()
    table.parent.rmdir()
    table.parent.symlink_to(tmp_path / "out")
    with pytest.raises(InputError, match="no link to another"):
        write_report(tmp_path / "in")
    assert not list((tmp_path / "out").iterdir())


POINT = {"case": {}, "predicted": [], "scene": ""}
SECONDS = {"seconds": 1.0, "processor_seconds": 1.0}


@pytest.mark.parametrize("value", [float("nan"), True, "1", [1]])
def test_a_case_of_other_numbers_is_measured_again(tmp_path: Path, value: Any) -> None:
    point = POINT | {"samples": [{"quantity": "parts", "values": [value], "keys": {}}]}
    data = {"points": [point], "made": SECONDS}
    (tmp_path / "a.json").write_text(json.dumps({"sha256": runs._sha256(data), "data": data}))
    assert runs._case(tmp_path / "a.json") is None and runs._case(tmp_path) is None


@pytest.mark.parametrize("how", ["cut off", "a number of 5000 digits", "a folder", "a key less"])
def test_a_record_that_cannot_be_is_left_out(record: Any, tmp_path: Path, how: str) -> None:
    whole = write_record(record, tmp_path)
    body = json.loads(whole.read_text())
    if how == "a key less":
        del body["content"]["points"][0]["scene"]
        body["sha256"] = content_sha256(body["content"])
    other = tmp_path / f"law-{body['sha256'][:16]}.json"
    if how == "cut off":
        other = whole.with_suffix(".json.gz")
        other.write_bytes(gzip.compress(whole.read_bytes())[:-20])
    elif how == "a folder":
        other = tmp_path / "law-0123456789abcdef.json"
        other.mkdir()
    else:
        text = json.dumps(body)
        other.write_text(text if how == "a key less" else text.replace(": 1,", f": {'1' * 5000},"))
    with pytest.raises(InputError):
        read_record(other)


def test_models_that_are_none_spoil_no_list(tmp_path: Path, monkeypatch: Any, capfd: Any) -> None:
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path))
    folder = tmp_path / "lodbench" / "models"
    (folder / "folder.npz").mkdir(parents=True)
    (folder / "gone.npz").symlink_to(folder / "nowhere")
    (folder / "a name.npz").write_bytes(b"")
    with (folder / "theirs.npz").open("wb") as file:
        np.savez(file, a=np.zeros(3))
    code, out, err = said(capfd, "model", "list", "--json")
    assert (code, json.loads(out)) == (0, {"models": {}})
    assert all(name in err for name in ("folder", "gone", "a name", "theirs"))
    for name in ("folder", "gone", "a name"):
        code, _, err = said(capfd, "model", "remove", name)
        assert (code, err.count("\n")) == (2, 1), err


def test_what_others_left_stops_no_command(tmp_path: Path, monkeypatch: Any, capfd: Any) -> None:
    (tmp_path / ".lodbench").mkdir()
    (tmp_path / ".lodbench" / "not json").write_text("{")
    (tmp_path / ".lodbench" / "folder").mkdir()
    with owned(tmp_path, "one", "works there"):
        pass
    pipe(tmp_path / "a.0001.exr")
    assert said(capfd, "verify", str(tmp_path))[0] in (1, 2)
    monkeypatch.setenv("LODBENCH_CACHE", "/dev/null")
    assert kept("tree", "a", lambda: ARRAY, ("lod.errors",)) is not None


@pytest.mark.parametrize("start", ["", "\ufeff"])
@pytest.mark.parametrize("end", ["\n", "\r\n"])
def test_a_preset_of_any_editor_is_read(tmp_path: Path, start: str, end: str) -> None:
    (tmp_path / "a.toml").write_bytes(f"{start}seed = 3{end}[render]{end}spp = 5{end}".encode())
    found = load_preset(str(tmp_path / "a.toml"))
    assert (found.seed, found.render.spp) == (3, 5)


@pytest.mark.parametrize(
    ("words", "rule"),
    [
        (("crowd.toml",), "UTF-8"),
        (("crowd", "--frame", "0"), "1<=x"),
        (("crowd", "-D", "camera.fps=24/0"), "fps"),
        (("crowd", "-D", "camera.fps=0/1001"), "fps"),
    ],
)
def test_a_habit_that_cannot_be_is_one_line(
    tmp_path: Path, monkeypatch: Any, capfd: Any, words: tuple[str, ...], rule: str
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "crowd.toml").write_text("seed = 3", encoding="utf-16")
    code, out, err = said(capfd, "count", *words)
    assert (code, out, err.count("\n"), rule in err) == (2, "", 1, True), err


def test_a_model_of_any_exporter_is_read(tmp_path: Path) -> None:
    whole = mill(tmp_path / "a.usda")
    one = read_model(whole).digest
    assert read_model(whole.rename(tmp_path / "A.USDA")).digest == one
    header, data = lamp_tree_parts()
    (tmp_path / "a.GLB").write_bytes(glb(header, data))
    whole = glb({**header, "extras": 0}, data)  # its text is filled up with zeros, not with spaces
    size = 20 + int.from_bytes(whole[12:16], "little")
    text = whole[20:size].replace(b', "extras": 0', b"").rstrip().ljust(size - 20, b"\0")
    (tmp_path / "z.glb").write_bytes(whole[:20] + text + whole[size:])
    assert read_model(tmp_path / "z.glb").digest == read_model(tmp_path / "a.GLB").digest
    (tmp_path / "a b.bin").write_bytes(data + bytes(4))
    header["buffers"][0]["uri"] = "a%20b.bin"
    (tmp_path / "a.gltf").write_text(json.dumps(header), encoding="utf-8-sig")
    assert read_model(tmp_path / "a.gltf").digest == read_model(tmp_path / "a.GLB").digest
