"""Right frames are kept, files of others refused, and what is left of damaged frames replaced."""

import errno
import os
import socket

import numpy as np
import pytest

from lod.errors import InputError
from scenes.files import DiskError
from scenes.frame.layers import Layers
from scenes.presets.load import preset_from
from scenes.render.exr.frames_on_disk import (
    FrameFailed,
    open_job,
    read_whole,
    render_sequence,
    settings_hash,
)
from scenes.render.exr.header import frame_settings, settings_attributes
from scenes.render.exr.layer_file import read_exr, write_exr

SETTINGS = frame_settings(preset_from({"render": {"size": "8x4", "spp": 4}}), "scalar_rgb")
OTHER = frame_settings(preset_from({"render": {"size": "8x4", "spp": 16}}), "scalar_rgb")


class Renderer:
    """One of no cost; ``asked`` are the frames it was asked for, ``trouble`` what some meet."""

    def __init__(self):
        self.asked, self.trouble = [], {}

    def __call__(self, settings, frame, target):
        self.asked.append(frame)
        if frame in self.trouble:
            target.write_text("half a frame")
            raise self.trouble[frame]
        ids = np.full((4, 8), frame)
        colour = np.full((4, 8, 3), settings["render"]["spp"] + frame / 100)
        layers = Layers(colour, ids, colour, colour / 200, ids, ids, ids)
        digest = write_exr(target, layers, settings_attributes(settings, frame))
        seconds, statistics = {"trace": 0.1}, {"n": 1}
        record = {"frame": frame, "sha256": digest, "seconds": seconds, "peak_rss_bytes": 2e9}
        return {**record, "statistics": statistics}


@pytest.fixture
def renderer():
    return Renderer()


@pytest.fixture
def rendered(renderer):
    return renderer.asked


@pytest.fixture
def run(tmp_path, renderer):
    def go(frames=(1, 2, 3), settings=SETTINGS, overwrite=False, folder="out"):
        job = open_job(tmp_path / folder / "a.####.exr", frames, settings, overwrite)
        return list(render_sequence(job, renderer))

    return go


def names(folder):
    return sorted(path.name for path in folder.iterdir())


def test_a_frame_is_its_own_record(run, tmp_path, rendered):
    records = run()
    assert rendered == [1, 2, 3] and [r["frame"] for r in records] == [1, 2, 3]
    for record in records:
        assert record["peak_rss_bytes"] > 1e6 and record["kept"] is False
        whole = read_whole(record["path"])
        assert whole == (record["frame"], SETTINGS, record["sha256"])
        assert settings_hash(whole.settings) == settings_hash(SETTINGS)
        assert read_exr(record["path"])[1]["lod:frame"] == record["frame"]
    assert names(tmp_path / "out") == ["a.0001.exr", "a.0002.exr", "a.0003.exr"]


def test_the_same_again_renders_nothing(run, rendered):
    first = run()
    again = run()
    assert rendered == [1, 2, 3]
    assert [r["sha256"] for r in again] == [r["sha256"] for r in first]
    assert all(r["kept"] for r in again)


def flip(path, at=-20):
    data = bytearray(path.read_bytes())
    data[at] ^= 1
    path.write_bytes(bytes(data))


DAMAGE = {
    "gone": lambda path: path.unlink(),
    "empty": lambda path: path.write_bytes(b""),
    "zeros": lambda path: path.write_bytes(bytes(path.stat().st_size)),
    "truncated": lambda path: path.write_bytes(path.read_bytes()[:900]),
    "one bit": flip,
    "one bit of its settings": lambda path: flip(path, path.read_bytes().index(b"preset.seed") + 4),
    "another frame": lambda path: path.write_bytes(
        path.with_name("a.0001.exr").read_bytes(),
    ),
}


@pytest.mark.parametrize("damage", DAMAGE)
def test_what_is_left_of_a_damaged_frame_is_rendered_again_alone(run, tmp_path, rendered, damage):
    first = run()
    DAMAGE[damage](tmp_path / "out" / "a.0002.exr")
    again = run()
    assert rendered == [1, 2, 3, 2]
    assert [r["kept"] for r in again] == [True, False, True]
    assert [r["sha256"] for r in again] == [r["sha256"] for r in first]


def test_other_settings_are_refused_by_name_before_anything_is_rendered(run, rendered):
    run()
    with pytest.raises(InputError, match=r"other settings \(render\.spp: 4 → 16.*--overwrite"):
        run(frames=(0, 3), settings=OTHER)
    assert rendered == [1, 2, 3]
    run(frames=(3,), settings=OTHER, overwrite=True)
    with pytest.raises(InputError, match=r"render\.spp: 16 → 4"):
        run()


def test_frames_of_another_version_are_refused_by_its_name(run):
    run(settings={**SETTINGS, "software": "lodbench 0.1 (Mitsuba 3.0)"})
    with pytest.raises(InputError, match=r"software: lodbench 0\.1 \(Mitsuba 3\.0\) → lodbench"):
        run()


