"""The scaling experiment: its grid, its predictions, its sampling and its verdicts."""

from dataclasses import replace
from functools import partial
from itertools import count

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import lod.metric
import lod.view
from bench.experiment import experiments, silent
from bench.experiments.scaling import count_field as scaling_measure
from bench.experiments.scaling import measure as scaling
from bench.experiments.scaling.claims import FAR, beyond, judge, noise_of, swept
from bench.experiments.scaling.count_field import COLUMNS, count_field, scene_hash, seed_of
from bench.experiments.scaling.measure import SampledCase, sampled_cases
from bench.experiments.scaling.prediction import disc_in_square, predict, shown_areas
from bench.fields.cases import EYE_HEIGHT_M, SWEEPS, Case, cases
from bench.fields.scene import prototypes_of, view_of
from bench.old_experiment import Effort
from bench.records.records import Point, columns, predictions, read_record, write_record
from bench.runs import run_experiment
from bench.statistics.samples import StoppingRule, sample, worst_error
from lod.law import chained_limits
from lod.metric import METRICS

EXPERIMENTS = experiments()


SMALL = Case("density", "figure", "blake", density=0.01, detail=20.0)
FIGURES = [case for case in cases() if case.species == "figure"]


def of(sweep, metric="blake"):
    return [case for case in FIGURES if (case.sweep, case.metric) == (sweep, metric)]


# The grid


@pytest.mark.parametrize("metric", ["blake", "bounded", "solid_angle"])
def test_every_sweep_spans_two_decades(metric):
    for sweep in SWEEPS:
        chosen = of(sweep, metric)
        if chosen:
            values = [
                swept(Point(case.as_json(), predictions(predict(case).as_json())))
                for case in chosen
            ]
            assert max(values) / min(values) >= 100, sweep


def test_blake_is_swept_in_everything_and_m_in_three_ways():
    assert {case.sweep for case in FIGURES if case.metric == "blake"} == set(SWEEPS)
    for sweep, key in (("detail", "detail"), ("resolution", "width"), ("magnification", "fov")):
        chosen = of(sweep)
        assert len({getattr(case, key) for case in chosen}) == len(chosen) >= 5
        others = {"detail", "width", "fov"} - {key}
        assert all(len({getattr(case, other) for case in chosen}) == 1 for other in others)


def test_the_limit_is_far_beyond_the_eye_height_wherever_the_power_of_m_is_claimed():
    for sweep in ("size", "detail", "resolution", "magnification"):
        assert all(predict(case).nearest_limit > FAR * EYE_HEIGHT_M for case in of(sweep))


@pytest.mark.parametrize("metric", ["blake", "bounded", "solid_angle"])
def test_worlds_reach_from_well_inside_the_limit_to_far_outside(metric):
    worlds = of("world", metric)
    limit = predict(worlds[0]).farthest_limit
    sides = np.array([case.extent for case in worlds])
    assert sides.min() < 0.25 * 2 * limit
    outside = sides[sides > 2 * limit]
    assert len(outside) >= 5 and outside.max() / outside.min() > 1e4


@pytest.mark.parametrize("case", [of(sweep)[0] for sweep in SWEEPS], ids=list(SWEEPS))
def test_m_is_that_of_the_view(case):
    assert view_of(case).m == pytest.approx(case.m, rel=1e-12)


# The predictions


def test_objects_are_those_of_the_closed_form():
    trees = [each.hierarchy for each in prototypes_of("figure", 2.0)]
    case = replace(SMALL, size=2.0)
    by_hand = [
        np.pi * 0.01 * (((t.P[0] + t.R[0]) / case.m) ** 2 - (EYE_HEIGHT_M - t.position[0, 2]) ** 2)
        for t in trees
    ]
    assert predict(case).objects == pytest.approx(np.mean(by_hand), rel=1e-12)


@pytest.mark.parametrize("extent", [None, 30.0])
def test_the_noise_of_parts_is_that_of_pairs(extent):
    case = replace(SMALL, extent=extent)
    total = 0.0
    for prototype in prototypes_of("figure", 1.0):
        tree = prototype.hierarchy
        h = EYE_HEIGHT_M - tree.position[:, 2]
        areas = shown_areas(chained_limits(tree, METRICS["blake"], case.m), h, extent)
        total += 0.01 / 4 * np.minimum(areas[:, None], areas[None, :]).sum()
    assert predict(case).parts_variance == pytest.approx(total, rel=1e-12)


