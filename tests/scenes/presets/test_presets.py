"""Presets say what they mean, are refused by key in one line, and read back as they are written."""

from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from lod.errors import InputError
from scenes.presets.load import (
    NAMED,
    key_entries,
    known_keys,
    load_preset,
    preset_names,
    preset_toml,
    preset_values,
)
from scenes.presets.schema import Preset
from scenes.presets.values import parse_length, parse_size

NAMES = [name for name, _ in preset_names()]


def test_every_key_is_described_once() -> None:
    names = [each.name for each in key_entries()]
    assert names == known_keys(dict.fromkeys(NAMED, ("NAME",)))
    assert len(set(names)) == len(names)
    assert all(each.about for each in key_entries())


def test_a_key_tells_its_type_unit_range_and_default() -> None:
    entries = {each.name: each for each in key_entries()}
    fov, seen = entries["camera.fov"], entries["air.visibility"]
    assert (fov.kind, fov.unit, fov.default) == ("number", "degrees", 60.0)
    assert fov.range == "above 0 and below 180"
    assert (seen.kind, seen.default, seen.required) == ("length", None, False)
    assert entries["species.NAME.density"].required
    assert entries["render.haze"].kind == '"analytic" or "medium"'


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


def refusal(name: str, *overrides: str) -> str:
    with pytest.raises(InputError) as caught:
        load_preset(name, overrides)
    return str(caught.value)


def test_an_empty_file_is_a_preset_of_defaults(tmp_path: Path) -> None:
    path = tmp_path / "empty.toml"
    path.write_text("")
    assert load_preset(str(path)) == Preset()


def test_the_rate_of_a_film_may_be_a_fraction() -> None:
    assert load_preset("meadow", ["camera.fps=24000/1001"]).camera.fps == 24000 / 1001
    with pytest.raises(InputError, match="24/0"):
        load_preset("meadow", ["camera.fps=24/0"])


@pytest.mark.parametrize(
    ("override", "key", "value"),
    [
        ("seed=7", "seed", 7),
        ("world.extent=3km", "world.extent", 3000.0),
        ("world.extent=endless", "world.extent", None),
        ("species.tree.sizes=[1, 2]", "species.tree.sizes", (1.0, 2.0)),
        ("camera.height=170cm", "camera.height", 1.7),
        ('camera.position=["1km", 5]', "camera.position", (1000.0, 5.0)),
        ("air.visibility='3 km'", "air.visibility", 3000.0),
        ("eye={}", "eye.signal_to_noise", 3.0),
        ("render.size=[8, 4]", "render.size", (8, 4)),
        ("view.look_around=true", "view.look_around", True),
        ('about="a = b"', "about", "a = b"),
    ],
)
def test_a_setting_reaches_its_key(override: str, key: str, value: object) -> None:
    found: object = load_preset("meadow", [override])
    for step in key.split("."):
        found = found[step] if isinstance(found, dict) else getattr(found, step)
    assert found == value


def test_the_last_setting_of_a_key_wins() -> None:
    assert load_preset("meadow", ["seed=1", "seed=2"]).seed == 2


def test_a_whole_species_can_be_added() -> None:
    wood = load_preset("meadow", ['species.oak={model="tree", density=0.001}'])
    assert wood.species["oak"].density == 0.001


@pytest.mark.parametrize(
    ("override", "says"),
    [
        ("sead=1", "did you mean seed?"),
        ("density=1", "did you mean species.figure.density?"),
        ("air.visibility=50", 'write "50km" or "50m"'),
        ("display.ppd=67", "no such key; did you mean display."),
        (
            "species.figur.density=1",
            "table [species.figur] in a file, as `lodbench show` writes one; did you mean figure?",
        ),
        ("camera.height=2Km", "'2Km': a number, or a length as 170cm or 2km"),
        ("camera.height=" + "9" * 5000, "a number"),
        ("camera=3", "a table of keys; `lodbench list --keys` shows every key"),
        ("species.elk={model='tree'}", "-D species.elk.density: missing: a required key"),
        ("species.9={model='tree', density=1}", "letter first; try oak_2"),
        (f"species.{'a' * 99}={{model='tree', density=1}}", "64 characters; try a shorter one"),
        ("view.metric=full", "-D view.metric: 'full': needs a finite world"),
        ("seed", "-D: 'seed': key=value"),
    ],
)
def test_a_bad_setting_is_refused_by_name(override: str, says: str) -> None:
    message = refusal("meadow", override)
    assert says in message
    assert "\n" not in message
    assert len(message) < 320


def test_metrics_that_need_an_axis_refuse_a_full_turn() -> None:
    assert "view.metric" in refusal("meadow", "view.metric=depth", "view.look_around=true")


@pytest.mark.parametrize(
    ("toml", "says"),
    [
        (
            "[air]\nvisibillity = '20km'",
            "air.visibillity: '20km': no such key; did you mean air.vis",
        ),
        ("seed = \n", "'seed =': not TOML: Invalid value (at line 1, column 8)"),
        ("seed = " + "9" * 5000, "not TOML"),
        ("seed = " + "[" * 100_000, "nested less deeply"),
        ("seed = -1\nfrog = 2", "(and 1 more)"),
    ],
)
def test_a_bad_file_is_refused_by_file_and_key(tmp_path: Path, toml: str, says: str) -> None:
    path = tmp_path / "mine.toml"
    path.write_text(toml)
    message = refusal(str(path))
    assert message.startswith(str(path))
    assert says in message
    assert "\n" not in message


def test_names_and_paths_that_lead_nowhere(tmp_path: Path) -> None:
    assert "did you mean meadow?" in refusal("medow")
    assert "no such file" in refusal(str(tmp_path / "none.toml"))
    assert "it is a folder" in refusal(str(tmp_path) + "/")
    latin = tmp_path / "latin.toml"
    latin.write_bytes(b"about = '\xe9'")
    assert "UTF-8" in refusal(str(latin))
    huge = tmp_path / "huge.toml"
    huge.write_bytes(b"#" * 1_000_001)
    assert "at most" in refusal(str(huge))


@pytest.mark.parametrize(
    ("text", "metres"),
    [("20km", 20_000.0), (".5m", 0.5), ("1e3km", 1e6)],
)
def test_a_length_is_in_metres(text: str, metres: float) -> None:
    assert parse_length(text) == metres


@pytest.mark.parametrize("text", ["20", 20, "", "-3km", "3 miles", "1e400km", "nan m", "١km", None])
def test_what_is_no_length_is_refused_with_the_units(text: object) -> None:
    with pytest.raises(InputError, match="km") as caught:
        parse_length(text, "--visibility")
    assert caught.value.where == "--visibility"
    assert caught.value.arrived == text


@pytest.mark.parametrize("text", ["0", "0km", "-3", "-0.0 m"])
def test_what_is_not_above_0_is_not_cured_by_a_unit(text: str) -> None:
    with pytest.raises(InputError, match=r"above 0.*20km"):
        parse_length(text, "--visibility")


@pytest.mark.parametrize(
    ("text", "size"), [("640x360", (640, 360)), (" 1 x 1 ", (1, 1)), ("16384x2", (16384, 2))]
)
def test_a_size_is_width_and_height(text: str, size: tuple[int, int]) -> None:
    assert parse_size(text) == size


@pytest.mark.parametrize(
    "text", ["0x0", "640", "x360", "-1x3", "16385x1", "1x1x1", "9" * 5000 + "x1"]
)
def test_what_is_no_size_is_refused(text: str) -> None:
    with pytest.raises(InputError, match="640x360"):
        parse_size(text, "--size")
