"""Fidelity: what is measured is right where it is known, and the verdicts follow from it."""

import base64
import io
import re
from dataclasses import replace

import numpy as np
import pytest
from PIL import Image

from bench.experiments.fidelity import pictures as fidelity_pictures
from bench.experiments.fidelity import plots as fidelity_plots
from bench.experiments.fidelity.claims import judge
from bench.experiments.fidelity.equal_error import equal_error, reached
from bench.experiments.fidelity.image_errors import BANDS, bias, picture_errors, reference_of
from bench.experiments.fidelity.scene import (
    GROUND,
    METRICS_TRIED,
    PIECES,
    PIECES_DETAIL,
    SPECIES,
    VIEWS,
    Case,
    displayed,
    grid_cases,
    parts_in,
    reference,
)
from bench.experiments.fidelity.timing import STAGES, TIMED, UNPRUNED, Timing, measure_times
from bench.experiments.figure.cases import curves
from bench.experiments.registry import EXPERIMENTS
from bench.records.embedded_pictures import NOTE, pictures_of
from bench.records.points import Column, Point, columns
from bench.records.provenance import provenance
from bench.records.records import Record
from scenes.frame.layers import Layers
from scenes.render.mitsuba.variants import choose

DETAILS = EXPERIMENTS["fidelity"].full["details"]
SHAPE = (12, 16)
PAIRS = 8


def frame(rgb):
    zero = np.zeros(SHAPE)
    Z = np.broadcast_to(np.linspace(5.0, 250.0, SHAPE[0])[:, None], SHAPE)
    flat = np.zeros((*SHAPE, 3))
    return Layers(rgb, Z, flat, flat, zero, zero, zero)


def noisy(seed, noise=0.02, offset=0.0):
    rng = np.random.Generator(np.random.Philox(seed))
    base = np.linspace(0.2, 0.8, SHAPE[1])[None, :, None] * np.ones((*SHAPE, 3))
    return frame(base + offset + noise * rng.standard_normal((*SHAPE, 3)))


def whole(noise=0.02):
    seeds = range(2 * PAIRS)
    frames = [noisy(seed, noise) for seed in seeds]
    return reference_of(frames[0::2], frames[1::2])


def offset_by(offset, noise=0.02):
    return [noisy(100 + k, noise, offset).rgb.astype(np.float64) for k in range(PAIRS)]


def test_bias_is_found_beneath_noise_four_times_as_large():
    """A planted offset of 0.01 beneath noise of 0.04: the products find its square alone."""
    known = whole(0.04)
    wanted = np.mean((0.01 * known.exposure) ** 2 / (known.mean**2 + 0.01))
    found = np.array(bias(offset_by(0.01, 0.04), known))
    assert found.mean() == pytest.approx(wanted, abs=4 * found.std() / PAIRS**0.5)
    none = np.array(bias(offset_by(0.0, 0.04), known))
    assert abs(none.mean()) < wanted / 2


def test_nothing_changed_measures_as_its_floor():
    known = whole()
    found = Point({}, samples=picture_errors(list(known.same), known))
    for name in ("flip", "ssim", "relmse"):
        assert found.column(name) == found.column(f"{name}_floor")
    assert found.column("relmse_bias") == [0] * PAIRS
    for band in (b for b in BANDS if found.column("pixels", band=b)[0]):
        tested, same = (
            found.column("luminance", picture=each, band=band) for each in ("tested", "reference")
        )
        assert tested == same
    worse = Point({}, samples=picture_errors(offset_by(0.2), known))
    assert min(worse.column("flip")) > max(worse.column("flip_floor"))
    assert max(worse.column("ssim")) < min(worse.column("ssim_floor")) + 100_000


