"""`make site`: submissions as one static page that sorts, with a CSV beside it.

python -m bench.submissions.site [FOLDER [OUT]]
"""

import csv
import io
import math
import re
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from bench.statistics.steps import find_step
from bench.submissions.entry import SUBMISSIONS, read_submission
from bench.templates import filled
from scenes.files import make_folder, write_text

Row = dict[str, Any]

HEADS = (
    *("pack", "program", "who", "score", "note", "valid", "flip", "land", "coverage"),
    *("seconds", "cpu seconds", "MB", "timing", "machine", "cores", "load", "date", "history"),
)


def table_rows(records: Sequence[Row]) -> list[tuple[str, ...]]:
    """Return the cells of every submission, the newest of a series first, with its history."""
    found = []
    for record in records:
        series = [r for r in records if _series(r) == _series(record)]
        series.sort(key=lambda each: str(each["date"]))
        pictures = [p for row in record["settings"] for p in row["pictures"].values()]
        voids = [p["void"] for p in pictures if p["void"]]
        best = _best(record)
        shown = list(best["pictures"].values())
        runs = best["runs"]
        machine = record["machine"]
        found.append(
            (
                *(record["pack"], record["program"], record["who"], _cell(record["score"])),
                *(record["told"], f"void: {voids[0]}" if voids else "valid"),
                *(_cell(_mean(p[name] for p in shown)) for name in ("flip", "land", "coverage")),
                *(_cell(_median(r.get(name) for r in runs)) for name in ("seconds", "cpu_seconds")),
                _cell((_median(r.get("peak_bytes") for r in runs) or math.nan) / 1e6),
                *(record["timing"], machine["cpu"], str(machine["cores"])),
                *(_cell(machine.get("load")), record["date"], _history(series)),
            )
        )
    return sorted(found, key=lambda row: (row[0], float(row[3]) if row[3] else math.inf))


def _series(record: Row) -> tuple[Any, ...]:
    machine = record["machine"]
    names = record["pack_sha256"], record["program"].split()[0], record["who"]
    return (*names, machine["cpu"], machine["cores"], record["timing"])


def _best(record: Row) -> Row:
    """Return the setting with the least error of those that count; the first where none does."""
    rows: list[Row] = record["settings"]
    able = [r for r in rows if not any(p["void"] for p in r["pictures"].values())]
    return min(
        able, key=lambda r: _mean(p["flip"] for p in r["pictures"].values()), default=rows[0]
    )


def _history(series: Sequence[Row]) -> str:
    scores = [r["score"] for r in series if r["score"]]
    step = find_step(np.log(np.array(scores, np.float64)))
    told = f"{len(series)} record{'s' * (len(series) > 1)}"
    if step is None:
        return told
    date = [r["date"] for r in series if r["score"]][step.row]
    return f"{told}; times {math.exp(step.height):.3f} from {date} on"


def _mean(values: Any) -> float:
    known = [each for each in values if each is not None]
    return float(np.mean(known)) if known else math.nan


def _median(values: Any) -> float:
    known = [each for each in values if each is not None]
    return float(np.median(known)) if known else math.nan


def _cell(value: float | None) -> str:
    return "" if value is None or math.isnan(value) else f"{value:.4g}"


def as_csv(rows: Sequence[Sequence[str]]) -> str:
    """Write the table as CSV."""
    text = io.StringIO()  # what a spreadsheet would calculate is quoted as it quotes texts
    told = ([re.sub("^(?=[=+@-])", "'", cell) for cell in row] for row in rows)
    csv.writer(text, lineterminator="\n").writerows([HEADS, *told])
    return text.getvalue()


def as_html(rows: Sequence[Sequence[str]]) -> str:
    """Write the page; without its script it is read in the order of the score."""
    return filled(Path(__file__).with_name("site.html"), heads=HEADS, rows=rows)


def write_site(folder: Path, out: Path) -> list[Path]:
    """Write the page and the CSV of a folder's records. Raises InputError for a broken record."""
    rows = table_rows([read_submission(path) for path in sorted(folder.glob("*.json"))])
    made = {"index.html": as_html(rows), "submissions.csv": as_csv(rows)}
    place = make_folder(out)
    for name, text in made.items():
        write_text(place / name, text)
    return [place / name for name in made]


if __name__ == "__main__":
    given = [Path(each) for each in sys.argv[1:]]
    for written in write_site(*given, *(SUBMISSIONS, Path("out/site"))[len(given) :]):
        print(written)
