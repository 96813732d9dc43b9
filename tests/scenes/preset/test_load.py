"""Presets say what they mean, or are refused by key, in one line with the nearest cure."""

import json
from pathlib import Path

import pytest

from lod.errors import InputError
from scenes.presets.load import Setting, load_preset, preset_from, preset_names
from scenes.presets.schema import Preset


def refusal(name: str, *overrides: str) -> str:
    with pytest.raises(InputError) as caught:
        load_preset(name, overrides)
    return str(caught.value)


def test_the_default_preset_has_all_three_subjects() -> None:
    meadow = load_preset("meadow")
    assert {each.model for each in meadow.species.values()} == {"figure", "tree", "sward"}
    assert meadow.terrain.amplitude > 0
    assert meadow.air.visibility is not None
    assert meadow.render.size == (640, 360)


def test_every_preset_of_the_package_says_what_it_shows() -> None:
    names = dict(preset_names())
    assert "meadow" in names
    assert all(about and "\n" not in about for about in names.values())


def test_a_preset_survives_being_written_down() -> None:
    meadow = load_preset("meadow", ["world.extent=2km"])
    assert preset_from(meadow.model_dump()) == meadow
    assert preset_from(json.loads(meadow.model_dump_json())) == meadow


def test_an_empty_file_is_a_preset_of_defaults(tmp_path: Path) -> None:
    path = tmp_path / "empty.toml"
    path.write_text("")
    assert load_preset(str(path)) == Preset()


def test_a_preset_is_frozen() -> None:
    with pytest.raises(ValueError, match="frozen"):
        load_preset("meadow").seed = 3  # type: ignore[misc]


