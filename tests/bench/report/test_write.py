"""The page stands alone, says what the records say, and can be read by everyone."""

import csv
import json
import os
import pickle
import re
from collections import Counter
from dataclasses import replace
from html import escape
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from bench.experiment import experiments
from bench.experiments.scaling.plots import half_interval, plots, point_table
from bench.plots.plot import Curve, against_law, curves
from bench.records.claims import four_decimals
from bench.records.records import pictures, read_record, write_record
from bench.report.first_screen import CHOSEN, strip_of
from bench.report.words import GLOSSARY, MARKS, summarise_verdicts, verified
from bench.report.write import write_report
from lod.errors import InputError

EXPERIMENTS = experiments()


REFERENCE = Path(__file__).parents[3] / "results" / "reference"
VOID = {"meta", "link", "br", "wbr", "hr", "img", "input"}


@pytest.fixture(scope="module")
def bare(record):
    """Claims without points, so without plots: quick to write."""
    return replace(record, experiment="other", points=())


@pytest.fixture(scope="module")
def drawn(record):
    return plots(record)


@pytest.fixture(scope="module")
def html(folder):
    return (folder / "report.html").read_text(encoding="utf-8")


class Page(HTMLParser):
    """Every tag with its attributes; whether they nest; and the text that is read."""

    def __init__(self, text):
        super().__init__()
        self.tags, self.open, self.text = [], [], ""
        self.feed(text)
        self.close()

    def handle_starttag(self, tag, attrs):
        self.tags.append((tag, dict(attrs)))
        if tag not in VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag, attrs):
        self.tags.append((tag, dict(attrs)))

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        if not {"style", "script"} & set(self.open):
            self.text += data


def without_scripts(html):
    return re.sub(r"<script.*?</script>", "<script></script>", html, flags=re.DOTALL)


def test_the_page_nests_and_has_one_heading_a_language_and_a_title(html):
    page = Page(html)
    assert page.open == []
    tags = Counter(tag for tag, _ in page.tags)
    assert tags["h1"] == tags["main"] == html.partition("</head>")[0].count("<title>") == 1
    assert dict(page.tags)["html"]["lang"] == "en"


def test_the_page_asks_for_nothing(html):
    html = without_scripts(html)
    page = Page(html)
    assert not {tag for tag, _ in page.tags} & {"img", "iframe", "object", "image"}
    policy = next(a["content"] for _, a in page.tags if "http-equiv" in a)
    assert policy.startswith("default-src 'none'") and "http" not in policy
    for _, attributes in page.tags:
        for key, value in attributes.items():
            if key in ("href", "src", "xlink:href", "action", "data", "poster"):
                assert value.startswith("#") or value == "data:,", value
    assert "@import" not in html
    assert all(target.startswith("#") for target in re.findall(r"url\(([^)]*)\)", html))


def test_ids_are_unique_and_every_reference_has_its_target(html):
    page = Page(html)
    ids = Counter(attributes["id"] for _, attributes in page.tags if "id" in attributes)
    assert {name: n for name, n in ids.items() if n > 1} == {}
    links = [a[key] for _, a in page.tags for key in ("href", "xlink:href") if key in a]
    wanted = {link[1:] for link in links if link.startswith("#")}
    wanted |= {target[1:] for target in re.findall(r"url\(([^)]*)\)", without_scripts(html))}
    assert wanted <= set(ids)


def test_every_figure_is_told_in_words(html, drawn):
    shown = [attributes for tag, attributes in Page(html).tags if tag == "svg"]
    assert len(shown) == len(drawn) >= 6
    for attributes in shown:
        assert attributes["role"] == "img" and len(attributes["aria-label"]) > 80
        assert "width" not in attributes and "viewbox" in attributes


def test_whatever_scrolls_can_be_reached_by_keyboard(html):
    regions = [a for _, a in Page(html).tags if a.get("class") == "wide"]
    assert regions and all(a["tabindex"] == "0" and a["aria-label"] for a in regions)


def test_every_claim_and_its_verdict_is_on_the_page(html, record):
    text = Page(html).text
    for claim in record.claims:
        assert claim.name in text and claim.about in text
        assert four_decimals(claim.measured) in text
    for verdict in MARKS:
        expected = sum(claim.verdict == verdict for claim in record.claims)
        assert html.count(f'<td role="cell" class="{verdict}">') == expected


def test_every_record_can_be_traced_and_repeated(html, record):
    text = Page(html).text
    for piece in (record.sha256, record.samples_sha256, record.name, record.provenance.cpu):
        assert piece in text
    assert "lodbench run scaling --quick -o DIR" in text
    assert "quick run: fewer samples" in text


