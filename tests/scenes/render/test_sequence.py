"""Right frames are kept, strangers refused, damaged frames rendered again."""

import json
import os

import numpy as np
import pytest

from lod.errors import InputError
from scenes.render import sequence
from scenes.render.exr import read_exr
from scenes.render.frame import FrameInput, Layers
from scenes.render.sequence import frame_path, render_sequence

SETTINGS = {"seed": 5, "render": {"spp": 4, "size": "8x4"}}


@pytest.fixture(autouse=True)
def rendered(monkeypatch):
    """A renderer of no cost; gives the list of frames it was asked for."""
    asked = []

    def stand_in(camera, visible, air, light, quality, frame):
        asked.append(frame)
        ids = np.full((4, 8), frame)
        colour = np.full((4, 8, 3), quality.spp + frame / 100)
        return Layers(colour, ids, colour, colour / 200, ids, ids, ids, {"trace": 0.1}, {"n": 1})

    monkeypatch.setattr(sequence, "render_frame", stand_in)
    return asked


@pytest.fixture
def run(make, tmp_path):
    def go(frames=(1, 2, 3), settings=SETTINGS, overwrite=False, folder="out"):
        def make_frame(frame):
            quality = make.quality("scalar_rgb", settings["render"]["spp"])
            visible = (make.ground(),)
            return FrameInput(make.camera((8, 4)), visible, make.clear, make.light, quality)

        pattern = tmp_path / folder / "a.####.exr"
        return list(render_sequence(pattern, frames, make_frame, settings, overwrite))

    return go


def test_frames_records_and_manifest(run, tmp_path, rendered):
    records = run()
    assert rendered == [1, 2, 3] and [r["frame"] for r in records] == [1, 2, 3]
    manifest = json.loads((tmp_path / "out" / "manifest.json").read_text())
    for record in records:
        assert {"describe", "trace", "write", "prepare"} >= set(record["seconds"]) >= {"write"}
        assert record["peak_rss_bytes"] > 1e6 and record["kept"] is False
        name = f"a.{record['frame']:04d}.exr"
        assert manifest["frames"][name]["sha256"] == record["sha256"]
        _, header = read_exr(record["path"])
        assert header["lod:render.spp"] == "4" and header["lod:frame"] == str(record["frame"])
    names = sorted(path.name for path in (tmp_path / "out").iterdir())
    assert names == ["a.0001.exr", "a.0002.exr", "a.0003.exr", "manifest.json"]


def test_the_same_again_renders_nothing(run, rendered):
    first = run()
    again = run()
    assert rendered == [1, 2, 3]
    assert [r["sha256"] for r in again] == [r["sha256"] for r in first]
    assert all(r["kept"] for r in again)


def test_what_is_missing_or_damaged_is_rendered_again(run, rendered, tmp_path):
    first = run()
    (tmp_path / "out" / "a.0001.exr").unlink()
    damaged = tmp_path / "out" / "a.0003.exr"
    data = bytearray(damaged.read_bytes())
    data[len(data) // 2] ^= 4
    damaged.write_bytes(bytes(data))
    again = run(frames=(1, 2, 3, 4))
    assert rendered == [1, 2, 3, 1, 3, 4]
    assert [r["sha256"] for r in again[:3]] == [r["sha256"] for r in first]


def test_a_kill_right_after_the_rename_leaves_no_stranger(run, rendered, monkeypatch):
    really = os.replace

    def killed_once_there(source, target):
        really(source, target)
        if str(target).endswith(".exr"):
            raise KeyboardInterrupt

    with monkeypatch.context() as patch:
        patch.setattr(os, "replace", killed_once_there)
        with pytest.raises(KeyboardInterrupt):
            run(frames=(1,))
    assert [r["kept"] for r in run(frames=(1,))] == [True]
    assert rendered == [1]


def test_other_settings_are_refused_by_name_before_anything_is_rendered(run, rendered):
    run()
    other = {"seed": 5, "render": {"spp": 16, "size": "8x4"}}
    with pytest.raises(InputError, match=r"render\.spp: 4 → 16.*--overwrite"):
        run(frames=(0, 3), settings=other)
    assert rendered == [1, 2, 3]
    run(frames=(3,), settings=other, overwrite=True)
    with pytest.raises(InputError, match=r"render\.spp: 16 → 4"):
        run()


def test_a_file_that_is_not_ours_is_refused(run, tmp_path):
    (tmp_path / "out").mkdir()
    stranger = tmp_path / "out" / "a.0002.exr"
    stranger.write_text("someone's work")
    with pytest.raises(InputError, match="does not know"):
        run()
    assert stranger.read_text() == "someone's work"
    assert [r["kept"] for r in run(overwrite=True)] == [False] * 3


@pytest.mark.parametrize(
    "text", ["", "[]", "{}", '{"version": 9}', '{"version": 1, "settings": {}, "frames": {"a": 1}}']
)
def test_a_broken_manifest_is_refused_and_overwritten_on_demand(run, tmp_path, text):
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "manifest.json").write_text(text)
    with pytest.raises(InputError, match="manifest"):
        run()
    assert len(run(overwrite=True)) == 3 and all(r["kept"] for r in run())


def test_a_folder_that_cannot_be_made(run, tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError, match="folder"):
        run(folder="file/out")


def test_a_full_disk_harms_no_finished_frame(run, monkeypatch, tmp_path):
    run(frames=(1,))

    def full(*_):
        raise OSError(28, "No space left on device")

    with monkeypatch.context() as patch:
        patch.setattr("scenes.render.exr.os.fsync", full)
        with pytest.raises(OSError, match="No space"):
            run(frames=(1, 2))
    assert [r["kept"] for r in run(frames=(1, 2))] == [True, False]


@pytest.mark.parametrize("pattern", ["a.exr", "a.###.exr", "a.####.png", "a.####.####.exr", "####"])
def test_bad_patterns(pattern):
    with pytest.raises(InputError, match="####"):
        frame_path(pattern, 1)


def test_frame_numbers_grow_past_four_digits():
    assert frame_path("o/a.####.exr", 7).name == "a.0007.exr"
    assert frame_path("o/a.####.exr", 12345).name == "a.12345.exr"
