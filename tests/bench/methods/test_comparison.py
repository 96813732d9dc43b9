"""Methods are compared at equal error: cheats never get there, and a copy ties.

Programs of others: what they are given, and that an environment is complete or is not there.
"""

import os
import weakref
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from bench.experiments.methods import (
    EXPERIMENT,
    estimated_bytes,
    measure_window,
    noise,
    peak_bytes,
    plan,
    tables,
)
from bench.frame_costs import Picture
from bench.images.differences import PAIR_BANDS
from bench.methods import environments
from bench.methods.comparison import (
    EQUAL_SHARE,
    RULES,
    at_equal_error,
    beside_best,
    judged_error,
)
from bench.methods.environments import CYCLES, VIDEO, answer_of
from bench.methods.known_methods import culled_beyond, methods
from bench.methods.method import Method, by_view
from bench.methods.runner import STAGES, Runner, Window
from bench.methods.video import just_objectionable_differences
from bench.records.records import Column, Point, where
from lod.errors import InputError
from scenes import plugins
from scenes.render.render import build_frame
from tests.bench.edited import record_of

PLUGIN = Path(__file__).parents[2] / "plugin"
EXAMPLE = PLUGIN.parents[1] / "examples" / "plugin"


EQUAL = 0.1 * EQUAL_SHARE
"""The excess of FLIP at equal error, where the ceiling is 0.1 above the floor."""


def point(arm, setting, excess, seconds, field=0, megabytes=100.0, cover=1.0):
    """A point of one arm, with times of its stages that sum to ``seconds``.

    ``excess`` is FLIP beyond the floor; the ceiling is 0.1 above it. It covers a share of what
    things cover in the farthest band that has any.
    """
    flip = Column("flip", [round(1e6 * (0.005 + excess))] * 2)
    floor, ceiling = Column("flip_floor", [5000] * 2), Column("flip_ceiling", [105_000] * 2)
    share = round(1e6 * seconds / len(STAGES))
    times = [Column("us", [share] * 3, {"stage": stage}) for stage in STAGES]
    held = Column("peak_bytes", [round(1e6 * megabytes)])
    case = {"topic": "rivals", "kind": "crowd", "objects": 1e3, "field": field, "arm": arm}
    case |= {"setting": setting}
    shown = [*_shown("reference", 1.0), *_shown("tested", cover)]
    pixels = [Column("pixels", [1000], {"band": band}) for band in PAIR_BANDS]
    samples = (flip, floor, ceiling, *times, held, *pixels, *shown, Column("sticks", [7]))
    return Point(case, samples=samples)


def _shown(picture, cover):
    shares = [1.0] * (len(PAIR_BANDS) - 2) + [cover, 1.0]
    for band, share in zip(PAIR_BANDS, shares, strict=True):
        yield Column("covered", [round(500 * share)], {"picture": picture, "band": band})
        yield Column("lit", [round(1e6 * 500 * share)], {"picture": picture, "band": band})


def rows(arm, times, field=0):
    """Settings 1, 2 and 4 with excesses of a half, equal and double error."""
    excess = (EQUAL / 2, EQUAL, 2 * EQUAL)
    settings = (1.0, 2.0, 4.0)
    found = zip(settings, excess, times, strict=True)
    return [point(arm, s, e, t, field) for s, e, t in found]


def test_time_at_equal_error_is_read_between_settings():
    half = [point("blake", 1.0, EQUAL / 4, 8.0), point("blake", 2.0, 4 * EQUAL, 2.0)]
    assert at_equal_error(half)["blake"][0].seconds == pytest.approx(4.0)
    assert at_equal_error(rows("blake", (8.0, 4.0, 2.0)))["blake"][0].seconds == pytest.approx(4.0)


def test_a_plan_says_where_an_hour_tells_most():
    """By hand: 3.4 % between 6 fields are ± 3.6 %; the plan begins with the most for an hour."""
    lines = plan(**EXPERIMENT.topics["rivals"].full)
    assert len(lines) == 6 and any("crowd" in each and "± 4 %" in each for each in lines)
    worth = [float(each.split(", ")[-1].split()[0]) for each in lines]
    assert worth == sorted(worth, reverse=True) and plan(worlds=[["zoo", 10.0, 2, []]]) == []


