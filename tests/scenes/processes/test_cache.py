"""The cache gives what was made, to the last bit, or makes it again; it never needs a folder."""

import json
import multiprocessing
import os
import zipfile
from dataclasses import dataclass, fields, is_dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from scenes.models.catalogue import MODELS
from scenes.processes import cache as module
from scenes.processes.cache import (
    cache_contents,
    clear_cache,
    content_key,
    kept,
    kept_data,
    pack,
    rounded_key,
    unpack,
    writable_cache,
)
from scenes.trees.species import Weather

ARRAYS = {
    "reals": np.linspace(0.0, 1.0, 12).reshape(3, 4)[:, ::2],
    "flags": np.array([True, False, True]),
    "number": np.array(7, np.int64),
    "none": np.empty((0, 3), np.float32),
    "names": np.array(["oak", "äsche"]),
}


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("LODBENCH_CACHE", str(tmp_path / "cache"))
    return tmp_path / "cache"


class Maker:
    """Counts how often the arrays had to be made."""

    def __init__(self, arrays=ARRAYS):
        self.arrays, self.times = arrays, 0

    def __call__(self):
        self.times += 1
        return self.arrays


def the_file(folder: Path) -> Path:
    (path,) = folder.glob("arrays/*/*.arrays")
    return path


def test_what_is_read_is_what_was_made_and_nobody_can_write_to_it(folder: Path) -> None:
    make = Maker()
    for found in (kept("tree", "a", make), kept("tree", "a", make)):
        assert found.keys() == ARRAYS.keys()
        for name, values in ARRAYS.items():
            assert found[name].dtype == values.dtype and found[name].shape == values.shape
            np.testing.assert_array_equal(found[name], values)
            assert found[name].flags.c_contiguous and not found[name].flags.writeable
    assert make.times == 1


def test_another_key_kind_or_code_is_another_entry(folder: Path) -> None:
    make = Maker()
    for kind, key, code in (
        ("tree", "a", ("lod", "scenes")),
        ("tree", "b", ("lod", "scenes")),
        ("leaf", "a", ("lod", "scenes")),
        ("tree", "a", ("lod",)),
        ("tree", "a", ("lod.arrays",)),
    ):
        kept(kind, key, make, code)
    assert make.times == 5
    with pytest.raises(ValueError, match="no source of this project"):
        kept("tree", "a", make, ("lod.arrrays",))


