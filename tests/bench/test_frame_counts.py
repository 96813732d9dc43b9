"""What a count predicts is the law's integral, whatever the sides of the picture cut off.

A workload is its counts: the same for everyone, or another version.
"""

import json

import pytest

from bench import frame_counts as count_frame
from bench import frame_counts as workloads
from bench.cli.main import main
from bench.frame_counts import Workload, first_frame_counts, predict, workload_named
from lod.errors import InputError
from scenes.presets.load import load_preset, preset_names
from scenes.scene import Scene


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


def test_grass_is_predicted_where_it_is_displayed_in_view_alone():
    others = [f"species.{name}.density=0" for name in ("figure", "tree")]
    scene = Scene(load_preset("meadow", ["view.detail=3", "species.sward.prototypes=1", *others]))
    found = count_frame.count(scene.world, scene.view(1))
    for each in (found.objects, found.parts):
        assert abs(each.displayed - each.predicted) < 4 * each.predicted_sd


QUICK = "fly_in"


def run(*words):
    with pytest.raises(SystemExit) as left:
        main(["count", *words])
    return left.value.code


def test_every_preset_is_a_workload():
    assert list(workloads.workloads()) == [name for name, _ in preset_names()]


@pytest.mark.slow
@pytest.mark.parametrize("name", [name for name, _ in preset_names()])
def test_all_golden_counts_are_counted(name):
    assert workloads.workloads()[name].mismatches(first_frame_counts(name)) == []


def test_a_workload_is_counted_and_found_golden(capfd):
    name = workloads.workloads()[QUICK].name
    assert run(name, "--json") == 0
    assert json.loads(capfd.readouterr().out)["workload"] == {"name": name, "golden": True}


def test_a_changed_workload_is_found_out(monkeypatch, capfd):
    (true,) = [each for each in workloads.workloads().values() if each.preset == QUICK]
    false = Workload(QUICK, 7, {**true.counts, "parts": true.counts["parts"] + 1})
    monkeypatch.setattr(workloads, "workloads", lambda: {QUICK: false})
    assert run(f"{QUICK}@7", "--json") == 1
    out, err = capfd.readouterr()
    assert json.loads(out)["workload"]["golden"] is False
    assert f"{QUICK}@7: parts {true.counts['parts']} instead of {false.counts['parts']}" in err


@pytest.mark.parametrize("text", ["meadow@99", "meadow@", "nowhere@1"])
def test_other_versions_are_refused(text):
    with pytest.raises(InputError, match="a workload that this version makes"):
        workload_named(text)
    assert workload_named("meadow") is None


def test_a_workload_takes_no_other_settings(capfd):
    assert run(workloads.workloads()[QUICK].name, "--detail", "3") == 2
    assert "as it is" in capfd.readouterr().err
    assert run(workloads.workloads()[QUICK].name, "--frame", "2") == 2
