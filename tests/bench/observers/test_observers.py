"""The experiment for people without a browser: blocks, fits, files, exclusions, the record."""

import json
import math
from collections import Counter
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from bench.experiments.observers import (
    EXPERIMENT,
    answers_record,
    measure_predicted,
    measure_simulated,
    thresholds,
)
from bench.images.as_shipped import places
from bench.methods.environments import VIDEO
from bench.observers import make
from bench.observers.plan import (
    CONDITIONS,
    FITTED_LEVELS,
    LEVELS_PX,
    PLACES,
    SMALL_SET,
    STAIRCASE,
    SUBJECTS,
    WAYS,
    Condition,
    block_of,
)
from bench.observers.psychometric import (
    AT_75,
    GUESS,
    LAPSE_BETA,
    SLOPE_PRIOR,
    THRESHOLD_DEVIATION,
    Fits,
    chance_correct,
    fit,
    join,
)
from bench.observers.results import read_result, read_results, result_text
from bench.observers.simulate import ObserverModel, power, simulated_sessions
from bench.records.records import merge_points
from lod.errors import InputError
from scenes.render.variants import choose


@pytest.mark.parametrize("first", [1, 7, 115])
def test_six_observers_see_every_condition_once_in_balanced_blocks(first):
    blocks = [[CONDITIONS[k] for k in block_of(first + n, CONDITIONS)] for n in range(6)]
    assert Counter(c for block in blocks for c in block) == Counter(CONDITIONS)
    for block in blocks:
        assert Counter(c.place for c in block) == dict.fromkeys(PLACES, 2)
        assert Counter(c.way for c in block) == dict.fromkeys(WAYS, 2)
        assert max(Counter(c.subject for c in block).values()) <= 2


def test_at_tau75_who_has_no_lapses_is_right_three_times_in_four():
    slope = np.array([1.0, 2.5, 6.0])
    found = chance_correct(np.array([0.3]), 0.3 - AT_75 / slope, slope, np.zeros(1))
    assert found == pytest.approx([0.75] * 3)


def test_a_fit_of_many_trials_finds_the_threshold():
    shown = np.full((1, len(FITTED_LEVELS)), 4000)
    slope, lapse, x = np.array([2.0]), np.array([0.02]), np.array(FITTED_LEVELS)
    chance = chance_correct(x, 0.5 - AT_75 / slope, slope, lapse)
    found = fit(FITTED_LEVELS, np.rint(chance * shown).astype(int), shown)
    assert found.value[0] == pytest.approx(0.5, abs=0.01)
    assert found.low[0] < 0.5 < found.high[0] and found.deviation[0] < 0.02


def test_without_answers_a_fit_is_its_prior():
    none = np.zeros((1, len(FITTED_LEVELS)), int)
    found = fit(FITTED_LEVELS, none, none)
    assert found.value[0] == pytest.approx(found.middle, abs=1e-6)
    assert found.high[0] - found.low[0] == pytest.approx(3.92 * THRESHOLD_DEVIATION, rel=0.02)


def test_a_fit_agrees_with_psignifit():
    """With the same prior; psignifit is under the GPL, and so only tests may import it."""
    psignifit = pytest.importorskip("psignifit")
    x = np.array(STAIRCASE.levels)
    shown = np.array([[0, 4, 10, 10, 20, 20, 10, 10, 4, 2, 0, 0]])
    right = np.array([[0, 2, 5, 7, 13, 17, 10, 9, 4, 2, 0, 0]])
    ours = fit(FITTED_LEVELS, right, shown)
    data = np.column_stack((x, right[0, :-1], shown[0, :-1]))[shown[0, :-1] > 0]
    steepness = math.log(-math.log(0.05)) - math.log(-math.log(0.95))  # width times slope

    def normal(at, mean, deviation):
        return np.exp(-(((at - mean) / deviation) ** 2) / 2)

    theirs = psignifit.psignifit(
        data.astype(float),
        experiment_type="2AFC",
        sigmoid="gumbel",
        stimulus_range=(float(x[0]), float(x[-1])),
        fixed_parameters={"eta": 0.0},
        priors={
            "threshold": lambda at: normal(at, ours.middle, THRESHOLD_DEVIATION),
            "width": lambda w: (
                normal(np.log(steepness / w / math.log(10) / SLOPE_PRIOR[0]), 0, SLOPE_PRIOR[1]) / w
            ),
            "lambda": lambda lapse: (1 - lapse) ** (LAPSE_BETA - 1),
        },
        verbose=False,
    )
    low, high = theirs.confidence_intervals["threshold"]["0.95"]
    assert ours.value[0] == pytest.approx(theirs.parameter_estimate_mean["threshold"], abs=0.01)
    assert (ours.low[0], ours.high[0]) == pytest.approx((low, high), abs=0.02)


