"""What a report says of records, and which it marks as of older code."""

import base64
import csv
import hashlib
import json
import os
import re
import shutil
import zlib
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from bench.cli.main import main
from bench.experiment import experiments, silent
from bench.records.probe import NOTE, SOURCES, has_changed, take_probe
from bench.records.records import FORMAT, FORMAT_VERSION, read_records, write_record
from bench.report import write as rule
from bench.report.document import Section
from bench.report.write import CHANGED, NO_PROBE, OTHER_VERSION, stale, write_report
from bench.runs import RunRequest, journal, run_request, serial_executor, sources
from lod.errors import InputError
from tests.bench.edited import with_cases

EXPERIMENTS = experiments()

RESULTS = Path(__file__).parents[3] / "results"
MARK = "of older code"


def probe(parts=10, value=100):
    pixels = np.full((36, 64, 3), value, np.uint8).tobytes()
    return {
        "preset": "meadow",
        "counts": {"tree": parts},
        "pixels": base64.b64encode(zlib.compress(pixels)).decode(),
    }


def test_a_probe_has_changed_where_counts_or_pixels_have():
    assert not has_changed(probe(), probe())
    assert has_changed(probe(), probe(parts=11))
    assert has_changed(probe(), probe(value=101))


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
    return Section(noted, "", (), ()).origin


def test_an_older_version_is_shown_as_it_was_judged(record, tmp_path):
    older = replace(record, version=0, claims=record.claims[:1])
    write_record(older, tmp_path)
    _, markdown = write_report(tmp_path)
    text = markdown.read_text()
    assert OTHER_VERSION in text and record.claims[0].name in text
    assert record.claims[1].name not in text


@pytest.mark.parametrize("name", ["report.html", "report.md", "claims.csv", "claims.json"])
def test_what_is_no_report_is_not_replaced(folder, tmp_path, name):
    """Each file is judged by itself, and a file that only speaks of lodbench is the user's."""
    shutil.copytree(folder, tmp_path, dirs_exist_ok=True)
    (tmp_path / name).write_text("What I think of lodbench, and of its report")
    with pytest.raises(InputError, match=name.replace(".", r"\.")):
        write_report(tmp_path)
    assert (tmp_path / name).read_text().startswith("What I think")
    write_report(tmp_path, overwrite=True)
    write_report(tmp_path)
    with pytest.raises(InputError, match="at least one record"):
        write_report(tmp_path / "empty")


PICTURE = {
    "name": "x",
    "title": "[t](http://evil)",
    "caption": "<script>alert(1)</script>",
    "alt": "![](http://evil)",
    "layers": [["a", "UklGRg=="], ["b", "UklGRg=="]],
}

HOSTILE = {
    "experiment is a path": lambda c: c | {"experiment": "../../out"},
    "experiment has no name": lambda c: c | {"experiment": ""},
    "experiment is a number": lambda c: c | {"experiment": 3},
    "picture is a path": lambda c: c | {"notes": {"pictures": [PICTURE | {"name": "../../../p"}]}},
    "picture is no data": lambda c: (
        c | {"notes": {"pictures": [PICTURE | {"layers": [["a", "?"]]}]}}
    ),
    "pictures are words": lambda c: c | {"notes": {"pictures": "none"}},
    "points are gone": lambda c: {key: value for key, value in c.items() if key != "points"},
    "points are numbers": lambda c: c | {"points": [1, 2]},
    "samples are words": lambda c: c | {"points": _sampled(c, ["many"])},
    "samples overflow": lambda c: c | {"points": _sampled(c, [10**400])},
    "samples are gone": lambda c: c | {"points": [each | {"samples": []} for each in c["points"]]},
    "claims are no claims": lambda c: c | {"claims": [{"estimand": "x"}]},
    "provenance is a list": lambda c: c | {"provenance": []},
    "notes cannot be ordered": lambda c: c | {"notes": {"x": [1, "a", *range(30)]}},
    "content is a list": lambda c: [],
    "content is null": lambda c: None,
}


def _sampled(content, values):
    first = content["points"][0]
    samples = [each | {"values": values} for each in first["samples"]]
    return [first | {"samples": samples}, *content["points"][1:]]


def _written(content, folder):
    """A record's file with any content, its hash and its name as they must be."""
    text = json.dumps(content, sort_keys=True, separators=(",", ":"))
    sha256 = hashlib.sha256(text.encode()).hexdigest()
    body = {"format": FORMAT, "format_version": FORMAT_VERSION, "sha256": sha256}
    path = folder / f"law-{sha256[:16]}.json"
    path.write_text(json.dumps(body | {"content": content}))
    return path


def test_a_record_that_is_damaged_or_hostile_is_named_and_left_out(record, tmp_path, capfd):
    within = tmp_path / "a" / "b" / "records"
    within.mkdir(parents=True)
    write_record(record, within)
    for change in HOSTILE.values():
        _written(change(record.content), within)
    (within / f"law-{'0' * 16}.json").write_text("[" * 10**5)
    os.mkfifo(within / f"law-{'1' * 16}.json")
    (within / f"law-{'2' * 16}.json").mkdir()
    bad = {path.name for path in within.iterdir()} - {record.name}
    left = []
    html, markdown = write_report(within, note=left.append)
    assert record.name in html.read_text() and record.name in markdown.read_text()
    assert len(left) == len(bad) == len(HOSTILE) + 3
    assert all(any(name in line for line in left) for name in bad)
    assert [path.name for path in tmp_path.rglob("*") if within not in path.parents] == [
        *("a", "b", "records")
    ]
    with pytest.raises(SystemExit) as ended:
        main(["report", str(within)])
    out, err = capfd.readouterr()
    assert ended.value.code == 1 and "report.html" in out and "Traceback" not in err
    assert "19 of the folder's records left out" in err.splitlines()[-1]


def test_what_a_record_says_is_text_on_both_pages(record, tmp_path):
    told = {"pictures": [PICTURE], "place": "<img src=x onerror=alert(1)> [a](http://evil)\n# b"}
    topic = "x; rm -rf ~"
    points = tuple(replace(each, case=each.case | {"topic": topic}) for each in record.points)
    write_record(replace(record, version=0, notes=told, points=points), tmp_path)
    html, markdown = (path.read_text() for path in write_report(tmp_path))
    assert "<img" not in markdown and "<script" not in markdown
    assert not re.search(r"(?<!\\)\]\((?!plots/)", markdown) and "\n# b" not in markdown
    assert "<script>alert" not in html and "<img src=x" not in html
    assert f"lodbench run '{topic}'" in markdown


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
