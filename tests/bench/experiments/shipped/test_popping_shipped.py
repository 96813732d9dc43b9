"""Walks through presets as shipped: verdicts follow from pairs of frames, and relief is shaded."""

import numpy as np
import pytest

from bench.experiment import experiments
from bench.experiments.popping.shipped import plots as shown
from bench.experiments.popping.shipped.claims import CLIPPED, SHIPPED, WAYS, judge
from bench.experiments.popping.shipped.measure import AT_ONCE, Steps, cases, measure
from bench.experiments.popping.silhouettes import SKY_SHARE, silhouettes
from bench.records.provenance import provenance
from bench.records.records import Point, Record, columns, merge_points
from lod.camera import Corner, camera_from_heading
from lod.metric import METRICS
from lod.pruner import prune
from lod.view import View
from scenes.frame.frame_input import Quality, display
from scenes.ground.terrain import Terrain
from scenes.presets.load import load_preset
from scenes.render.variants import choose
from scenes.world.light import Light

EXPERIMENTS = experiments()


FULL = EXPERIMENTS["popping_shipped"].effort("full")


def walked(way, change, popped=0, preset="forest", first=2):
    scatter = np.array([-1, 1] * 4) * 0.05 * change
    samples = {
        "frame": [*range(first, first + 8)],
        "popped": [popped] * 8,
        "changed_ppm": np.rint(1e6 * (change + scatter)).astype(int).tolist(),
    }
    return Point({"preset": preset, "way": way}, samples=columns(samples))


def verdicts(shipped, clipped):
    return {each.name.split("/")[-1]: each.verdict for each in judge((shipped, clipped))}


def test_verdicts_follow_from_pairs_of_frames():
    clipped = walked(CLIPPED, 0.2, popped=9)
    assert set(verdicts(walked(SHIPPED, 0.03), clipped).values()) == {"holds"}
    assert verdicts(walked(SHIPPED, 0.03, popped=1), clipped)["popped"] == "refuted"
    worse = verdicts(walked(SHIPPED, 0.12), clipped)
    assert worse == {"popped": "holds", "change": "refuted", "clipping": "refuted"}
    assert verdicts(walked(SHIPPED, 0.05), clipped)["change"] == "undecided"


def test_a_walk_has_all_its_pairs_in_cases_that_are_kept_one_by_one():
    made = cases(FULL)
    assert EXPERIMENTS["popping_shipped"].apart
    for preset in ("forest", "mountain"):
        for way in (SHIPPED, CLIPPED):
            mine = [case for case in made if (case.preset, case.way) == (preset, way)]
            frames = [case.first + k for case in mine for k in range(case.pairs)]
            assert frames == list(range(1, 49)) and max(c.pairs for c in mine) == AT_ONCE
            loaded = load_preset(preset, mine[0].settings)
            assert loaded.camera.speed == 1.4
            assert loaded.view.detail == load_preset(preset, ()).view.detail
            assert (loaded.view.fade == 0) == (way == CLIPPED)


def test_the_report_has_a_plot_for_each_walk_and_a_row_for_each_way():
    halves = [
        walked(way, x, 1, first=f) for way, x in ((SHIPPED, 0.03), (CLIPPED, 0.2)) for f in (2, 10)
    ]
    points = merge_points(halves)
    made = Record("popping_shipped", 1, True, "", provenance("", 0), points, judge(points), {})
    heads, rows = shown.point_table(made)
    assert [row[:4] for row in rows] == [("forest", way, "16", "16") for way in (SHIPPED, CLIPPED)]
    assert all(len(row) == len(heads) for row in rows)
    (plot,) = shown.plots(made)
    assert list(plot.drawn[0].x) == list(range(2, 18)) and len(plot.drawn) == 3


@pytest.mark.parametrize("elevation", [20.0, 90.0])
def test_shaded_ground_is_as_bright_as_its_slope_to_the_sun(elevation):
    ground = Terrain(0, 0.0, 64.0, 0.8, reach=32.0)
    camera = camera_from_heading(Corner(0, 0), np.array((0.0, 0.0, 2.0)), 0.0, -60.0, 40.0, (16, 9))
    view = View(camera, METRICS["blake"])
    shown_ground = (display(ground, prune(ground, view), view),)
    looks = camera, 0.0, Light(0.0, elevation), Quality(choose("auto"), 4), (1,)
    (plain,), (shaded,) = (silhouettes(shown_ground, *looks, each) for each in (False, True))
    wanted = SKY_SHARE + (1 - SKY_SHARE) * np.sin(np.radians(elevation))
    assert shaded.mean() / plain.mean() == pytest.approx(wanted, rel=0.02)


@pytest.mark.slow
def test_a_clipped_walk_jumps_more():
    """The frames of a wood in which large branches come and go, with pixels as large as they."""
    wood = "world.extent=60.0", "terrain.reach=300.0", "view.haze_aware=false"
    looks = *wood, "render.size=64x36", "render.spp=4", "view.detail=2.4"
    found = [
        measure(Steps("forest", way, (*looks, *WAYS[way]), 36, 1, choose()), 0) for way in WAYS
    ]
    assert [p.column("frame") for p in found] == [[37]] * 2
    (shipped,), (clipped,) = (p.column("popped") for p in found)
    assert shipped == 0 and clipped > 2
    (shipped,), (clipped,) = (p.column("changed_ppm") for p in found)
    assert 0 < shipped < clipped
