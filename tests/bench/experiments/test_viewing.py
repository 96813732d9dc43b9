"""What air, display, eye, motion and lens hide: one m on both sides, and a law of its own."""

from dataclasses import asdict
from functools import partial

import numpy as np
import pytest

from bench import motion_cuts, part_sizes
from bench.experiments.viewing import (
    EXPERIMENT,
    VIEWERS,
    measure_eye,
    measure_haze,
    one_sided_excess_flip,
)
from bench.images.differences import LEAST_PAIRS
from bench.lens_cuts import (
    BANDS_M,
    LENS_CUTS,
    measure_lens_fields,
    measure_lens_parts,
    measure_lens_pictures,
)
from bench.motion_cuts import BARE, FAST, Move, displayed_parts, measure_pictures
from bench.part_sizes import SIZES, part_counts, predicted_parts
from bench.records.records import Column, Point, columns, merge_points
from bench.statistics.estimates import two_sided_share
from scenes.presets.load import load_preset
from scenes.render.variants import choose
from scenes.scene import Scene
from tests.bench.edited import edited, record_of


def measured(cases, seed=5):
    found = [case(seed) for case in cases]
    points = [p for each in found for p in ([each] if isinstance(each, Point) else each)]
    return record_of(EXPERIMENT, merge_points(points))


@pytest.fixture(scope="module")
def haze():
    seen = (500.0, 2e3, 5e4)
    kinds = ("figure", "nobody"), ("tree", "eye")
    return measured([partial(measure_haze, *each, 640, 4, visibilities_m=seen) for each in kinds])


@pytest.fixture(scope="module")
def eye():
    return measured([partial(measure_eye, "figure", ppd, 4) for ppd in (30.0, 67.0, 120.0)])


def verdicts(record):
    return {claim.name: claim.verdict for claim in record.claims}


def test_the_interval_of_a_share_covers_it_as_often_as_it_says():
    """Clumped fields, 12 of them: 92 to 98 of 100 intervals hold the truth."""
    rng = np.random.default_rng(1)
    hits = 0
    for _ in range(1000):
        out_of = rng.poisson(3.0, (12, 40)) * 30.0
        kept = rng.binomial(30, 0.3, (12, 40)) / 30.0
        found = two_sided_share((out_of * kept).sum(axis=1), out_of.sum(axis=1))
        hits += found.low <= 0.3 <= found.high
    assert 920 <= hits <= 980


KEPT = "share_of_parts_that_haze_leaves_all_visibilities/figure/nobody/640_px"


def test_haze_only_takes_and_takes_what_is_predicted(haze):
    assert verdicts(haze)[KEPT] == "holds"
    for point in haze.points:
        for size in SIZES:
            clear, hazy = (part_counts(point, [size], air=air) for air in ("clear", "hazy"))
            assert (hazy <= clear).all()
            for air, counts in (("clear", clear), ("hazy", hazy)):
                mean = predicted_parts(point, [size], air=air)
                assert abs(counts.mean() - mean) < 0.35 * mean + 5
    thick, _, thin = (part_counts(p, air="hazy").sum() for p in haze.points[3:])
    assert thick < 0.9 * thin


def test_a_law_that_knows_no_haze_is_refuted(monkeypatch):
    limits = part_sizes.chained_limits
    monkeypatch.setattr(
        part_sizes, "chained_limits", lambda tree, name, m, sight=None: limits(tree, name, m)
    )
    blinded = measured(
        [partial(measure_haze, "figure", "nobody", 640, 4, visibilities_m=(500.0, 2e3))], seed=0
    )
    assert verdicts(blinded)[KEPT] == "refuted"


def test_blur_leaves_one_part_in_its_square_and_a_fine_display_more_than_contrast_does(eye):
    kept = "share_of_parts_that_display_and_eye_leave_all_displays/figure"
    found = verdicts(eye)
    assert [v for name, v in found.items() if name.startswith(kept)] == ["holds"] * len(VIEWERS)
    square, beyond = [v for name, v in found.items() if not name.startswith(kept)]
    assert square != "refuted" and beyond == "holds"
    fine = eye.points[-1]
    counts = {v: part_counts(fine, viewer=v).sum() for v in ("ideal", "contrast", "faint", "blur")}
    assert counts["ideal"] > counts["contrast"] > counts["faint"] > counts["blur"]


def counted(move, world="endless", keeps=0.25):
    """Counts of fields in which a move keeps a share; unpruned are 20 times as many."""
    spatial = [1000, 1001, 1002, 1004]
    cuts = {"spatial": spatial, "motion": [round(keeps * n) for n in spatial]}
    if world == "finite":
        cuts["everything"] = [20_000, 20_010, 20_000, 20_020]
    found = (Column("parts", row, {"cut": cut}) for cut, row in cuts.items())
    return Point({"topic": "motion", "world": world, **asdict(move)}, samples=tuple(found))