def test_a_cheat_never_reaches_equal_error():
    cheat = [point("distance", s, 0.2, 0.01) for s in (100.0, 50.0)]
    found = at_equal_error([*rows("blake", (8.0, 4.0, 2.0)), *cheat])
    assert not found["distance"][0].reached and beside_best(found, "seconds") is None
    assert EXPERIMENT.judged((*rows("blake", (8.0, 4.0, 2.0)), *cheat)) == ()


def test_who_leaves_out_what_is_far_is_not_within_the_error():
    """FLIP over the picture forgives that some of the far is not drawn; the cover does not."""
    few = [point("distance", 400.0, 0.0, 4.0), point("distance", 50.0, 0.001, 1.0, cover=0.97)]
    assert at_equal_error(few, RULES[1])["distance"][0].seconds == pytest.approx(1.0)
    assert at_equal_error(few)["distance"][0].seconds == pytest.approx(4.0)
    assert not at_equal_error(few[1:])["distance"][0].reached


def test_a_baseline_that_fits_in_some_fields_alone_does_not_count():
    both = [each for field in (0, 1) for each in rows("blake", (8.0, 4.0, 2.0), field)]
    assert beside_best(at_equal_error([*both, *rows("full", (2.0, 2.0, 2.0))]), "seconds") is None


def test_a_copy_ties_and_the_better_of_two_baselines_counts():
    both = [
        each
        for field in (0, 1)
        for times, arm in (((8, 4, 2), "blake"), ((8, 4, 2), "copy"), ((9, 5, 3), "worse"))
        for each in rows(arm, times, field)
    ]
    time, same_time, memory, same_memory, *alone = EXPERIMENT.judged(tuple(both))
    of = {"kind": "crowd", "objects": 1e3, "error by": RULES[0], "baseline": "copy"}
    assert time.condition == same_time.condition == of
    assert (time.measured, time.low, time.high) == pytest.approx((1.0, 1.0, 1.0))
    assert {each.verdict for each in (time, same_time, memory, same_memory)} == {"holds"}
    assert same_time.verdict_text == "equivalent within ±0.05"
    assert {each.condition["error by"] for each in alone} == {RULES[1]}


def test_weighted_by_contrast_the_metric_stands_beside_blake_alone():
    """Twice blake's time is refuted, however little others take, and is nobody's baseline."""
    every = {"blake": (8, 4, 2), "contrast_weighted": (16, 8, 4), "discrete": (2, 1, 1)}
    both = [p for field in (0, 1) for arm, times in every.items() for p in rows(arm, times, field)]
    found = {
        (c.estimand.split(", ")[-1], c.condition["baseline"]): c
        for c in EXPERIMENT.judged(tuple(both))
        if c.estimand.startswith("time") and c.condition["error by"] == RULES[0]
    }
    weighted = found["contrast_weighted ÷ best baseline", "blake"]
    assert (weighted.measured, weighted.verdict) == (pytest.approx(2.0), "refuted")
    assert set(found) == {
        (f"{m} ÷ best baseline", b)
        for m, b in (("contrast_weighted", "blake"), ("blake", "discrete"))
    }


def test_fields_pass_together():
    """What one field covers too little another covers too much: the world is not off."""
    both = [
        point("blake", 1.0, 0.0, 4.0, field, cover=cover) for field, cover in ((0, 0.97), (1, 1.03))
    ]
    assert all(each.reached for each in at_equal_error(both)["blake"])
    assert not at_equal_error(both[:1])["blake"][0].reached


def test_a_slower_metric_is_refuted():
    both = [
        each
        for field in (0, 1, 2)
        for times, arm in (((8, 4 + field / 10, 2), "blake"), ((4, 2, 1), "discrete"))
        for each in rows(arm, times, field)
    ]
    time, same, *_ = EXPERIMENT.judged(tuple(both))
    assert same.verdict == "refuted"
    assert time.verdict == "refuted" and time.measured == pytest.approx(2.05, abs=0.01)