@pytest.mark.parametrize(
    ("override", "key", "value"),
    [
        ("seed=7", "seed", 7),
        ("world.extent=1e6", "world.extent", 1e6),
        ("world.extent=3km", "world.extent", 3000.0),
        ("world.extent=endless", "world.extent", None),
        ("species.figure.density=0.002", "species.figure.density", 0.002),
        ("species.tree.sizes=[1, 2]", "species.tree.sizes", (1.0, 2.0)),
        ("camera.height = 200", "camera.height", 200.0),
        ("camera.position=[1e12, -3]", "camera.position", (1e12, -3.0)),
        ("air.visibility=500m", "air.visibility", 500.0),
        ("air.visibility='3 km'", "air.visibility", 3000.0),
        ("air.visibility=clear", "air.visibility", None),
        ("air.mist=300m", "air.mist", 300.0),
        ("air.mist_base=-5m", "air.mist_base", -5.0),
        ("air.mist_scale=0.02km", "air.mist_scale", 20.0),
        ("display.pixels_per_degree=40", "display.pixels_per_degree", 40.0),
        ("eye={}", "eye.signal_to_noise", 3.0),
        ("view.haze_aware=false", "view.haze_aware", False),
        ("render.size=8x4", "render.size", (8, 4)),
        ("render.size=[8, 4]", "render.size", (8, 4)),
        ("view.metric=bounded", "view.metric", "bounded"),
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
        ("seed=-1", "-D seed: -1: at least 0"),
        (f"seed={2**63}", f"at most {2**63 - 1}"),
        ("seed=1.5", "1.5: a whole number"),
        ("seed=true", "True: a whole number"),
        ("sead=1", "did you mean seed?"),
        ("density=1", "did you mean species.figure.density?"),
        ("camera.hight=2", "did you mean camera.height?"),
        ("camera.height.x=2", "did you mean camera.height?"),
        ("air.qqq=1", "known here: visibility"),
        ("air.visibility=1000km", "-D air.visibility: 1000000.0: at most 330000"),
        ("air.mist=50", 'write "50km" or "50m"'),
        ("air.mist_base=20", "-D air.mist_base: 20: a number with its unit"),
        ("air.mist_scale=0m", "a length above 0"),
        ("air.mist_scale=-1m", "a length above 0"),
        ("air.seeing=-1", "-D air.seeing: -1: at least 0"),
        ("display.ppd=67", "no such key; did you mean display."),
        ("display.pixels_per_degree=0", "-D display.pixels_per_degree: 0: at least 1"),
        ("eye.efficiency=2", "-D eye.efficiency: 2: above 0 and at most 1"),
        ("eye=3", "a table of keys"),
        (
            "species.figur.density=1",
            "table [species.figur] in a file, as `lodbench show` writes one; did you mean figure?",
        ),
        ("species.zzz.density=1", "one of: figure, tree"),
        ("camera.height=0", "-D camera.height: 0: above 0"),
        ("camera.height=nan", "nan: a finite number"),
        ("camera.height=1e999", "inf: a finite number"),
        ("camera.height=" + "9" * 5000, "a number"),
        ("camera.position=[1]", "-D camera.position[1]"),
        ("camera.position=[0, inf]", "-D camera.position[1]: inf: a finite number"),
        ("camera.fov=180", "above 0 and below 180"),
        ("camera=3", "a table of keys; `lodbench list --keys` shows every key"),
        ("species.figure.density=-1", "-D species.figure.density: -1: at least 0"),
        ("species.figure.density=nan", "-D species.figure.density: nan: a finite number"),
        ("species.figure.prototypes=0", "at least 1"),
        ("species.figure.sizes=[]", "-D species.figure.sizes: (): at least 1"),
        ("species.figure.sizes=[0.0]", "-D species.figure.sizes[0]: 0.0: at least 0.001"),
        ("species.figure.model=elf", "'elf': one of 'figure', 'boulder', 'sward', 'giraffe'"),
        ("species.elk={model='tree'}", "-D species.elk.density: missing: a required key"),
        ("species.9={model='tree', density=1}", "letter first; try oak_2"),
        (f"species.{'a' * 99}={{model='tree', density=1}}", "64 characters; try a shorter one"),
        ("species=3", "a table of keys; `lodbench list --keys`"),
        ("air.visibility=20", 'write "20km" or "20m"'),
        ("air.visibility=0.5m", "1m to 330km"),
        ("world.extent=0", "above 0"),
        ("view.metric=blak", "one of blake, bounded"),
        ("view.metric=full", "-D view.metric: 'full': needs a finite world"),
        ("view.detail=0", "-D view.detail: 0: above 0"),
        ("light.sun_elevation=91", "at most 90"),
        ("render.spp=0", "at least 1"),
        ("render.size=0x0", "'0x0': each side from 1"),
        ("render.size=640", "WIDTHxHEIGHT"),
        ("terrain.hurst=0", "above 0 and at most 1"),
        ("terrain.wavelength=1000", "1000: a power of two; try 1024"),
        ("terrain.wavelength=-2", "-D terrain.wavelength: -2: "),
        ("terrain.wavelength=33554432", "at most 16777216"),
        ("seed", "-D: 'seed': key=value"),
        ("=3", "key=value"),
        ("seed=", "key=value"),
        ("seed=1\nabout='x'", "a whole number"),
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
        ("seed = 1\ncamera = {height = nan}", "camera.height: nan: a finite number"),
        ("[species.elk]\nmodel = 'tree'\ndensity = inf", "species.elk.density: inf"),
        (
            "[air]\nvisibillity = '20km'",
            "air.visibillity: '20km': no such key; did you mean air.vis",
        ),
        ("visibility = '20km'", "did you mean air.visibility?"),
        ("seed = \n", "'seed =': not TOML: Invalid value (at line 1, column 8)"),
        ("seed = 1\nseed = 2", "not TOML"),
        ("[camera", "'[camera': not TOML"),
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


def test_an_error_blames_the_flag_that_set_the_key() -> None:
    with pytest.raises(InputError, match=r"^--spp: 0: at least 1"):
        load_preset("meadow", [Setting("--spp", "render.spp", 0)])
