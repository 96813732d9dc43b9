"""`lodbench count --json` keeps its contract, and the words say the same."""

import json
import math

import pytest

from bench.cli.main import main

ADULTS = '{model="figure", density=0.01, prototypes=1}'
CHILDREN = '{model="figure", density=0.02, prototypes=1, sizes=[0.5]}'
SPECIES = ("-D", f"species={{adult={ADULTS}, child={CHILDREN}}}")
SMALL = "64x36"


def counted(capfd: pytest.CaptureFixture[str], *arguments: str, size: str = SMALL) -> str:
    with pytest.raises(SystemExit) as left:
        main(["count", "meadow", "--size", size, *SPECIES, *arguments])
    out, err = capfd.readouterr()
    assert left.value.code == 0, err
    return out


def test_the_json_is_one_object_with_every_key(capfd: pytest.CaptureFixture[str]) -> None:
    out = counted(capfd, "--json")
    assert out.count("\n") == 1
    data = json.loads(out)
    for kind in ("objects", "parts"):
        tally = data[kind]
        assert set(tally) == {"examined", "displayed", "predicted", "predicted_sd"}
        assert 0 < tally["displayed"] <= tally["examined"]
        assert tally["predicted_sd"] > 0
    assert set(data["by_species"]) == {"adult", "child"}
    total = sum(each["parts"]["displayed"] for each in data["by_species"].values())
    assert total == data["parts"]["displayed"] == sum(data["by_level"])
    assert data["terrain"]["tiles"] > 0
    assert data["terrain"]["triangles"] > 0
    assert data["terrain"]["predicted"] is None
    assert data["detail"] == 1.0
    assert data["m"] == pytest.approx(2 * math.tan(math.radians(30)) / 64)
    assert all(spent >= 0 for spent in data["seconds"].values())
    assert data["peak_rss_bytes"] > 2**20


def test_what_has_no_law_is_null(capfd: pytest.CaptureFixture[str]) -> None:
    data = json.loads(counted(capfd, "--json", "--metric", "depth"))
    assert data["objects"]["predicted"] is None
    assert data["parts"]["predicted_sd"] is None


def test_haze_and_eye_show_less_and_the_law_knows(capfd: pytest.CaptureFixture[str]) -> None:
    """Flat ground, fog: what is left is what is predicted, within 4 standard deviations."""
    fog = ("--json", "--visibility", "300m", "--density", "adult=0.05")
    found = {}
    for name, flags in {
        "blind": ("--no-haze-aware",),
        "aware": (),
        "eye": ("--display-ppd", "67"),
    }.items():
        words = (*fog, *flags, "-D", "terrain.amplitude=0")
        found[name] = json.loads(counted(capfd, *words, size="640x36"))
        parts = found[name]["objects"]
        assert abs(parts["displayed"] - parts["predicted"]) < 4 * parts["predicted_sd"]
    objects = [found[name]["objects"]["displayed"] for name in ("blind", "aware", "eye")]
    assert objects[0] > 1.5 * objects[1] >= 1.5 * objects[2]
    assert found["aware"]["m"] == found["blind"]["m"]
    assert found["eye"]["m"] == pytest.approx(2.35 * found["blind"]["m"], rel=0.01)