@pytest.mark.slow
def test_an_arm_that_is_foretold_not_to_fit_is_entered_with_what_it_needs(monkeypatch):
    """Without a whole picture there are no errors; the arms that fit are timed as they are."""
    some = {name: methods()[name] for name in ("blake", "full", "distance")}
    few = {name: replace(arm, settings=arm.settings[-1:]) for name, arm in some.items()}
    monkeypatch.setattr("bench.experiments.methods.methods", lambda: few)
    window = Window("crowd", 60.0, 0, Picture("32x18", 1), 1, 1, "scalar_rgb", weighed=0)
    monkeypatch.setattr("bench.experiments.methods.MOST_BYTES", 1)
    points = measure_window(window, 0)
    needed = {p.case["arm"]: p.column("foretold_bytes")[0] for p in points if len(p.samples) == 1}
    assert set(needed) == {"full", "distance"} and min(needed.values()) > 1e6
    assert EXPERIMENT.judged(tuple(points)) == () and at_equal_error(points) == {}
    _, (_, (_, rows)), *_ = tables(record_of(EXPERIMENT, points))
    cost = {row[1]: row[2] for row in rows}
    assert cost["full"] == cost["distance"] == "does not fit"
    assert cost["blake"].startswith("no reference; ")
    assert cost["blake"].endswith(f" at {few['blake'].settings[-1]:g}")


def test_no_scene_of_another_method_exists_while_a_picture_is_made(monkeypatch):
    """Its shapes would be in the code that is compiled: 10⁵ copies have taken all memory so."""
    some = {name: methods()[name] for name in ("blake", "full")}
    few = {name: replace(arm, settings=arm.settings[-1:]) for name, arm in some.items()}
    monkeypatch.setattr("bench.experiments.methods.methods", lambda: few)
    built, alive = [], []

    def noted(*arguments):
        made = build_frame(*arguments)
        built.append(weakref.ref(made.scene))
        return made

    def picture(runner, seed):
        alive.append(sum(each() is not None for each in built))
        return made_picture(runner, seed)

    made_picture = Runner.picture
    monkeypatch.setattr("bench.methods.runner.build_frame", noted)
    monkeypatch.setattr(Runner, "picture", picture)
    window = Window("still crowd", 60.0, 0, Picture("32x18", 1), 1, 1, "scalar_rgb", weighed=0)
    measure_window(window, 0)
    assert len(built) >= 4 and max(alive) == 1


def test_culling_is_estimated_to_need_no_more_than_everything():
    """The ground of a culling arm is the whole view's, and is not refined by the arm's metric."""
    window = Window("crowd", 300.0, 0, Picture("320x180", 16), 1, 1, "scalar_rgb")
    scene = window.scene(0)
    full, far, near = (
        estimated_bytes(methods()[name], setting, scene, "scalar_rgb")
        for name, setting in (("full", 0.0), ("distance", 800.0), ("distance", 50.0))
    )
    assert full == far > near > 0.3 * full


CHEAT = Method(
    "cheat",
    "nothing beyond 50 m",
    "planted",
    "none",
    (50.0,),
    by_view(culled_beyond),
    culled_beyond,
)


@pytest.fixture(scope="module")
def planted():
    """Points of a small field: with a cheat, a copy of the metric, and an outside package's arm.

    The example package is installed, here and in processes that are started.
    """
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(str(EXAMPLE))
        patch.syspath_prepend(str(PLUGIN))
        patch.setenv("PYTHONPATH", f"{PLUGIN}{os.pathsep}{EXAMPLE}")
        plugins.installed.cache_clear()
        some = {name: methods()[name] for name in ("blake", "full", "nearest")}
        blake = replace(some["blake"], settings=(0.5, 2.0))
        tried = {**some, "blake": blake, "copy": replace(blake, name="copy"), "cheat": CHEAT}
        patch.setattr("bench.experiments.methods.methods", lambda: tried)
        patch.setattr("bench.experiments.methods.peak_bytes", _peak_of(blake))
        window = Window("crowd", 1000.0, 0, Picture("64x36", 16), 2, 3, "scalar_rgb")
        yield tuple(measure_window(window, 0))
    plugins.installed.cache_clear()


