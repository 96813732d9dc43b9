"""The experiment law: its grid, its verdicts on planted counts, and a run from end to end."""

from dataclasses import asdict, replace
from functools import cache, partial

import numpy as np
import pytest

from bench.counting import (
    COLUMNS,
    SWEEPS,
    Case,
    beyond_grid,
    count_field,
    field_seed,
    predict,
    scaling_grid,
)
from bench.experiments.law import (
    EXPERIMENT,
    EXTENTS_M,
    QUADRANTS,
    beyond,
    measure_scaling,
    noise_of,
    over_flat_ground,
    rows,
)
from bench.records.records import (
    Column,
    Point,
    columns,
    predictions,
    read_record,
    where,
    write_record,
)
from bench.runs import RunRequest, run_experiment
from bench.statistics.estimates import StoppingRule
from tests.bench.edited import edited

SMALL = Case("density", "figure", "blake", density=0.01, detail=20.0)
FIGURES = [case for case in scaling_grid() if case.species == "figure" and case.sweep in SWEEPS]
law_of = cache(predict)


def point(case, samples):
    return Point({"topic": "scaling", **asdict(case)}, predictions(asdict(law_of(case))), samples)


def test_counts_are_near_their_prediction():
    found = measure_scaling(SMALL, StoppingRule(0.03, 4, 4000), seed=0)
    for what in ("objects", "parts"):
        ratio = np.mean(found.column(what)) / found.prediction(what)
        assert ratio == pytest.approx(1.0, abs=0.09)  # three standard errors


# Verdicts on planted counts


def planted(seed, prefactor=1.0, drift=0.0, power=1.0, search=0.0, effort=0.004):
    """Points of the figures' grid, with counts drawn about a law that may be a false one."""
    chance, points = np.random.default_rng(seed), []
    for case in FIGURES:
        law = asdict(law_of(case))
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
        points.append(point(case, columns(samples)))
    return tuple(points)


def verdicts(points):
    return {claim.name: claim.verdict for claim in EXPERIMENT.judged(points)}


GROWTH = "exponent_of_objects_displayed_against"
SEARCH = "exponent_of_objects_examined_against"


def test_a_true_law_is_not_refuted():
    points = planted(0)
    found = verdicts(points)
    assert len(found) >= 25
    assert set(found.values()) == {"holds"}
    noise = noise_of(points)
    assert len(noise) == 6 and all(0.9 < value < 1.1 for value in noise.values())
    worlds = where(points, sweep="world", metric="blake")
    assert 0 < sum(map(beyond, worlds)) < len(worlds)


def test_a_false_prefactor_is_refuted():
    found = verdicts(planted(1, prefactor=1.05))
    ratios = [verdict for name, verdict in found.items() if "_over_predicted/" in name]
    assert ratios == ["refuted"] * 6
    assert found[f"{GROWTH}_p_+_r/blake/figure/size"] == "holds"


def test_a_false_power_is_refuted():
    found = verdicts(planted(2, power=1.05))
    for name in ("k/blake/figure/density", "p_+_r/blake/figure/size", "m/blake/figure/detail"):
        assert found[f"{GROWTH}_{name}"] == "refuted"
    assert found[f"{GROWTH}_objects_predicted/blake/figure"] == "refuted"
    assert found[f"{SEARCH}_objects_displayed/bounded/figure"] == "refuted"


@pytest.mark.parametrize(("false", "displayed"), [("drift", "refuted"), ("search", "holds")])
def test_a_world_or_a_search_that_grows_with_it_is_refuted(false, displayed):
    found = verdicts(planted(3, **{false: 0.01}))
    assert found[f"{GROWTH}_l/blake/figure/world"] == displayed
    assert found[f"{SEARCH}_l/blake/figure"] == "refuted"


# Beyond even, flat, clear ground


@pytest.fixture(scope="module")
def points():
    made = []
    for case in beyond_grid():
        if case.sweep != "mixed":
            counts = [count_field(case, field_seed(asdict(case), 1, k)) for k in range(6)]
            samples = dict(zip(COLUMNS, map(list, zip(*counts, strict=True)), strict=True))
            made.append(point(case, columns(samples)))
    return tuple(made)


def test_the_extended_model_is_within_its_own_noise_everywhere(points):
    """31 points, objects and parts: no mean of six fields is 4.5 standard errors off."""
    for each in points:
        for what in ("objects", "parts"):
            mean, spread = np.mean(each.column(what)), each.prediction(f"{what}_variance") / 6
            assert abs(mean - each.prediction(what)) < 4.5 * spread**0.5, (each.case, what)


def test_where_the_flat_ground_model_breaks(points):
    hardest = {p.case["sweep"]: over_flat_ground(p) for p in points}
    assert 0.98 < hardest["slope"].value < 1.02
    for sweep in ("hills", "clearing", "near", "height", "haze"):
        assert hardest[sweep].value < 0.96, sweep


