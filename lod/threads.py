"""A map over chunks of neighbouring items on threads, with the same results for any thread count.

It is meant for compiled kernels that release the interpreter's lock. Numba sets the number of
threads (NUMBA_NUM_THREADS, numba.set_num_threads).
"""

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from itertools import pairwise
from typing import TypeVar

import numpy as np
from numba import get_num_threads

Result = TypeVar("Result")


def map_chunks(
    task: Callable[[int, int], Result], count: int, least: int, most: int | None = None
) -> list[Result]:
    """Call ``task(first, last)`` for consecutive chunks of items 0 to ``count``; results in order.

    least  number of items for which another thread is worth its start
    most   approximate upper bound on the items of a chunk, where the working set of a task should
           stay in the cache; None for no bound
    """
    threads = max(1, min(get_num_threads(), count // least))
    runs = threads if most is None else threads * -(-count // (threads * most))
    if runs <= 1:
        return [task(0, count)]
    ends = np.linspace(0, count, runs + 1).astype(np.int64).tolist()
    if threads == 1:
        return [task(first, last) for first, last in pairwise(ends)]
    with ThreadPoolExecutor(threads) as pool:
        return list(pool.map(task, ends[:-1], ends[1:]))
