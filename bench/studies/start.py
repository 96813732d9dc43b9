"""How long does a command take from the shell to its answer, against importing what it needs?

Commands run in processes of their own, in turns with one that only imports the packages, so that
whatever else the machine does falls on both. Cold: nothing is kept and no kernel is compiled.
"""

import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path
from resource import RUSAGE_CHILDREN, getrusage
from typing import NamedTuple

import click
import numpy as np

from bench.cli.output import table
from bench.statistics.estimates import LEAST_REPEATS, two_sided_median
from scenes.processes.cache_folder import VARIABLE

IMPORTS = "import numpy, numba, scipy, pydantic, click"
WARM, COLD = "warm", "cold"


class Took(NamedTuple):
    """Seconds that a process took: by the clock, and of the processor's."""

    wall_s: float
    cpu_s: float


def timed(words: Sequence[str], cache: Path) -> Took:
    """Run Python with these words in a process of its own, which keeps things in a folder.

    Raises CalledProcessError where it fails.
    """
    environment = {k: v for k, v in os.environ.items() if k != "NUMBA_CACHE_DIR"}
    before, start = getrusage(RUSAGE_CHILDREN), time.perf_counter()
    subprocess.run(
        [sys.executable, *words],
        env=environment | {VARIABLE: str(cache)},
        stdout=subprocess.DEVNULL,
        check=True,
    )
    wall, after = time.perf_counter() - start, getrusage(RUSAGE_CHILDREN)
    cpu = after.ru_utime - before.ru_utime + after.ru_stime - before.ru_stime
    return Took(wall, cpu)


def rounds(command: Sequence[str], repeats: int, cold: int) -> dict[str, list[tuple[Took, Took]]]:
    """Time a lodbench command and the imports in turns: pairs of imports and command."""
    words, imports = ("-m", "lodbench", *command), ("-c", IMPORTS)
    found: dict[str, list[tuple[Took, Took]]] = {COLD: [], WARM: []}
    with tempfile.TemporaryDirectory() as scratch:
        for number in range(cold):
            fresh = Path(scratch, f"cold{number}")
            found[COLD].append((timed(imports, fresh), timed(words, fresh)))
        kept = Path(scratch, "warm")
        timed(words, kept)  # fills the cache
        found[WARM] = [(timed(imports, kept), timed(words, kept)) for _ in range(repeats)]
    return found


def report(found: dict[str, list[tuple[Took, Took]]]) -> str:
    """Write medians, and the ratio of each pair with its 95 % interval."""
    rows: list[tuple[object, ...]] = [
        ("", "imports [s]", "command [s]", "ratio", "95 % from", "to")
    ]
    for name, pairs in found.items():
        for clock in Took._fields if pairs else ():
            one, other = (np.array([getattr(p[k], clock) for p in pairs]) for k in (0, 1))
            ratio, low, high = np.median(other / one), None, None
            if len(pairs) >= LEAST_REPEATS:
                estimate = two_sided_median(other / one)
                low, high = estimate.low, estimate.high
            medians = float(np.median(one)), float(np.median(other))
            rows.append((f"{name}, {clock}", *medians, float(ratio), low, high))
    return table(rows)


@click.command(context_settings={"ignore_unknown_options": True})
@click.argument("words", nargs=-1, type=click.UNPROCESSED)
@click.option("--repeats", default=9, show_default=True, help="Warm pairs.")
@click.option("--cold", default=1, show_default=True, help="Pairs that begin with nothing kept.")
def command(words: tuple[str, ...], repeats: int, cold: int) -> None:
    """Time `lodbench WORDS`, by default `count meadow`, against the imports that it needs."""
    click.echo(report(rounds(words or ("count", "meadow"), repeats, cold)))
