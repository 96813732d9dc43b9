"""Work shared out to threads in runs of neighbours: the same results for any number of threads.

For compiled kernels that let go of the interpreter's lock. How many threads there are is numba's to
say (NUMBA_NUM_THREADS, numba.set_num_threads).
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
    """``task(first, last)`` of every run of items 0 to ``count``, in order.

    least: items for which another thread is worth its start; most: about so many in a run at most,
    where what a task needs for each of them should stay in the cache.
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