def test_a_version_is_named_before_the_keys_that_it_has_otherwise(run):
    older = {**SETTINGS, "a": 1, "b": 2, "c": 3, "d": 4, "software": "lodbench 0.1 (Mitsuba 3.0)"}
    run(settings=older)
    with pytest.raises(InputError, match=r"\(software: lodbench 0\.1 .*; a: 1 → absent; b: 2"):
        run()


def test_a_file_that_is_not_ours_is_refused(run, tmp_path):
    (tmp_path / "out").mkdir()
    stranger = tmp_path / "out" / "a.0002.exr"
    stranger.write_text("someone's work")
    with pytest.raises(InputError, match="no frame of lodbench"):
        run()
    assert stranger.read_text() == "someone's work"
    assert [r["kept"] for r in run(overwrite=True)] == [False] * 3


@pytest.mark.parametrize("links", [True, False])
def test_what_comes_while_a_frame_is_rendered_is_not_replaced(
    run, tmp_path, renderer, monkeypatch, links
):
    """By another's settings or hand; the same frame of another process is the same."""
    path = tmp_path / "out" / "a.0002.exr"

    def no_links(*_):
        raise OSError(errno.EPERM, "no links here")

    if not links:
        monkeypatch.setattr(os, "link", no_links)

    def rendered_while(theirs):
        def meanwhile(settings, frame, target):
            if frame == 2:
                path.unlink(missing_ok=True)
                theirs()
            return renderer(settings, frame, target)

        return [record.get("error") for record in render_sequence(job, meanwhile)]

    job = open_job(path.with_name("a.####.exr"), (1, 2), SETTINGS)
    _, error = rendered_while(lambda: path.write_text("someone's work"))
    assert "no frame of lodbench" in error and path.read_text() == "someone's work"
    _, error = rendered_while(lambda: Renderer()(OTHER, 2, path))
    assert "other settings" in error and read_whole(path).settings == OTHER
    assert rendered_while(lambda: Renderer()(SETTINGS, 2, path)) == [None, None]
    assert names(path.parent) == ["a.0001.exr", "a.0002.exr"]


def test_what_is_interrupted_leaves_whole_frames_only(run, tmp_path, renderer):
    renderer.trouble = {2: KeyboardInterrupt()}
    with pytest.raises(KeyboardInterrupt):
        run()
    assert names(tmp_path / "out") == ["a.0001.exr"]


def test_a_frame_that_fails_costs_itself_only(run, tmp_path, renderer):
    renderer.trouble = {2: FrameFailed("it ended its worker", 3)}
    records = run()
    path = str(tmp_path / "out" / "a.0002.exr")
    bad = {"frame": 2, "path": path, "error": "it ended its worker", "tries": 3}
    assert [record["frame"] for record in records] == [1, 2, 3] and records[1] == bad
    assert names(tmp_path / "out") == ["a.0001.exr", "a.0003.exr"]
    renderer.trouble = {}
    assert [record["kept"] for record in run()] == [True, False, True]


def test_bad_input_in_the_first_frame_ends_it_and_later_costs_a_frame(run, renderer):
    wrong = InputError("eye", 1, "2")
    renderer.trouble = {1: wrong}
    with pytest.raises(InputError, match="eye"):
        run()
    renderer.trouble = {3: wrong}
    assert [record.get("error") for record in run()] == [None, None, str(wrong)]
    assert [record.get("error") for record in run((1, 3, 4))] == [None, str(wrong), None]


TROUBLE = [
    (errno.ENOSPC, "the disk is full"),
    (errno.EACCES, "writing there is not allowed"),
    (errno.EMFILE, "cannot be written"),
]


@pytest.mark.parametrize(("code", "says"), TROUBLE, ids=lambda each: str(each))
def test_what_the_disk_refuses_is_said_and_harms_no_finished_frame(
    run, renderer, tmp_path, code, says
):
    renderer.trouble = {2: OSError(code, os.strerror(code))}
    with pytest.raises(DiskError, match=rf"a\.0002\.exr: .*{says}.*{os.strerror(code)}"):
        run()
    assert names(tmp_path / "out") == ["a.0001.exr"]
    renderer.trouble = {}
    assert [record["kept"] for record in run()] == [True, False, False]


def test_what_a_killed_process_left_goes_and_what_a_live_one_writes_stays(run, tmp_path):
    run(frames=(1,))
    host = socket.gethostname().replace(".", "-")
    dead, alive = f"{host}-999999999", f"{host}-{os.getppid()}"
    for name in ("a.0001.exr", "a.0002.exr"):
        for writer in (dead, alive, "elsewhere-7"):
            (tmp_path / "out" / f".{name}.{writer}.part").write_text("half")
    run(frames=(1, 2))
    left = [name for name in names(tmp_path / "out") if name.startswith(".")]
    kept = [f".a.0001.exr.{writer}.part" for writer in (dead, alive, "elsewhere-7")]
    assert sorted(left) == sorted([*kept, f".a.0002.exr.{alive}.part"])
