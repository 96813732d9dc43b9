"""Whatever is wrong with a folder of frames is found and named, and rendered again on demand."""

import hashlib

import numpy as np
import pytest

from lod.errors import InputError
from scenes.frame.layers import Layers
from scenes.presets.load import preset_from
from scenes.render.exr.frames_on_disk import open_job, render_sequence
from scenes.render.exr.header import frame_settings, settings_attributes
from scenes.render.exr.layer_file import write_exr
from scenes.render.exr.verify import check_folder, repairs

SETTINGS = frame_settings(preset_from({"render": {"size": "8x4"}}), "scalar_rgb")
FRAMES = range(1, 6)


class Renderer:
    """One of no cost; ``spoil`` maps a layer to what is done to it; ``asked`` are its frames."""

    def __init__(self):
        self.asked, self.spoil, self.size = [], {}, (4, 8)

    def __call__(self, settings, frame, target):
        self.asked.append(frame)
        ids, colour = np.full(self.size, frame), np.full((*self.size, 3), frame / 100)
        arrays = {"rgb": colour, "Z": ids, "N": -colour, "albedo": colour}
        for name, change in self.spoil.items():
            arrays[name] = change(np.array(arrays[name], np.float32))
        layers = Layers(**arrays, object=ids, part=ids, level=ids)
        digest = write_exr(target, layers, settings_attributes(settings, frame))
        return {"frame": frame, "sha256": digest, "seconds": {}, "statistics": {}}


@pytest.fixture
def renderer():
    return Renderer()


@pytest.fixture
def frames(tmp_path, renderer):
    """A function that renders five frames and gives their paths by number."""

    def make():
        job = open_job(tmp_path / "a.####.exr", FRAMES, SETTINGS)
        list(render_sequence(job, renderer))
        renderer.asked.clear()
        return job.paths

    return make


def file_hash(path):
    return hashlib.sha256(path.read_bytes()).hexdigest()


def wrong(folder, frames=None):
    found = check_folder(folder, frames)
    return {each.path.name: "; ".join(each.wrong) for each in found if each.wrong}


def mend(folder, renderer, frames=None):
    found = [each for each in check_folder(folder, frames) if each.wrong]
    after = repairs(folder, found, lambda job: render_sequence(job, renderer))
    return [each for each in after if each.wrong]


def test_what_is_right_is_left_alone(frames, tmp_path, renderer):
    frames()
    assert wrong(tmp_path) == {} and mend(tmp_path, renderer) == []
    assert renderer.asked == []


def swap(paths):
    a, b = paths[2].read_bytes(), paths[4].read_bytes()
    paths[2].write_bytes(b)
    paths[4].write_bytes(a)


def flip(paths):
    data = bytearray(paths[3].read_bytes())
    data[-20] ^= 1
    paths[3].write_bytes(bytes(data))


DAMAGE = [
    (swap, {2: "header says that it is frame 4", 4: "header says that it is frame 2"}),
    (flip, {3: "SHA-256"}),
    (lambda p: p[1].write_bytes(p[1].read_bytes()[:-1]), {1: "SHA-256"}),
    (lambda p: p[5].write_bytes(bytes(p[5].stat().st_size)), {5: "SHA-256"}),
    (lambda p: p[5].write_bytes(b""), {5: "SHA-256"}),
    (lambda p: p[2].unlink(), {2: "no such file"}),
    (lambda p: p[3].write_text("of others"), {3: "looks like a frame, and is none"}),
]


@pytest.mark.parametrize(("damage", "says"), DAMAGE)
def test_damage_is_found_named_and_mended_alone(frames, tmp_path, renderer, damage, says):
    paths = frames()
    before = {frame: file_hash(path) for frame, path in paths.items()}
    damage(paths)
    found = wrong(tmp_path)
    assert found.keys() == {paths[frame].name for frame in says}
    for frame, words in says.items():
        assert words in found[paths[frame].name]
    assert mend(tmp_path, renderer) == []
    assert renderer.asked == list(says)
    assert {frame: file_hash(path) for frame, path in paths.items()} == before


def test_frames_may_come_in_any_order_and_each_is_told_of_once(frames, tmp_path, renderer):
    paths = frames()
    for frame in (1, 3, 4):
        paths[frame].write_bytes(b"")
    found = [each for each in check_folder(tmp_path) if each.wrong]

    def last_first(job):
        assert list(job.paths) == [1, 3, 4]
        return reversed(list(render_sequence(job, renderer)))

    assert [each.frame for each in repairs(tmp_path, found, last_first)] == [4, 3, 1]
    assert wrong(tmp_path) == {}


def test_bad_input_leaves_wrong_what_was_not_rendered(frames, tmp_path, renderer):
    paths = frames()
    for frame in (1, 3, 4):
        paths[frame].write_bytes(b"")
    found = [each for each in check_folder(tmp_path) if each.wrong]

    def stops(job):
        records = render_sequence(job, renderer)
        yield next(records)
        raise InputError("--cluster", "tcp://a", "it went away")

    after = {each.frame: each.wrong for each in repairs(tmp_path, found, stops)}
    assert after[1] == () and all("it went away" in after[frame][-1] for frame in (3, 4))