def exact_fits(value, deviation):
    """Fits whose likelihood is normal about a value, with the prior multiplied in."""
    precision = 1 / deviation**2 + 1 / THRESHOLD_DEVIATION**2
    drawn = (value / deviation**2 + 0.45 / THRESHOLD_DEVIATION**2) / precision
    return Fits(drawn, precision**-0.5, drawn, drawn, 0.45)


def test_the_mixed_model_finds_means_and_variances():
    rng = np.random.default_rng(3)
    observer, condition = np.repeat(np.arange(400), 3), np.tile(np.arange(3), 400)
    mean, error = np.array([0.0, 0.3, 0.9]), np.full(1200, 0.1)
    value = mean[condition] + rng.normal(0, 0.2, 400)[observer] + rng.normal(0, 0.1, 1200)
    fits = exact_fits(value + rng.normal(0, error), error)
    found, deviations = join(fits, observer, condition)
    assert [e.value for e in found] == pytest.approx(mean, abs=0.03)
    assert deviations == pytest.approx((0.2, 0.1), abs=0.03)
    assert all(e.low < m < e.high for e, m in zip(found, mean, strict=True))


def test_more_trials_need_fewer_observers():
    rows = power(36, ObserverModel())
    assert [row["trials"] for row in rows] == [12, 24, 48]
    for one, other in pairwise(rows):
        assert one["deviation"] > other["deviation"] and one["observers"] > other["observers"]
    assert power(6, ObserverModel())[0]["observers"] == rows[0]["each"]
    alike = replace(ObserverModel(), observers=0.0, conditions=0.0)
    assert power(36, alike)[1]["each"] < rows[1]["each"] / 2


def written(folder, plan, lapse, seed=0):
    paths = []
    for content in simulated_sessions(plan, lapse, ObserverModel(), seed):
        paths.append(folder / f"{content['observer']}.json")
        paths[-1].write_text(result_text(content), "utf-8")
    return paths


def test_bad_files_are_a_line_each_and_good_ones_are_read(plan, tmp_path):
    paths = written(tmp_path, plan, [math.nan] * 4)
    text = [path.read_text("utf-8") for path in paths]
    changed = json.loads(text[0])["content"]
    changed["trials"][0]["condition"] = 99
    bad = {
        "broken": text[0][:-100],
        "no-json": "\x00\xff",
        "a-list": "[]",
        "edited": text[0].replace('"answer": 0', '"answer": 1', 1),
        "doubled": text[0],
        "foreign": result_text({**json.loads(text[0])["content"], "plan": "0" * 64}),
        "newer": text[0].replace('"format_version": 1', '"format_version": 2'),
        "lacking": result_text({"plan": plan["sha256"]}),
        "off-protocol": result_text(changed),
    }
    for name, content in bad.items():
        (tmp_path / name).write_text(content, "utf-8")
    sessions, refused = read_results(
        [*paths, *map(tmp_path.joinpath, bad), tmp_path / "gone"], plan
    )
    assert [each.observer for each in sessions] == [1, 2, 3, 4]
    for name, said in {
        "broken": "a readable JSON file",
        "no-json": "a readable JSON file",
        "a-list": "a file that the page saved",
        "edited": "it was edited or damaged",
        "doubled": "who has 1.json as well",
        "foreign": "it is of another",
        "newer": "format_version: Input should be 1",
        "lacking": "observer",
        "off-protocol": "trials of the block of observer 1",
        "gone": "a readable JSON file",
    }.items():
        (line,) = (line for line in refused if f"/{name}" in line or f"/{name}'" in line)
        assert said in line and "\n" not in line
    assert len(refused) == len(bad) + 1


@pytest.mark.parametrize(
    ("change", "why"),
    [
        (lambda c: c["trials"].pop(), "not finished"),
        (lambda c: [t.update(ms=200) for t in c["trials"]], "sooner than 300 ms"),
        (lambda c: c["screen"].update(millipixels_per_degree=80000), "off 60 pixels"),
        (lambda c: None, ""),
    ],
)
def test_exclusions_are_by_rule(plan, tmp_path, change, why):
    (content,) = simulated_sessions(plan, [0.0], ObserverModel(), 1)
    change(content)
    (tmp_path / "a.json").write_text(result_text(content), "utf-8")
    reason = read_result(tmp_path / "a.json", plan).excluded(plan)
    assert why in reason and bool(why) == bool(reason)


def test_guessers_are_excluded(plan, tmp_path):
    sessions, _ = read_results(written(tmp_path, plan, [GUESS] * 6 + [math.nan] * 6), plan)
    assert [bool(each.excluded(plan)) for each in sessions] == [True] * 6 + [False] * 6


