"""The experiments haze and eye: one m on both sides, a law apart from the pruner, honest shares."""

from dataclasses import replace

import numpy as np
import pytest

from bench import part_sizes as sight_measure
from bench.experiment import experiments
from bench.experiments.eye import measure as eye_experiment
from bench.experiments.eye.measure import Case as EyeCase
from bench.experiments.haze import measure as haze_experiment
from bench.experiments.haze.measure import Case as HazeCase
from bench.part_sizes import SIZES, part_counts, predicted_parts, prototypes_with, size_class
from bench.runs import run_experiment
from bench.statistics.estimates import two_sided_share
from lod.errors import InputError
from lod.eye import CONTRAST_CLASSES

EXPERIMENTS = experiments()


def run_cases_of(name, cases, seed=5):
    experiment = replace(EXPERIMENTS[name], cases=lambda effort: cases)
    return run_experiment(experiment, experiment.effort("quick"), seed)


@pytest.fixture(scope="module")
def haze():
    seen = (500.0, 2e3, 5e4)
    cases = [HazeCase("figure", "nobody", 640, 4, seen), HazeCase("tree", "eye", 1280, 4, seen)]
    return run_cases_of("haze", cases)


@pytest.fixture(scope="module")
def eye():
    return run_cases_of("eye", [EyeCase("figure", ppd, 4) for ppd in (30.0, 67.0, 120.0)])


def verdicts(record):
    return {claim.name: claim.verdict for claim in record.claims}


def test_a_share_by_hand():
    found = two_sided_share(np.array([1.0, 3.0]), np.array([4.0, 4.0]))
    assert found.value == 0.5
    assert found.standard_error == pytest.approx(np.std([1 - 2, 3 - 2], ddof=1) / 2**0.5 / 4)
    assert (found.low, found.high) == (0.0, 1.0)
    assert two_sided_share(np.zeros(3), np.zeros(3)).value == 0.0


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


@pytest.mark.parametrize(
    ("counts", "out_of"), [([1.0], [2.0]), ([3.0, 1.0], [2.0, 2.0]), ([-1.0, 1.0], [2.0, 2.0])]
)
def test_what_is_no_share_is_refused(counts, out_of):
    with pytest.raises(InputError, match="share"):
        two_sided_share(np.array(counts), np.array(out_of))


def test_size_classes_begin_at_their_bounds():
    assert size_class(np.array([0.05, 0.1, 0.29, 1.0, 2.9, 3.0])).tolist() == [0, 1, 1, 3, 3, 4]
    assert len(SIZES) == len(sight_measure.BOUNDS_M) + 1


@pytest.mark.parametrize("viewer", ["nobody", "eye"])
def test_haze_is_compared_at_one_detail_angle(viewer):
    hazy, clear = haze_experiment.views_of(viewer, 1920, 2e3)
    assert hazy.m == clear.m
    assert (clear.m > 2 * clear.camera.pixel_angle) == (viewer == "eye")
    assert clear.conditions.extinction == 0 < hazy.conditions.extinction
    assert clear.camera.width == 1920


def test_haze_only_takes_and_takes_what_is_predicted(haze):
    assert verdicts(haze)["figure/nobody/640/kept"] == "holds"
    for point in haze.points:
        for size in SIZES:
            clear, hazy = (part_counts(point, [size], air=air) for air in ("clear", "hazy"))
            assert (hazy <= clear).all()
            for air, counts in (("clear", clear), ("hazy", hazy)):
                mean = predicted_parts(point, [size], air=air)
                assert abs(counts.mean() - mean) < 0.35 * mean + 5
    thick, _, thin = (part_counts(p, air="hazy").sum() for p in haze.points[3:])
    assert thick < 0.9 * thin


def test_a_law_that_knows_no_haze_is_refuted(haze, monkeypatch):
    def blind(hierarchy, name, m, sight=None):
        return sight_measure_limits(hierarchy, name, m)

    sight_measure_limits = sight_measure.chained_limits
    monkeypatch.setattr(sight_measure, "chained_limits", blind)
    blinded = run_cases_of("haze", [HazeCase("figure", "nobody", 640, 4, (500.0, 2e3))], seed=0)
    assert verdicts(blinded)["figure/nobody/640/kept"] == "refuted"


def test_every_part_can_be_given_one_contrast():
    usual = prototypes_with("figure", None)
    faint = prototypes_with("figure", 0.1)
    for one, other in zip(usual, faint, strict=True):
        assert (other.hierarchy.contrast == CONTRAST_CLASSES.index(0.1)).all()
        assert (other.hierarchy.P == one.hierarchy.P).all()


def test_blur_leaves_one_part_in_its_square_and_a_fine_display_more_than_contrast_does(eye):
    names = verdicts(eye)
    assert names["figure/blur/square"] != "refuted"
    assert names["figure/both/beyond_blur"] == "holds"
    assert {names[f"figure/{v}/kept"] for v in ("blur", "contrast", "faint", "both")} == {"holds"}
    fine = eye.points[-1]
    counts = {v: part_counts(fine, viewer=v).sum() for v in ("ideal", "contrast", "faint", "blur")}
    assert counts["ideal"] > counts["contrast"] > counts["faint"] > counts["blur"]


@pytest.mark.parametrize("name", ["haze", "eye"])
def test_records_are_drawn_and_told(name, request):
    record = request.getfixturevalue(name)
    experiment = EXPERIMENTS[name]
    plots = experiment.plots(record)
    assert len(plots) == (2 if name == "haze" else 1)
    for plot in plots:
        assert plot.svg.startswith("<svg")
        assert "predicted" in plot.caption
        assert "nan" not in plot.alt
    heads, rows = experiment.point_table(record)
    assert all(len(row) == len(heads) for row in rows)
    assert record.provenance.scene


def test_the_same_seed_counts_the_same(eye):
    point = eye.points[0]
    again = eye_experiment.measure(EyeCase("figure", 30.0, 4), 5)
    assert again == point
    assert eye_experiment.measure(EyeCase("figure", 30.0, 4), 6).samples != point.samples
