"""What does a result depend on: one digest of plain data, such as parameters and arrays."""

import hashlib
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np


def content_key(*values: Any) -> str:
    """Give a digest [hex] of numbers, strings, arrays, None, and data made of them.

    Frozen dataclasses, mappings and sequences are read through. Two keys are equal only where all
    values are, to the last bit. Raises TypeError for anything else.
    """
    digest = hashlib.sha256()
    for piece in _pieces(values):
        digest.update(len(piece).to_bytes(8, "little") + piece)
    return digest.hexdigest()


def _pieces(value: Any) -> Iterator[bytes]:
    """Yield the bytes of a value with a mark of its kind, so that no two values read alike."""
    match value:
        case np.ndarray() if not value.dtype.hasobject:
            yield f"array {value.dtype.str} {value.shape}".encode()
            yield np.ascontiguousarray(value).tobytes()
        case None | bool() | int() | str() | bytes() | Path():
            yield f"{type(value).__name__} {value!r}".encode()
        case float():
            yield f"float {float(value).hex()}".encode()
        case np.generic():
            yield from _pieces(np.asarray(value))
        case Mapping():
            yield f"mapping {len(value)}".encode()
            for name in sorted(value):
                yield from _pieces((name, value[name]))
        case list() | tuple():
            yield f"sequence {len(value)}".encode()
            for each in value:
                yield from _pieces(each)
        case _ if hasattr(type(value), "__dataclass_fields__"):
            yield f"{type(value).__module__}.{type(value).__qualname__}".encode()
            for name in type(value).__dataclass_fields__:
                yield from _pieces((name, getattr(value, name)))
        case _:
            raise TypeError(f"a key is made of plain data, not of {type(value).__name__}")
