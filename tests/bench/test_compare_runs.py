"""Two runs are compared claim by claim, and only where they can be."""

import gzip
import json
from dataclasses import replace
from pathlib import Path

import jsonschema
import pytest

from bench.cli.main import main
from bench.compare_runs import compare, compare_paths
from bench.experiment import Experiment, experiments
from bench.records.claims import Claim
from bench.records.provenance import provenance, scene_digest
from bench.records.records import (
    Point,
    Record,
    columns,
    predictions,
    read_record,
    read_records,
    record_schema,
    write_record,
)
from lod.errors import InputError

SCHEMA = record_schema()
RESULTS = Path("results/reference")
HELD = Claim("a", "within", 1.0, 0.02, {}, "field", "§4.1", 1.0, 0.99, 1.01)
NEAR = replace(HELD, measured=1.002, low=0.992, high=1.012)
APART = replace(HELD, measured=1.015, low=1.012, high=1.018)
FALSE = replace(HELD, measured=1.5, low=1.4, high=1.6)


def a_record(claims=(HELD,), samples=(1, 2), made="2026-01-01T00:00:00Z", **origin):
    point = Point({"x": 1}, predictions({"n": 1.0}), columns({"n": list(samples)}))
    found = replace(provenance("ab" * 32, 0), **origin)
    return Record("scaling", 1, True, made, found, (point,), tuple(claims), {})


@pytest.mark.parametrize(
    "after, change",
    [
        ((HELD,), "same"),
        ((NEAR,), "within the intervals"),
        ((APART,), "moved"),
        ((FALSE,), "verdict"),
        ((), "gone"),
    ],
)
def test_each_claim_tells_what_became_of_it(after, change):
    found = compare(a_record(), a_record(after))
    assert [each.change for each in found.differences] == [change]


def test_a_claim_that_is_new_is_said_to_be(tmp_path):
    found = compare(a_record(()), a_record())
    assert [each.change for each in found.differences] == ["new"]
    assert found.same_samples and found.origin == {}
    other = compare(a_record(), a_record(samples=(1, 3), seed=4, commit="0" * 40))
    assert not other.same_samples and set(other.origin) == {"seed", "commit"}


def test_times_drift_on_one_kind_of_machine_and_numbers_on_any():
    """In one case of three times are half of what they were, and counts 2 % more."""

    def measured(us, n, **origin):
        rows = zip("abc", (9000, 9000, us), (500, 500, n), strict=True)
        points = [Point({"x": x}, (), columns({"t_us": [t] * 4, "n": [k] * 4})) for x, t, k in rows]
        return replace(a_record(**origin), points=tuple(points))

    before, here = measured(9000, 500), measured(4500, 510)
    there = measured(4500, 510, cpu="another", cores=9, threads=9)
    found = {name: compare(before, each) for name, each in (("here", here), ("there", there))}
    drifted = {name: {each.quantity for each in one.drifts} for name, one in found.items()}
    assert drifted == {"here": {"n", "t_us"}, "there": {"n"}}
    assert set(found["there"].origin) == {"cpu", "cores", "threads"}


@pytest.mark.parametrize(
    "change",
    [
        {"scene": "cd" * 32},
        {"variant": "x"},
    ],
)
def test_what_cannot_be_compared_is_refused(change):
    with pytest.raises(InputError, match=next(iter(change))):
        compare(a_record(), a_record(**change))


@pytest.mark.parametrize("change", [{"quick": False}, {"version": 2}, {"experiment": "figure"}])
def test_other_questions_are_refused(change):
    with pytest.raises(InputError, match=next(iter(change))):
        compare(a_record(), replace(a_record(), **change))


def test_folders_are_compared_by_their_newest_records(tmp_path, capfd):
    one, other = tmp_path / "one", tmp_path / "other"
    write_record(a_record((FALSE,)), one)
    write_record(a_record(made="2026-01-02T00:00:00Z"), one)
    write_record(a_record((NEAR,)), other)
    (found,) = compare_paths(one, other)
    assert found.differences[0].change == "within the intervals"
    with pytest.raises(SystemExit) as left:
        main(["compare", str(one), str(other), "--json"])
    assert left.value.code == 0
    assert json.loads(capfd.readouterr().out)["differences"][0]["name"] == "a"
    with pytest.raises(SystemExit) as left:
        main(["compare", str(one), str(other)])
    assert left.value.code == 0 and "0 of 1 claims are the same" in capfd.readouterr().out


