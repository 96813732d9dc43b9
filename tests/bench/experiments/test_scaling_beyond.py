"""The law beyond even, flat, clear ground: what it adds is right, and the bare law breaks."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import quad

from bench.experiments.scaling.cases_beyond import BEYOND, beyond_cases, swept_beyond
from bench.experiments.scaling.claims import judge
from bench.experiments.scaling.claims_beyond import judge_beyond, over_bare, over_law
from bench.experiments.scaling.count_field import COLUMNS, chance, count_field, seed_of, stands
from bench.experiments.scaling.plots_beyond import beyond_plots
from bench.experiments.scaling.prediction import cleared, clumping, predict
from bench.fields.cases import Case
from bench.fields.scene import KEPT
from bench.records.provenance import provenance
from bench.records.records import Point, Record, columns, predictions
from tests.bench.edited import edited

CASES = [case for case in beyond_cases() if case.sweep != "mixed"]


def measured(case, fields):
    rows = [count_field(case, seed_of(case, 1, k)) for k in range(fields)]
    return dict(zip(COLUMNS, map(list, zip(*rows, strict=True)), strict=True))


def point(case, fields=6):
    return Point(
        case.as_json(), predictions(predict(case).as_json()), columns(measured(case, fields))
    )


@pytest.fixture(scope="module")
def points():
    return [point(case) for case in CASES]


def test_every_question_is_swept_from_mild_to_hard():
    assert {case.sweep for case in beyond_cases()} == set(BEYOND)
    assert {case.gathered for case in beyond_cases()} == set(KEPT)
    for sweep in BEYOND:
        values = [swept_beyond(case) for case in beyond_cases() if case.sweep == sweep]
        assert len(values) >= 3
        assert values in (sorted(values), sorted(values)[::-1])


def test_the_law_that_knows_is_within_its_own_noise_everywhere(points):
    """31 points, objects and parts: no mean of six fields is 4.5 standard errors off."""
    for each in points:
        for what in ("objects", "parts"):
            mean, spread = np.mean(each.column(what)), each.prediction(f"{what}_variance") / 6
            assert abs(mean - each.prediction(what)) < 4.5 * spread**0.5, (each.case, what)


def test_where_the_bare_law_breaks(points):
    hardest = {p.case["sweep"]: over_bare(p) for p in points}
    assert 0.98 < hardest["slope"].value < 1.02
    for sweep in ("hills", "clearing", "near", "height", "haze"):
        assert hardest[sweep].value < 0.96, sweep


@pytest.mark.slow
def test_several_species_add_up():
    case = next(case for case in beyond_cases() if case.sweep == "mixed")
    alone = [predict(replace(case, species=s, density=case.density / 3)).objects
             for s in case.species.split("+")]  # fmt: skip
    assert predict(case).objects == pytest.approx(sum(alone), rel=1e-12)
    found = over_law([point(case, 12)], "objects")
    assert found.low < 1.02 and found.high > 0.98


def test_a_clearing_is_the_integral_of_its_density():
    for radius in (30.0, 100.0, 700.0):
        wanted = quad(lambda r: min(1, r / 100) * 2 * np.pi * r, 0, radius, points=[100.0])[0]
        assert cleared(np.array([np.pi * radius**2]), 100.0)[0] == pytest.approx(wanted, rel=1e-6)


def test_patches_are_clumped_as_the_law_says():
    case = Case("patches", "figure", "blake", 3.6e-3, detail=10.0, gathered="patches", scale=20.0)
    law = predict(case)
    counts = np.array(measured(case, 120)["objects"], np.float64)
    assert clumping(case) > 4
    assert 0.7 < counts.var(ddof=1) / law.objects_variance < 1.4


def test_a_patch_is_there_or_not_for_all_of_its_objects():
    cells = np.stack(np.meshgrid(np.arange(-150, 150), np.arange(-150, 150)), -1).reshape(-1, 2)
    u = chance(7, cells)
    assert np.array_equal(u, chance(7, cells))
    assert not np.array_equal(u, chance(8, cells))
    assert np.abs(np.histogram(u, 10, (0, 1))[0] - 9000).max() < 450
    assert np.abs(np.corrcoef(u[:-1], u[1:])[0, 1]) < 0.02
    patches = Case("patches", "figure", "blake", 1.0, gathered="patches", scale=8.0)
    close = np.array([[3.0, 3.0], [3.01, 3.01]])
    both = [stands(patches, close, seed) for seed in range(400)]
    assert np.mean([a == b for a, b in both]) > 0.98
    assert 0.18 < np.mean(both) < 0.32


def test_a_slope_has_its_density_at_the_eye_and_none_far_to_the_west():
    slope = Case("slope", "figure", "blake", 1.0, gathered="slope", scale=100.0)
    for x, share in ((0.0, 0.5), (100.0, 1.0), (-100.0, 0.0), (50.0, 0.75)):
        there = stands(slope, np.tile((x, 5.0), (4000, 1)), 3)
        assert there.mean() == pytest.approx(share, abs=0.03)


def twice(row):
    return [2 * n for n in row]


def test_verdicts_follow_from_the_samples(points):
    before = {c.name: c.verdict for c in judge_beyond(points)}
    assert {c.name for c in judge(tuple(points))} == set(before)
    assert before["beyond/near/bare_at_0.72"] == "fails as expected"
    doubled = [edited(p, "objects", twice) for p in points]
    after = {c.name: c.verdict for c in judge_beyond(doubled)}
    assert {v for k, v in after.items() if k.endswith("objects_ratio")} == {"refuted"}


def test_the_bare_law_is_expected_to_fail_where_the_knowing_one_says_so_alone(points):
    """Where the two laws agree, counts that are off refute the bare one."""
    alike = [
        replace(
            edited(p, "objects", twice),
            predicted=tuple(
                replace(each, value=p.prediction("objects")) if each.quantity == "bare" else each
                for each in p.predicted
            ),
        )
        for p in points
    ]
    bare = [c for c in judge_beyond(alike) if "/bare_at_" in c.name]
    assert bare and {c.verdict for c in bare} == {"refuted"}
    mild = [c for c in judge_beyond(points) if c.name.startswith("beyond/hills/bare_at_")]
    assert [c.expected_to_fail for c in mild] == [False, True]


def test_every_sweep_has_its_figure(points):
    record = Record("scaling", 2, True, "", provenance("", 0), tuple(points), (), {})
    names = {plot.name for plot in beyond_plots(record)}
    assert names == {f"beyond-{sweep}" for sweep in BEYOND if sweep != "mixed"}