def test_predictions_owe_nothing_to_the_pruner(monkeypatch):
    def broken(*_):
        raise AssertionError("the pruner's limits were asked for")

    monkeypatch.setattr(lod.metric, "limit_distances", broken)
    monkeypatch.setattr(lod.view, "limit_distances", broken)
    assert predict(SMALL).parts > predict(SMALL).objects > 0


@given(st.floats(0.0, 3.0), st.floats(0.2, 3.0))
def test_disc_in_square(radius, side):
    area = disc_in_square(np.array([radius]), side)[0]
    width = min(radius, side / 2) / 4000
    x = (np.arange(4000) + 0.5) * width  # one quarter, column by column
    height = np.minimum(np.sqrt(np.maximum(radius**2 - x**2, 0.0)), side / 2)
    assert area == pytest.approx(4 * width * height.sum(), rel=1e-4, abs=1e-9)


def test_a_world_beyond_the_limit_is_an_endless_one():
    endless, vast = predict(SMALL), predict(replace(SMALL, extent=1e6))
    assert vast.as_json() == pytest.approx(endless.as_json(), rel=1e-12)
    tiny = predict(replace(SMALL, extent=2.0))
    assert tiny.objects == pytest.approx(0.01 * 4.0)


# Counting and sampling


def test_fields_are_functions_of_their_seed():
    seeds = [seed_of(SMALL, 0, index) for index in range(50)]
    assert len({*seeds, seed_of(SMALL, 1, 0), seed_of(replace(SMALL, size=2.0), 0, 0)}) == 52
    assert all(0 <= seed < 2**63 for seed in seeds)
    assert count_field(SMALL, seeds[0]) == count_field(SMALL, seeds[0])
    assert len({count_field(SMALL, seed) for seed in seeds[:10]}) > 5


def test_nothing_is_displayed_unexamined():
    for index in range(10):
        row = dict(zip(COLUMNS, count_field(SMALL, seed_of(SMALL, 0, index)), strict=True))
        assert row["objects"] <= row["objects_examined"] <= row["parts_examined"]
        assert row["objects"] <= row["parts"] <= row["parts_examined"]


def test_counts_are_near_their_prediction():
    point = scaling.measure(SampledCase(SMALL, StoppingRule(0.03, 4, 4000)), seed=0)
    for what in ("objects", "parts"):
        found = np.mean(point.column(what)) / point.prediction(what)
        assert found == pytest.approx(1.0, abs=0.09)  # three standard errors


