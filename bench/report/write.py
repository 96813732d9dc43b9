"""How does a folder of records become a report: one offline page, Markdown, CSV and JSON?"""

import base64
import csv
import io
import json
import os
import re
import warnings
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from contextlib import suppress
from dataclasses import replace
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import numpy as np

from bench.experiment import Progress, experiments, silent
from bench.plots import alone
from bench.records.claims import plain_number
from bench.records.probe import CASES, NOTE, SOURCES, has_changed, take_probe
from bench.records.records import Record, pictures_of, read_record, record_paths
from bench.report.document import Section
from bench.report.first_screen import TITLE
from bench.report.pages import picture_path, plot_files, to_html, to_markdown
from bench.runs import sources
from lod.errors import InputError
from scenes.files import check_free, whole_file

NO_PROBE = (
    "Of older code: this record keeps no probe by which to tell whether it would come out so."
)
CHANGED = "Of older code: the frame that this record keeps as a probe comes out otherwise today."
OTHER_VERSION = "Of older code: its experiment asks something else today."

_CLAIM = (
    *("name", "verdict", "estimand", "relation", "value", "margin", "measured", "low", "high"),
    *("unit", "where", "source", "kind", "sentence"),
)
_RUN = ("experiment", "quick", "record_sha256")
"""The columns of claims.csv: those of the record, and after them those of a claim."""


def write_report(
    folder: Path,
    overwrite: bool = False,
    progress: Progress = silent,
    note: Callable[[str], object] = warnings.warn,
) -> tuple[Path, Path]:
    """Write report.html, report.md and the plots beside it; give the paths of the two.

    An earlier report is replaced. ``note`` is told of each record that is left out, and why. Raises
    InputError for a folder without records that can be shown, for one that cannot be written, and
    for files of the same names that are no report's, unless ``overwrite``.
    """
    folder = Path(folder)
    names = list(experiments())

    def place(section: Section) -> tuple[int, str]:
        name = section.record.experiment
        return names.index(name) if name in names else len(names), name

    html, markdown = folder / "report.html", folder / "report.md"
    for path in (html, markdown):  # before the work of judging
        check_free(path, overwrite or _is_ours(path), "DIR")
    made = _sections(record_paths(folder), progress)
    for why in made:
        if isinstance(why, str):
            note(why)
    sections = [each for each in made if isinstance(each, Section)]
    sections.sort(key=lambda each: each.record.made, reverse=True)
    sections.sort(key=place)
    if not sections:
        cure = f"make one with `lodbench run law -o {folder}`"
        raise InputError("DIR", str(folder), "a folder with at least one record", cure)
    progress(2 * len(made), 2 * len(made) + 1, "pages")
    files: dict[Path, str | bytes] = {html: to_html(sections), markdown: to_markdown(sections)}
    files |= {folder / name: content for name, content in _beside(sections).items()}
    for path in files:
        check_free(path, overwrite or _is_ours(path), "DIR")
        if not path.parent.resolve().is_relative_to(folder.resolve()):
            rule = f"{path.parent.name} is a folder there, and no link to another"
            raise InputError("DIR", str(folder), rule, "remove the link")
    try:
        for path, content in files.items():
            path.parent.mkdir(parents=True, exist_ok=True)
            data = content.encode("utf-8", "replace") if isinstance(content, str) else content
            with whole_file(path, overwrite=True) as temporary:
                temporary.write_bytes(data)
    except OSError as error:
        raise InputError("DIR", str(folder), f"a folder to write into ({error.strerror})") from None
    return html, markdown


_MARKS = {
    "report.html": f"<title>{TITLE}</title>",
    "report.md": f"# {TITLE}\n",
    "claims.csv": ",".join((*_RUN, *_CLAIM)),
    "claims.json": '"record_sha256": "',
}
"""What stands near the beginning of each file of a report; others bear a record's hash as name."""


def _is_ours(path: Path) -> bool:
    with suppress(OSError), path.open("rb") as file:
        return path.name not in _MARKS or _MARKS[path.name].encode() in file.read(2**12)
    return False


