"""The report of a folder of records: one page that opens offline, and the same in Markdown."""

import os
from pathlib import Path

from bench.experiments import EXPERIMENTS
from bench.records import Record, read_records
from bench.report_html import page
from bench.report_markdown import FIGURES, document
from bench.report_parts import Section
from lod.errors import InputError


def write_report(folder: Path) -> tuple[Path, Path]:
    """Write report.html, report.md and the figures beside it; give the paths of the two.

    Raises InputError for a folder without records, or one that cannot be written.
    """
    folder = Path(folder)
    records = read_records(folder)
    if not records:
        cure = f"make one with `lodbench run scaling -o {folder}`"
        raise InputError("DIR", str(folder), "a folder with at least one record", cure)
    sections = [_section(record) for record in records]
    html, markdown = folder / "report.html", folder / "report.md"
    texts = {html: page(sections), markdown: document(sections)}
    for section in sections:
        for figure in section.figures:
            texts[folder / FIGURES / f"{section.anchor}-{figure.name}.svg"] = figure.svg
    try:
        for path, text in texts.items():
            _write(path, text)
    except OSError as error:
        raise InputError("DIR", str(folder), f"a folder to write into ({error.strerror})") from None
    return html, markdown


def _section(record: Record) -> Section:
    experiment = EXPERIMENTS.get(record.experiment)
    if experiment is None:
        return Section(record, record.experiment, (), ((), []))
    question, figures = experiment.question, experiment.figures(record)
    return Section(record, question, figures, experiment.table(record), experiment.limits)


def _write(path: Path, text: str) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    temporary = path.with_name(f".{path.name}.part")
    temporary.write_text(text, encoding="utf-8")
    os.replace(temporary, path)