def point(metric, detail, excess, parts, floor=5000, view="aerial", pruned=SPECIES):
    bands = [
        Column("luminance", [1000] * PAIRS, {"picture": which, "band": b})
        for which in ("tested", "reference")
        for b in BANDS
    ]
    bands += [Column("pixels", [100], {"band": b}) for b in BANDS]
    spread = [-20, 20] * (PAIRS // 2)
    samples = {
        "flip": [floor + round(1e6 * excess) + each for each in spread],
        "flip_floor": [floor] * PAIRS,
        **{k: [990_000] * PAIRS for k in ("ssim", "ssim_floor")},
        **{f"relmse{k}": [100] * PAIRS for k in ("", "_floor", "_bias")},
        **{k: [5] for k in ("sticks", "triangles", "foretold_bytes")},
        "parts": [parts],
    }
    return Point(
        {"view": view, "metric": metric, "detail": detail, "pruned": pruned},
        samples=(*bands, *columns(samples)),
    )


def timed_point(metric, detail, seconds, view="aerial"):
    """A frame that takes so long in all, now a third more and now a third less."""
    micros = [round(1e6 * seconds * (4 / 3 if k % 2 else 2 / 3)) for k in range(PAIRS)]
    times = [Column("us", [us // 3 for us in micros], {"stage": stage}) for stage in STAGES]
    counted = columns({"parts": [7], "foretold_bytes": [5]})
    return Point(
        {"view": view, "metric": metric, "detail": detail, "pruned": TIMED},
        samples=(*times, *counted),
    )


def planted(rival=2.0, faster=0.5):
    """Excess 0.01·τ by every metric; the others have ``rival`` times as many parts as blake."""
    made = []
    for metric in METRICS_TRIED:
        factor = 1.0 if metric == "blake" else rival
        made += [point(metric, d, 0.01 * d, round(1e5 * factor / d**2)) for d in DETAILS]
    made += [point("blake", PIECES_DETAIL, 0.004, 10, pruned=piece) for piece in PIECES]
    made += [timed_point("blake", 2.0, 0.2), timed_point("blake", 1.0, faster)]
    made += [timed_point("depth", d, 0.3 / d) for d in (1.0, 2.0)]
    return (*made, timed_point(UNPRUNED, 1.0, 1.0))


def test_where_the_excess_comes_up_to_an_error_is_read_between_details():
    row = [p for p in planted() if p.case["metric"] == "blake" and p.case["pruned"] == SPECIES]
    ((detail, parts),) = reached(row, np.arange(PAIRS)[None], 0.015)
    assert detail == pytest.approx(1.5, rel=1e-6)
    assert parts == pytest.approx(1e5 / 1.5**2, rel=1e-3)
    assert np.isnan(reached(row[:2], np.arange(PAIRS)[None], 0.5)).all()


def test_verdicts_follow_from_samples():
    verdict = {c.name: c.verdict for c in judge(planted(rival=2.0))}
    assert verdict["bounded/aerial/parts"] == "holds"
    assert verdict["floor/aerial"] == "holds"
    assert verdict["blake/aerial/luminance_from_0_m"] == "holds"
    assert "refuted" == {c.name: c.verdict for c in judge(planted(rival=0.5))}["depth/aerial/parts"]
    noisy = Column("flip_floor", [20_000] * PAIRS)
    noisy_floor = tuple(
        replace(p, samples=tuple(noisy if c.quantity == "flip_floor" else c for c in p.samples))
        for p in planted()
    )
    assert {c.name: c.verdict for c in judge(noisy_floor)}["floor/aerial"] == "refuted"


def test_a_frame_is_held_against_the_unpruned_one_of_its_own_round():
    """Rounds differ by a factor of two, and the ratio not at all."""
    verdict = {c.name: c for c in judge(planted(faster=0.5))}["blake/aerial/time"]
    assert verdict.verdict == "holds"
    assert (verdict.low, verdict.high) == pytest.approx((0.5, 0.5), rel=1e-4)
    slower = {c.name: c.verdict for c in judge(planted(faster=1.1))}
    assert slower["blake/aerial/time"] == "refuted"


def test_at_equal_error_every_metric_is_summed_up_with_its_interval():
    found = equal_error(planted(rival=3.0))
    assert found["blake"].detail.value == pytest.approx(1.0, rel=0.02)
    assert found["depth"].parts_over(found["blake"]).value == pytest.approx(3.0, rel=1e-3)
    points = planted(rival=3.0)
    made = Record("fidelity", 2, True, "", provenance("", 0), points, (), {})
    heads, rows = fidelity_plots.summary(made)
    assert [row[1] for row in rows] == list(METRICS_TRIED)
    assert rows[1][4].startswith("3.00 (3.00") and all(len(row) == len(heads) for row in rows)
    never = tuple(p for p in points if p.case["detail"] < 1 or p.case["metric"] == "blake")
    assert not equal_error(never)["depth"].found
    _, rows = fidelity_plots.summary(replace(made, points=never))
    assert rows[3][2:4] == ("over 0.5, the last tried", f"under {round(3e5 / 0.25)}")


def test_another_metric_is_tried_in_every_view():
    more = set(grid_cases(DETAILS, (1.0,), "halfway")) - set(grid_cases(DETAILS, (1.0,)))
    assert {(c.view, c.metric, c.detail, c.pruned) for c in more} == {
        (view, "halfway", detail, SPECIES) for view in VIEWS for detail in DETAILS
    }
    assert {c.metric for c in set(curves("halfway")) - set(curves())} == {"halfway"}


@pytest.mark.slow
def test_a_timed_frame_has_every_stage_and_the_unpruned_one_has_more_parts():
    made = measure_times(Timing("hazy", ("blake", "depth"), (1.0,), choose()), 0)
    assert [p.case["metric"] for p in made] == ["blake", "depth", UNPRUNED]
    one, other, whole = (p.column("parts")[0] for p in made)
    assert 0 < other < one < whole
    for point in made:
        assert all(len(point.column("us", stage=stage)) == PAIRS for stage in STAGES)
        assert min(min(each.values) for each in point.samples) > 0


def test_the_report_draws_every_view_with_its_floor():
    points = planted()
    made = Record("fidelity", 1, True, "", provenance("", 0), points, judge(points), {})
    heads, rows = fidelity_plots.point_table(made)
    assert len(rows) == len(points) and all(len(row) == len(heads) for row in rows)
    shown = {plot.name: plot for plot in fidelity_plots.plots(made)}
    assert list(shown) == [f"fidelity-aerial-{k}" for k in ("detail", "parts", "time", "memory")]
    for plot in shown.values():
        assert plot.drawn[-1].label == "noise floor" and set(plot.drawn[-1].y) == {0.005}
        assert not re.search(r"\bnan\b", plot.svg)
    by_time = {each.label: each for each in shown["fidelity-aerial-time"].drawn}
    assert list(by_time) == ["blake", "depth", "unpruned", "noise floor"]
    assert by_time["depth"].x == pytest.approx((0.15, 0.3), rel=1e-3)
    assert by_time["depth"].y == pytest.approx((0.02, 0.01), rel=1e-3)
    assert by_time["unpruned"].x == pytest.approx([1.0, 1.0], rel=1e-3)


def test_which_metric_needs_the_fewest_parts_is_said_where_that_is_decided():
    fewer = equal_error(planted(rival=0.5))
    assert fidelity_plots.standing(fewer) == {
        "blake": "more",
        "bounded": "the fewest",
        **dict.fromkeys(("solid_angle", "depth"), "not told apart from the fewest"),
    }
    more = fidelity_plots.standing(equal_error(planted(rival=2.0)))
    assert more == dict.fromkeys(METRICS_TRIED, "more") | {"blake": "the fewest"}
    fine = tuple(p for p in planted() if p.case["detail"] < 1)
    assert fidelity_plots.standing(equal_error(fine)) == {}
    made = Record("fidelity", 3, True, "", provenance("", 0), planted(0.5), (), {})
    plot = fidelity_plots.plots(made)[1]
    assert "The fewest parts there are those of bounded (not told apart: " in plot.caption


@pytest.mark.slow
def test_pieces_put_together_are_the_whole():
    """Objects in view and out of it are each pruned alone, and nothing is lost between them."""
    view, full = "eye level", reference("eye level")
    kinds = (*PIECES, SPECIES, GROUND)
    by_piece = {kind: displayed(Case(view, "blake", 1.0, kind)) for kind in kinds}
    everything, pruned = parts_in(full), parts_in(by_piece[SPECIES])
    assert parts_in(by_piece[GROUND]) == everything
    assert parts_in(by_piece["everything"]) == pruned
    saved = [everything - parts_in(by_piece[k]) for k in ("objects", "casters")]
    assert sum(saved) == everything - pruned
    assert parts_in(by_piece["no casters"]) < parts_in(by_piece["casters"]) < everything
    assert len(grid_cases(DETAILS, EXPERIMENTS["fidelity"].full["ground_details"])) == 3 * (
        4 * 7 + 3 + 4
    )


@pytest.mark.slow
def test_pictures_show_whole_pruned_and_where_they_differ(monkeypatch):
    monkeypatch.setattr(fidelity_pictures, "VIEWS", {"hazy": ()})
    monkeypatch.setattr(fidelity_pictures, "MAGNIFIED", 1)
    (note,) = fidelity_pictures.pictures_of(choose(), 9, 0)
    made = Record("fidelity", 1, True, "", provenance("", 0), planted(), (), {NOTE: [note]})
    names, files = zip(*pictures_of(made)[0].layers, strict=True)
    assert names[0] == "everything there is" and len(names) == 5
    shown = [Image.open(io.BytesIO(base64.b64decode(data))) for data in files]
    assert {picture.size for picture in shown} == {(64, 36)}
    seen = [np.asarray(picture, np.float64).mean() for picture in shown[3:]]
    assert 0 < seen[0] < seen[1]  # FLIP of τ = 4 px is the brighter
