"""A record is raw, whole, immutable and traceable; a verdict follows from its numbers."""

import json
import os
from dataclasses import replace

import pytest

from bench.records.claims import Claim, claim, claim_from
from bench.records.provenance import provenance
from bench.records.records import (
    Point,
    Record,
    columns,
    predictions,
    read_record,
    read_records,
    write_record,
)
from bench.statistics.estimates import Estimate
from lod.errors import InputError


def a_claim(low, high, predicted=2.0, tolerance=0.02, relation="equals"):
    return Claim(
        "x",
        "about",
        "exponent",
        "§4.1",
        predicted,
        tolerance,
        (low + high) / 2,
        low,
        high,
        relation,
    )


def a_record(seed=0, made="2026-01-01T00:00:00Z", **changes):
    points = (
        Point(
            {"K": 0.01, "name": "größe [ 1,\n 2 ]"},
            predictions({"objects": 3.5}),
            columns({"objects": [3, 4, 2**60]}),
        ),
        Point({"K": 0.1}, predictions({"objects": 0.1 + 0.2}), columns({"objects": []})),
    )
    made_here = provenance(scene="ab" * 32, seed=seed)
    record = Record(
        "scaling", 1, False, made, made_here, points, (a_claim(1.99, 2.01),), {"target": 0.005}
    )
    return replace(record, **changes)


@pytest.mark.parametrize(
    "low, high, relation, verdict",
    [
        (1.985, 2.015, "equals", "holds"),
        (1.98, 2.02, "equals", "holds"),
        (1.97, 2.01, "equals", "undecided"),
        (1.5, 2.5, "equals", "undecided"),
        (2.021, 2.03, "equals", "refuted"),
        (1.9, 1.979, "equals", "refuted"),
        (0.1, 0.2, "at most", "holds"),
        (0.1, 2.1, "at most", "undecided"),
        (2.03, 2.1, "at most", "refuted"),
    ],
)
def test_the_verdict_follows_from_the_interval(low, high, relation, verdict):
    assert a_claim(low, high, relation=relation).verdict == verdict


@pytest.mark.parametrize(
    "low, high, verdict",
    [(1.99, 2.01, "holds"), (1.97, 2.01, "undecided"), (2.03, 2.1, "fails as expected")],
)
def test_what_fails_where_that_is_expected_refutes_nothing(low, high, verdict):
    made = replace(a_claim(low, high), expected_to_fail=True)
    assert made.verdict == verdict
    assert claim_from(made.as_json()) == made
    assert "expected_to_fail" not in a_claim(low, high).as_json()


def test_a_verdict_is_never_read_back():
    data = a_claim(1.99, 2.01).as_json()
    assert data["verdict"] == "holds"
    assert claim_from(data | {"verdict": "refuted"}).verdict == "holds"
    assert claim_from(data | {"low": 1.0}).verdict == "undecided"


def test_a_claim_takes_its_numbers_from_the_estimate():
    made = claim("n", ("a", "q", "§"), 1.0, 0.02, Estimate(1.001, 0.99, 1.01, 0.005, 1.0, 9))
    assert (made.measured, made.low, made.high, made.verdict) == (1.001, 0.99, 1.01, "holds")


@pytest.mark.parametrize("low, high", [(float("nan"), 1.0), (1.0, float("inf"))])
def test_a_claim_of_numbers_that_are_not_finite_is_refused(low, high):
    with pytest.raises(InputError, match="finite"):
        a_claim(low, high)


def test_a_claim_outside_its_own_interval_is_refused():
    with pytest.raises(InputError, match="low"):
        Claim("x", "about", "q", "§", 1.0, 0.1, measured=3.0, low=1.0, high=2.0)


def test_what_is_written_reads_back(tmp_path):
    record = a_record()
    path = write_record(record, tmp_path / "new" / "folder")
    assert read_record(path) == record
    assert path.name == f"scaling-{record.sha256[:16]}.json" == record.name
    assert os.listdir(path.parent) == [path.name]
    assert write_record(record, path.parent) == path