def test_sampling_goes_on_until_the_error_is_small():
    chance = np.random.default_rng(0)
    asked = count()

    def draw(index):
        assert index == next(asked)
        return int(chance.poisson(30)), int(chance.poisson(400)), int(chance.poisson(1))

    rows = sample(draw, needed=10, judged=2, rule=StoppingRule(0.01, 4, 5000))
    assert worst_error(rows, 2) < 0.01 < worst_error(rows[: len(rows) // 2], 2)
    assert 200 < len(rows) < 800


def test_sampling_stops_at_the_cap_and_starts_with_the_least():
    noisy = iter(range(10**9))
    rows = sample(lambda _: (next(noisy) % 2 * 1000, 1), 3, 2, StoppingRule(0.001, 4, 50))
    assert len(rows) == 50
    assert len(sample(lambda _: (5, 5), 1, 2, StoppingRule(0.001, 4, 50))) == 4
    assert len(sample(lambda _: (0, 0), 1, 2, StoppingRule(0.1, 4, 50))) == 50


# The verdicts, on synthetic counts


def synthetic(chance, prefactor=1.0, drift=0.0, power=1.0, search=0.0, effort=0.004):
    """Points of the figures' grid, with counts drawn about a law that may be a false one."""
    points = []
    for case in FIGURES:
        law = predict(case).as_json()
        samples = {}
        factor = prefactor * (case.extent or 1.0) ** drift
        for what in ("objects", "parts"):
            mean = factor * law[what] ** power
            spread = np.sqrt(law[f"{what}_variance"] * mean / law[what])
            fields = max(4, int((spread / mean / effort) ** 2))
            drawn = np.maximum(np.rint(chance.normal(mean, spread, min(fields, 2000))), 0)
            samples[what] = [int(n) for n in drawn]
            wasted = 2 * (case.extent or 1.0) ** search
            samples[f"{what}_examined"] = [round(wasted * n) for n in drawn]
        points.append(Point(case.as_json(), predictions(law), columns(samples)))
    return tuple(points)


def verdicts(points):
    return {claim.name: claim.verdict for claim in judge(points)}


def test_a_true_law_is_not_refuted():
    found = verdicts(synthetic(np.random.default_rng(0)))
    assert len(found) >= 25
    assert set(found.values()) == {"holds"}


def test_a_false_prefactor_is_refuted():
    found = verdicts(synthetic(np.random.default_rng(1), prefactor=1.05))
    ratios = {name: verdict for name, verdict in found.items() if name.endswith("/ratio")}
    assert set(ratios.values()) == {"refuted"} and len(ratios) == 6
    assert found["blake/figure/objects/slope_size"] == "holds"


def test_a_false_power_is_refuted():
    found = verdicts(synthetic(np.random.default_rng(2), power=1.05))
    for name in ("slope_density", "slope_size", "slope_detail", "slope_prediction"):
        assert found[f"blake/figure/objects/{name}"] == "refuted"
    assert found["bounded/figure/objects_examined/slope_prediction"] == "refuted"


def test_a_world_that_matters_is_refuted():
    found = verdicts(synthetic(np.random.default_rng(3), drift=0.01))
    assert found["blake/figure/objects/slope_world"] == "refuted"
    assert found["blake/figure/objects_examined/slope_world"] == "refuted"


def test_a_search_that_grows_with_the_world_is_refuted():
    found = verdicts(synthetic(np.random.default_rng(6), search=0.01))
    assert found["blake/figure/objects/slope_world"] == "holds"
    assert found["blake/figure/objects_examined/slope_world"] == "refuted"


def test_worlds_within_the_limit_do_not_count_against_it():
    points = synthetic(np.random.default_rng(4))
    worlds = [p for p in points if p.case["sweep"] == "world" and p.case["metric"] == "blake"]
    assert 0 < sum(map(beyond, worlds)) < len(worlds)


def test_the_noise_is_told():
    found = noise_of(synthetic(np.random.default_rng(5)))
    assert set(found) == {
        f"{metric}/figure/{what}"
        for metric in ("blake", "bounded", "solid_angle")
        for what in ("objects", "parts")
    }
    assert all(0.9 < value < 1.1 for value in found.values())


# From end to end


FEW = tuple(
    replace(SMALL, sweep=sweep, density=0.02 * factor, detail=20 * factor)
    for sweep in ("density", "detail")
    for factor in (0.5, 1.0)
)


def run_few(seed=0, progress=silent):
    cases = partial(sampled_cases, FEW)
    experiment = replace(EXPERIMENTS["scaling"], cases=lambda effort, metric: cases(effort))
    effort = Effort("quick", {"target": 0.1, "least": 3, "most": 50})
    return run_experiment(experiment, effort, seed, progress=progress)


def test_a_run_is_its_record(tmp_path):
    told = []
    record = run_few(progress=lambda *args: told.append(args))
    assert [done for done, _, _ in told] == [0, 1, 2, 3, 4]
    assert record.quick and record.experiment == "scaling"
    assert [point.case for point in record.points] == [case.as_json() for case in FEW]
    assert record.provenance.scene == hashed(FEW)
    assert record.notes["target_standard_error"] == 0.1
    back = read_record(write_record(record, tmp_path))
    assert back == record and judge(back.points) == record.claims


def test_the_same_seed_gives_the_same_samples():
    one, same, other = (run_few(seed) for seed in (0, 0, 1))
    assert one.samples_sha256 == same.samples_sha256 != other.samples_sha256
    assert one.provenance.scene == other.provenance.scene


def hashed(cases):
    return scene_hash(tuple(Point(case.as_json()) for case in cases))


def test_the_scene_hash_tells_shapes_apart(monkeypatch):
    before = hashed(FEW)
    monkeypatch.setattr(scaling_measure, "prototypes_of", lambda name, _: prototypes_of(name, 2.0))
    assert hashed(FEW) != before


def test_the_scene_hash_tells_scenes_apart():
    assert hashed(FEW) != hashed(FEW[:-1])
    assert hashed(FEW) != hashed((*FEW[:-1], replace(FEW[-1], density=0.5)))


def test_a_full_run_aims_at_half_a_per_cent():
    experiment = EXPERIMENTS["scaling"]
    assert experiment.full["target"] <= 0.005 < experiment.quick["target"]
