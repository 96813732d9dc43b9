"""A prediction is the law's integral whatever the picture cuts off, and golden counts repeat."""

import json

import pytest

from bench import frame_counts as count_frame
from bench.frame_counts import predict
from scenes.presets.load import load_preset, preset_names
from scenes.scene import Scene
from tests.tools.golden_counts import FILE, golden_counts


@pytest.mark.parametrize("pitch", [0, -50, -89])
def test_a_prediction_is_right_to_a_thousandth(monkeypatch, pitch):
    """Of a hundred kinds of people before a camera that looks along the ground, aside and down."""
    keys = ["species.tree.density=0", f"camera.pitch={pitch}", "camera.roll=20"]
    preset = load_preset("crowd", keys)
    scene = Scene(preset)
    world = scene.world
    view = scene.view(1)
    (people,) = [each for each in world.fields if each.name == "figure"]
    quick = predict(people, view)
    monkeypatch.setattr(count_frame, "_NODES", 2**20)
    fine = predict(people, view)
    assert quick.objects == pytest.approx(fine.objects, rel=1e-3)
    assert quick.parts == pytest.approx(fine.parts, rel=1e-3)


@pytest.mark.parametrize(
    "name",
    [
        pytest.param(name, marks=[pytest.mark.slow] * (name != "fly_in"))
        for name, _ in preset_names()
    ],
)
def test_first_frames_have_their_golden_counts(name):
    assert golden_counts(name) == json.loads(FILE.read_text())[name]


def test_grass_is_predicted_where_it_is_displayed_in_view_alone():
    others = [f"species.{name}.density=0" for name in ("figure", "tree")]
    scene = Scene(load_preset("meadow", ["view.detail=3", "species.sward.prototypes=1", *others]))
    found = count_frame.count(scene.world, scene.view(1))
    for each in (found.objects, found.parts):
        assert abs(each.displayed - each.predicted) < 4 * each.predicted_sd
