"""Compiled kernels: Numba's ``njit``, which compiles anew what its cache cannot give back whole.

Numba takes each file of its cache as it stands: one that was cut off or emptied stops the program
with an error of pickle's, and one with a changed byte would be run. Here every kernel is kept with
the SHA-256 of its code, and a function whose files fail in any way begins with an empty index.
"""

import contextlib
import hashlib
import pickle
from typing import Any

from numba import njit
from numba.core.caching import CompileResultCacheImpl, FunctionCache
from numba.core.serialize import dumps

__all__ = ["njit"]


class _Sealed(CompileResultCacheImpl):
    def reduce(self, cres: Any) -> tuple[bytes, bytes]:
        code = dumps(super().reduce(cres))
        return hashlib.sha256(code).digest(), code

    def rebuild(self, target_context: Any, payload: tuple[bytes, bytes]) -> Any:
        digest, code = payload
        if hashlib.sha256(code).digest() != digest:
            raise ValueError("a kernel was changed")
        return super().rebuild(target_context, pickle.loads(code))


def _load_or_forget(self: Any, sig: Any, target_context: Any) -> Any:
    try:
        return _load(self, sig, target_context)
    except Exception:  # damage may appear as any error at all
        with contextlib.suppress(OSError):
            self.flush()
        return None


_load = FunctionCache.load_overload
FunctionCache.load_overload = _load_or_forget
FunctionCache._impl_class = _Sealed
