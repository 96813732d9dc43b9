"""Every fault that an audit planted is named: by a check of the record, or beside the run before.

Faults are planted in records of the reference run, whose samples are real. Two runs of the same
have the same samples, but for times, which get the noise that times have.
"""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from bench.compare_runs import compare, drifts, problems
from bench.experiment import experiments
from bench.images import fields
from bench.records.records import Column, Point, read_record, where
from bench.runs import RunRequest, run_experiment
from tests.bench.edited import edited, record_of, with_cases

pytestmark = pytest.mark.slow
EXPERIMENTS = experiments()


def of_reference(name):
    return read_record(next(Path("results/reference").glob(f"{name}-*")))


@pytest.fixture(scope="module")
def images():
    record = of_reference("images")
    return replace(record, points=tuple(where(record.points, topic="fidelity", what="headline")))


def with_points(record, change, **case):
    """The record with a change made to the points of these cases."""
    hit = [id(p) for p in where(record.points, **case)]
    assert hit
    return replace(record, points=tuple(change(p) if id(p) in hit else p for p in record.points))


def with_columns(change):
    """A change of a point: one of each of its columns."""
    return lambda point: replace(point, samples=tuple(map(change, point.samples)))


def scaled(quantity, factor, **keys):
    """A change of a point: columns of a quantity with these keys are multiplied."""

    def change(column):
        if column.quantity != quantity or not keys.items() <= column.keys.items():
            return column
        return replace(column, values=[round(factor * v) for v in column.values])

    return with_columns(change)


def exchanged(key, one, other):
    """A change of a point: columns with one value of a key get the other, and the reverse."""
    turned = {one: other, other: one}

    def change(column):
        value = column.keys.get(key)
        if value not in turned:
            return column
        return replace(column, keys=column.keys | {key: turned[value]})

    return with_columns(change)


swapped = exchanged("picture", "tested", "reference")


def test_nothing_is_wrong_with_the_records_of_the_reference_run(images):
    for name in ("methods", "cost", "law"):
        assert problems(of_reference(name)) == ()
    assert problems(images) == ()
    assert drifts(images, images) == ()


@pytest.mark.parametrize("pruned", [fields.EVERYTHING, fields.SPECIES])
def test_swapped_pictures_are_named(images, pruned):
    found = problems(with_points(images, swapped, view="aerial", pruned=pruned))
    assert any("the reference is another" in each for each in found)


def test_more_sticks_than_the_reference_are_named(images):
    most = max(where(images.points, pruned=fields.NOTHING)[0].column("sticks"))
    change = lambda p: edited(p, "sticks", lambda row: [most + 1] * len(row))  # noqa: E731
    found = problems(with_points(images, change, pruned=fields.SPECIES))
    assert found and all("more sticks" in each for each in found)


def test_a_treatment_that_is_missing_under_one_sun_is_named():
    def seen(pruned, suns):
        case = {"topic": "fidelity", "view": "hazy", "pruned": pruned}
        columns = Column("field", [*range(len(suns))]), Column("sun_deg", suns)
        return Point(case, samples=columns)

    both = [seen("everything", [10, 40, 70] * 2), seen("species", [10, 40, 70])]
    made = record_of(replace(EXPERIMENTS["images"], topics={}), both)
    assert problems(made) == ()
    odd = replace(made, points=tuple(seen(name, [10, 40, 70, 10]) for name in ("all", "species")))
    assert problems(odd) == ()
    for suns in ([10, 10, 70], [10, 40], [10, 40] * 2, [10, 40, 70, 10, 10]):
        for points in ((both[0], seen("species", suns)), (seen("species", suns), both[0])):
            found = problems(replace(made, points=points))
            assert any("some suns are missing" in each for each in found), suns


@pytest.mark.parametrize(
    "quantity, factor, keys, drifted",
    [
        ("light", 1.015, {"picture": "tested"}, "light"),
        ("light", 1 + 0.3 * 0.03, {"picture": "tested"}, "light"),  # 3 % of a species: 0.3 of it
        ("rays", 0.97, {"picture": "tested"}, "rays"),
        ("flip_ppm", 1.2, {}, "flip_ppm"),
    ],
)
def test_what_no_verdict_sees_drifts_beside_the_run_before(images, quantity, factor, keys, drifted):
    after = with_points(images, scaled(quantity, factor, **keys), pruned=fields.EVERYTHING)
    found = compare(images, after)
    assert {each.quantity for each in found.drifts} == {drifted}
    assert all(each.ratio == pytest.approx(factor, rel=2e-3) for each in found.drifts)
    assert found.as_json()["drifts"]


def test_an_error_that_is_two_thousandths_larger_drifts(images):
    def change(column):
        larger = [each + 2000 for each in column.values]
        return replace(column, values=larger) if column.quantity == "flip_ppm" else column

    found = drifts(images, with_points(images, with_columns(change), pruned=fields.EVERYTHING))
    assert {each.quantity for each in found} == {"flip_ppm"} and len(found) == 3  # every view


def refuted(record):
    judged = EXPERIMENTS[record.experiment].judged(record.points)
    return {each.name for each in judged if each.verdict == "refuted"}


def test_swapped_counts_of_samples_refute_that_the_reference_is_itself(images):
    other = replace(images, points=tuple(map(exchanged("samples", 32, 128), images.points)))
    found = refuted(other) - refuted(images)
    assert {f"flip_of_the_reference_to_itself/{view}" for view in ("aerial", "hazy")} <= found


def test_a_prediction_that_is_three_per_cent_too_large_is_refuted():
    law = of_reference("law")

    def change(point):
        larger = (replace(each, value=1.03 * each.value) for each in point.predicted)
        return replace(point, predicted=tuple(larger))

    assert not refuted(law)
    assert len(refuted(replace(law, points=tuple(map(change, law.points))))) > 30


def noisy(record, seed, spread=0.05):
    """The record with times that another run of the same would have had."""
    rng = np.random.default_rng(seed)
    day = float(np.exp(0.1 * rng.standard_normal()))

    def change(column):
        if column.quantity != "us":
            return column
        noise = np.exp(spread * rng.standard_normal(len(column.values)))
        return replace(
            column, values=np.rint(day * np.array(column.values) * noise).astype(int).tolist()
        )

    return replace(record, points=tuple(map(with_columns(change), record.points)))


@pytest.mark.parametrize("seed", range(5))
def test_a_slower_method_is_named_and_a_slower_day_is_not(seed):
    record = of_reference("methods")
    record = replace(record, points=tuple(p for p in record.points if "part" not in p.case))
    again = noisy(record, seed)
    assert drifts(record, again) == ()
    slower = with_points(again, scaled("us", 1.1), arm="blake")
    found = drifts(record, slower)
    assert found and all("blake" in each.where for each in found)
    assert all(each.ratio == pytest.approx(1.1, abs=0.05) for each in found)


def test_nothing_drifts_between_runs_of_other_seeds():
    """Counts of other fields: five seeds beside one."""
    law = EXPERIMENTS["law"]
    topic = law.topics["scaling"]
    cases = [
        each
        for each in topic.cases(metric=None, target=0.05, least=6, most=12)
        if each.args[0].species == "figure"
        and each.args[0].sweep in ("density", "world")
        and each.args[0].metric == "bounded"
    ]
    few = replace(with_cases(law, "scaling", cases), notes=None)
    first, *others = (
        run_experiment(few, RunRequest("law", ("scaling",), True, seed)) for seed in range(6)
    )
    assert [(problems(each), drifts(first, each)) for each in others] == [((), ())] * 5
