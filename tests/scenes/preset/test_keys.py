"""The list of keys says what the models say, and a preset written as TOML reads back the same."""

from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from scenes.presets.keys import NAMED, key_entries, known_keys
from scenes.presets.load import load_preset, preset_names, preset_toml, preset_values

NAMES = [name for name, _ in preset_names()]


def test_every_key_is_described_once() -> None:
    names = [each.name for each in key_entries()]
    assert names == known_keys(dict.fromkeys(NAMED, ("NAME",)))
    assert len(set(names)) == len(names)
    assert all(each.about for each in key_entries())


def test_a_key_tells_its_type_unit_range_and_default() -> None:
    entries = {each.name: each for each in key_entries()}
    fov, mist = entries["camera.fov"], entries["air.mist_scale"]
    assert (fov.kind, fov.unit, fov.default) == ("number", "degrees", 60.0)
    assert fov.range == "above 0 and below 180"
    assert (mist.kind, mist.default, mist.required) == ("length", 50.0, False)
    assert entries["species.NAME.density"].required
    assert entries["render.haze"].kind == '"analytic" or "scattered" or "medium"'


@pytest.mark.parametrize("name", NAMES)
def test_a_preset_written_as_toml_is_the_same_preset(name: str, tmp_path: Path) -> None:
    preset, path = load_preset(name), tmp_path / "again.toml"
    path.write_text(preset_toml(preset), encoding="utf-8")
    assert load_preset(str(path)) == preset


@given(
    text=st.text(st.characters(codec="utf-8"), max_size=40),
    height=st.floats(1e-6, 1e6),
    visibility=st.none() | st.floats(1, 330e3),
    cell=st.integers(-(2**55), 2**55),
    sizes=st.lists(st.floats(1e-3, 1e3), min_size=1, max_size=4),
)
def test_any_values_survive_the_way_through_toml(
    tmp_path_factory: pytest.TempPathFactory,
    text: str,
    height: float,
    visibility: float | None,
    cell: int,
    sizes: list[float],
) -> None:
    meadow = load_preset("meadow")
    tree = meadow.species["tree"].model_copy(update={"sizes": tuple(sizes)})
    camera = meadow.camera.model_copy(update={"height": height, "cell": (cell, -cell)})
    changed = {
        "about": text,
        "camera": camera,
        "air": meadow.air.model_copy(update={"visibility": visibility}),
        "species": {"tree": tree},
    }
    preset = meadow.model_copy(update=changed)
    path = tmp_path_factory.mktemp("toml") / "any.toml"
    path.write_text(preset_toml(preset), encoding="utf-8")
    assert load_preset(str(path)) == preset


def test_values_are_given_by_dotted_key() -> None:
    values = preset_values(load_preset("fly_in"))
    assert values["view.detail"] == 60.0
    assert values["camera.keys.frame"] == [1, 24, 48]
    assert values["eye.efficiency"] is None
