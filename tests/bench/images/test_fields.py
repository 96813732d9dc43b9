"""Fidelity: what is measured is right where it is known, and the verdicts follow from it."""

from dataclasses import replace

import numpy as np
import pytest

from bench.experiments.images import EXPERIMENT
from bench.images.differences import (
    PAIR_BANDS,
    Looks,
    errors,
    picture_errors,
    reference_of,
    same_place,
)
from bench.images.equal_error import crossings, equal_error
from bench.images.fields import (
    COARSER,
    EDGES_M,
    EVERYTHING,
    GROUND,
    METRICS_TRIED,
    NOTHING,
    SPECIES,
    SUN_ELEVATIONS_DEG,
    Field,
    cases,
    displayed,
    judged_bands,
    measure,
    parts_in,
    reference,
    scene_of,
)
from bench.records.records import Column, Point, columns, merge_points
from bench.seeds import BUILDING_SEEDS
from scenes.frame.layers import Layers
from scenes.models.catalogue import PROTOTYPE_SEED
from scenes.presets.load import load_preset

FULL, QUICK = (EXPERIMENT.topics["fidelity"].sizes(effort) for effort in ("full", "quick"))
DETAILS = FULL["details"]
SHAPE = (12, 16)
PAIRS = 8
FIELDS = 6
SAMPLES = (16, 64)
BANDS = len(EDGES_M) - 1


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


def test_nothing_changed_measures_as_its_floor():
    known = whole()
    same = [noisy(2 * k).rgb.astype(np.float64) for k in range(PAIRS)]
    found = Point({}, samples=picture_errors(same, known))
    assert found.column("flip") == found.column("flip_floor")
    counts = [found.column("pixels", band=band)[0] for band in PAIR_BANDS]
    assert sum(counts) == SHAPE[0] * SHAPE[1] and counts[0] > 0
    worse = Point({}, samples=picture_errors(offset_by(0.2), known))
    assert min(worse.column("flip")) > max(worse.column("flip_floor"))