def _peak_of(blake):
    """Memory is measured in processes that know no planted arm: a copy is asked for as blake."""

    def peak(runner, case, seed):
        known = {"copy": blake, "cheat": methods()["distance"]}
        method = known.get(runner.method.name, runner.method)
        return peak_bytes(replace(runner, method=method), case, seed)

    return peak


@pytest.mark.slow
def test_a_planted_cheat_never_comes_up_to_the_error(planted):
    found = at_equal_error(planted)
    assert not any(each.reached for arm in ("cheat", "nearest") for each in found[arm])
    assert all(each.reached for arm in ("blake", "full") for each in found[arm])


@pytest.mark.slow
def test_a_planted_copy_ties(planted):
    """Its errors are the very same, and so is what decides its time and memory: all it draws."""
    mine, copied = (where(planted, arm=arm) for arm in ("blake", "copy"))
    assert [judged_error([p]) for p in mine] == [judged_error([p]) for p in copied]
    assert [_drawn(p) for p in mine] == [_drawn(p) for p in copied]
    assert len({_drawn(p) for p in mine}) == len(mine)


def _drawn(each):
    return tuple(each.values(name)[0] for name in ("shapes", "sticks", "triangles"))


@pytest.fixture
def none_made(tmp_path, monkeypatch):
    monkeypatch.setattr(environments.platformdirs, "user_data_path", lambda *args, **more: tmp_path)
    return tmp_path


def test_an_environment_is_there_when_it_was_made_whole_from_these_requirements(none_made):
    python = CYCLES.folder / "bin" / "python"
    python.parent.mkdir(parents=True)
    python.touch()
    assert none_made in python.parents and CYCLES.python() is None
    (CYCLES.folder / "made-from").write_text(CYCLES._digest(), encoding="utf-8")
    assert CYCLES.python() == python
    assert replace(CYCLES, requirements=VIDEO.requirements).python() is None


@pytest.mark.usefixtures("none_made")
def test_what_cannot_be_made_or_asked_is_refused_in_a_line(monkeypatch):
    with pytest.raises(InputError, match="lodbench environments cycles"):
        answer_of(CYCLES, "a_child.py", "{}")
    with pytest.raises(InputError, match=r"Python 2\.7 alone"):
        replace(CYCLES, needs_python="2.7").make()
    full = SimpleNamespace(free=1e9)
    monkeypatch.setattr(environments.shutil, "disk_usage", lambda path: full)
    with pytest.raises(InputError, match=r"downloads 3\.1 GB"):
        VIDEO.make()


def test_noise_is_the_variance_of_one_sample():
    """Light of 1 with a standard deviation of 0.1 at 4 samples: 0.04 × exposure² of each pixel."""
    random = np.random.default_rng(1)
    few, many = (
        [1.0 + spread * random.standard_normal((90, 160, 3)) for _ in range(3)]
        for spread in (0.1, 0.05)
    )
    assert np.mean(noise(few, 4)) == pytest.approx(np.mean(noise(many, 16)), rel=0.03)
    assert 0.02 * 1e6 < np.mean(noise(few, 4)) <= 0.042 * 1e6


@pytest.mark.slow
@pytest.mark.skipif(VIDEO.python() is None, reason="no environment with ColorVideoVDP was made")
def test_the_same_video_has_ten_points_and_a_noisy_one_fewer():
    random = np.random.default_rng(0)
    whole = random.random((8, 36, 64, 3)).astype("f4")
    noisy = np.clip(whole + 0.1 * random.standard_normal(whole.shape), 0, 1).astype("f4")
    videos = {"same": whole, "noisy": noisy}
    found = just_objectionable_differences(videos, whole, 24.0, (75.4, 30.0))
    assert found["same"] == pytest.approx([10.0, 10.0]) and max(found["noisy"]) < 9.5
