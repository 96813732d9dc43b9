"""Where do results go? With --json stdout carries JSON lines alone, and the rest is on stderr."""

import contextlib
import dataclasses
import json
import os
import sys
from collections.abc import Iterable, Iterator, Sequence
from typing import Any, TextIO

import click
import numpy as np

from scenes.processes.streams import carry_failure, lenient_stream, stdout_to_stderr


@dataclasses.dataclass(frozen=True)
class Output:
    """Results of one command: ``record`` for programs, ``say`` for people, ``note`` for both."""

    stream: TextIO | None

    def record(self, data: dict[str, Any]) -> None:
        """Print one JSON object on one line, under --json only."""
        if self.stream is not None:
            line = json.dumps(data, allow_nan=False, default=_plain, ensure_ascii=False)
            print(line, file=self.stream, flush=True)

    def say(self, text: str) -> None:
        """Print a result in words, without --json only."""
        if self.stream is None:
            click.echo(text)

    def note(self, text: str) -> None:
        """Print progress or advice on stderr."""
        click.echo(text, err=True)


@contextlib.contextmanager
def output(as_json: bool) -> Iterator[Output]:
    """Open the results of one command; under --json even what a library prints goes to stderr."""
    if not as_json:
        yield Output(None)
        return
    results = sys.stdout
    with lenient_stream(os.dup(1), closefd=True) as stream, stdout_to_stderr():
        try:
            yield Output(stream)
        finally:
            carry_failure(stream, results)


def table(rows: Iterable[Sequence[object]], indent: str = "  ") -> str:
    """Lay out rows in columns, text to the left and numbers to the right."""
    cells = [[_cell(value) for value in row] for row in rows]
    if not cells:
        return ""
    widths = [max(len(row[k][0]) for row in cells) for k in range(len(cells[0]))]
    lines = (
        indent + "  ".join(_pad(cell, width) for cell, width in zip(row, widths, strict=True))
        for row in cells
    )
    return "\n".join(line.rstrip() for line in lines)


def _cell(value: object) -> tuple[str, bool]:
    """Write one cell: its text, and whether it is a number."""
    if value is None:
        return "–", True
    if isinstance(value, float):
        return (f"{value:,.0f}" if abs(value) >= 1000 else f"{value:.4g}"), True
    if isinstance(value, int) and not isinstance(value, bool):
        return f"{value:,}", True
    return str(value), False


def _pad(cell: tuple[str, bool], width: int) -> str:
    text, is_number = cell
    return text.rjust(width) if is_number else text.ljust(width)


def _plain(value: Any) -> Any:
    if isinstance(value, np.generic):
        return value.item()
    if isinstance(value, os.PathLike):
        return os.fspath(value)
    raise TypeError(f"{type(value).__name__} is no JSON")
