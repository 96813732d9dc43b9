"""The study of acting, small: who may wait, how far off that is, and that nobody meets."""

import json
from pathlib import Path

import numpy as np
from click.testing import CliRunner

from bench.acting import (
    KINDS,
    Crowd,
    Saving,
    acted_on_a_copy,
    costs,
    costs_by_behaviour,
    feet_of_actors,
    feet_of_the_field,
    meetings,
    nearest_m,
    off_px,
    saving,
    sticks_off_px,
    troupe_of,
    verdict_rows,
    walkers,
    walking_rows,
)
from bench.studies.acting import study
from lod.pruner import prune
from scenes.actors.acting import Rules
from scenes.actors.behaviours import BEHAVIOURS
from scenes.scene import view_at
from scenes.world.cast import make_cast
from scenes.world.world import build_world, make_terrain


def test_those_who_wait_are_off_by_less_than_the_threshold():
    found = saving(Crowd(16, threshold=8.0), 8, 0, looks=2)
    assert 0.1 < found.updated < 0.9
    assert 0 < found.at_once_px[0] <= found.at_once_px[1] < 8.0
    assert 0 < found.in_time_px[1] < 8.0
    assert 0.99 < found.parts_ratio < 1.01


def test_a_copy_acts_and_leaves_the_scene_as_it_was():
    """The copy does what the scene then does with everyone updated, and is told apart from it."""
    preset = walkers(6, 20.0, 8, 64.0, 0)
    once, again = troupe_of(preset), troupe_of(preset)
    for _ in range(3):
        once.acting.act(), again.acting.act()
    copied = acted_on_a_copy(once.acting, 4)
    once.acting.rules = Rules()
    meant = [once.acting.act() for _ in range(4)]
    assert all(np.array_equal(a.places, b.places) for a, b in zip(copied, meant, strict=True))
    waited = [again.acting.act() for _ in range(4)]
    assert not np.array_equal(waited[-1].places, copied[-1].places)
    view = view_at(build_world(preset), preset, 3)
    assert off_px(troupe_of(preset).cast, copied[-1], view, 3).max() > 0.5


def test_sticks_are_held_against_the_same_sticks():
    """Of the same cast nothing is off; of one in which a head has turned, its parts alone."""
    plain = walkers(4, 20.0, 4, 0.0, 0)
    said = {"to": "walker_1 head", "do": "turn z 20deg"}
    turned = plain.model_validate(plain.model_dump() | {"script": (said,)})
    shown, other = (make_cast(each, make_terrain(each)) for each in (plain, turned))
    view = view_at(build_world(plain), plain, 2)
    assert sticks_off_px(shown, shown, view).max() == 0.0
    off = sticks_off_px(shown, other, view)
    parts = prune(shown, view).parts
    assert set(parts.object[off > 1e-6].tolist()) == {0}
    assert 0 < np.count_nonzero(off) < 20


def test_people_keep_clear_of_each_other():
    assert min(nearest_m(8, 8.0, 24, 0)) > 0.4


def test_feet_stand_as_those_of_the_field_do():
    """In the first second all set off and turn; where feet are not planted it is 13 mm a frame."""
    actors, field = feet_of_actors(8, 12.0, 1.0, 0), feet_of_the_field(8, 6.0, 1.0, 0)
    assert field.slide_mm[0] < 2.5
    assert actors.slide_mm[0] < 11.5
    assert max(actors.sink_mm, field.sink_mm) < 1.7


def test_the_split_of_an_update_is_the_whole():
    found = costs(6, 20.0, 8, 0)
    assert set(found.split) == {*KINDS, "else"}
    assert np.isclose(sum(found.split.values()), found.update_us)
    assert found.prune_us > 0


def test_every_shipped_behaviour_of_bodies_is_measured():
    found = costs_by_behaviour(4, 12.0, 2, 0).found
    shipped = {"walk", "follow", "flee", "herd", "face_wind"}
    assert {each.who for each in found} == shipped | {"walk without waving"}
    assert shipped == set(BEHAVIOURS) - {"watch", "chase"}
    assert all(each.actors == 4 and each.update_us > 0 for each in found)


def test_waving_walkers_wave():
    """Some of ten who meet hold an arm up, unless they are told not to."""
    for waving in (False, True):
        acting = troupe_of(walkers(10, 10.0, 24, 0.0, 1, waving)).acting
        assert bool([k for _ in range(24) for k in acting.act().held]) is waving


def test_the_verdict_is_of_the_bound_that_saves_most_within_the_error():
    def found(bound, times, at_once, in_time):
        crowd = Crowd(1000, threshold=bound)
        return Saving(crowd, times, 1.0, 0.5, (at_once, 0.7), (in_time, 2.0), 1.0)

    several = verdict_rows([found(0.5, 2.0, 0.1, 0.4), found(2.0, 4.0, 0.3, 0.9)])
    assert (
        several[2] == "  at once: reached: 4.00 times at a bound of 2 px (0.300 px off, most 0.700)"
    )
    assert "in time: not reached at any bound tried (0.5, 2 px): 2.00 times" in several[3]
    assert (
        "not reached at the bound tried (8 px): 0.600 px"
        in verdict_rows([found(8.0, 9.0, 0.6, 0.7)])[2]
    )


def test_who_meets_in_a_preset_is_told_by_kinds():
    met = meetings("playground", 2)
    assert met.updated == 1.0  # in the first frames everyone sets off
    assert met.overlapping == 0
    assert met.nearest_m["figure and figure"] > 0.4
    assert "overlapping in 0 of 2 frames" in "\n".join(walking_rows([], [met], []))


def test_a_run_goes_on_with_what_is_not_there(tmp_path, monkeypatch):
    path, asked = tmp_path / "r.json", []
    real = study.measurements

    def counted(quick, seed):
        for name, measure in real(quick, seed):
            yield name, lambda name=name, measure=measure: asked.append(name) or measure()

    monkeypatch.setattr(study, "measurements", counted)
    for only in ("feet field", "feet f,clear", "clear"):
        words = ["--quick", "-o", str(path), "--only", only]
        said = CliRunner().invoke(study.command, words)
        assert said.exit_code == 0, said.output
    assert asked == ["feet field", "clear 1"]
    assert "overlapping in 0 of 24 frames" in said.output
    data = json.loads(path.read_text())
    assert data["origins"] == {}
    data["origin"]["seed"] = 7
    path.write_text(json.dumps(data))
    words = ["--quick", "-o", str(path), "--only", "feet a"]
    assert CliRunner().invoke(study.command, words).exit_code == 0
    data = json.loads(path.read_text())
    assert data["origin"]["seed"] == 7
    assert {name: each["seed"] for name, each in data["origins"].items()} == {"feet actors 1": 0}
    path.write_text("{}")
    refused = CliRunner().invoke(study.command, ["--quick", "-o", str(path)])
    assert "a record that this study wrote" in str(refused.exception)


def test_the_page_of_results_says_what_the_record_holds():
    results = Path(__file__).parents[3] / "results"
    said = study.page(study.read_record(results / "acting.json"))
    assert len(said) > 500
    assert said in (results / "acting.md").read_text(encoding="utf-8")
