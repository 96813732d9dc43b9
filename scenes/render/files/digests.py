"""What a frame's header says of its own file, which thereby tells alone whether it is whole."""

import hashlib
import mmap
from collections.abc import Mapping
from pathlib import Path
from typing import BinaryIO

import numpy as np

PIXELS_SHA256 = "lod:pixels_sha256"
"""Where a header holds ``pixels_digest`` of the file's channels."""

FILE_SHA256 = "lod:file_sha256"
"""Where the first header holds the SHA-256 of the whole file, taken with zeros for its digits."""

UNSEALED = "0" * 64
_MARK = FILE_SHA256.encode() + b"\0string\0" + len(UNSEALED).to_bytes(4, "little")


def pixels_digest(pixels: Mapping[str, np.ndarray]) -> str:
    """Hash the channels of a frame, (h, w) each, as they are in its file, to 64 hexadecimal digits.

    It is the SHA-256 of, for each channel in the order of the names' bytes: the name in UTF-8, a
    line feed, ``half``, ``float`` or ``uint``, a line feed, and the numbers in little-endian order,
    row by row from the top. Parts and compression do not count.
    """
    digest = hashlib.sha256()
    for name in sorted(pixels, key=str.encode):
        values = pixels[name]
        digest.update(f"{name}\n{_TYPES[values.dtype.name]}\n".encode())
        digest.update(values.astype(values.dtype.newbyteorder("<"), copy=False).tobytes())
    return digest.hexdigest()


def seal(path: str | Path) -> None:
    """Write a file's own hash over the zeros that its header holds in its place."""
    with open(path, "r+b") as file:
        at, digest = _own_digest(file)
        file.seek(at)
        file.write(digest.encode())


def is_sealed(path: str | Path) -> bool:
    """Whether every byte of a file is as it was when its hash was written into it."""
    with open(path, "rb") as file:
        at, digest = _own_digest(file)
        file.seek(at)
        return file.read(len(UNSEALED)) == digest.encode()


def _own_digest(file: BinaryIO) -> tuple[int, str]:
    """Where the hash stands, and what it should be; nowhere is the end of the file."""
    with mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ) as data, memoryview(data) as view:
        found = data.find(_MARK)
        at = len(data) if found < 0 else found + len(_MARK)
        digest = hashlib.sha256(view[:at])
        digest.update(UNSEALED.encode())
        digest.update(view[at + len(UNSEALED) :])
    return at, digest.hexdigest()


_TYPES = {"float16": "half", "float32": "float", "uint32": "uint"}