def test_a_record_of_answers_is_judged_and_drawn(plan, tmp_path):
    sessions, _ = read_results(written(tmp_path, plan, [math.nan] * 12, seed=2), plan)
    record = answers_record(sessions, plan, {})
    means = 10 ** ObserverModel().means(len(SMALL_SET))
    assert [c.measured for c in record.claims] == pytest.approx(means, rel=0.2)
    assert EXPERIMENT.judged(record.points) == record.claims
    (plot,) = EXPERIMENT.plots(record)
    assert plot.labels == ("observers", "Barten's eye", "FLIP 0.01")
    ((_, (_, rows)),) = EXPERIMENT.tables(record)
    assert len(rows) == 12 * len(SMALL_SET)
    with pytest.raises(InputError, match="2 observers"):
        answers_record(sessions[:1], plan, {})


def test_models_predict_where_their_values_cross():
    flip = [0.0025 * k for k in range(len(LEVELS_PX))]
    lost = [0.25 * 2**k for k in range(len(LEVELS_PX))]
    found = thresholds({"flip": flip, "lost": lost, "barten": [0.5] * len(LEVELS_PX)})
    assert found == pytest.approx({"flip": LEVELS_PX[4], "lost": LEVELS_PX[2]})
    halfway = thresholds({"lost": [0.25, 0.5, 2.0, 3.0, *[4.0] * (len(LEVELS_PX) - 4)]})
    assert halfway == pytest.approx({"lost": LEVELS_PX[1] * 2**0.25})
    assert thresholds({"flip": [0.02] * len(LEVELS_PX)}) == {}


def test_barten_sees_a_grating_at_the_contrast_of_its_sensitivity():
    """A grating whose half-period is 4 px, at its threshold modulation, has the value 1."""
    from lod.eye import SQUARE_WAVE_GAIN, Display, Eye, sensitivity

    side, px = 256, 4.0
    eye = sensitivity(Display(60.0, field_deg=side / 60), Eye())
    least = SQUARE_WAVE_GAIN / np.interp(60 / (2 * px), eye.frequency, eye.value)
    wave = 0.2 * (1 + least * np.sin(np.pi * np.arange(side) / px))
    encoded = [1.055 * v ** (1 / 2.4) - 0.055 for v in (wave, np.full(side, 0.2))]
    one, other = (np.broadcast_to(v[:, None, None], (side, side, 3)) for v in encoded)
    found = make.band_contrasts(one, other)
    assert found[LEVELS_PX.index(4.0)] == pytest.approx(1.0, rel=0.02)
    assert found[LEVELS_PX.index(16.0)] < 0.05


def test_pictures_that_are_finished_are_kept(tmp_path, monkeypatch):
    tiny = Path(__file__).parents[1] / "cli" / "tiny.toml"
    monkeypatch.setitem(SUBJECTS, "ground", str(tiny))
    monkeypatch.setattr(type(VIDEO), "python", lambda self: None)  # a minute, where it was made
    how, condition = make.Pictures("16x16", 1, 2), Condition("ground", "near", "still")
    (tmp_path / make.PICTURES).mkdir()
    entry = make.make_condition(condition, tmp_path, how)
    files = [entry["reference"], entry["again"], *entry["levels"]]
    assert len(set(files)) == len(FITTED_LEVELS) + 2
    times = {name: (tmp_path / name).stat().st_mtime_ns for name in files}
    (tmp_path / entry["levels"][3]).unlink()
    once_more = make.make_condition(condition, tmp_path, how)
    assert once_more["seconds"] > 0 and {**once_more, "seconds": entry["seconds"]} == entry
    now = {name: (tmp_path / name).stat().st_mtime_ns for name in files}
    assert [name for name in files if now[name] != times[name]] == [
        entry["reference"],
        entry["levels"][3],
    ]
    assert set(entry["models"]) >= {"flip", "barten"}


@pytest.mark.slow
@pytest.mark.skipif(VIDEO.python() is None, reason="no environment with ColorVideoVDP was made")
def test_models_see_more_in_a_coarser_preset():
    seen = []
    for detail in ("view.detail=1", "view.detail=16"):
        (place,) = places("crowd", 1, False, "64x36")
        place = replace(place, settings=(*place.settings, detail))
        point = measure_predicted(place, "still", 16, 1, 4 * 10**9, choose(), 0)
        seen.append(point.column("jod", ppd=60)[0])
    assert seen[1] < seen[0]


def claims_of(groups, count):
    points = merge_points(measure_simulated(count, group, 0) for group in range(groups))
    return {(c.estimand, c.condition["of"]): c for c in EXPERIMENT.judged(points)}


def test_guessers_and_observers_part_in_simulation():
    found = claims_of(4, 10)
    assert found["share excluded", "guessers"].measured >= 0.99
    assert found["share excluded", "lapsers"].measured == pytest.approx(0.958, abs=0.1)
    assert found["share excluded", "observers"].measured <= 0.1


@pytest.mark.slow
def test_simulated_observers_are_fitted_without_bias_and_intervals_cover():
    for claim in claims_of(100, 20).values():
        assert claim.verdict in ("holds", "inconclusive"), claim
