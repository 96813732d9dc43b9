"""Spread and budget: what is predicted, what is judged, and a fault that is planted."""

from dataclasses import replace
from functools import partial

import numpy as np
import pytest

from bench.experiments import spread
from bench.experiments.spread import (
    BUDGET,
    EXPERIMENT,
    detail_within,
    measure_spread,
    pattern_of,
)
from bench.records.records import Column, Point, predictions
from bench.runs import case_label
from scenes.field.patterns import ThomasCells

TIGHT = ("tight clusters", None)


def test_the_budgets_detail_is_where_the_prediction_meets_it():
    pattern = pattern_of(*TIGHT)
    detail = detail_within(pattern, 1500)
    assert pattern.predict(detail).quantile(0.99) == pytest.approx(1500, rel=1e-3)
    assert detail_within(pattern, 400) > detail > detail_within(pattern_of("Poisson", None), 1500)


def judged_point(parts, topic="spread"):
    case = {"topic": topic, "pattern": "Poisson", "species": "figure", "detail": 10.0}
    told = predictions({"mean": 100.0, "variance": 2500.0, "percentile": 246.0})
    rows = [Column("parts", row, {"walk": k} if topic == "budget" else {}) for k, row in parts]
    return Point(case, told, tuple(rows))


def verdicts(point):
    return [each.verdict for each in EXPERIMENT.judged([point])]


def test_claims_follow_from_the_samples_alone():
    gamma = np.random.default_rng(1).gamma(4.0, 25.0, 40_000)
    told = judged_point([(0, gamma.round().astype(int).tolist())])
    assert verdicts(told) == ["holds"] * 3
    wider = judged_point([(0, (100 + 1.2 * (gamma - 100)).round().astype(int).tolist())])
    assert verdicts(wider) == ["holds", "refuted", "refuted"]


@pytest.mark.parametrize(("share", "verdict"), [(0.99, "holds"), (0.97, "refuted"), (1, "refuted")])
def test_a_budget_must_be_kept_and_used(share, verdict):
    most = BUDGET["figure"]
    over = round(100 * (1 - share))
    rows = [(k, [most + 1] * over + [most] * (100 - over)) for k in range(20)]
    rows[0] = (0, [most] * 99 + [most + 1])  # so that walks are not all alike
    assert verdicts(judged_point(rows, "budget")) == [verdict]


def test_a_map_is_told_by_its_name_alone():
    """Labels of cases stand in the record, which others read."""
    topic = EXPERIMENT.topics["spread"]
    *_, case = topic.cases(**topic.sizes("quick"), stems=("/home/me/stems.csv", "ab" * 32))
    assert case_label(case).startswith("stems of a map stems.csv, ")


@pytest.mark.slow
def test_the_pruner_keeps_the_prediction_and_a_planted_fault_is_named(monkeypatch):
    """Clusters of half as many members as they are said to have."""
    case = partial(measure_spread, TIGHT, 20.0, 2_000)
    name = "99th_percentile_of_a_frame_s_parts_over_predicted_by_pair_correlation"
    where = "tight_clusters/figure/20_px"
    before = {c.name: c.verdict for c in EXPERIMENT.judged([case(0)])}
    planted = partial(ThomasCells, parents=2 * spread.DENSITY / 10, sigma=8.0)
    pattern = replace(pattern_of(*TIGHT), cells=planted)
    monkeypatch.setattr(spread, "pattern_of", lambda *of: pattern)
    after = {c.name: c.verdict for c in EXPERIMENT.judged([case(0)])}
    assert before[f"{name}/{where}"] != "refuted"
    assert after[f"{name}/{where}"] == "refuted"