def put(value, *where):
    def change(array):
        array[where] = value
        return array

    return change


PIXELS = [
    ("rgb", put(np.nan, 2, 5, 0), "R is NaN at x 5, y 2 from the upper left"),
    ("rgb", put(-1.0, 0, slice(3, 6), 1), "G is negative at x 3, y 0 from the upper left, and 2"),
    ("Z", put(np.inf, 3, 7), "Z is infinite at x 7, y 3"),
    ("Z", put(-2.0, 1, 1), "Z is negative at x 1, y 1"),
    ("albedo", put(-0.5, 0, 0, 2), "albedo.B is negative at x 0, y 0"),
    ("N", put(np.nan, 1, 0, 2), "N.Z is NaN at x 0, y 1"),
]


@pytest.mark.parametrize(("layer", "change", "says"), PIXELS)
def test_numbers_that_no_frame_may_hold(frames, tmp_path, renderer, layer, change, says):
    """Their bytes are those that were written, so only a look at the pixels finds them."""
    renderer.spoil = {layer: change}
    frames()
    assert all(says in each for each in wrong(tmp_path).values())
    assert len(wrong(tmp_path)) == len(FRAMES)
    assert len(mend(tmp_path, renderer)) == len(FRAMES)  # the same numbers come again
    renderer.spoil = {}
    assert mend(tmp_path, renderer) == [] and wrong(tmp_path) == {}


def test_another_size_or_type_is_found(frames, tmp_path, renderer):
    renderer.size = (5, 8)
    frames()
    assert "8×5 pixels, not 8×4" in wrong(tmp_path)["a.0001.exr"]
    half = frame_settings(preset_from({"output": {"colour": "half"}}), "scalar_rgb")
    renderer(half, 6, tmp_path / "a.0006.exr")
    assert "channel R is float32, not float16" in wrong(tmp_path)["a.0006.exr"]


def test_gaps_are_found_and_frames_that_were_asked_for(tmp_path, renderer):
    job = open_job(tmp_path / "a.####.exr", (10, 20, 30, 50), SETTINGS)
    list(render_sequence(job, renderer))
    assert wrong(tmp_path) == {"a.0040.exr": "there is no such file"}
    assert wrong(tmp_path, [10, 20, 50]) == {}
    assert wrong(tmp_path, [1, 10]) == {"a.0001.exr": "there is no such file"}
    renderer.asked.clear()
    assert mend(tmp_path, renderer, [1, 10, 40]) == [] and renderer.asked == [1, 40]


def test_a_number_beside_the_frames_is_no_harm(tmp_path, renderer):
    job = open_job(tmp_path / "v1####.exr", range(1, 4), SETTINGS)
    list(render_sequence(job, renderer))
    assert wrong(tmp_path) == {}
    job.paths[2].write_bytes(b"")
    assert wrong(tmp_path).keys() == {"v10002.exr"} and mend(tmp_path, renderer) == []


def test_files_beside_the_frames(frames, tmp_path, renderer):
    frames()
    for name in (".a.0002.exr.gone-1.part", ".a.0009.exr.gone-1.part", "a.0042.exr", "b.0001.exr"):
        (tmp_path / name).write_text("x")
    found = wrong(tmp_path)
    assert found.keys() == {".a.0002.exr.gone-1.part", ".a.0009.exr.gone-1.part", "a.0042.exr"}
    assert [each.path.name for each in mend(tmp_path, renderer)] == ["a.0042.exr"]
    assert wrong(tmp_path).keys() == {"a.0042.exr"} and renderer.asked == []


def test_where_no_frame_says_with_which_settings_nothing_is_rendered(frames, tmp_path, renderer):
    """None is whole, or there are some of two kinds; the same command again knows."""
    paths = frames()
    renderer({**SETTINGS, "seed": 9}, 2, tmp_path / "b.0002.exr")
    (tmp_path / "b.0002.exr").replace(paths[2])
    paths[1].write_bytes(paths[1].read_bytes()[:-1])
    renderer.asked.clear()
    (left,) = mend(tmp_path, renderer)
    assert left.frame == 1 and "no whole frames of one kind say" in left.wrong[-1]
    for path in paths.values():
        path.write_bytes(path.read_bytes()[:-1])
    assert len(mend(tmp_path, renderer)) == len(FRAMES) and renderer.asked == []
    list(render_sequence(open_job(tmp_path / "a.####.exr", FRAMES, SETTINGS), renderer))
    assert wrong(tmp_path) == {}


def test_two_sequences_of_a_folder_are_repaired_each_by_itself(tmp_path, renderer):
    for name in ("a", "b"):
        job = open_job(tmp_path / f"{name}.####.exr", FRAMES, SETTINGS)
        list(render_sequence(job, renderer))
        job.paths[2].write_bytes(b"")
    assert mend(tmp_path, renderer) == [] and wrong(tmp_path) == {}


def test_another_version_renders_nothing(frames, tmp_path, renderer, monkeypatch):
    frames()[2].unlink()
    monkeypatch.setattr("scenes.render.exr.verify.software", lambda: "lodbench 99")
    (left,) = mend(tmp_path, renderer)
    assert "lodbench 99 would make another" in left.wrong[-1] and renderer.asked == []