def noisy_flip(error, k):
    """FLIP of two pictures of so many samples [ppm] where the error is so large, in each field."""
    spread = 1 + 0.01 * np.array([-1, 1] * (FIELDS // 2))
    return [round(1e6 * each) for each in error * spread + 0.1 / SAMPLES[k] ** 0.5]


def headline(view="aerial", pruned=EVERYTHING, error=0.004, light=1.0, rays=1.0):
    """A headline point of FIELDS fields; land fills the first three bands alike."""
    found = []
    for k, samples in enumerate(SAMPLES):
        keys = {"samples": samples, "number": k}
        flip = noisy_flip(error, k)
        found.append(Column("flip_ppm", flip, keys))
        for band in range(BANDS):
            sums = [100 * each if band < 3 else 0 for each in flip]
            found.append(Column("flip_sum_ppm", sums, keys | {"band": band}))
    for band in range(BANDS):
        here = 1000 if band < 3 else 0
        found.append(Column("pixels", [100 if here else 0] * FIELDS, {"band": band}))
        for which, more, fill in (("tested", light, rays), ("reference", 1.0, 1.0)):
            values = [round(here * fill) + k for k in range(FIELDS)] if here else [0] * FIELDS
            keys = {"picture": which, "band": band}
            found.append(Column("rays", values, keys))
            found.append(Column("light", [round(7 * more * v) for v in values], keys))
    counted = {"parts": [10] * FIELDS}
    case = {"topic": "fidelity", "what": "headline", "view": view, "pruned": pruned}
    case |= {"metric": "blake", "detail": 1.0}
    return Point(case, samples=(*columns(counted), *found))


def sweep(metric, detail, error, parts, view="aerial"):
    found = [
        Column("flip_ppm", noisy_flip(error, k), {"samples": n, "number": k})
        for k, n in enumerate(SAMPLES)
    ]
    case = {"topic": "fidelity", "what": "sweep", "view": view, "pruned": SPECIES}
    case |= {"metric": metric, "detail": detail}
    return Point(case, samples=(*columns({"parts": [parts] * FIELDS}), *found))


def planted(rival=2.0, **band):
    """Error 0.006·τ by every metric; the others have ``rival`` times as many parts as blake."""
    ways = {EVERYTHING: 0.012, SPECIES: 0.004, GROUND: 0.009, NOTHING: 0.0}
    made = [headline(pruned=way, error=each, **band) for way, each in ways.items()]
    for metric in METRICS_TRIED:
        factor = 1.0 if metric == "blake" else rival
        made += [sweep(metric, d, 0.006 * d, round(1e5 * factor / d**2)) for d in DETAILS]
    return tuple(made)


def test_where_the_error_comes_up_to_one_is_read_between_details():
    details = np.array([0.5, 1.0, 2.0, 4.0])
    found = np.outer(details, [0.01, 0.006, 0.1])
    parts = np.broadcast_to(1e5 / details[:, None] ** 2, found.shape)
    (detail, part), other, never = crossings(details, found, parts, 0.015)
    assert detail == pytest.approx(1.5, rel=1e-6) and part == pytest.approx(1e5 / 1.5**2)
    assert other[0] == pytest.approx(2.5, rel=1e-6)
    assert np.isnan(never).all()


def verdicts(points):
    return {
        (c.estimand, *c.condition.values()): c.verdict for c in EXPERIMENT.judged(tuple(points))
    }


def test_verdicts_follow_from_samples():
    found = verdicts(planted(rival=2.0))
    to_reference = ("FLIP to the reference", "aerial", "blake", "1 px")
    assert found["FLIP of the reference to itself", "aerial"] == "holds"
    assert found[*to_reference, "species"] == found[*to_reference, "ground"] == "holds"
    assert found[*to_reference, "all representations"] == "refuted"
    assert found["luminance ratio to the reference", "aerial", "20–60 m"] == "holds"
    assert found["FLIP in the same places", "aerial", "20–60 m"] == "refuted"
    assert found["parts at equal FLIP, blake ÷ bounded", "aerial", 0.01] == "holds"
    cheap = verdicts(planted(0.5))
    assert cheap["parts at equal FLIP, blake ÷ depth", "aerial", 0.01] == "refuted"


@pytest.mark.parametrize(("what", "which"), [("light", "luminance"), ("rays", "coverage")])
def test_light_and_coverage_are_judged_apart(what, which):
    found = verdicts(planted(**{what: 1.05}))
    for each in ("luminance", "coverage"):
        verdict = found[f"{each} ratio to the reference", "aerial", "0–20 m"]
        assert verdict == ("refuted" if each == which else "holds")


def test_intervals_are_as_much_wider_as_the_fit_is_biased_and_the_reference_moved():
    plain = planted()
    biased = [p for p in plain if p.case["pruned"] != NOTHING]
    biased += [headline(pruned=NOTHING, error=0.001)]
    moved = [*biased, headline(pruned=COARSER, error=0.003, light=1.01, rays=1.004)]
    found = [
        {(c.estimand, *c.condition.values()): c for c in EXPERIMENT.judged(p)}
        for p in (plain, biased, moved)
    ]
    flip = ("FLIP to the reference", "aerial", "blake", "1 px", "species")
    lit, seen = (f"{each} ratio to the reference" for each in ("luminance", "coverage"))
    for name, steps in {
        flip: (0.001, 0.003),
        (lit, "aerial", "20–60 m"): (0.0, 0.01),
        (seen, "aerial", "20–60 m"): (0.0, 0.004),
    }.items():
        first, *rest = (each[name] for each in found)
        for other, step in zip(rest, steps, strict=True):
            assert first.low - other.low == pytest.approx(step, abs=2e-5)
            assert other.high - first.high == pytest.approx(step, abs=2e-5)


def test_a_metric_that_never_reaches_the_error_is_not_compared():
    never = [p for p in planted(3.0) if p.case["what"] == "sweep" and p.case["detail"] <= 1]
    assert not equal_error(never, errors)["depth"].found
    assert not verdicts(never)


def test_bands_that_nobody_sees_are_not_judged_and_noise_is_taken_from_the_same_place():
    point = headline(error=0.004)
    assert judged_bands(point) == [0, 1, 2]
    assert same_place(point, 0).value == pytest.approx(0.004, rel=1e-3)
    assert same_place(point, 4) is None


def test_fields_have_suns_in_turn_and_full_runs_judge_what_nobody_looked_at():
    full = [c.args[1] for c in cases(**FULL)]
    seeds = {f.preset(0).seed for f in full}
    assert len(seeds) == 12 and min(seeds) > BUILDING_SEEDS
    assert {f.preset(0).light.sun_elevation for f in full} == set(SUN_ELEVATIONS_DEG)
    assert min(f.prototype_seed for f in full) > BUILDING_SEEDS
    quick = [c.args[1] for c in cases(**QUICK)]
    assert max(f.preset(5).seed for f in quick) <= BUILDING_SEEDS
    assert {f.prototype_seed for f in quick} == {PROTOTYPE_SEED}
    assert not {f.preset(0).seed for f in quick} & {f.preset(1).seed for f in quick}


def test_weighted_by_contrast_details_are_finer_and_haze_is_swept_by_two_metrics():
    swept = {
        f.view: ways for what, f, ways, *_ in (c.args for c in cases(**FULL)) if what == "sweep"
    }
    for view in ("eye level", "aerial", "hazy"):
        by = {m: [d for _, metric, d in swept[view] if metric == m] for _, m, _ in swept[view]}
        assert by["blake"] == DETAILS
        assert by["contrast_weighted"] == pytest.approx([1 / 16, 1 / 8, 1 / 4, 1 / 2, 1])
    assert set(by) == {"blake", "contrast_weighted"}


@pytest.mark.slow
def test_a_field_is_measured_and_pruned_apart():
    what, field, ways, _, variant = next(c.args for c in cases(**QUICK) if len(c.args[2]) > 1)
    field = replace(field, size="32x18")
    case = what, field, ways, Looks((4, 16), 2), variant
    points = merge_points([*measure(*case, 0), *measure(*case, 0)])
    by_way = {p.case["pruned"]: p for p in points}
    assert set(by_way) == {EVERYTHING, NOTHING, COARSER, SPECIES, GROUND}
    assert by_way[COARSER].column("parts")[0] < by_way[NOTHING].column("parts")[0]
    assert all(errors(p)[0] == errors(p)[1] for p in points)
    nothing, everything = by_way[NOTHING], by_way[EVERYTHING]
    assert nothing.column("parts")[0] > by_way[SPECIES].column("parts")[0]
    assert everything.column("triangles")[0] < nothing.column("triangles")[0]
    scene = scene_of(field, 0)
    world, view = scene.world, scene.view(1)
    whole = reference(world, view)
    alone = displayed(world, view, GROUND, "blake", 1.0)
    assert parts_in(world, alone) == parts_in(world, whole) == nothing.column("parts")[0]
    assert (
        load_preset("meadow").world.season == Field("hazy", 0, False, "9x9").preset(0).world.season
    )