def test_the_samples_have_a_hash_of_their_own():
    one, later = a_record(), a_record(made="2027-01-01T00:00:00Z", notes={"seconds": 3.0})
    assert one.samples_sha256 == later.samples_sha256
    assert one.sha256 != later.sha256


@pytest.mark.parametrize(
    "old, new", [('"low": 1.99', '"low": 1.9'), ("[3,4,", "[3,5,"), ("0.01", "0.02")]
)
def test_an_edited_record_is_refused(tmp_path, old, new):
    path = write_record(a_record(), tmp_path)
    text = path.read_text()
    assert text.count(old) >= 1
    path.write_text(text.replace(old, new, 1))
    with pytest.raises(InputError, match="SHA-256"):
        read_record(path)


def test_a_record_that_names_another_hash_is_refused(tmp_path):
    path = write_record(a_record(), tmp_path)
    path.write_text(path.read_text().replace(a_record().sha256, "0" * 64))
    with pytest.raises(InputError, match="SHA-256"):
        read_record(path)


@pytest.mark.parametrize("version", [1, 2, 4, None])
def test_a_record_of_another_format_is_refused(tmp_path, version):
    path = write_record(a_record(), tmp_path)
    body = json.loads(path.read_text(encoding="utf-8"))
    assert body["format_version"] == 3
    path.write_text(json.dumps(body | {"format_version": version}), encoding="utf-8")
    with pytest.raises(InputError, match="format version 3"):
        read_record(path)


def test_a_renamed_record_is_refused(tmp_path):
    path = write_record(a_record(), tmp_path)
    moved = path.rename(tmp_path / f"scaling-{'0' * 16}.json")
    with pytest.raises(InputError, match="SHA-256"):
        read_record(moved)


@pytest.mark.parametrize(
    "text, rule",
    [
        ("{", "readable JSON"),
        ("[]", "format"),
        ('{"format": "other"}', "format"),
        ('{"format": "lodbench-record", "format_version": 99}', "version"),
    ],
)
def test_what_is_not_a_record_is_refused(tmp_path, text, rule):
    path = tmp_path / f"scaling-{'0' * 16}.json"
    path.write_text(text)
    with pytest.raises(InputError, match=rule):
        read_record(path)
    with pytest.raises(InputError, match=rule):
        read_records(tmp_path)


def test_a_folder_gives_its_records_the_newest_first(tmp_path):
    days = ["2026-01-02T00:00:00Z", "2026-01-03T00:00:00Z", "2026-01-01T00:00:00Z"]
    for day in days:
        write_record(a_record(made=day), tmp_path)
    (tmp_path / "manifest.json").write_text("{}")
    (tmp_path / "something-else.json").write_text("{}")
    assert [r.made for r in read_records(tmp_path)] == sorted(days, reverse=True)


def test_a_failed_write_leaves_nothing_behind(tmp_path, monkeypatch):
    def fail(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "replace", fail)
    with pytest.raises(InputError, match="No space left"):
        write_record(a_record(), tmp_path)
    assert os.listdir(tmp_path) == []


def test_numbers_that_are_not_finite_are_never_written(tmp_path):
    with pytest.raises(ValueError):
        write_record(a_record(notes={"x": float("nan")}), tmp_path)
    assert os.listdir(tmp_path) == []


def test_provenance_names_the_machine_and_the_packages():
    here = provenance(scene="x", seed=3)
    assert here.cpu and here.platform and here.cores >= 1 and here.threads == 1
    assert {"numpy", "scipy", "statsmodels", "numba"} <= set(here.packages)
    assert here.commit is None or len(here.commit.removesuffix("+changes")) == 40


def test_readable_text(tmp_path):
    lines = write_record(a_record(), tmp_path).read_text().splitlines()
    assert sum('"values": [3,4,' in line for line in lines) == 1
    assert json.loads("\n".join(lines))["format"] == "lodbench-record"
