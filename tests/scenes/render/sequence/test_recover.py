"""A lost or edited manifest is rebuilt from what is whole, and nothing that is damaged gets in."""

import json

import numpy as np
import pytest

from lod.errors import InputError
from scenes.frame.layers import Layers
from scenes.preset.load import preset_from
from scenes.render.files.exr import write_exr
from scenes.render.files.header import settings_attributes
from scenes.render.files.manifest import NAME, Manifest, file_hash, load_manifest, settings_hash
from scenes.render.sequence.recover import rebuild_manifest
from scenes.render.sequence.sequence import open_job, render_sequence
from scenes.render.sequence.settings import frame_settings
from scenes.render.sequence.verify import check_folder

SETTINGS = frame_settings(preset_from({"render": {"size": "8x4"}}), "scalar_rgb")
OTHER = frame_settings(preset_from({"render": {"size": "8x4"}, "seed": 9}), "scalar_rgb")
NAMES = tuple(f"a.{frame:04d}.exr" for frame in range(1, 5))


def render(settings, frame, target):
    ids, colour = np.full((4, 8), frame), np.full((4, 8, 3), frame / 100)
    layers = Layers(colour, ids, colour, colour, ids, ids, ids)
    digest = write_exr(target, layers, settings_attributes(settings, frame))
    return {"frame": frame, "sha256": digest, "seconds": {}, "statistics": {}}


@pytest.fixture
def folder(tmp_path):
    list(render_sequence(open_job(tmp_path / "a.####.exr", range(1, 5), SETTINGS), render))
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
    assert load_manifest(folder).settings == {settings_hash(SETTINGS): SETTINGS}
    assert open_job(folder / "a.####.exr", range(1, 5), SETTINGS).done == {1, 2, 3, 4}


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
    job = open_job(folder / "a.####.exr", range(1, 5), SETTINGS)
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
    list(render_sequence(open_job(tmp_path / "v1####.exr", range(1, 3), SETTINGS), render))
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
