"""How does a folder of records become a report: one offline page, Markdown, CSV and JSON?"""

import base64
import csv
import io
import json
import os
from collections.abc import Iterable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from multiprocessing import get_context
from pathlib import Path
from typing import Any

from bench.experiment import Progress, experiments, point_table, silent
from bench.plots import alone
from bench.records.probe import NOTE, SOURCES, has_changed, take_probe
from bench.records.records import Record, pictures_of, read_records
from bench.report.document import Section
from bench.report.pages import picture_path, plot_files, to_html, to_markdown
from bench.runs import sources
from lod.errors import InputError
from scenes.files import check_free, made_by_lodbench, whole_file

NO_PROBE = (
    "Of older code: this record keeps no probe by which to tell whether it would come out so."
)
CHANGED = "Of older code: the frame that this record keeps as a probe comes out otherwise today."
OTHER_VERSION = "Of older code: its experiment asks something else today."

_CLAIM = (
    *("name", "verdict", "estimand", "relation", "value", "margin", "measured", "low", "high"),
    *("unit", "where", "source", "kind", "sentence"),
)
"""The columns of claims.csv, after those of the record."""


def write_report(
    folder: Path, overwrite: bool = False, progress: Progress = silent
) -> tuple[Path, Path]:
    """Write report.html, report.md and the plots beside it; give the paths of the two.

    An earlier report is replaced. Raises InputError for a folder without records, for one that
    cannot be written, and for files of the same names that are no report's, unless ``overwrite``.
    """
    folder = Path(folder)
    names = list(experiments())

    def place(record: Record) -> int:
        return names.index(record.experiment) if record.experiment in names else len(names)

    records = sorted(read_records(folder), key=place)
    if not records:
        cure = f"make one with `lodbench run law -o {folder}`"
        raise InputError("DIR", str(folder), "a folder with at least one record", cure)
    html, markdown = folder / "report.html", folder / "report.md"
    replaces = overwrite or made_by_lodbench(html)
    for path in (html, markdown):  # before the work of judging
        check_free(path, replaces, "DIR")
    sections = _sections(records, progress)
    progress(2 * len(records), 2 * len(records) + 1, "pages")
    files: dict[Path, str | bytes] = {html: to_html(sections), markdown: to_markdown(sections)}
    files |= {folder / name: content for name, content in _beside(sections).items()}
    for path in files:
        check_free(path, replaces, "DIR")
    try:
        for path, content in files.items():
            path.parent.mkdir(parents=True, exist_ok=True)
            with whole_file(path, overwrite=True) as temporary:
                temporary.write_bytes(content.encode() if isinstance(content, str) else content)
    except OSError as error:
        raise InputError("DIR", str(folder), f"a folder to write into ({error.strerror})") from None
    return html, markdown


def _beside(sections: list[Section]) -> dict[str, str | bytes]:
    """Give the files that stand beside the page: numbers, plots and pictures, by their names."""
    runs = [
        {
            "experiment": each.record.experiment,
            "quick": each.record.quick,
            "record_sha256": each.record.sha256,
            "commit": each.record.provenance.commit,
            "claims": [claim.as_json() for claim in each.claims],
        }
        for each in sections
    ]
    rows = [
        (s.record.experiment, s.record.quick, s.record.sha256, *(getattr(c, k) for k in _CLAIM))
        for s in sections
        for c in s.claims
    ]
    files: dict[str, str | bytes] = {
        "claims.csv": _csv(("experiment", "quick", "record_sha256", *_CLAIM), rows),
        "claims.json": json.dumps(runs, indent=1, ensure_ascii=False, allow_nan=False) + "\n",
    }
    for section in sections:
        sha256 = section.record.sha256
        heads, points = point_table(section.record.points, most_columns=10**6)
        table = _csv(("record_sha256", *heads), [(sha256, *row) for row in points])
        files[f"tables/{section.anchor}.csv"] = table
        for plot in section.plots:
            files |= {path: alone(svg) for path, (svg, _) in plot_files(section, plot).items()}
        for each in section.pictures:
            for number, (_, data) in enumerate(each.layers):
                files[picture_path(section, each, number)] = base64.b64decode(data)
    return files


def _csv(heads: Sequence[str], rows: Iterable[Sequence[object]]) -> str:
    stream = io.StringIO()
    csv.writer(stream, lineterminator="\n").writerows([heads, *rows])
    return stream.getvalue()


def _sections(records: Sequence[Record], progress: Progress) -> list[Section]:
    """Make the section of every record, as many at once as there are processors.

    Drawing is what takes the time. Processes are forked where the system can, so that nothing is
    imported twice.
    """

    def told(results: Iterable[Any], doing: str, before: int = 0) -> Iterator[Any]:
        coming = iter(results)
        for number, record in enumerate(records, before):
            progress(number, 2 * len(records) + 1, f"{doing} {record.experiment}")
            yield next(coming)

    workers = min(len(records), os.cpu_count() or 1)
    if workers == 1 or not hasattr(os, "fork"):
        made = list(told(map(_section, records), "drawing"))
    else:
        with ProcessPoolExecutor(workers, get_context("fork")) as pool:
            made = list(told(pool.map(_section, records), "drawing"))
    # Here, and after: what renders must not be forked.
    marks = told(map(stale, records), "probe of", len(records))
    return [replace(each, stale=mark) for each, mark in zip(made, marks, strict=True)]


def _section(record: Record) -> Section:
    """Work a record out; one of another version of its experiment says what it said when made."""
    experiment, table = experiments().get(record.experiment), point_table(record.points)
    shown = pictures_of(record)
    if experiment is None or experiment.version != record.version:
        return Section(record, record.experiment, record.claims, (), table, pictures=shown)
    judged = replace(record, claims=experiment.judged(record.points))
    return Section(
        record,
        experiment.question,
        judged.claims,
        experiment.plots(judged),
        table,
        experiment.caveats,
        shown,
        experiment.tables(judged),
    )


def stale(record: Record) -> str:
    """Say in a sentence that a record is of older code; an empty text where it is not.

    A frame is rendered only where the sources are others than those that made the record.
    """
    experiment = experiments().get(record.experiment)
    if experiment is not None and experiment.version != record.version:
        return OTHER_VERSION
    probe = record.notes.get(NOTE)
    if probe is None:
        return NO_PROBE
    if record.notes.get(SOURCES) == sources():
        return ""
    return CHANGED if has_changed(probe, take_probe(probe["preset"])) else ""