def test_both_writers_walk_the_same_blocks_in_one_order(html, folder):
    headings = re.findall(r"^### (.*)$", (folder / "report.md").read_text(encoding="utf-8"), re.M)
    titles = [each for each in headings if each != "Where it comes from"]  # there, per section
    assert len(titles) > 5
    at = html.index('<main id="main">')
    for title in titles:
        at = html.index(escape(title), at)


def test_words_are_explained(html):
    text = Page(html).text
    assert all(word in text and meaning in text for word, meaning in GLOSSARY)


def test_the_markdown_says_the_same_and_its_figures_are_there(folder, record, drawn):
    text = (folder / "report.md").read_text(encoding="utf-8")
    assert all(f"| {claim.name} |" in text for claim in record.claims)
    paths = re.findall(r"!\[[^\]]{80,}\]\(([^)]*)\)", text)
    assert len(paths) == len(drawn)
    for path in paths:
        assert (folder / path).read_text(encoding="utf-8").startswith("<svg")
    assert record.sha256 in text


def test_the_same_record_gives_the_same_bytes(folder, tmp_path, record):
    write_record(record, tmp_path)
    for path in write_report(tmp_path):
        assert path.read_bytes() == (folder / path.name).read_bytes()


def test_a_changed_record_changes_the_verdict(bare, tmp_path):
    claims = [
        replace(c, kind="measurement", predicted=c.predicted + 1, relation="equals",
                low=c.measured - 1e-3, high=c.measured + 1e-3)
        for c in bare.claims
    ]  # fmt: skip
    write_record(replace(bare, claims=tuple(claims)), tmp_path)
    html = write_report(tmp_path)[0].read_text(encoding="utf-8")
    assert f"{len(claims)} are refuted" in Page(html).text


def test_verdicts_follow_from_the_samples(record, tmp_path):
    edited = replace(record, points=tuple(trebled(point) for point in record.points))
    before, after = (
        {c["name"]: c for c in claims_of(each, tmp_path / str(k))}
        for k, each in enumerate((record, edited))
    )
    assert before == {c.name: c.as_json() | {"kind": c.kind} for c in record.claims}
    name = "blake/figure/objects/ratio"
    assert before[name]["verdict"] != "refuted" and after[name]["verdict"] == "refuted"


def trebled(point):
    samples = (replace(each, values=[3 * n for n in each.values]) for each in point.samples)
    return replace(point, samples=tuple(samples))


def claims_of(record, folder):
    write_record(record, folder)
    html, _ = write_report(folder)
    (told,) = json.loads((folder / "claims.json").read_text())
    assert told["record_sha256"] == record.sha256
    rows = list(csv.DictReader((folder / "claims.csv").read_text().splitlines()))
    assert [row["verdict"] for row in rows] == [c["verdict"] for c in told["claims"]]
    text = Page(html.read_text(encoding="utf-8")).text
    assert all(four_decimals(c["measured"]) in text for c in told["claims"])
    return told["claims"]


def test_every_table_and_figure_names_its_record(html, record, drawn):
    links = re.findall(r'<a class="origin" href="#([^"]*)">record (\w+)</a>', html)
    assert {short for _, short in links} == {record.sha256[:8]}
    assert {anchor for anchor, _ in links} == {f"scaling-{record.sha256[:8]}-record"}
    tables = html.count('<table class="claims"')
    assert len(links) == tables + len(drawn) + 2  # answer, every point


def test_a_plot_holds_the_numbers_of_its_figure(drawn):
    for plot in drawn:
        heads, rows = plot.numbers
        assert len(rows) == sum(len(each.x) for each in plot.drawn) > 0
        assert {len(row) for row in rows} == {len(heads)}
        said = {mark.words for mark in plot.marks}
        for each in plot.drawn:
            assert f"{each.label}: {each.y[0]:.4g} at {each.x[0]:.4g}" in said


def test_points_tell_their_numbers_where_they_are_drawn():
    """Marks stand on the renderer's own markers: every ``use`` of one, up to rounding."""
    plot = a_curve([1.0, 10.0, 100.0], [1.0, 2.0, 8.0], ([1.0, 100.0], [1.0, 9.0]))
    uses = re.findall(r'<use [^>]*x="([\d.]+)" y="([\d.]+)"[^>]*fill', plot.svg)
    places = np.array(uses, float)
    for mark in plot.marks:
        assert np.abs(places - mark.place).max(axis=1).min() < 0.1
    assert [mark.curve for mark in plot.marks] == [0, 0, 0, 1, 1, 1]
    assert plot.marks[1].words == "one: 2 at 10"
    assert plot.marks[4].words.startswith("one ÷ line: 0.6667 at")


