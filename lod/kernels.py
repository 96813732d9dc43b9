"""Compiled kernels: Numba's ``njit``, which compiles anew what its cache cannot give back whole.

Numba takes each file of its cache as it stands: one that was cut off or emptied stops the program
with an error of pickle's, and one with a changed byte would be run. Here every kernel is kept with
the SHA-256 of its code, and a function whose files fail in any way begins with an empty index.
"""

import contextlib
import hashlib
import pickle
from collections.abc import Callable
from typing import Any

import numba
import numpy as np
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