def twice(row):
    return [2 * n for n in row]


def test_verdicts_follow_from_the_samples(points):
    before = verdicts(points)
    assert before["objects_displayed_over_flat-ground_model/the_near_field/0.72"] == (
        "expected violation"
    )
    after = verdicts(tuple(edited(p, "objects", twice) for p in points))
    extended = [v for k, v in after.items() if k.startswith("objects_displayed_over_extended")]
    assert set(extended) == {"refuted"}


def test_a_violation_is_expected_where_the_extended_model_says_so_alone(points):
    """Where the two models agree, counts that are off refute the flat-ground one."""
    alike = tuple(
        replace(
            edited(p, "objects", twice),
            predicted=tuple(
                replace(each, value=p.prediction("objects")) if each.quantity == "bare" else each
                for each in p.predicted
            ),
        )
        for p in points
    )
    flat = [c for c in EXPERIMENT.judged(alike) if "flat-ground" in c.estimand]
    assert flat and {c.verdict for c in flat} == {"refuted"}
    hills = [
        c for c in EXPERIMENT.judged(points) if "flat-ground" in c.estimand and "hills" in c.where
    ]
    assert [c.violation_expected for c in hills] == [False, True]


@pytest.mark.slow
def test_several_species_are_counted_together():
    case = next(case for case in beyond_grid() if case.sweep == "mixed")
    counts = [count_field(case, field_seed(asdict(case), 1, k)) for k in range(12)]
    samples = dict(zip(COLUMNS, map(list, zip(*counts, strict=True)), strict=True))
    found = rows([point(case, columns(samples))], "objects").over_prediction()
    assert found.low < 1.02 and found.high > 0.98


# Depth complexity


def pierced_points(favoured=1.0, growing=0.0):
    rng = np.random.Generator(np.random.Philox(2))
    draws = rng.poisson(400, (300, QUADRANTS)).astype(float)
    draws[:, 0] *= favoured
    points = []
    for extent in EXTENTS_M:
        for metric in ("blake", "full"):
            by = extent / EXTENTS_M[0] if metric == "full" else extent**growing
            counts = np.rint(draws * by).astype(int)
            found = [
                Column("pierced", counts[:, k].tolist(), {"quadrant": k}) for k in range(QUADRANTS)
            ]
            case = {"topic": "depth", "extent": extent, "metric": metric}
            points.append(Point(case, samples=tuple(found)))
    return tuple(points)


def test_verdicts_follow_from_surfaces_pierced():
    assert {c.verdict for c in EXPERIMENT.judged(pierced_points())} == {"holds"}
    refuted = [
        c.name for c in EXPERIMENT.judged(pierced_points(growing=0.5)) if c.verdict == "refuted"
    ]
    assert refuted == ["surfaces_pierced_side_of_the_world_450_m_over_300_m/pruned"]
    found = verdicts(pierced_points(favoured=2.0))
    assert found["surfaces_pierced_over_mean_of_all_directions/pruned/1"] == "refuted"


# From end to end


FEW = tuple(
    replace(SMALL, sweep=sweep, density=0.02 * factor, detail=20 * factor)
    for sweep in ("density", "detail")
    for factor in (0.5, 1.0)
)


def run_few(seed=0, topics=("scaling",), **more):
    def cases(metric, **rule):
        return [partial(measure_scaling, case, StoppingRule(**rule)) for case in FEW]

    scaling, depth = (EXPERIMENT.topics[name] for name in ("scaling", "depth"))
    rule = {"target": 0.1, "least": 3, "most": 50}
    few = {
        "scaling": replace(scaling, cases=cases, quick=rule),
        "depth": replace(depth, quick={"fields": 2}),
    }
    experiment = replace(EXPERIMENT, topics=few)
    return run_experiment(experiment, RunRequest("law", topics, True, seed), **more)


def test_a_run_is_its_record(tmp_path):
    told = []
    record = run_few(topics=("scaling", "depth"), progress=lambda *args: told.append(args))
    assert [done for done, _, _ in told] == list(range(13))
    assert record.quick and record.experiment == "law"
    named = [{"topic": "scaling", **asdict(case)} for case in FEW]
    assert [p.case for p in where(record.points, topic="scaling")] == named
    assert record.notes["sizes"]["scaling"]["target"] == 0.1
    back = read_record(write_record(record, tmp_path))
    assert back == record and EXPERIMENT.judged(back.points) == record.claims


def test_the_same_seed_gives_the_same_samples():
    one, same, other = (run_few(seed) for seed in (0, 0, 1))
    assert one.samples_sha256 == same.samples_sha256 != other.samples_sha256
    assert one.provenance.scene == other.provenance.scene
