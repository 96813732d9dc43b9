"""Right frames are kept, strangers refused, damaged frames rendered again.

A lost or edited manifest is rebuilt from what is whole, and nothing that is damaged gets in.
"""

import errno
import json
import os
import socket

import numpy as np
import pytest

from lod.errors import InputError
from scenes.files import DiskError, frame_path
from scenes.frame.layers import Layers
from scenes.presets.load import preset_from
from scenes.render.exr.header import frame_settings, settings_attributes
from scenes.render.exr.layers import read_exr, write_exr
from scenes.render.exr.sequence import (
    NAME,
    FrameFailed,
    Manifest,
    file_hash,
    load_manifest,
    open_job,
    rebuild_manifest,
    render_sequence,
    settings_hash,
)
from scenes.render.exr.verify import check_folder

SETTINGS = {"seed": 5, "render": {"spp": 4, "size": "8x4"}}


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
        digest = write_exr(target, layers, {"lod:frame": frame})
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


def test_frames_records_and_manifest(run, tmp_path, rendered):
    records = run()
    assert rendered == [1, 2, 3] and [r["frame"] for r in records] == [1, 2, 3]
    manifest = json.loads((tmp_path / "out" / "manifest.json").read_text())
    for record in records:
        assert record["peak_rss_bytes"] > 1e6 and record["kept"] is False
        entry = manifest["frames"][f"a.{record['frame']:04d}.exr"]
        assert entry["sha256"] == record["sha256"] and entry["state"] == "done"
        assert manifest["settings"][entry["settings"]] == SETTINGS
        assert read_exr(record["path"])[1]["lod:frame"] == record["frame"]
    assert names(tmp_path / "out") == ["a.0001.exr", "a.0002.exr", "a.0003.exr", "manifest.json"]


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


def test_before_it_is_rendered_a_frame_is_pending(run, tmp_path, renderer):
    renderer.trouble = {2: KeyboardInterrupt()}
    with pytest.raises(KeyboardInterrupt):
        run()
    frames = load_manifest(tmp_path / "out").frames
    assert [frames[name]["state"] for name in sorted(frames)] == ["done", "pending", "pending"]
    assert names(tmp_path / "out") == ["a.0001.exr", "manifest.json"]


def test_a_frame_that_fails_costs_itself_only(run, tmp_path, renderer):
    renderer.trouble = {2: FrameFailed("it ended its worker", 3)}
    records = run()
    path = str(tmp_path / "out" / "a.0002.exr")
    bad = {"frame": 2, "path": path, "error": "it ended its worker", "tries": 3}
    assert [record["frame"] for record in records] == [1, 2, 3] and records[1] == bad
    entry = load_manifest(tmp_path / "out").frames["a.0002.exr"]
    assert (entry["state"], entry["error"], entry["tries"]) == ("failed", "it ended its worker", 3)
    assert names(tmp_path / "out") == ["a.0001.exr", "a.0003.exr", "manifest.json"]
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
    (errno.EDQUOT, "the quota is used up"),
    (errno.EROFS, "the disk is read-only"),
    (errno.EACCES, "writing there is not allowed"),
    (errno.ENOENT, "the folder has gone"),
    (errno.ESTALE, "the folder has gone"),
    (errno.EIO, "the disk fails"),
    (errno.EMFILE, "cannot be written"),
]


@pytest.mark.parametrize(("code", "says"), TROUBLE, ids=lambda each: str(each))
def test_what_the_disk_refuses_is_said_and_harms_no_finished_frame(
    run, renderer, tmp_path, code, says
):
    renderer.trouble = {2: OSError(code, os.strerror(code))}
    with pytest.raises(DiskError, match=rf"a\.0002\.exr: .*{says}.*{os.strerror(code)}"):
        run()
    assert names(tmp_path / "out") == ["a.0001.exr", "manifest.json"]
    renderer.trouble = {}
    assert [record["kept"] for record in run()] == [True, False, False]


def test_a_manifest_that_cannot_be_saved_names_no_frame(run, tmp_path, monkeypatch, rendered):
    run(frames=(1,))

    def full(*_):
        raise OSError(errno.ENOSPC, "No space left on device")

    with monkeypatch.context() as patch:
        patch.setattr("scenes.render.exr.sequence.os.fsync", full)
        with pytest.raises(DiskError, match="the disk is full"):
            run(frames=(1, 2))
    assert names(tmp_path / "out") == ["a.0001.exr", "manifest.json"]
    assert [r["kept"] for r in run(frames=(1, 2))] == [True, False]


