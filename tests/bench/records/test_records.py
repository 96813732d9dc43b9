"""A record is raw, whole, immutable and traceable; a verdict follows from its numbers."""

import json
import os
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from bench.records.claims import EXACT, at_least, at_most, claim, claim_from, equals, within
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

WITHIN = within(2.0, 0.02)


def a_claim(low, high, bound=WITHIN, replicates=9, **more):
    found = Estimate((low + high) / 2, low, high, 0.1, 1.0, replicates)
    return claim(
        "exponent of parts against τ",
        bound,
        {"preset": "meadow", "τ": "1 px"},
        found,
        **{"unit": "field", "source": "§4.1"} | more,
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
    ("low", "high", "bound", "verdict", "text"),
    [
        (1.985, 2.015, WITHIN, "holds", "equivalent within ±0.02"),
        (1.98, 2.02, WITHIN, "holds", "equivalent within ±0.02"),
        (1.97, 2.01, WITHIN, "inconclusive", "inconclusive"),
        (1.5, 2.5, WITHIN, "inconclusive", "inconclusive"),
        (2.021, 2.03, WITHIN, "refuted", "refuted"),
        (1.9, 1.979, WITHIN, "refuted", "refuted"),
        (0.1, 0.2, at_most(2.02), "holds", "holds"),
        (0.1, 2.1, at_most(2.02), "inconclusive", "inconclusive"),
        (2.03, 2.1, at_most(2.02), "refuted", "refuted"),
        (2.03, 2.1, at_least(2.02), "holds", "holds"),
        (0.1, 2.1, at_least(2.02), "inconclusive", "inconclusive"),
        (0.1, 0.2, at_least(2.02), "refuted", "refuted"),
    ],
)
def test_the_verdict_follows_from_the_interval(low, high, bound, verdict, text):
    made = a_claim(low, high, bound)
    assert (made.verdict, made.verdict_text) == (verdict, text)
    assert claim_from(json.loads(json.dumps(made.as_json()))) == made


@given(st.floats(-5, 5), st.floats(0.001, 3), st.floats(0, 2), st.floats(-5, 5))
def test_at_least_is_at_most_turned_round(middle, half, margin, value):
    low, high = middle - half, middle + half
    least = a_claim(low, high, at_least(value)).verdict
    assert least == a_claim(-high, -low, at_most(-value)).verdict
    if a_claim(low, high, within(value, margin)).verdict == "holds":
        assert a_claim(low, high, at_most(value + margin)).verdict == "holds"
        assert a_claim(low, high, at_least(value - margin)).verdict == "holds"


@pytest.mark.parametrize(
    ("low", "high", "verdict", "in_json"),
    [
        (1.99, 2.01, "holds", "holds"),
        (1.97, 2.01, "inconclusive", "undecided"),
        (2.03, 2.1, "expected violation", "refuted"),
    ],
)
def test_what_fails_where_that_is_expected_refutes_nothing(low, high, verdict, in_json):
    made = a_claim(low, high, violation_expected=True)
    assert made.verdict == verdict
    data = made.as_json()
    assert (data["verdict"], data["violation_expected"]) == (in_json, True)


def test_sentence_and_name_are_made_of_the_fields():
    made = a_claim(1.99, 2.01)
    assert made.sentence == "Exponent of parts against τ within 2 ± 0.02 (meadow, τ = 1 px)."
    assert made.name == "exponent_of_parts_against_tau/meadow/1_px"
    assert made.measured_text == "2.0000 (1.9900 to 2.0100)"
    assert a_claim(0.25, 0.3, at_least(0.1)).bound.__str__() == "≥ 0.1"


@given(st.floats(0.01, 3), st.floats(0.1, 3), st.integers(2, 200))
def test_a_claim_holds_where_its_chance_is_at_most_a_twentieth(half, margin, replicates):
    made = a_claim(2 - half, 2 + half, within(2, margin), replicates=replicates)
    assert (made.chance <= 0.05) == (made.verdict == "holds") or abs(half - margin) < 1e-9
    wider = a_claim(2 - 2 * half, 2 + 2 * half, within(2, margin), replicates=replicates)
    assert wider.chance > made.chance


def test_a_verdict_is_never_read_back():
    data = a_claim(1.99, 2.01).as_json()
    assert claim_from(data | {"verdict": "refuted"}).verdict == "holds"
    assert claim_from(data | {"low": 1.0}).verdict == "inconclusive"


@pytest.mark.parametrize(("low", "high"), [(float("nan"), 1.0), (1.0, float("inf"))])
def test_a_claim_of_numbers_that_are_not_finite_is_refused(low, high):
    with pytest.raises(InputError, match="finite"):
        a_claim(low, high)


def test_a_claim_outside_its_own_interval_is_refused():
    with pytest.raises(InputError, match="low"):
        replace(a_claim(1.0, 2.0), measured=3.0)


def test_a_single_number_says_that_it_is_exact_or_unreplicated():
    with pytest.raises(InputError, match="exact"):
        a_claim(2.0, 2.0, replicates=1)
    assert a_claim(2.0, 2.0).verdict == "holds", "nine fields that agree"
    assert a_claim(2.0, 2.0, unit=EXACT).measured_text == "2.0000 (exact)"
    assert a_claim(2.0, 2.0, equals(2.0), unit=EXACT).verdict == "holds"


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


@pytest.mark.parametrize("version", [3, None])
def test_a_record_of_another_format_is_refused(tmp_path, version):
    path = write_record(a_record(), tmp_path)
    body = json.loads(path.read_text(encoding="utf-8"))
    assert body["format_version"] == 4
    path.write_text(json.dumps(body | {"format_version": version}), encoding="utf-8")
    with pytest.raises(InputError, match="format version 4"):
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