def test_a_changed_source_makes_the_entry_again(
    folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    make, code = Maker(), ("growth",)
    monkeypatch.setattr(module, "ROOT", tmp_path)
    for text in ("x = 1", "x = 1", "x = 2"):
        (tmp_path / "growth.py").write_text(text)
        module._code_digest.cache_clear()
        module._digest.cache_clear()
        kept("tree", "a", make, code)
    assert make.times == 2


@pytest.mark.parametrize("part", range(6))
def test_a_damaged_entry_is_made_again(folder: Path, part: int) -> None:
    make = Maker()
    kept("tree", "a", make)
    path = the_file(folder)
    whole = path.read_bytes()
    flipped = bytearray(whole)
    flipped[part * (len(whole) - 1) // 5] ^= 1
    for damaged in (bytes(flipped), whole[: part * len(whole) // 6], whole + b"\0"):
        path.write_bytes(damaged)
        found = kept("tree", "a", make)
        for name, values in ARRAYS.items():
            np.testing.assert_array_equal(found[name], values)
        path.write_bytes(whole)
    assert make.times > 1


def test_an_entry_that_lacks_a_member_is_made_again(folder: Path) -> None:
    """As damage to ZIP's own list of its members leaves one: nothing else of it is wrong."""
    make = Maker()
    kept("tree", "a", make)
    path = the_file(folder)
    with zipfile.ZipFile(path) as whole:
        members = {name: whole.read(name) for name in whole.namelist()}
    for gone in members:
        with zipfile.ZipFile(path, "w") as less:
            for name in members.keys() - {gone}:
                less.writestr(name, members[name])
        assert kept("tree", "a", make).keys() == ARRAYS.keys()
    assert make.times == 1 + len(members) == 2 + len(ARRAYS)


def test_without_a_writable_folder_everything_is_made_each_time(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "file").write_text("no folder can be made below a file")
    monkeypatch.setenv("LODBENCH_CACHE", str(tmp_path / "file"))
    make = Maker()
    for _ in range(2):
        np.testing.assert_array_equal(kept("tree", "a", make)["reals"], ARRAYS["reals"])
    assert make.times == 2 and writable_cache() is None


def test_what_others_may_have_written_is_not_believed(folder: Path) -> None:
    make = Maker()
    kept("tree", "a", make)
    assert folder.stat().st_mode & 0o777 == 0o700
    folder.chmod(0o770)
    kept("tree", "a", make)
    assert make.times == 2 and writable_cache() is None


def test_a_write_that_fails_leaves_nothing(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(*_: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "replace", full)
    np.testing.assert_array_equal(kept("tree", "a", Maker())["reals"], ARRAYS["reals"])
    assert [path for path in folder.rglob("*") if path.is_file()] == []


def test_the_oldest_entries_go_first(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    make = Maker({"a": np.zeros(1000)})
    for k, key in enumerate("abcd"):
        kept("tree", key, make)
        newest = max(folder.glob("arrays/*/*.arrays"), key=lambda path: path.stat().st_mtime_ns)
        os.utime(newest, (k, k))
    kept("tree", "a", make)  # used again, so "b" is the oldest
    monkeypatch.setattr(module, "LIMIT_BYTES", 30_000)  # holds three entries
    kept("tree", "e", make)
    assert make.times == 5
    for key, times in (("a", 5), ("d", 5), ("e", 5), ("b", 6)):
        kept("tree", key, make)
        assert make.times == times


def test_the_contents_are_counted_and_cleared(folder: Path) -> None:
    for kind, key in (("tree", "a"), ("tree", "b"), ("sky", "a")):
        kept(kind, key, Maker())
    (folder / "kernels-1" / "lod").mkdir(parents=True)
    (folder / "kernels-1" / "lod" / "walk.nbc").write_bytes(b"1234")
    (folder / "mine.txt").write_text("a stranger's file")
    found = {each.kind: (each.entries, each.size_bytes) for each in cache_contents(folder)}
    assert {kind: entries for kind, (entries, _) in found.items()} == {
        "sky": 1,
        "tree": 2,
        "kernels": 1,
    }
    assert found["kernels"][1] == 4 and found["tree"][1] == 2 * found["sky"][1] > 0
    clear_cache(folder)
    assert cache_contents(folder) == [] and (folder / "mine.txt").exists()


def _keep_often(folder: str, seed: int) -> float:
    os.environ["LODBENCH_CACHE"] = folder
    rng, total = np.random.default_rng(seed), 0.0
    for _ in range(60):
        key = int(rng.integers(3))
        total += kept("tree", str(key), lambda key=key: {"a": np.full(20_000, key)})["a"].sum() - (
            20_000 * key
        )
        if rng.random() < 0.2:
            clear_cache(Path(folder))
    return total


def test_several_processes_may_make_read_and_clear_at_once(folder: Path) -> None:
    with multiprocessing.get_context("spawn").Pool(3) as pool:
        wrong = pool.starmap(_keep_often, [(str(folder), seed) for seed in range(3)])
    assert wrong == [0.0, 0.0, 0.0]


@dataclass(frozen=True)
class Leaf:
    length: float
    points: np.ndarray


def test_keys_differ_where_values_do() -> None:
    values = [
        (1,),
        (1.0,),
        ("1",),
        (True,),
        (None,),
        (np.float64(1.0), 2),
        ([1, 2],),
        ([1], 2),
        ([[1], 2],),
        ({"a": 1, "b": 2},),
        (np.array([1, 2]),),
        (np.array([1.0, 2.0]),),
        (np.array([[1], [2]]),),
        (Leaf(1.0, np.arange(3.0)),),
        (Leaf(1.0, np.nextafter(np.arange(3.0), 9.0)),),
        (0.1 + 0.2,),
        (0.3,),
    ]
    keys = [content_key(*each) for each in values]
    assert len(set(keys)) == len(values)
    assert content_key({"b": 2, "a": 1}) == content_key({"a": 1, "b": 2})
    with pytest.raises(TypeError, match="plain data"):
        content_key(object())


def same(a: object, b: object) -> bool:
    """Whether two data are of the same types and bits."""
    if type(a) is not type(b):
        return False
    if isinstance(a, np.ndarray) and isinstance(b, np.ndarray):
        return a.dtype == b.dtype and a.shape == b.shape and a.tobytes() == b.tobytes()
    if is_dataclass(a):
        return all(same(getattr(a, each.name), getattr(b, each.name)) for each in fields(a))
    if isinstance(a, tuple) and isinstance(b, tuple):
        return len(a) == len(b) and all(same(x, y) for x, y in zip(a, b, strict=True))
    return a == b


@pytest.mark.parametrize("model", ["figure", "birch"])
def test_prototypes_are_the_same_when_they_are_read_back(
    model: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("LODBENCH_CACHE", str(tmp_path))
    made = MODELS[model](0, 1, Weather("summer", 3.0))
    times: list[None] = []

    def make() -> tuple:
        times.append(None)
        return made

    assert kept_data("prototypes", model, make) is made
    read = kept_data("prototypes", model, make)
    assert same(read, made) and read is not made and len(times) == 1
    assert not same(read[0].scaled(1.0 + 1e-15), made[0])


class Strange(NamedTuple):
    values: np.ndarray


def test_classes_of_other_projects_are_never_made() -> None:
    packed = pack(Strange(np.zeros(3)))
    with pytest.raises(ValueError, match="not of this project"):
        unpack(packed)
    bad = json.dumps({"class": "os:system", "of": ["true"]}).encode()
    with pytest.raises(ValueError, match="not of this project"):
        unpack({"description": np.frombuffer(bad, np.uint8)})
    with pytest.raises(TypeError, match="hold no set"):
        pack(({1, 2},))


@given(st.integers(-(10**7), 10**7), st.sampled_from((-1, 1)))
def test_the_last_bit_of_a_number_of_few_decimals_does_not_change_its_rounded_key(
    millionths, direction
):
    exact = np.array([millionths / 2e6])
    assert rounded_key(exact) == rounded_key(np.nextafter(exact, direction * np.inf))
    assert rounded_key(exact) != rounded_key(exact + 2e-6)
