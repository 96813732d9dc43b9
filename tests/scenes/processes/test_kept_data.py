"""Data that are read back are those that were made, to the last bit, and nothing else is made."""

import json
from dataclasses import fields, is_dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest

from scenes.models.catalogue import MODELS
from scenes.processes.kept_data import kept_data, pack, unpack
from scenes.trees.species import Weather


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


@pytest.mark.parametrize("model", ["figure", "rabbit", "boulder", "birch"])
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


def test_numbers_keep_their_types_and_equal_arrays_are_kept_once() -> None:
    array = np.arange(5.0)
    data = (1, True, 0.1, np.float32(0.1), np.int64(7), None, "é", array, (array, ()), -0.0)
    packed = pack(data)
    assert same(unpack(packed), data)
    assert sum(each.shape == (5,) and each.dtype == float for each in packed.values()) == 1


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
