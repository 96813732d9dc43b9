"""Compiled kernels: Numba's ``njit``, which compiles anew what its cache cannot give back whole.

Numba takes each file of its cache as it stands: one that was cut off or emptied stops the program
with an error of pickle's, and one with a changed byte would be run. Here every kernel is kept with
the SHA-256 of its code, and a function whose files fail in any way begins with an empty index.

A map over chunks of neighbouring items on threads, with the same results for any thread count.

It is meant for compiled kernels that release the interpreter's lock. Numba sets the number of
threads (NUMBA_NUM_THREADS, numba.set_num_threads).
"""

import contextlib
import hashlib
import pickle
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from itertools import pairwise
from typing import Any, TypeVar

import numba
import numpy as np
from numba import get_num_threads
from numba.core.caching import CompileResultCacheImpl, FunctionCache
from numba.core.serialize import dumps

ZERO, ONE = np.int64(0), np.int64(1)
"""For arguments of kernels: of one that is called with a bare 0 Numba compiles two."""


def njit(*, cache: bool, **options: Any) -> Callable[[Callable[..., Any]], Any]:
    """Compile a function as ``numba.njit`` does; with ``cache`` its kernels are kept as above."""

    def compiled(function: Callable[..., Any]) -> Any:
        dispatcher = numba.njit(**options)(function)
        if cache:
            dispatcher._cache = _Cache(function)
        return dispatcher

    return compiled


class _Sealed(CompileResultCacheImpl):
    def reduce(self, cres: Any) -> tuple[bytes, bytes]:
        code = dumps(super().reduce(cres))
        return hashlib.sha256(code).digest(), code

    def rebuild(self, target_context: Any, payload: tuple[bytes, bytes]) -> Any:
        digest, code = payload
        if hashlib.sha256(code).digest() != digest:
            raise ValueError("a kernel was changed")
        return super().rebuild(target_context, pickle.loads(code))


class _Cache(FunctionCache):
    _impl_class = _Sealed

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        try:
            return super().load_overload(sig, target_context)
        except Exception:  # damage may appear as any error at all
            with contextlib.suppress(OSError):
                self.flush()
            return None


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
