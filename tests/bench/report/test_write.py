"""What a report says of records, and which it marks as of older code."""

import base64
import csv
import json
import re
import zlib
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from bench.experiment import experiments, silent
from bench.records.probe import NOTE, SOURCES, has_changed, take_probe
from bench.records.records import read_records, write_record
from bench.report import write as rule
from bench.report.document import Section
from bench.report.write import CHANGED, NO_PROBE, OTHER_VERSION, stale, write_report
from bench.runs import RunRequest, journal, run_request, serial_executor, sources
from lod.errors import InputError
from tests.bench.edited import with_cases

EXPERIMENTS = experiments()

RESULTS = Path(__file__).parents[3] / "results"
MARK = "of older code"


def probe(parts=10, description="a", value=100):
    pixels = np.full((36, 64, 3), value, np.uint8).tobytes()
    return {
        "preset": "meadow",
        "counts": {"tree": parts},
        "description": description,
        "pixels": base64.b64encode(zlib.compress(pixels)).decode(),
    }


def test_a_probe_has_changed_where_counts_or_pixels_have():
    assert not has_changed(probe(), probe())
    assert has_changed(probe(), probe(parts=11))
    assert not has_changed(probe(), probe(description="b")), "last digits of another machine"
    assert has_changed(probe(), probe(description="b", value=101))


def test_a_record_is_stale_where_sources_and_probe_are_others(record, monkeypatch):
    noted = replace(record, notes={NOTE: probe(), SOURCES: "before"})
    monkeypatch.setattr(rule, "take_probe", lambda preset: probe())
    assert stale(noted) == "" and stale(record) == NO_PROBE
    monkeypatch.setattr(rule, "take_probe", lambda preset: probe(parts=7))
    assert stale(noted) == CHANGED
    assert stale(replace(noted, notes=noted.notes | {SOURCES: sources()})) == ""
    assert stale(replace(noted, version=record.version + 1)) == OTHER_VERSION


def test_the_report_marks_it(record, tmp_path):
    write_record(record, tmp_path)
    html, markdown = write_report(tmp_path)
    assert f'<p class="stale">{NO_PROBE}</p>' in html.read_text()
    assert f"**{NO_PROBE}**" in markdown.read_text()
    assert "probe" not in {row[0] for row in _origin(record)}


def _origin(record):
    noted = replace(record, notes={NOTE: probe(), SOURCES: "x"})
    return Section(noted, "", (), (), ((), [])).origin.rows


def test_an_older_version_is_shown_as_it_was_judged(record, tmp_path):
    older = replace(record, version=0, claims=record.claims[:1])
    write_record(older, tmp_path)
    _, markdown = write_report(tmp_path)
    text = markdown.read_text()
    assert OTHER_VERSION in text and record.claims[0].name in text
    assert record.claims[1].name not in text


def test_what_is_no_report_is_not_replaced(record, tmp_path):
    write_record(record, tmp_path)
    (tmp_path / "report.html").write_text("mine")
    with pytest.raises(InputError, match=r"report\.html"):
        write_report(tmp_path)
    assert (tmp_path / "report.html").read_text() == "mine"
    write_report(tmp_path, overwrite=True)
    write_report(tmp_path)
    with pytest.raises(InputError, match="at least one record"):
        write_report(tmp_path / "empty")


def test_pages_and_numbers_say_the_same(folder, record):
    (run,) = json.loads((folder / "claims.json").read_text())
    rows = list(csv.DictReader((folder / "claims.csv").open()))
    text = (folder / "report.md").read_text()
    assert [c["name"] for c in run["claims"]] == [r["name"] for r in rows]
    for claim in record.claims:
        assert f"| {claim.name} |" in text and claim.measured_text in text
        assert (claim.sentence in {r["sentence"] for r in rows}) and str(claim.bound) in text
    for plot in re.findall(r"\]\((plots/[^)]+)\)", text):
        assert (folder / plot).read_text().startswith("<svg")


@pytest.mark.slow
def test_a_run_keeps_a_probe_that_is_the_same_again(tmp_path, monkeypatch):
    quick = with_cases(EXPERIMENTS["law"], "scaling", [])
    asked = RunRequest("law", ("scaling",), quick=True)
    _, record = run_request(quick, asked, journal(tmp_path), serial_executor, silent)
    found = record.notes[NOTE]
    take_probe.cache_clear()
    assert found == take_probe("meadow") and stale(record) == ""
    assert found["counts"]["tree"] > 0 and found["counts"]["triangles"] > 0


@pytest.mark.slow
def test_no_page_quotes_a_stale_record_without_saying_so():
    """Lists the stale records; a page that names the command of one must carry the mark."""
    old = {r.experiment: s for r in read_records(RESULTS / "reference") if (s := stale(r))}
    print(*(f"{name}: {why}" for name, why in sorted(old.items())), sep="\n")
    for page in sorted(RESULTS.glob("*.md")):
        text = page.read_text(encoding="utf-8")
        quoted = [name for name in old if f"lodbench run {name}" in text]
        assert not quoted or MARK in text, (page.name, quoted)