def _beside(sections: list[Section]) -> dict[str, str | bytes]:
    """Give the files that stand beside the page: numbers, plots and pictures, by their names.

    Raises InputError where a name would lead elsewhere.
    """
    runs = [
        {
            "experiment": each.record.experiment,
            "quick": each.record.quick,
            "record_sha256": each.record.sha256,
            "commit": each.record.provenance.commit,
            "case_commits": [*dict.fromkeys(c["commit"] for c in each.record.notes.get(CASES, ()))],
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
        "claims.csv": _csv((*_RUN, *_CLAIM), rows),
        "claims.json": json.dumps(runs, indent=1, ensure_ascii=False, allow_nan=False) + "\n",
    }
    for section in sections:
        files[f"tables/{section.anchor}.csv"] = _csv(_POINT, _point_rows(section.record))
        for plot in section.plots:
            files |= {path: alone(svg) for path, (svg, _) in plot_files(section, plot).items()}
        for each in section.pictures:
            for number, (_, data) in enumerate(each.layers):
                files[picture_path(section, each, number)] = base64.b64decode(data)
    if wrong := [name for name in files if not re.fullmatch(r"((tables|plots)/)?[\w.-]+", name)]:
        raise InputError("record", wrong[0], "files of a report are named by letters and digits")
    return files


_POINT = "record_sha256", "case", "quantity", "n", "mean", "standard deviation", "predicted"


def _point_rows(record: Record) -> Iterator[tuple[str, ...]]:
    """Give a row for each column of each point: its case, mean, deviation and prediction."""
    for point in record.points:
        told = {k: plain_number(v) if isinstance(v, float) else v for k, v in point.case.items()}
        case = ", ".join(f"{k} {v}" for k, v in told.items() if v is not None)
        law = {repr((each.quantity, each.keys)): f"{each.value:.6g}" for each in point.predicted}
        for each in point.samples:
            values = np.asarray(each.values, np.float64)
            spread = f"{values.std(ddof=1):.4g}" if len(values) > 1 else "-"
            mean = f"{values.mean():.6g}" if len(values) else "-"
            found = f"{len(values)}", mean, spread, law.get(repr(each.name), "-")
            yield record.sha256, case, each.label, *found


def _csv(heads: Sequence[str], rows: Iterable[Sequence[object]]) -> str:
    stream = io.StringIO()
    # Texts that a spreadsheet would calculate are quoted as it quotes them.
    told = ([f"'{v}" if re.match("[=+@-]", str(v)) and v == str(v) else v for v in r] for r in rows)
    csv.writer(stream, lineterminator="\n").writerows([heads, *told])
    return stream.getvalue()


def _sections(paths: Sequence[Path], progress: Progress) -> list[Section | str]:
    """Make the section of every record, or say why not, as many at once as there are processors.

    Drawing is what takes the time. Processes are forked where the system can, so that nothing is
    imported twice.
    """

    def told(results: Iterable[Any], doing: str, before: int = 0) -> Iterator[Any]:
        coming = iter(results)
        for number, path in enumerate(paths, before):
            progress(number, 2 * len(paths) + 1, f"{doing} {path.stem}")
            yield next(coming)

    workers = min(len(paths), os.cpu_count() or 1)
    if workers < 2 or not hasattr(os, "fork"):
        made = list(told(map(_section_or_why, paths), "drawing"))
    else:
        with ProcessPoolExecutor(workers, get_context("fork")) as pool:
            made = list(told(pool.map(_section_or_why, paths), "drawing"))
    # Here, and after: what renders must not be forked.
    return list(told(map(_marked, made), "probe of", len(paths)))


def _section_or_why(path: Path) -> Section | str:
    try:
        section = _section(read_record(path))
        to_markdown([section])  # what cannot be shown fails here, and spoils no other
        _beside([section])
        return section
    except Exception as error:  # a record may be damaged, or made to do harm
        kind = "" if isinstance(error, InputError) else f"{type(error).__name__}: "
        return f"{path.name} is left out: {kind}{error}"


def _marked(made: Section | str) -> Section | str:
    return made if isinstance(made, str) else replace(made, stale=stale(made.record))


def _section(record: Record) -> Section:
    """Work a record out; one of another version of its experiment says what it said when made."""
    experiment, shown = experiments().get(record.experiment), pictures_of(record)
    if experiment is None or experiment.version != record.version:
        return Section(record, record.experiment, record.claims, (), pictures=shown)
    judged = replace(record, claims=experiment.judged(record.points))
    return Section(
        record,
        experiment.question,
        judged.claims,
        experiment.plots(judged),
        experiment.caveats,
        shown,
        experiment.tables(judged),
    )


def stale(record: Record) -> str:
    """Say in a sentence that a record is of older code; an empty text where it is not.

    A frame is rendered only where the sources are others than those that made the record.
    """
    experiment = experiments().get(record.experiment)
    if experiment is None or experiment.version != record.version:
        return OTHER_VERSION
    probe = record.notes.get(NOTE)
    if probe is None:
        return NO_PROBE
    if record.notes.get(SOURCES) == sources():
        return ""
    return CHANGED if has_changed(probe, take_probe(experiment.probe)) else ""
