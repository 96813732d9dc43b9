"""What a command prints: results as words or, with --json, as JSON lines alone on stdout.

Progress is on stderr: bars on a terminal, and elsewhere a line every ten seconds.
"""

import json
import math
import os
import sys
import threading
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, TextIO

import click
import numpy as np

from bench.cli.kernel_cache import is_first_run
from lod.errors import InputError, shown
from scenes.processes.progress import followed_by, kernels_told
from scenes.processes.streams import carry_failure, lenient_stream, stdout_to_stderr

if TYPE_CHECKING:
    from scenes.render.worker import Making


@dataclass(frozen=True)
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
            click.echo(shown(text))

    def note(self, text: str) -> None:
        """Print progress or advice on stderr."""
        click.echo(shown(text), err=True)


@contextmanager
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
        indent
        + "  ".join(
            text.rjust(width) if is_number else text.ljust(width)
            for (text, is_number), width in zip(row, widths, strict=True)
        )
        for row in cells
    )
    return "\n".join(line.rstrip() for line in lines)


def _cell(value: object) -> tuple[str, bool]:
    match value:
        case None:
            return "–", True
        case float():
            return (f"{value:,.0f}" if abs(value) >= 1000 else f"{value:.4g}"), True
        case int() if not isinstance(value, bool):
            return f"{value:,}", True
    return str(value), False


def _plain(value: Any) -> Any:
    if isinstance(value, np.generic):
        return value.item()
    if isinstance(value, os.PathLike):
        return os.fspath(value)
    raise TypeError(f"{type(value).__name__} is no JSON")


Progress = Callable[[int, int, str], None]
"""Called with the number done, the number in all, and a name for what comes next."""

_BAR_FORMAT = "{desc}{n:.4g}{of} {unit} {bar} {elapsed}{left}{postfix}"


def _bar(total: float | None, unit: str, what: str = "", disable: bool = False) -> Any:
    """Open a bar on stderr: every command shows how far it is in this one way."""
    from tqdm import tqdm

    class Bar(tqdm):
        time_left = TimeLeft()

        @property
        def format_dict(self) -> dict[str, Any]:
            known = super().format_dict
            done = self.n - self.initial
            takes = self.total and done and known["elapsed"] * (self.total - self.n) / done
            left = self.time_left.tell(takes, time.monotonic()) if takes else ""
            return known | {"of": f"/{self.total}" if self.total else "", "left": left}

    return Bar(
        total=total,
        desc=what,
        unit=unit,
        bar_format=_BAR_FORMAT,
        leave=False,
        smoothing=0,
        disable=disable,
        file=sys.stderr,
    )


class TimeLeft:
    """A time left that rises by at most a tenth in ten seconds, and says where that is too little.

    What is told first rests on little; whoever plans by it is better served by "more than".
    """

    def __init__(self) -> None:
        self._told, self._at = math.inf, -math.inf

    def tell(self, seconds: float, now: float) -> str:
        """Write the time left as the end of a line, from an estimate made at a time ``now`` [s]."""
        most = self._told if now < self._at + _RISE_S else 1.1 * self._told
        if seconds < self._told or most > self._told:
            self._told, self._at = min(seconds, most), now
        bound = "more than " if seconds > 1.1 * self._told else ""
        return f", {bound}{duration_text(self._told)} left"


_RISE_S = 10

_AT_ONCE_S = 1.0  # what is done so soon was kept, and tells nothing of what is left


def bars_are_shown() -> bool:
    """Tell whether someone looks: stderr is a terminal, and the command prints no JSON."""
    command = click.get_current_context(silent=True)
    results = command and command.params.get("out")
    return sys.stderr.isatty() and not (results and results.stream)


class _Doing:
    """What this process does at the moment: words for it, and the bar that shows it if one does."""

    def __init__(self) -> None:
        self.text, self.left = "", ""
        self.kernels, self._until = "", 0.0
        self.bar: Any = None
        self._works: dict[float, tuple[float, float, float, TimeLeft]] = {}

    def tell(self, what: str, done: float, total: float, kept: bool = False) -> None:
        """Note how far something is, and how long it still takes once that is known."""
        now = time.monotonic()
        if not total:  # what nobody knows the end of, as compilation, passes over the rest
            self.kernels, self._until = what, now + _RISE_S
            return
        first, last, began, time_left = self._works.get(total, (done, math.inf, now, TimeLeft()))
        if done < last or kept:  # new work; the steps of one have names of their own
            first, began, time_left = done, now, TimeLeft()
        self._works[total] = first, done, began, time_left
        if done >= total:
            self.text = self.left = ""  # what comes next is not known yet
            return
        self.text, self.left = f"{what[:60]} {done:.0f}/{total:.0f}", ""
        if done > first:
            left = (now - began) * (total - done) / (done - first)
            self.left = time_left.tell(left, now)

    def __str__(self) -> str:
        """Say what is done now, and how long that takes."""
        recent = time.monotonic() < self._until
        return self.kernels if recent else f"{self.text or 'working'}{self.left}"


