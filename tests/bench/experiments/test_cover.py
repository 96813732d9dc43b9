"""Each picture has its own bands, and the verdicts follow from the light there."""

import re
from dataclasses import replace

import numpy as np
import pytest

from bench.experiments.cover import plots as cover_plots
from bench.experiments.cover.claims import SAME_RAYS, bands, judge, room, same_rays, tone
from bench.experiments.cover.measure import in_bands
from bench.experiments.cover.scene import LOOKS, Case, displayed, pictures, preset_of, whole
from bench.experiments.registry import EXPERIMENTS
from bench.records.points import Column, Point
from bench.records.provenance import provenance
from bench.records.records import Record
from lod.metric.family import METRICS
from lod.pruning.pruner import prune
from lod.pruning.view_geometry import in_view
from scenes.frame.layers import Layers
from scenes.world.view import view_at
from scenes.world.world import build_world


def picture(Z, value):
    Z = np.array(Z)
    three, none = np.full((*Z.shape, 3), value), np.zeros(Z.shape)
    return Layers(three, Z, three, three, none, none, none)


def test_light_is_summed_by_the_distances_of_each_picture():
    edges = 10.0, 20.0, 40.0
    unpruned = picture([[5, 10, 19], [20, 39, 1e10]], 0.5)
    tested = picture([[5, 15, 25], [25, 1e10, 39]], 0.25)
    found = in_bands(tested, unpruned, edges)
    point = Point({}, samples=found)

    def sums(quantity, seen):
        return [point.column(quantity, picture=seen, band=k)[0] for k in (0, 1)]

    assert sums("light", "whole") == [1_000_000, 1_000_000] and sums("rays", "whole") == [2, 2]
    assert sums("light", "pruned") == [250_000, 750_000] and sums("rays", "pruned") == [1, 3]
    assert sums("light", SAME_RAYS) == [500_000, 500_000]


def test_a_tree_that_stands_elsewhere_keeps_its_tone():
    """Half a picture of dark tree before bright sky, its gaps drawn anew: along the same rays it
    would have become far brighter, and yet nothing has changed."""
    rng = np.random.default_rng(2)
    both = []
    for _ in range(2):
        tree = rng.random((50, 80)) < 0.5
        light = np.where(tree, 0.01, 0.1)[..., None].repeat(3, axis=2)
        both.append(replace(picture(np.where(tree, 30.0, 1e10), 0.0), rgb=light))
    found = in_bands(*both, (10.0, 40.0))
    four = tuple(replace(each, values=each.values * 4) for each in found)
    point = Point(vars(pictures()[0]), samples=four)
    assert tone(point, 0).value == pytest.approx(1.0, abs=1e-6)
    assert room(point, 0) == pytest.approx(1.0, abs=0.1) and same_rays(point, 0) > 4


def test_edges_rise_and_lie_in_the_window():
    for look in LOOKS.values():
        assert len(look.edges_m) == 9 and (np.diff(look.edges_m) > 0).all()
        across = np.hypot(*(0.5 - abs(each) for each in look.eye_at))
        assert look.edges_m[-1] < look.side_m * (0.5 - look.eye_at[1]) < look.side_m * (1 + across)


def planted(shift=0.0):
    points = []
    for case in pictures():
        samples = []
        for k in range(8):
            whole_light = [1_000_000 + 1000 * n for n in range(4)]
            share = 1.0 + (shift if case.cover and k == 3 else 0.0) + (0.0 if case.cover else 0.5)
            pruned = [round(share * v) for v in whole_light]
            for seen, light in (("pruned", pruned), ("whole", whole_light), (SAME_RAYS, pruned)):
                samples.append(Column("light", light, {"picture": seen, "band": k}))
                samples.append(Column("rays", [500] * 4, {"picture": seen, "band": k}))
        points.append(Point(vars(case), samples=tuple(samples)))
    return tuple(points)


def test_verdicts_follow_from_the_light_of_each_band():
    claims = judge(planted())
    assert len(claims) == 64 and {c.verdict for c in claims} == {"holds"}
    refuted = {c.name for c in judge(planted(0.03)) if c.verdict == "refuted"}
    assert refuted == {c.name for c in claims if c.name.endswith("band_4")}


def test_the_report_shows_all_of_it():
    points = planted(0.03)
    made = Record("cover", 1, True, "", provenance("", 0), points, judge(points), {})
    assert EXPERIMENTS["cover"].judge(made.points) == made.claims
    heads, rows = cover_plots.point_table(made)
    assert len(rows) == sum(bands(p) for p in points)
    assert all(len(row) == len(heads) for row in rows)
    assert any("1.500" in row for row in rows), "without cover it stands in the table as well"
    assert not any(re.search(r"\bnan\b", plot.svg) for plot in cover_plots.plots(made))


def test_the_whole_has_every_leaf_in_view_and_no_cover_is_bare_ground():
    """One kind of tree, few of them."""
    kept = ("species.shrub.density=0.0002",)
    others = [f"species.{s}.density=0" for s in ("broadleaf", "birch", "conifer", "figure")]
    case = Case("aerial", "clear", 12.0, True)
    preset = preset_of(case.look, case.air, 1, (*kept, *others, "species.shrub.prototypes=1"))
    world = build_world(preset)
    (ground, shrubs), (bare, _) = whole(world, preset), displayed(world, preset, 12.0, False)
    view = replace(view_at(world, preset, 1), metric=METRICS["full"])
    all_of_it = prune(world.fields[0], view).parts
    in_it = in_view(view, all_of_it.centre, all_of_it.bound).sum()
    assert in_it > 5000 and len(shrubs.cut) > 0.98 * in_it and len(ground.shape) > 1000
    left = displayed(world, preset, 12.0, True)[0].shape.colours
    assert not np.array_equal(left, bare.shape.colours)