def test_what_a_killed_process_left_goes_and_what_a_live_one_writes_stays(run, tmp_path):
    run(frames=(1,))
    host = socket.gethostname().replace(".", "-")
    dead, alive = f"{host}-999999999", f"{host}-{os.getppid()}"
    for name in ("a.0001.exr", "a.0002.exr", "manifest.json"):
        for writer in (dead, alive, "elsewhere-7"):
            (tmp_path / "out" / f".{name}.{writer}.part").write_text("half")
    run(frames=(1, 2))
    left = [name for name in names(tmp_path / "out") if name.startswith(".")]
    kept = [f".a.0001.exr.{writer}.part" for writer in (dead, alive, "elsewhere-7")]
    of_others = [f".{name}.{alive}.part" for name in ("a.0002.exr", "manifest.json")]
    assert sorted(left) == sorted(kept + of_others)


def test_two_runs_in_one_folder_know_of_each_other(tmp_path, renderer):
    """As render farms do it: each process has its own frames, and all have one manifest."""
    jobs = [open_job(tmp_path / "a.####.exr", (k,), SETTINGS) for k in (1, 2, 3)]
    for job in reversed(jobs):
        list(render_sequence(job, renderer))
    frames = load_manifest(tmp_path).frames
    assert [frames[name]["state"] for name in sorted(frames)] == ["done"] * 3


@pytest.mark.parametrize("pattern", ["a.exr", "a.###.exr", "a.####.png", "a.####.####.exr", "####"])
def test_bad_patterns(pattern):
    with pytest.raises(InputError, match="####"):
        frame_path(pattern, 1)


def test_frame_numbers_grow_past_four_digits():
    assert frame_path("o/a.####.exr", 7).name == "a.0007.exr"
    assert frame_path("o/a.####.exr", 12345).name == "a.12345.exr"


SETTINGS_test_recover = frame_settings(preset_from({"render": {"size": "8x4"}}), "scalar_rgb")
OTHER = frame_settings(preset_from({"render": {"size": "8x4"}, "seed": 9}), "scalar_rgb")
NAMES = tuple(f"a.{frame:04d}.exr" for frame in range(1, 5))


def render(settings, frame, target):
    ids, colour = np.full((4, 8), frame), np.full((4, 8, 3), frame / 100)
    layers = Layers(colour, ids, colour, colour, ids, ids, ids)
    digest = write_exr(target, layers, settings_attributes(settings, frame))
    return {"frame": frame, "sha256": digest, "seconds": {}, "statistics": {}}


@pytest.fixture
def folder(tmp_path):
    list(
        render_sequence(
            open_job(tmp_path / "a.####.exr", range(1, 5), SETTINGS_test_recover), render
        )
    )
    return tmp_path


def wrong(folder):
    return {each.path.name for each in check_folder(load_manifest(folder)) if each.wrong}


def edited(change):
    """Write the manifest anew after a change to its data."""

    def damage(folder):
        data = json.loads((folder / NAME).read_text())
        change(data)
        (folder / NAME).write_text(json.dumps(data))

    return damage


def set_entry(**values):
    return edited(lambda data: data["frames"][NAMES[1]].update(values))


def seed_edited(data):
    next(iter(data["settings"].values())).update(seed=3)


def truncate(folder):
    (folder / NAME).write_bytes((folder / NAME).read_bytes()[:700])


def other_settings(data):
    data["settings"][settings_hash(OTHER)] = OTHER
    data["frames"][NAMES[1]]["settings"] = settings_hash(OTHER)


DAMAGE = {
    "lost": (lambda folder: (folder / NAME).unlink(), NAMES),
    "empty": (lambda folder: (folder / NAME).write_text(""), NAMES),
    "truncated": (truncate, NAMES),
    "binary": (lambda folder: (folder / NAME).write_bytes(b"\xff\0" * 99), NAMES),
    "an old version": (edited(lambda data: data.update(version=1)), NAMES),
    "an entry gone": (edited(lambda data: data["frames"].pop(NAMES[1])), NAMES[1:2]),
    "all entries gone": (edited(lambda data: data["frames"].clear()), NAMES),
    "another hash": (set_entry(sha256="0" * 64), NAMES[1:2]),
    "another frame": (set_entry(frame=7), NAMES[1:2]),
    "never finished": (set_entry(state="pending"), NAMES[1:2]),
    "failed": (set_entry(state="failed", error="x"), NAMES[1:2]),
    "other settings": (edited(other_settings), NAMES[1:2]),
    "settings edited": (edited(seed_edited), NAMES),
}