_DOING = _Doing()
SIGN_OF_LIFE_VARIABLE = "LODBENCH_SIGN_OF_LIFE"
"""Environment variable of the seconds from one line to the next; 0 for none."""


@contextmanager
def progress_shown() -> Iterator[None]:
    """Show what takes long inside: a bar on a terminal, a line every ten seconds elsewhere.

    What is made once and then kept, as fitted appearances are, has a bar of its own.
    """
    bar: Any = None
    ended, began = threading.Event(), time.monotonic()
    asked = os.environ.get(SIGN_OF_LIFE_VARIABLE, "10")
    try:
        every = float(asked)
    except ValueError:
        rule = "seconds from one line of progress to the next"
        raise InputError(SIGN_OF_LIFE_VARIABLE, asked, rule, "0 for none") from None

    def follow(what: str, done: float, steps: int) -> None:
        nonlocal bar
        _DOING.tell(what, done, steps)
        if bar is None and done < steps and bars_are_shown():
            bar = _DOING.bar = _bar(steps, "steps", f"{what} ")
            bar.initial = done
        if bar is not None and steps:
            bar.n = done
            bar.refresh()
            if done >= steps:
                bar.close()
                bar = _DOING.bar = None

    def show_life() -> None:
        while not ended.wait(every):
            if _DOING.bar is not None:
                _DOING.bar.refresh()
            else:
                took = duration_text(time.monotonic() - began)
                print(f"lodbench: {took}: {_DOING}", file=sys.stderr, flush=True)
                _DOING.left = ""  # it is old by the next line, unless it is told again

    if every > 0:
        threading.Thread(target=show_life, daemon=True).start()
    try:
        with followed_by(follow):
            yield
    finally:
        ended.set()
        _DOING.text = ""


@contextmanager
def _shown_bar(total: float | None, unit: str) -> Iterator[Any]:
    """Open a bar, which is disabled away from a terminal and under --json."""
    shown = bars_are_shown()
    with _bar(total, unit, disable=not shown) as bar:
        _DOING.bar = bar if shown else None
        try:
            yield bar
        finally:
            _DOING.bar = None


@contextmanager
def progress_bar(unit: str) -> Iterator[Progress]:
    """Open a bar that counts units; away from a terminal and under --json it only notes them."""
    began = time.monotonic()
    with _shown_bar(None, unit) as bar:

        def show(done: int, total: int, what: str) -> None:
            kept = time.monotonic() < began + _AT_ONCE_S
            if bar.disable:
                _DOING.tell(what, done, total, kept)
                return
            bar.total, bar.n = total, done
            if kept:
                bar.initial = done
            bar.set_description_str(f"{what} ")  # at once: what comes next may take long

        yield show


def tell_first_run() -> None:
    """Say why this command is slow to begin, if nothing is compiled yet; tell what it compiles."""
    click.get_current_context().with_resource(kernels_told())
    if is_first_run():
        _DOING.text = "compiling kernels and growing models: about a minute, both are kept"
        if bars_are_shown():
            print(f"lodbench: first run: {_DOING.text}", file=sys.stderr, flush=True)


class FrameProgress:
    """A bar over the frames of a sequence that also moves within a frame."""

    def __init__(self, bar: Any) -> None:
        self._bar, self._done = bar, 0

    def clear(self) -> None:
        """Clear the bar, so that a line can be printed in its place."""
        self._bar.clear()

    def finish_frame(self, record: dict[str, Any]) -> None:
        """Count one frame more; a kept one says nothing about the time that the others take."""
        self._done += 1
        if record.get("kept") and not self._bar.disable:
            self._bar.initial += 1
        self._move(self._done)

    def show_samples(
        self, process: int, traced: int, total: int, making: "Making | None" = None
    ) -> None:
        """Show how many samples of its frame a process has traced, and the memory it holds.

        ``total`` is 0 while the frame is prepared; ``making`` is what is made for it then.
        """
        if making:
            _DOING.tell(*making)
            words = [str(_DOING)]
        elif total:
            frames = f"frame {self._done + 1} of {self._bar.total}: samples traced [%]"
            _DOING.tell(frames, 100 * traced / total, 100)
            words = [f"{traced / total:.0%} of {total / 1e6:.1f} M samples"]
        else:
            words = ["preparing"]
        if self._bar.disable:
            return
        import psutil

        with suppress(psutil.Error):
            words.append(f"{psutil.Process(process).memory_info().rss / 1e9:.2f} GB")
        self._bar.set_postfix_str(", ".join(words), refresh=False)
        self._move(self._done + (traced / total if total else 0.0))

    def _move(self, frames: float) -> None:
        if not self._bar.disable:
            self._bar.n = frames
            self._bar.refresh()


@contextmanager
def frame_progress(frames: int) -> Iterator[FrameProgress]:
    """Open a bar for so many frames, which is shown as ``progress_bar`` shows its own."""
    with _shown_bar(frames, "frames") as bar:
        yield FrameProgress(bar)


def duration_text(seconds: float) -> str:
    """Write a duration as ``40 s`` or ``12 min``."""
    return f"{seconds:.0f} s" if seconds < 90 else f"{seconds / 60:.0f} min"
