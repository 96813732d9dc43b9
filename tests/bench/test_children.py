"""A function in a fresh process returns what it would here, and only its own time and memory."""

import os
import subprocess
import time

import numpy as np
import pytest

from bench.children import run_in_child


def held_and_slept(megabytes: int, seconds: float) -> tuple[int, bool]:
    """Hold memory, sleep, print, and return the number of the process."""
    held = np.ones(megabytes * 125_000)
    time.sleep(seconds)
    print("not the answer")
    return os.getpid(), bool(held.all())


def killed() -> None:
    """End as a process does that the system kills."""
    os.kill(os.getpid(), 9)


def test_a_function_is_measured_in_a_process_of_its_own():
    small, large = (run_in_child(held_and_slept, mb, 0.3) for mb in (1, 201))
    assert small.result[1] is True
    assert len({os.getpid(), small.result[0], large.result[0]}) == 3
    assert small.wall_s > 0.3 and 0 < small.cpu_s
    assert large.peak_bytes - small.peak_bytes == pytest.approx(200e6, rel=0.1)


def test_a_child_that_was_killed_is_told_by_its_signal():
    with pytest.raises(subprocess.CalledProcessError) as failed:
        run_in_child(killed)
    assert failed.value.returncode == -9
