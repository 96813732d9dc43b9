"""A user's own preset in place of the experiments' worlds; and how a preset's frames grow."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from bench import preset_growth as growth
from bench import runs
from bench.experiment import experiments
from bench.frame_costs import own_kind
from bench.images.fields import EVERYTHING, Field
from bench.records.records import Point, columns, merge_points, read_record
from bench.runs import case_label
from lod.errors import InputError
from scenes.presets.load import load_preset
from tests.said import said

EXPERIMENTS = experiments()
MINE = """
[camera]
height = 2
[terrain]
amplitude = 3
reach = 500
[species.figure]
model = "figure"
density = 0.02
prototypes = 2
[species.sward]
model = "sward"
metric = "bounded"
density = 0.01
prototypes = 1
[render]
size = "64x36"
"""


@pytest.fixture
def mine(tmp_path):
    path = tmp_path / "mine.toml"
    path.write_text(MINE)
    return path


def grown(exponent, prefactor=1.0, cost=0.9, beyond=0.0, fields=4):
    """Points in which parts grow with a power of what is swept, as was predicted with 1 and 1."""
    made, noise = [], np.random.Generator(np.random.Philox(3))
    for sweep, (_, steps) in growth.SWEEPS.items():
        for step in steps:
            x = 1000.0 * step
            told = x if sweep != "world" else 1e5
            scatter = 1 + 0.002 * noise.normal(size=fields)
            parts = prefactor * told * (step**exponent / step) * scatter
            spent = 1e4 * (parts / 1e3) ** cost * (step**beyond if sweep == "world" else 1.0)
            counts = {
                "parts": np.rint(parts),
                "predicted": [1e3 * told] * fields,
                "cpu_us": np.rint(spent),
                "bytes": np.rint(100 * spent),
            }
            case = {"topic": "growth", "preset": "mine.toml", "metric": "blake", "sweep": sweep}
            samples = columns({name: [int(v) for v in row] for name, row in counts.items()})
            made.append(Point(case | {"x": x, "step": float(step)}, samples=samples))
    return made


def not_held(points):
    return {
        claim.name: claim.verdict for claim in growth.claims(points) if claim.verdict != "holds"
    }


def steady(points):
    return [p for p in points if p.case["sweep"] != "world"]


@settings(max_examples=10, deadline=None)
@given(st.floats(0.9, 1.1), st.floats(0.9, 1.1))
def test_exponent_and_prefactor_are_those_of_the_counts(exponent, prefactor):
    found = {c.estimand: c for c in growth.claims(steady(grown(exponent, prefactor)))}
    assert found["exponent of parts displayed against K"].measured == pytest.approx(
        exponent, abs=0.01
    )
    assert found["exponent of parts displayed against K"].value == 1.0


def test_verdicts_follow_from_what_is_planted():
    assert not_held(grown(1.0)) == {}
    assert set(not_held(grown(1.0, prefactor=1.2))) == {
        "parts_displayed_over_predicted/mine.toml/blake"
    }
    assert (
        not_held(steady(grown(1.2)))["exponent_of_parts_displayed_against_k/mine.toml/blake"]
        == "refuted"
    )
    dear = not_held(grown(1.0, cost=1.3))
    assert {name.split("/")[0] for name in dear} == {
        f"exponent_of_{cost}_against_parts_displayed" for cost in ("cpu_time", "memory")
    }
    world = not_held(grown(1.0, beyond=0.4))
    assert any("against_side_of_the_world" in name for name in world)


def test_windows_of_objects_have_no_grass_and_the_eye_in_their_middle(mine):
    preset, words = own_kind(load_preset(str(mine), ("camera.position=[900, 0]",)))
    changed = load_preset(preset, words)
    assert changed.camera.position == (0.0, 0.0)
    assert [name for name, each in changed.species.items() if each.density > 0] == ["figure"]
    with pytest.raises(InputError, match="grass is left out"):
        own_kind(load_preset(str(mine), ("species.figure.density=0",)))


def test_every_experiment_that_takes_a_preset_makes_cases_of_it_alone(mine):
    own = "mine.toml", load_preset(str(mine))
    for name in ("law", "images", "cost", "methods"):
        every = EXPERIMENTS[name]
        (topic,) = every.accepting("preset", every.topics)
        sizes = every.topics[topic].sizes("quick")
        told = dict.fromkeys(every.topics[topic].accepts) | {"preset": own}
        made = every.topics[topic].cases(**sizes, **told)
        assert made and "mine.toml" in repr(made[0].args), name
        assert not any("SpeciesPreset" in case_label(each) for each in made), name
        assert not any(f"'{preset}'" in repr(made) for preset in ("crowd", "forest", "eye level"))


def test_metrics_are_compared_of_all_species_and_the_preset_keeps_its_sun(mine):
    own = "mine.toml", load_preset(str(mine))
    fidelity = EXPERIMENTS["images"].topics["fidelity"]
    made = fidelity.cases(**fidelity.sizes("quick"), metric=None, preset=own)
    headline, sweep = (next(c for c in made if c.args[0] == what) for what in ("headline", "sweep"))
    for case, metric in ((headline, "bounded"), (sweep, None)):
        field = case.args[1]
        assert isinstance(field, Field) and field.view == "mine.toml"
        preset = field.preset(0)
        assert preset.species["sward"].metric == metric
        assert preset.light.sun_elevation == own[1].light.sun_elevation
    assert headline.args[2][0][0] == EVERYTHING


def test_a_preset_is_resumed_told_apart_and_reported(mine, tmp_path, capfd, monkeypatch):
    """What is measured is planted, so that the way from the command to the page is tried alone."""
    out = tmp_path / "out"

    def planted(name, preset, metric, sweep, first, seed):
        points = [p for p in grown(1.0) if p.case["sweep"] == sweep]
        one = [replace(c, values=c.values[:1], keys=c.keys) for p in points for c in p.samples]
        rows = [one[k : k + 4] for k in range(0, len(one), 4)]
        cases = [p.case | {"preset": name, "metric": metric} for p in points]
        return [Point(case, samples=tuple(row)) for case, row in zip(cases, rows, strict=True)]

    monkeypatch.setattr(growth, "measure", planted)
    monkeypatch.setattr(runs, "take_probe", lambda preset: {})
    words = ("run", "law", "--quick", "--preset", str(mine), "-o", str(out), "--json")
    code, first, err = said(capfd, *words)
    assert code == 0, err
    record = read_record(Path(json.loads(first)["record"]))
    assert record.subject == "law of mine.toml" and str(tmp_path) not in json.dumps(record.content)
    assert {p.case["topic"] for p in record.points} == {"growth"}
    assert not json.loads(first)["kept"] and json.loads(said(capfd, *words)[1])["kept"]
    mine.write_text(MINE.replace("0.02", "0.03"))
    code, other, err = said(capfd, *words)
    assert code == 0 and not json.loads(other)["kept"], err
    assert (
        read_record(Path(json.loads(other)["record"])).provenance.scene != record.provenance.scene
    )
    assert "density = 0.03" in read_record(Path(json.loads(other)["record"])).notes["preset_text"]
    code, _, err = said(capfd, "report", str(out))
    assert code == 0, err
    page = (out / "report.md").read_text()
    assert "## law of mine.toml: quick run" in page
    assert "lodbench run growth --preset mine.toml --quick" in page


@pytest.mark.slow
def test_the_steps_of_a_preset_are_counted_predicted_and_timed(mine, monkeypatch):
    steps = {name: (axis, some[:3]) for name, (axis, some) in growth.SWEEPS.items()}
    monkeypatch.setattr(growth, "SWEEPS", steps)
    preset = load_preset(str(mine))
    fields = [
        point
        for sweep in steps
        for first in (900, 901)
        for point in growth.measure("mine.toml", preset, "blake", sweep, first, 0)
    ]
    merged = merge_points(fields)
    assert len(merged) == 9 and all(len(p.column("parts")) == 2 for p in merged)
    found = {c.estimand: c for c in growth.claims(merged)}
    assert 0.5 < found["parts displayed ÷ predicted"].measured < 2
    assert found["exponent of parts displayed against K"].value == pytest.approx(1, abs=0.01)
    assert all(c.verdict != "refuted" for c in found.values() if c.kind == "verification")


@pytest.mark.slow
@pytest.mark.parametrize("name", ["images", "cost", "methods"])
def test_a_preset_of_ones_own_is_judged_by_each(name, mine, tmp_path, capfd, monkeypatch):
    tiny = {
        "images": {"fields": 2, "sweep_fields": 2, "size": "32x18", "sweep_size": "32x18"},
        "cost": {"worlds": {"crowd": [30.0]}, "size": "32x18", "frames": 2, "samples": [4, 16]},
        "methods": {"worlds": [["crowd", 30.0, 2, []]], "size": "32x18", "spp": 4, "pairs": 1},
    }
    every = EXPERIMENTS[name]
    (topic,) = every.accepting("preset", every.topics)
    asked = every.topics[topic]
    few = {**asked.quick, **tiny[name]}
    if name == "images":
        few |= {"samples": [4, 16], "sweep_samples": [4, 16], "light_passes": 4}
    changed = replace(every, topics={**every.topics, topic: replace(asked, quick=few)})
    monkeypatch.setitem(EXPERIMENTS, name, changed)
    code, out, err = said(
        capfd, "run", name, "--quick", "--preset", str(mine), "-o", str(tmp_path), "--json"
    )
    assert code == 0, err
    record = read_record(Path(json.loads(out)["record"]))
    assert record.subject == f"{name} of mine.toml"
    assert all("mine.toml" in p.case.values() for p in record.points)
    assert record.claims and changed.plots(record)