@pytest.mark.parametrize("case", DAMAGE)
def test_whatever_became_of_the_manifest_every_whole_frame_is_kept(folder, case):
    before = {name: file_hash(folder / name) for name in NAMES}
    damage, taken = DAMAGE[case]
    damage(folder)
    assert rebuild_manifest(folder) == taken
    assert wrong(folder) == set()
    assert rebuild_manifest(folder) == ()
    assert {name: file_hash(folder / name) for name in NAMES} == before
    assert load_manifest(folder).settings == {
        settings_hash(SETTINGS_test_recover): SETTINGS_test_recover
    }
    assert open_job(folder / "a.####.exr", range(1, 5), SETTINGS_test_recover).done == {1, 2, 3, 4}


def test_a_right_folder_is_left_alone(folder):
    before = (folder / NAME).stat()
    assert rebuild_manifest(folder) == ()
    assert (folder / NAME).stat().st_mtime_ns == before.st_mtime_ns


@pytest.mark.parametrize("lost", [True, False])
def test_every_flipped_bit_keeps_a_frame_out(folder, lost):
    path = folder / NAMES[2]
    whole = path.read_bytes()
    for at in range(0, len(whole), 211):
        data = bytearray(whole)
        data[at] ^= 1 << at % 8
        path.write_bytes(bytes(data))
        if lost:
            (folder / NAME).unlink()
        assert NAMES[2] not in rebuild_manifest(folder)
        assert wrong(folder) == {NAMES[2]}, at


def test_of_a_lost_manifest_what_is_damaged_is_rendered_with_the_settings_of_its_like(folder):
    (folder / NAMES[0]).write_text("half")
    (folder / "b.0001.exr").write_text("of nothing known")
    (folder / NAME).unlink()
    assert rebuild_manifest(folder) == NAMES[1:]
    entry = load_manifest(folder).frames[NAMES[0]]
    assert (entry["state"], entry["frame"]) == ("pending", 1)
    assert "b.0001.exr" not in load_manifest(folder).frames
    job = open_job(folder / "a.####.exr", range(1, 5), SETTINGS_test_recover)
    assert job.done == {2, 3, 4}


def test_frames_that_changed_places_and_strangers_stay_out(folder):
    one, two = ((folder / name).read_bytes() for name in NAMES[:2])
    (folder / NAMES[0]).write_bytes(two)
    (folder / NAMES[1]).write_bytes(one)
    assert rebuild_manifest(folder) == ()
    assert wrong(folder) == set(NAMES[:2])
    render(OTHER, 3, folder / "x.exr")
    (folder / "x.exr").replace(folder / NAMES[2])  # whole, and not what is on record
    assert rebuild_manifest(folder) == ()
    assert wrong(folder) == set(NAMES[:3])


def test_a_frame_under_the_number_of_another_is_wrong_and_becomes_its_own_again(folder):
    """Entries that changed places, of frames that are gone: each would be rendered as the other."""
    data = json.loads((folder / NAME).read_text())
    frames = data["frames"]
    frames[NAMES[0]], frames[NAMES[1]] = frames[NAMES[1]], frames[NAMES[0]]
    (folder / NAME).write_text(json.dumps(data))
    for name in NAMES[:2]:
        (folder / name).unlink()
    assert wrong(folder) == set(NAMES[:2])
    assert "the manifest says that it is frame 2" in str(list(check_folder(load_manifest(folder))))
    (folder / "a.0009.exr").write_text("of nobody")
    assert rebuild_manifest(folder) == ()
    entries = load_manifest(folder).frames
    assert [(entries[n]["frame"], entries[n]["state"]) for n in NAMES[:2]] == [
        (1, "pending"),
        (2, "pending"),
    ]
    assert "a.0009.exr" not in entries


def test_a_number_beside_the_frames_is_no_harm(tmp_path):
    list(
        render_sequence(
            open_job(tmp_path / "v1####.exr", range(1, 3), SETTINGS_test_recover), render
        )
    )
    assert wrong(tmp_path) == set()
    (tmp_path / NAME).unlink()
    assert rebuild_manifest(tmp_path) == ("v10001.exr", "v10002.exr")


def test_a_broken_manifest_where_nothing_is_whole_stays(tmp_path):
    (tmp_path / NAME).write_text("{")
    (tmp_path / "a.0001.exr").write_text("half")
    with pytest.raises(InputError, match="no frame in it is whole"):
        rebuild_manifest(tmp_path)
    assert (tmp_path / NAME).read_text() == "{"
    assert Manifest(tmp_path).frames == {}
