"""What comes with the package of fits is what the program makes from nothing."""

import zipfile

import numpy as np
import pytest

from scenes.processes import cache
from tests.tools.fitted import differing, entries, fill, shipped, write


def test_it_is_small_and_of_kinds_that_are_fitted():
    assert cache.FITTED.stat().st_size < 15e6
    assert {entry.partition("/")[0] for entry in shipped()} == set(cache.FITTED_KINDS)


def test_what_comes_with_the_package_is_not_made(monkeypatch):
    name = next(iter(shipped()))
    monkeypatch.setattr(cache, "content_key", lambda *_: name.partition("/")[2])
    found = cache.kept(name.partition("/")[0], "any", lambda: pytest.fail("it is made"))
    assert all(np.array_equal(found[key], values) for key, values in shipped()[name].items())


def test_a_damaged_file_is_as_none(tmp_path, monkeypatch):
    damaged = tmp_path / "fitted.zip"
    damaged.write_bytes(cache.FITTED.read_bytes()[:-500])
    monkeypatch.setattr(cache, "FITTED", damaged)
    assert cache._fitted.__wrapped__() == {}


def test_written_entries_are_read_again(tmp_path):
    found = {"tone/a": {"tone": np.arange(6.0).reshape(2, 3)}, "sky/b": {"radiance": np.ones(2)}}
    write(found, tmp_path / "a.zip")
    write(found, tmp_path / "b.zip")
    assert (tmp_path / "a.zip").read_bytes() == (tmp_path / "b.zip").read_bytes()
    with zipfile.ZipFile(tmp_path / "a.zip") as file:
        assert np.array_equal(np.load(file.open("tone/a/tone.npy")), found["tone/a"]["tone"])


@pytest.mark.slow
def test_fits_made_again_are_those_that_come_with_the_package(tmp_path):
    """Of one preset, which has all kinds; ``python -m tests.tools.fitted --check`` makes all."""
    fill("campfire", tmp_path)
    made = entries(tmp_path)
    assert {entry.partition("/")[0] for entry in made} == set(cache.FITTED_KINDS)
    assert differing(made) == []
    entry, arrays = next(iter(made.items()))
    assert differing({entry: {name: values + 1 for name, values in arrays.items()}}) == [entry]
