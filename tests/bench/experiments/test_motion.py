"""What motion leaves out is counted and judged from the counts alone."""

import re
from dataclasses import asdict

import pytest

from bench.experiment import experiments
from bench.experiments.motion import measure as motion_experiment
from bench.experiments.motion import pictures as motion_picture
from bench.experiments.motion import plots as motion_plots
from bench.experiments.motion.claims import judge, kept, one_sided_excess_flip
from bench.experiments.motion.moves import FAST, MOVES, PICTURED, Move
from bench.experiments.motion.pictures import Pictures
from bench.images.compare import LEAST_PAIRS
from bench.records.records import Column, Point, columns, merge_points
from bench.runs import run_experiment
from scenes.render.variants import choose
from tests.bench.edited import edited

EXPERIMENTS = experiments()


def fake(settings, move, seed):
    """Counts of a field in which a pan keeps a quarter; everything is 20 times as much."""
    if "view.metric=full" in settings:
        return 20_000 + seed
    moving = "view.smear=off" not in settings and move.turn > 0
    return (250 if moving else 1000) + seed % 3


def fake_pictures(case, seed):
    """Excess FLIP of 0.004 by motion and 0.05 by the planted cut, above a floor of 0.009."""
    flips = {"motion": 13_000 + case.pair, "planted": 59_000 + case.pair}
    return [picture(cut, [flips[cut]], [9_000], case.move) for cut in case.cuts]


def picture(cut, flips, floors, move=FAST):
    samples = {"flip": flips, "flip_floor": floors}
    return Point(
        {"world": "picture", **asdict(move), "cut": cut, "spp": 1}, samples=columns(samples)
    )


@pytest.fixture
def record(monkeypatch):
    monkeypatch.setattr(
        motion_experiment, "parts", lambda world, move, seed, settings: fake(settings, move, seed)
    )
    monkeypatch.setattr(motion_experiment, "world_of", lambda seed, settings: None)
    monkeypatch.setattr(motion_picture, "measure", fake_pictures)
    experiment = EXPERIMENTS["motion"]
    return run_experiment(experiment, experiment.effort("quick"))


def test_every_claim_is_judged_from_the_points(record):
    verdicts = {claim.name: claim.verdict for claim in record.claims}
    names = ["pan/parts", "rest/parts", "walk/parts", "finite/size_and_distance"]
    assert verdicts == dict.fromkeys([*names, "pan/excess", "pan/planted"], "holds")
    assert judge(record.points) == record.claims


def test_the_picture_is_judged_by_its_upper_bound_and_only_where_parts_are_left_out(record):
    pan = next(p for p in record.points if p.case["turn"] == 90.0)
    worse = picture("motion", [25_000, 12_000] * 4, [9_000] * 8)
    (_, excess) = judge((pan, worse))
    assert excess.measured == pytest.approx(0.0095)
    assert excess.verdict == "undecided"
    vacuous = edited(pan, "parts", lambda _: pan.column("parts", cut="spatial"), cut="motion")
    assert [c.name for c in judge((vacuous, worse))] == ["pan/parts"]


@pytest.mark.slow
def test_a_fast_pan_looks_as_it_did_and_one_cut_coarsely_does_not(monkeypatch):
    """Rendered with few samples in few sub-frames: the floor is high, and what is found is nearly
    all there is.
    """
    monkeypatch.setattr(motion_picture, "SUBFRAMES", 4)
    points = merge_points(
        point
        for pair in range(LEAST_PAIRS)
        for point in motion_picture.measure(
            Pictures(FAST, pair, ("motion", "planted"), choose(), 16), seed=0
        )
    )
    found = {point.case["cut"]: one_sided_excess_flip(point) for point in points}
    assert found["motion"].high < 0.01 < found["planted"].low


def test_a_pan_that_keeps_everything_is_refuted_and_so_is_a_rest_that_does_not(record):
    pan, rest = (
        next(p for p in record.points if p.case["turn"] == turn and p.case["world"] == "endless")
        for turn in (90.0, 0.0)
    )
    vacuous = edited(pan, "parts", lambda _: pan.column("parts", cut="spatial"), cut="motion")
    assert judge((vacuous,))[0].verdict == "refuted"
    moved = edited(rest, "parts", lambda row: [0] * len(row), cut="motion")
    assert judge((moved,))[0].verdict == "refuted"


def test_it_has_a_row_for_every_case_and_a_figure_without_gaps(record):
    assert len(motion_plots.point_table(record)[1]) == len(MOVES) + 1 + len(PICTURED[0][1])
    (plot,) = motion_plots.plots(record)
    assert not re.search(r"\bnan\b", plot.svg)


def test_the_share_kept_is_that_of_all_fields_together():
    point = Point(
        {},
        samples=(
            Column("parts", [100, 300], {"cut": "spatial"}),
            Column("parts", [50, 50], {"cut": "motion"}),
        ),
    )
    assert kept(point).value == 0.25


def test_a_real_pan_leaves_out_parts_and_a_rest_does_not():
    """Where motion is heeded and where not, in a thin field."""
    thin = ("species.tree.density=0", "species.figure.prototypes=1", "render.size=160x90")
    blind = (*thin, "view.smear=off")
    world = motion_experiment.world_of(1, thin)
    counts = [motion_experiment.parts(world, FAST, 1, each) for each in (thin, blind)]
    assert counts[0] < 0.9 * counts[1]
    rest = Move(0.0, 0.0, 180.0)
    still = [motion_experiment.parts(world, rest, 1, each) for each in (thin, blind)]
    assert still[0] == still[1]
