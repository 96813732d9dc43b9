"""How long does a command take from the shell to its answer, against importing what it needs?

Commands run in processes of their own, in turns with one that only imports the packages, so that
whatever else the machine does falls on both. What a command must do in any case, as tracing the
rays of a frame, counts beside the imports. Cold: nothing is kept and no kernel is compiled.
"""

import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from resource import RUSAGE_CHILDREN, getrusage
from typing import Any, NamedTuple

import click
import numpy as np

from bench.cli.output import counted, table
from bench.records.study_record import study_record, write_study_record
from bench.statistics.estimates import LEAST_REPEATS, two_sided_median
from scenes.processes.cache import VARIABLE
from scenes.render.variants import choose

IMPORTS = "import numpy, numba, scipy, pydantic, click"
WARM, COLD = "warm", "cold"
SIZE, SPP = "640x360", 16
PRESETS = "meadow", "forest"


class Took(NamedTuple):
    """Seconds that a process took, by the clock and of the processor's, and what it printed."""

    wall_s: float
    cpu_s: float
    said: str


@dataclass(frozen=True)
class Start:
    """A command that is timed.

    name      of its figures
    words     of the command, after ``lodbench``
    imports   Python that imports what it needs
    own_s     seconds of work that it must do in any case, of what it printed
    """

    name: str
    words: tuple[str, ...]
    imports: str
    own_s: Callable[[str], float]


class Turn(NamedTuple):
    """The imports and the command, one after the other; ``own_s`` is of the command [s]."""

    imports: Took
    command: Took
    own_s: float

    @property
    def ratio(self) -> float:
        """Clock time of the command over that of its imports and the work that it must do."""
        return self.command.wall_s / (self.imports.wall_s + self.own_s)


def counting(words: tuple[str, ...]) -> Start:
    """Return a command that needs the imports and has no other work that it must do."""
    return Start(f"lodbench {' '.join(words)}", words, IMPORTS, lambda said: 0.0)


def first_frame(preset: str, folder: Path, variant: str) -> Start:
    """Return the first frame of a preset, from the command to the file in a folder."""
    words = ("render", preset, "-o", str(folder / "a.####.exr"), "--overwrite", "--json")
    picture = "--size", SIZE, "--spp", str(SPP), "--variant", variant
    imports = f"{IMPORTS}, drjit, OpenEXR, mitsuba; mitsuba.set_variant({variant!r})"
    return Start(
        f"first frame of {preset}, {SIZE}, {SPP} spp", (*words, *picture), imports, trace_s
    )


def trace_s(said: str) -> float:
    """Find the seconds of the trace in what `render --json` printed of one frame."""
    return float(json.loads(said.splitlines()[0])["seconds"]["trace"])


def timed(words: Sequence[str], cache: Path) -> Took:
    """Run Python with these words in a process of its own, which keeps things in a folder.

    Raises CalledProcessError where it fails.
    """
    environment = {k: v for k, v in os.environ.items() if k != "NUMBA_CACHE_DIR"}
    before, start = getrusage(RUSAGE_CHILDREN), time.perf_counter()
    done = subprocess.run(
        [sys.executable, *words],
        env=environment | {VARIABLE: str(cache)},
        stdout=subprocess.PIPE,
        text=True,
        check=True,
    )
    wall, after = time.perf_counter() - start, getrusage(RUSAGE_CHILDREN)
    cpu = after.ru_utime - before.ru_utime + after.ru_stime - before.ru_stime
    return Took(wall, cpu, done.stdout)


def rounds(start: Start, repeats: int, cold: int, kept: Path) -> dict[str, list[Turn]]:
    """Time a command and its imports in turns, cold, and warm with a folder of what is kept."""
    words, imports = ("-m", "lodbench", *start.words), ("-c", start.imports)

    def turn(cache: Path) -> Turn:
        first, then = timed(imports, cache), timed(words, cache)
        return Turn(first, then, start.own_s(then.said))

    def numbers(turns: int, name: str) -> Iterator[int]:
        return counted(range(turns), "turn", lambda number: f"{start.name}, {name}")

    with tempfile.TemporaryDirectory() as scratch:
        found = {COLD: [turn(Path(scratch, f"cold{k}")) for k in numbers(cold, COLD)]}
    if repeats:
        timed(words, kept)  # what is not there yet
    return found | {WARM: [turn(kept) for _ in numbers(repeats, WARM)]}


def figures(turns: Sequence[Turn]) -> dict[str, Any]:
    """Give medians [s] and the median ratio, with its 95 % interval where turns are enough."""
    ratios = np.array([each.ratio for each in turns])
    columns: dict[str, Any] = {
        "imports_s": [each.imports.wall_s for each in turns],
        "own_s": [each.own_s for each in turns],
        "command_s": [each.command.wall_s for each in turns],
        "command_cpu_s": [each.command.cpu_s for each in turns],
        "ratio": ratios,
    }
    found: dict[str, Any] = {name: float(np.median(each)) for name, each in columns.items()}
    found |= {"turns": len(turns), "low": None, "high": None}
    if len(turns) >= LEAST_REPEATS:
        estimate = two_sided_median(ratios)
        found |= {"low": estimate.low, "high": estimate.high}
    return found


def report(found: dict[str, dict[str, Any]]) -> str:
    """Write the figures of each command, cold and warm, as a table."""
    heads = ("", "imports [s]", "trace [s]", "command [s]", "ratio", "95 % from", "to")
    columns = ("imports_s", "own_s", "command_s", "ratio", "low", "high")
    rows = [(name, *(each[column] for column in columns)) for name, each in found.items()]
    return table([heads, *rows])


@click.command(context_settings={"ignore_unknown_options": True})
@click.argument("words", nargs=-1, type=click.UNPROCESSED)
@click.option("--repeats", default=9, show_default=True, help="Warm turns.")
@click.option("--cold", default=1, show_default=True, help="Turns that begin with nothing kept.")
@click.option("--record", type=click.Path(path_type=Path), help="A file for the figures.")
def command(words: tuple[str, ...], repeats: int, cold: int, record: Path | None) -> None:
    """Time `lodbench WORDS` against imports; by default `count meadow` and first frames."""
    variant, found = choose(), {}
    with tempfile.TemporaryDirectory() as folder:
        starts = [counting(words or ("count", "meadow"))]
        starts += [first_frame(each, Path(folder), variant) for each in PRESETS if not words]
        for start in starts:
            for name, turns in rounds(start, repeats, cold, Path(folder, "kept")).items():
                if turns:
                    found[f"{start.name}, {name}"] = figures(turns)
    click.echo(report(found))
    if record:
        settings = {"words": list(words), "repeats": repeats, "cold": cold}
        write_study_record(record, study_record("start", settings, found, variant))
