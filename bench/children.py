"""Functions that run in fresh processes, so that their time and memory are of nothing else.

The function and its arguments travel by pickle, and so does what it returns: a function is named by
its module, and nothing of this process's state goes with it.
"""

import os
import pickle
import subprocess
import sys
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from scenes.processes.memory_limit import peak_rss_bytes
from scenes.render.variants import trusting

_ROOT = Path(__file__).resolve().parents[1]


@dataclass(frozen=True)
class Child:
    """What a function that ran in a fresh process returned, and what the process took.

    wall_s, cpu_s  of the whole process, its imports included [s]
    peak_bytes     most memory that it held
    """

    result: Any
    wall_s: float
    cpu_s: float
    peak_bytes: int


def run_in_child(
    function: Callable[..., Any],
    *arguments: object,
    variant: str | None = None,
    timeout_s: float = 1800.0,
) -> Child:
    """Call a function of a module in a fresh process.

    ``variant`` is one that was tried here and that the child need not try again. What the function
    prints goes to stderr.

    Raises CalledProcessError where it fails, with ``returncode`` −9 where the system killed it for
    its memory, and TimeoutExpired.
    """
    paths = os.pathsep.join([str(_ROOT), *filter(None, [os.environ.get("PYTHONPATH")])])
    environment = {**(trusting(variant) if variant else os.environ), "PYTHONPATH": paths}
    words = (sys.executable, "-P", "-m", "bench.children")
    asked = pickle.dumps((function, arguments))
    said, wall_s, cpu_s = run_timed(words, environment, asked, timeout_s)
    result, peak = pickle.loads(said)
    return Child(result, wall_s, cpu_s, peak)


def run_timed(
    words: Sequence[str],
    environment: Mapping[str, str],
    asked: bytes = b"",
    timeout_s: float | None = None,
) -> tuple[bytes, float, float]:
    """Run a command, and return its standard output, wall seconds and CPU seconds.

    CPU seconds are those of the process and of all it waited for.
    Raises CalledProcessError where it fails, and TimeoutExpired.
    """
    before, start = os.times(), time.perf_counter()
    done = subprocess.run(
        words, input=asked, env=environment, stdout=subprocess.PIPE, timeout=timeout_s, check=True
    )
    wall, after = time.perf_counter() - start, os.times()
    cpu = after.children_user - before.children_user
    return done.stdout, wall, cpu + after.children_system - before.children_system


def _answer() -> None:
    answers = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)
    function, arguments = pickle.load(sys.stdin.buffer)
    result = function(*arguments)
    with answers:
        pickle.dump((result, peak_rss_bytes()), answers)


if __name__ == "__main__":
    _answer()
