"""Surfaces that a ray pierces are those of geometry, and the verdicts follow from their counts."""

import re

import numpy as np

from bench.experiments.depth import plots as depth_plots
from bench.experiments.depth.claims import QUADRANTS, judge
from bench.experiments.depth.measure import EXTENTS_M, RAYS, pierced
from bench.records.provenance import provenance
from bench.records.records import Column, Point, Record
from lod.shapes import Sticks

NORTH = np.array([[0.0, 1.0, 0.0]])
EYE = np.zeros(3)


def sticks(*rows):
    """Each a start, an end and two radii."""
    start, end, r0, r1 = (np.array(each, float) for each in zip(*rows, strict=True))
    zero = np.zeros(len(rows), np.int64)
    return Sticks(start, end, r0, r1, zero, np.ones((1, 3)), zero)


def seen(*row):
    return pierced(sticks(row), EYE, NORTH).tolist()[0]


def test_a_stick_is_pierced_where_it_is_wide_enough():
    across = (-1.0, 9.0, 0.0), (1.0, 9.0, 0.0)
    assert seen(*across, 0.1, 0.1) == 1
    raised = (-1.0, 9.0, 0.25), (1.0, 9.0, 0.25)
    assert seen(*raised, 0.2, 0.2) == 0
    assert seen(*raised, 0.2, 0.4) == 1, "0.3 wide in the middle"
    assert seen((0.5, 9.0, 0.0), (2.0, 9.0, 0.0), 0.4, 0.6) == 0
    assert seen((0.5, 9.0, 0.0), (2.0, 9.0, 0.0), 0.6, 0.4) == 1
    assert seen((0.1, 5.0, 0.0), (0.1, 9.0, 0.0), 0.2, 0.2) == 1, "along the ray, once"
    assert seen((0.0, 5.0, 0.0), (0.0, 5.0, 0.0), 0.2, 0.2) == 1, "a sphere"
    assert seen((0.0, -9.0, 0.0), (0.0, -8.0, 0.0), 0.2, 0.2) == 0, "behind"


def test_every_stick_counts_for_every_ray():
    two = sticks(*[((-1.0, y, 0.0), (1.0, y, 0.0), 0.1, 0.1) for y in (4.0, 8.0)])
    rays = np.array([[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, -1.0, 0.0]])
    assert pierced(two, EYE, rays).tolist() == [2, 0, 0]


def planted(favoured=1.0, growing=0.0):
    rng = np.random.Generator(np.random.Philox(2))
    draws = rng.poisson(400, (300, QUADRANTS)).astype(float)
    draws[:, 0] *= favoured
    points = []
    for extent in EXTENTS_M:
        for metric in ("blake", "full"):
            by = extent / EXTENTS_M[0] if metric == "full" else extent**growing
            rows = np.rint(draws * by).astype(int)
            samples = tuple(
                Column("pierced", rows[:, k].tolist(), {"quadrant": k}) for k in range(QUADRANTS)
            )
            points.append(Point({"extent": extent, "metric": metric}, samples=samples))
    return tuple(points)


def test_verdicts_follow_from_counts():
    assert {c.verdict for c in judge(planted())} == {"holds"}
    assert {c.name for c in judge(planted(growing=0.5)) if c.verdict == "refuted"} == {
        "blake/growth"
    }
    assert {c.name: c.verdict for c in judge(planted(favoured=2.0))}["blake/direction_1"] == (
        "refuted"
    )


def test_the_report_shows_all_of_it():
    points = planted()
    notes = {"rays_in_a_quadrant": RAYS}
    made = Record("depth", 1, True, "", provenance("", 0), points, judge(points), notes)
    heads, rows = depth_plots.point_table(made)
    assert len(rows) == len(points) and all(len(row) == len(heads) for row in rows)
    assert not any(re.search(r"\bnan\b", plot.svg) for plot in depth_plots.plots(made))