def test_paths_of_two_kinds_and_folders_with_nothing_shared_are_refused(tmp_path, capfd):
    path = write_record(a_record(), tmp_path / "one")
    (tmp_path / "none").mkdir()
    for pair in ((path, tmp_path), (tmp_path / "one", tmp_path / "none")):
        with pytest.raises(SystemExit) as left:
            main(["compare", *map(str, pair)])
        assert left.value.code == 2 and "A B" in capfd.readouterr().err


def of_topics(*topics, number=2, made="2026-01-01T00:00:00Z"):
    """A full record of counts of surfaces, whose topics are what is asked."""
    cases = [{"topic": topic, "x": number} for topic in topics]
    points = tuple(Point(case, (), columns({"n": [1, 2]})) for case in cases)
    record = replace(a_record(made=made, scene=scene_digest(cases)), points=points)
    return replace(record, experiment="law", version=experiments()["law"].version)


@pytest.fixture
def claims_by_topic(monkeypatch):
    """Let each topic of ``law`` make one claim, of its own name."""

    def judged(self, points):
        return tuple(replace(HELD, estimand=point.case["topic"]) for point in points)

    monkeypatch.setattr(Experiment, "judged", judged)


def test_records_are_compared_by_the_topics_of_both(claims_by_topic):
    whole, part = of_topics("scaling", "depth", "growth"), of_topics("depth")
    for pair in ((whole, part), (part, whole)):
        found = compare(*pair)
        assert [(each.name, each.change) for each in found.differences] == [("depth", "same")]
        assert found.same_samples
        assert (found.before, found.after) == tuple(each.name for each in pair)
    with pytest.raises(InputError, match="scene"):
        compare(whole, of_topics("depth", number=3))
    with pytest.raises(InputError, match="scene"):
        compare(part, of_topics("growth"))


def test_folders_meet_topic_by_topic_each_in_its_newest_record(claims_by_topic, tmp_path):
    one, other = tmp_path / "one", tmp_path / "other"
    old = write_record(of_topics("scaling", "depth"), one).name
    new = write_record(of_topics("depth", made="2026-01-02T00:00:00Z"), one).name
    write_record(of_topics("scaling", "depth", "growth"), other)
    found = {each.before: [d.name for d in each.differences] for each in compare_paths(one, other)}
    assert found == {old: ["scaling"], new: ["depth"]}
    (tmp_path / "third").mkdir()
    write_record(of_topics("growth"), tmp_path / "third")
    with pytest.raises(InputError) as refused:
        compare_paths(one, tmp_path / "third")
    assert f"of law {one} has depth scaling, {tmp_path / 'third'} growth" in str(refused.value)
    assert refused.value.cure.endswith(f"lodbench run growth -o {one}")


# The published schema


def test_records_follow_the_published_schema(tmp_path):
    check = jsonschema.Draft202012Validator(SCHEMA)
    check.check_schema(SCHEMA)
    check.validate(json.loads(write_record(a_record(), tmp_path).read_bytes()))
    for path in RESULTS.glob("*-*.json.gz"):
        record = json.loads(gzip.decompress(path.read_bytes()))
        for column in (c for p in record["content"]["points"] for c in p["samples"]):
            del column["values"][9:]  # which are numbers, every one
        check.validate(record)


def test_a_compressed_record_is_the_same_and_a_torn_one_is_refused(tmp_path):
    path = write_record(a_record(), tmp_path)
    packed = path.with_name(f"{path.name}.gz")
    packed.write_bytes(gzip.compress(path.read_bytes()))
    assert read_record(packed) == read_record(path)
    path.unlink()
    assert read_records(tmp_path) == (read_record(packed),)
    packed.write_bytes(packed.read_bytes()[:-20])
    with pytest.raises(InputError, match="readable JSON"):
        read_record(packed)


def test_quick_and_full_runs_of_one_experiment_are_told_apart(tmp_path):
    for name, quick in (("one", True), ("two", False)):
        (tmp_path / name).mkdir()
        write_record(replace(a_record(), quick=quick), tmp_path / name)
    with pytest.raises(InputError) as found:
        compare_paths(tmp_path / "one", tmp_path / "two")
    assert f"scaling {tmp_path / 'one'} has quick ones, {tmp_path / 'two'} full" in str(found.value)
    assert found.value.cure == f"measure in full: lodbench run scaling -o {tmp_path / 'one'}"
