"""What switches in a step is what plane geometry says, and the verdicts follow from the counts."""

import math
import re

import numpy as np
import pytest

from bench.experiments.popping import plots as popping_plots
from bench.experiments.popping.claims import QUANTILES, SWITCHED, WAYS, judge
from bench.experiments.popping.measure import in_one_only
from bench.records.provenance import provenance
from bench.records.records import Column, Point, Record, columns, predictions


def test_area_in_one_disc_only():
    """Nothing without a step, both discs when apart, 4·r·s for a small step."""
    assert in_one_only(np.array([3.0]), 0.0)[0] == pytest.approx(0.0)
    assert in_one_only(np.array([3.0, 0.0]), 6.1).tolist() == pytest.approx([2 * math.pi * 9, 0])
    assert in_one_only(np.array([100.0]), 0.1)[0] == pytest.approx(4 * 100 * 0.1, rel=1e-6)
    rng = np.random.Generator(np.random.Philox(1))
    x, y = rng.uniform(-3, 5, (2, 400_000))
    inside = (np.hypot(x, y) < 2) != (np.hypot(x - 1.5, y) < 2)
    assert in_one_only(np.array([2.0]), 1.5)[0] == pytest.approx(64 * inside.mean(), rel=0.02)


def planted(switches=100.0, popped=0, worst=1.0):
    rng = np.random.Generator(np.random.Philox(5))
    counts = rng.poisson(switches, 200).tolist()
    samples = {"switches": counts, "size_mpx": [400] * 100, "distance_mm": [9000, 20_000] * 50}
    points = [
        Point(
            {"what": "switches", "species": "tree"},
            predictions({"switches": 100.0}),
            columns(samples),
        )
    ]
    for way, share in zip(WAYS, (0.001, 0.3 * worst, 1.0), strict=True):
        rows = {q: [round(1e6 * share) + k for k in range(6)] for q in QUANTILES}
        many = [popped, popped + 1, popped] if way == "clipped" else [popped] * 3
        changes = (Column(SWITCHED, row, {"quantile": q}) for q, row in rows.items())
        samples = (*columns({"popped": many}), *changes)
        points.append(Point({"what": "walk", "way": way}, samples=samples))
    return tuple(points)


def test_verdicts_follow_from_counts():
    verdict = {c.name: c.verdict for c in judge(planted())}
    for name in ("blake/tree/switches", "blake/tree/size", "walk/fading/popped"):
        assert verdict[name] == "holds", name
    for name in ("unpruned/switched", "fading/better", "fading/switched"):
        assert verdict[f"walk/{name}"] == "holds", name
    little = {c.name: c.verdict for c in judge(planted(worst=2.0))}
    assert little["walk/fading/switched"] == "refuted" and little["walk/fading/better"] == "holds"
    wrong = {c.name: c.verdict for c in judge(planted(120.0, 9, 4.0))}
    for name in ("blake/tree/switches", "walk/fading/popped", "walk/fading/better"):
        assert wrong[name] == "refuted", name


def test_the_report_shows_switches_and_walks():
    points = planted()
    made = Record("popping", 1, True, "", provenance("", 0), points, judge(points), {})
    heads, rows = popping_plots.point_table(made)
    assert len(rows) == len(points) and all(len(row) == len(heads) for row in rows)
    assert not any(re.search(r"\bnan\b", plot.svg) for plot in popping_plots.plots(made))
