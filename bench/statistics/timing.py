"""Processor time of tasks that take turns, so that a drift of the machine meets all of them."""

import time
from collections.abc import Callable, Sequence
from typing import Any


def interleaved_seconds(tasks: Sequence[Callable[[], Any]], repeats: int) -> list[list[float]]:
    """Time every repeat of each task, the tasks taking turns.

    Gives one list of ``repeats`` times for each task: seconds of processor time of this thread.
    """
    seconds: list[list[float]] = [[] for _ in tasks]
    for _ in range(repeats):
        for task, times in zip(tasks, seconds, strict=True):
            start = time.thread_time()
            task()
            times.append(time.thread_time() - start)
    return seconds