def picture(cut, flips, floors):
    named = {"topic": "motion", "world": "picture", **asdict(FAST), "cut": cut, "spp": 1}
    return Point(named, samples=columns({"flip": flips, "flip_floor": floors}))


REST, WALK = Move(0.0, 0.0, 180.0), Move(0.0, 1.4, 180.0)
NEAR = picture("motion", [13_000 + k for k in range(8)], [9_000] * 8)
FAR = picture("planted", [59_000 + k for k in range(8)], [9_000] * 8)


def judged(*points):
    return EXPERIMENT.judged(points)


def test_motion_is_judged_from_the_points():
    fields = counted(FAST), counted(REST, keeps=1), counted(WALK, keeps=1)
    made = judged(*fields, counted(FAST, "finite"), NEAR, FAR)
    assert [each.verdict for each in made] == ["holds"] * 6


def test_the_picture_is_judged_by_its_upper_bound_and_only_where_parts_are_left_out():
    worse = picture("motion", [25_000, 12_000] * 4, [9_000] * 8)
    (_, excess) = judged(counted(FAST), worse)
    assert excess.measured == pytest.approx(0.0095)
    assert excess.verdict == "inconclusive"
    (alone,) = judged(counted(FAST, keeps=1), worse)
    assert alone.verdict == "refuted"
    moved = edited(counted(REST), "parts", lambda row: [0] * len(row), cut="motion")
    assert judged(moved)[0].verdict == "refuted"


def test_a_real_pan_leaves_out_parts_and_a_rest_does_not():
    """Where motion is heeded and where not, in a thin field."""
    thin = ("species.tree.density=0", "species.figure.prototypes=1", "render.size=160x90")
    field = Scene(load_preset("meadow", (BARE, "seed=1", *thin)))

    def counts(move):
        ways = (), ("view.smear=off",)
        return [displayed_parts(field, "seed=1", *thin, *move.settings, *way) for way in ways]

    aware, blind = counts(FAST)
    assert aware < 0.9 * blind
    aware, blind = counts(REST)
    assert aware == blind


@pytest.mark.slow
def test_a_fast_pan_looks_as_it_did_and_one_cut_coarsely_does_not(monkeypatch):
    """Rendered with few samples in few sub-frames: the floor is high, and what is found is nearly
    all there is.
    """
    monkeypatch.setattr(motion_cuts, "SUBFRAMES", 4)
    points = merge_points(
        point for pair in range(LEAST_PAIRS) for point in measure_pictures(pair, choose(), 16, 0)
    )
    found = {point.case["cut"]: one_sided_excess_flip(point) for point in points}
    assert found["motion"].high < 0.01 < found["planted"].low


def test_the_law_knows_how_many_parts_a_lens_leaves():
    record = measured([partial(measure_lens_fields, 6)], seed=0)
    (ratio,) = record.claims
    assert ratio.low < 1.01 and ratio.high > 0.99
    assert ratio.high - ratio.low < 0.1


def lens_pictures(aware, unaware):
    for cut, error in zip(LENS_CUTS, (aware, unaware), strict=True):
        found = (
            Column("flip_ppm", [error + 10 * k + 100 // spp for k in range(4)], {"samples": spp})
            for spp in (4, 16)
        )
        named = {"topic": "defocus", "what": "picture", "cut": cut}
        yield Point(named, samples=tuple(found))


def test_a_cut_that_knows_of_the_lens_is_held_against_one_that_does_not():
    for aware, verdict in ((21_000, "holds"), (90_000, "refuted")):
        assert [each.verdict for each in judged(*lens_pictures(aware, 20_000))] == [verdict]


@pytest.mark.slow
def test_the_lens_hides_parts_that_are_far_and_pictures_are_compared():
    aware, unaware = measure_lens_parts("480x270", 0)
    sharp, lens = (
        np.array([p.column("parts", **{"from": low})[0] for low in BANDS_M[:-1]])
        for p in (unaware, aware)
    )
    assert (lens <= sharp).all() and lens.sum() < 0.8 * sharp.sum()
    saved = 1 - lens / np.maximum(sharp, 1)
    assert saved[-1] == saved.max() and saved[2] < 0.1  # at the focus hardly any
    points = measure_lens_pictures(0, "24x14", (1, 4), choose(), 0)
    assert [p.case["cut"] for p in points] == [*LENS_CUTS, "unpruned"]
