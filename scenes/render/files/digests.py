"""What a frame's header says of its own file, which thereby tells alone whether it is whole."""

import hashlib
from collections.abc import Mapping

import numpy as np


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


_TYPES = {"float16": "half", "float32": "float", "uint32": "uint"}
