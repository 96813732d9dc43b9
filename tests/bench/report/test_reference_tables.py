"""Tables of pages say what claims.json says, and which verdicts are others than before."""

import csv
import json

import pytest

from bench.records.claims import Claim
from bench.report.reference_tables import (
    changed_table,
    experiment_table,
    judged_claims,
    short_commits,
)

WORDS = "Parts drop off.", "exponent", "§4"
CLAIMS = (
    Claim("blake/person/exponent", *WORDS, -0.5, 0.1, -0.78, -0.79, -0.77),
    Claim("blake/person/visible", *WORDS, -0.5, 0.1, -0.55, -0.56, -0.54),
    Claim("blake/person/ratio", *WORDS, 1.0, 0.01, 1.0, 0.999, 1.001, kind="verification"),
)


@pytest.fixture
def folder(tmp_path):
    """A folder with the claims of one run, whose record names its commit."""
    run = {"experiment": "figure", "quick": False, "record_sha256": "ab" * 32}
    claims = [each.as_json() for each in CLAIMS]
    (tmp_path / "claims.json").write_text(json.dumps([{**run, "claims": claims}]))
    record = {"content": {"provenance": {"commit": "0123456789abcdef"}}}
    (tmp_path / f"figure-{'ab' * 8}.json").write_text(json.dumps(record))
    return tmp_path


def before(path, rows):
    with path.open("w", newline="") as file:
        table = csv.DictWriter(file, ["experiment", "name", "verdict", "measured", "low", "high"])
        table.writeheader()
        table.writerows(rows)
    return path


def row(name, verdict, experiment="figure"):
    numbers = {"measured": 1, "low": 0.5, "high": 2}
    return {"experiment": experiment, "name": name, "verdict": verdict, **numbers}


def test_claims_of_a_name_have_a_row_each(folder):
    table = experiment_table(judged_claims(folder), "figure", "*/exponent")
    rows = [line for line in table.splitlines() if line.startswith("| Parts")]
    assert rows == [
        "| Parts drop off. `blake/person/exponent` | exponent | −0.5 ± 0.1 "
        "| −0.7800 (−0.7900 to −0.7700) | ✗ refuted |"
    ]
    assert "2 measured claims: 1 hold, 1 refuted." in table
    assert "1 of 1 as predicted" in table and "commit 0123456." in table


def test_without_names_all_that_was_measured_is_there_and_nothing_verified(folder):
    table = experiment_table(judged_claims(folder), "figure")
    assert table.count("| Parts drop off.") == 2


def test_a_name_that_no_claim_has_is_an_error(folder):
    with pytest.raises(ValueError, match=r"figure: no claim is named \*/size"):
        experiment_table(judged_claims(folder), "figure", "*/size")


def test_an_experiment_without_a_record_says_so(folder):
    assert experiment_table(judged_claims(folder), "cover", "*").startswith("Not measured yet")


def test_verdicts_that_differ_and_claims_that_are_gone_stand_side_by_side(folder, tmp_path):
    rows = [
        row("blake/person/exponent", "holds"),
        row("blake/person/visible", "holds"),
        row("blake/person/lost", "undecided"),
        row("whatever", "holds", experiment="cover"),
    ]
    told = changed_table(before(tmp_path / "before.csv", rows), judged_claims(folder))
    assert told.splitlines()[2:] == [
        "| figure | `blake/person/exponent` | 1.0000 (0.5000 to 2.0000) holds "
        "| −0.7800 (−0.7900 to −0.7700) refuted |",
        "| figure | `blake/person/lost` | 1.0000 (0.5000 to 2.0000) undecided | – |",
    ]


def test_a_commit_with_changes_says_so():
    assert short_commits(["0123456789", "abcdef01234+changes"]) == (
        "commits 0123456 and abcdef0 with changes"
    )