def test_pictures_of_a_record_stand_on_the_page_and_beside_it(bare, tmp_path):
    grey = np.full((4, 6, 3), 128, np.uint8)
    words = "Title", "Caption", "What it shows"
    note = pictures("view", words, {"whole": grey, "pruned": grey // 2})
    record = replace(bare, notes={"pictures": [note]})
    write_record(record, tmp_path)
    html, markdown = (path.read_text(encoding="utf-8") for path in write_report(tmp_path))
    tags = Page(html).tags
    assert [a["alt"] for t, a in tags if t == "img"] == [
        f"{name}. What it shows" for name in ("pruned", "whole")
    ]
    paths = re.findall(r"!\[[^\]]*\]\((plots/[^)]*webp)\)", markdown)
    assert [Image.open(tmp_path / path).size for path in paths] == [(6, 4)] * 2
    with pytest.raises(InputError, match="one size"):
        pictures("view", words, {"whole": grey, "pruned": grey[:2]})


def test_two_records_stand_side_by_side(record, tmp_path):
    full = replace(record, quick=False, made="2030-01-01T00:00:00Z")
    for each in (record, full):
        write_record(each, tmp_path)
    page = Page(write_report(tmp_path)[0].read_text(encoding="utf-8"))
    assert full.name in page.text and record.name in page.text
    assert page.text.index(full.name) < page.text.index(record.name)
    ids = [attributes["id"] for _, attributes in page.tags if "id" in attributes]
    assert len(ids) == len(set(ids))


def test_what_a_record_says_is_text_never_markup(bare, tmp_path):
    claims = (replace(bare.claims[0], about="<b>&amp; | x", name="a/<i>/c"),)
    write_record(replace(bare, claims=claims), tmp_path)
    html, markdown = (path.read_text(encoding="utf-8") for path in write_report(tmp_path))
    assert "<b>" not in html and "<i>" not in html
    assert "<b>&amp; | x" in Page(html).text
    assert "\\| x |" in markdown


def test_an_unknown_experiment_still_shows_its_claims(bare, tmp_path):
    write_record(bare, tmp_path)
    text = Page(write_report(tmp_path)[0].read_text(encoding="utf-8")).text
    assert bare.claims[0].name in text


def test_the_answer_in_a_sentence(record):
    good = replace(record.claims[0], predicted=0.0, tolerance=0.5, measured=0.1, low=0.0, high=0.2)
    bad = replace(good, low=0.6, measured=0.7, high=0.8)
    open_ = replace(good, low=0.1, measured=0.4, high=0.8)
    assert summarise_verdicts([good, good]) == "Yes: all 2 claims hold."
    assert summarise_verdicts([good, open_]).startswith("So far 1 of 2")
    assert "1 is refuted" in summarise_verdicts([good, bad, open_])
    expected = replace(bad, expected_to_fail=True)
    assert summarise_verdicts([good, expected]).startswith("Yes: all 1 claims hold. 1 more fails")
    assert "1 is refuted" in summarise_verdicts([good, bad, expected])
    assert summarise_verdicts([]) == ""


def test_what_verifies_is_told_apart_from_what_was_measured(record):
    held = replace(record.claims[0], kind="verification", predicted=0.0, tolerance=0.5,
                   measured=0.1, low=0.0, high=0.2)  # fmt: skip
    open_ = replace(held, low=0.1, measured=0.4, high=0.8)
    wrong = replace(held, name="a/b", low=0.6, measured=0.7, high=0.8)
    assert verified([held, open_]).endswith("1 of 2 as predicted, 1 undecided.")
    assert "REFUTED" in verified([held, wrong]) and "a/b" in verified([held, wrong])
    assert verified([]) == ""


def test_the_first_screen_shows_measured_claims_that_exist():
    """Each chosen name is one of its experiment's reference claims, and a measurement.

    An experiment whose reference record is of another version has no such claims yet.
    """
    assert len(CHOSEN) <= 10
    found = 0
    for experiment, name in CHOSEN:
        (path,) = REFERENCE.glob(f"{experiment}-*.json")
        record = read_record(path)
        if record.version == EXPERIMENTS[experiment].version:
            judged = EXPERIMENTS[experiment].judge(record.points)
            assert [c.kind for c in judged if c.name == name] == ["measurement"], name
            found += 1
    assert found


def test_a_record_of_another_version_says_what_it_said(record, tmp_path):
    other = replace(record.claims[0], measured=0.5, low=0.4, high=0.6)
    for version, shown in ((record.version + 1, True), (record.version, False)):
        folder = tmp_path / str(version)
        write_record(replace(record, version=version, claims=(other,)), folder)
        write_report(folder)
        assert (other.measured_text in (folder / "report.md").read_text()) == shown


def test_a_strip_places_the_interval_against_the_claim(record):
    within = replace(record.claims[0], relation="equals", predicted=1.0, tolerance=0.1,
                     measured=1.0, low=0.95, high=1.05)  # fmt: skip
    drawn = strip_of(within)
    assert drawn.claimed == (4.0, 116.0) and drawn.measured == pytest.approx(60.0)
    assert drawn.interval == pytest.approx((32.0, 88.0))
    beyond = strip_of(replace(within, relation="at most", measured=2.2, low=2.0, high=2.2))
    assert beyond.claimed == pytest.approx((4.0, 60.0)) and beyond.interval[1] == 116.0


def test_numbers_as_they_are_written():
    assert [four_decimals(v) for v in (-2.00004, -0.00001, 0.5)] == ["−2.0000", "0.0000", "0.5000"]


def test_a_folder_without_records_is_refused(tmp_path):
    with pytest.raises(InputError, match="at least one record"):
        write_report(tmp_path)


def test_a_report_that_cannot_be_written_leaves_nothing_half(bare, tmp_path, monkeypatch):
    write_record(bare, tmp_path)
    monkeypatch.setattr(os, "replace", lambda *_: (_ for _ in ()).throw(OSError(30, "read-only")))
    with pytest.raises(InputError, match="read-only"):
        write_report(tmp_path)
    assert not (tmp_path / "report.html").exists()


# The plots


def test_error_bars_are_those_of_the_model(record):
    point = record.points[0]
    fields = len(point.column("objects"))
    half = half_interval(point, "objects", {"blake/figure/objects": 4.0})
    assert half == pytest.approx(1.959964 * 2 * np.sqrt(point.prediction("objects") / fields))


def test_the_table_has_every_point(record):
    heads, rows = point_table(record)
    assert len(rows) == len(record.points) and {len(row) for row in rows} == {len(heads)}


def test_a_figure_tells_its_worst_departure():
    law = [1.0, 10.0], [2.0, 20.0]
    counts = [Curve("objects", [1.0, 10.0], [2.0, 21.0], [1.9, 20.9], [2.1, 21.1], law)]
    drawn = against_law("name", "title", "caption", ("K", "count"), counts)
    assert "never more than 5 %" in drawn.alt and 'id="name-' in drawn.svg
    assert drawn == against_law("name", "title", "caption", ("K", "count"), counts)


def test_one_processor_or_several_make_the_same_report(record, bare, tmp_path, monkeypatch):
    made = []
    for processors in (1, 2):
        place = tmp_path / str(processors)
        for each in (record, bare):
            write_record(each, place)
        monkeypatch.setattr(os, "cpu_count", lambda n=processors: n)
        write_report(place)
        made.append({p.relative_to(place): p.read_bytes() for p in place.rglob("*") if p.is_file()})
    assert made[0] == made[1]


@pytest.mark.parametrize("processors", [1, 2])
def test_each_record_is_named_before_it_is_drawn_and_before_its_probe(
    record, bare, tmp_path, monkeypatch, processors
):
    for each in (record, bare):
        write_record(each, tmp_path)
    monkeypatch.setattr(os, "cpu_count", lambda: processors)
    said = []
    write_report(tmp_path, progress=lambda *step: said.append(step))
    names = ["drawing scaling", "drawing other", "probe of scaling", "probe of other", "pages"]
    assert said == [(number, 5, name) for number, name in enumerate(names)]


def test_a_refusal_in_another_process_arrives_whole():
    refused = InputError("DIR", 3, "a folder", "make one")
    again = pickle.loads(pickle.dumps(refused))
    assert (str(again), vars(again)) == (str(refused), vars(refused))


def a_curve(x, y, line=((), ())):
    return curves("c", "C", "c", ("x", "y"), [Curve("one", x, y, line=line)])


@pytest.mark.parametrize("y, reach", [(1.000001, 1.03), (1.0, 1.03), (0.5, 2**1.1)])
def test_what_is_over_its_line_is_drawn_about_one(y, reach):
    """Neither noise of one in a million nor a perfect fit fills the axis."""
    plot = a_curve([1.0, 10.0, 100.0], [y, 1.0, 1.0], ([1.0, 100.0], [1.0, 1.0]))
    first, second, _ = (mark.place[1] for mark in plot.marks if mark.curve == 1)
    height = 1.25 / 4.25 * 5.2 * 72 * (0.985 - 0.1)  # of the lower panel, nearly
    away = np.log(y) if reach > 2 else y - 1
    whole = 2 * np.log(reach) if reach > 2 else reach - 1 / reach
    assert (second - first) / height == pytest.approx(away / whole, abs=0.02)


def test_a_strangers_file_is_refused_before_the_work(record, tmp_path, monkeypatch):
    write_record(record, tmp_path)
    (tmp_path / "report.md").write_text("mine")
    monkeypatch.setattr("bench.report.write._sections", lambda *_: 1 / 0)
    with pytest.raises(InputError, match=r"report\.md"):
        write_report(tmp_path)
