"""Named arrays as one file with a checksum, written whole or not at all.

A file is its format, a checksum of all that follows, the length of the header, the header (JSON:
name, dtype, shape and place of each array) and the bytes of the arrays.
"""

import json
import os
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any

import mmh3
import numpy as np

UNFINISHED = ".part"
"""How the names of files end that are being written."""

FORMAT = b"lodbench arrays 1\n"
_DIGEST = 16  # bytes of MurmurHash3
_ALIGNMENT = 64

Arrays = Mapping[str, np.ndarray]


def read_only(values: Any) -> np.ndarray:
    """Give a read-only array in C order; raises TypeError for Python objects and for records."""
    array = np.asarray(values, order="C").view()
    if array.dtype.hasobject or array.dtype.names:
        raise TypeError(f"a file holds arrays of numbers and of text, not of {array.dtype}")
    array.setflags(write=False)
    return array


def encode_arrays(arrays: Arrays) -> list[bytes | memoryview]:
    """Give the file's bytes: format, checksum, length of the header, header, aligned arrays."""
    rows, start = [], 0
    body: list[bytes | memoryview] = []
    for name, array in arrays.items():
        rows.append([name, array.dtype.str, list(array.shape), start])
        padding = -array.nbytes % _ALIGNMENT
        body += [array.reshape(-1).view(np.uint8).data, bytes(padding)]
        start += array.nbytes + padding
    header = json.dumps(rows).encode()
    head = len(FORMAT) + _DIGEST + 8
    header += b" " * (-(head + len(header)) % _ALIGNMENT)
    body = [len(header).to_bytes(8, "little"), header, *body]
    hasher = mmh3.mmh3_x64_128()
    for piece in body:
        hasher.update(piece)
    return [FORMAT, hasher.digest(), *body]


def decode_arrays(content: np.ndarray) -> dict[str, np.ndarray]:
    """Read a file's bytes as read-only arrays; raises ValueError where they are damaged."""
    start = len(FORMAT) + _DIGEST
    if content[: len(FORMAT)].tobytes() != FORMAT:
        raise ValueError("another format")
    hasher = mmh3.mmh3_x64_128(content[start:].data)
    if hasher.digest() != content[len(FORMAT) : start].tobytes():
        raise ValueError("damaged")
    content.setflags(write=False)
    begin = start + 8
    first = begin + int.from_bytes(content[start:begin].tobytes(), "little")
    arrays = {}
    for name, kind, shape, offset in json.loads(content[begin:first].tobytes()):
        dtype = np.dtype(kind)
        stop = first + offset + dtype.itemsize * int(np.prod(shape, dtype=np.int64))
        arrays[name] = content[first + offset : stop].view(dtype).reshape(shape)
    return arrays


def write_array_file(path: Path, pieces: list[bytes | memoryview]) -> None:
    """Write an encoded file whole or not at all; raises OSError where it cannot be."""
    path.parent.mkdir(parents=True, exist_ok=True)
    temporary = path.with_name(f"{path.name}.{os.urandom(8).hex()}{UNFINISHED}")
    try:
        with temporary.open("xb") as file:
            file.writelines(pieces)
        os.replace(temporary, path)
    except BaseException:
        with suppress(OSError):
            temporary.unlink()
        raise
