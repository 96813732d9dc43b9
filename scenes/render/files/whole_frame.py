"""A frame without its manifest: what it says that it is, once it is known to be whole."""

from pathlib import Path
from typing import Any

from lod.errors import InputError
from scenes.render.files.digests import is_sealed
from scenes.render.files.exr import UNREADABLE_CURE, read_header
from scenes.render.files.header import FRAME, settings_in


def whole_frame(path: str | Path) -> tuple[int, dict[str, Any]]:
    """Read a frame's number and settings from its header.

    Raises InputError for a file that is none of ours, and where a byte of it is not as written.
    """
    header = read_header(path)
    if FRAME not in header:
        raise InputError(
            "frame",
            str(path),
            "a frame of lodbench, with its number in the header",
            UNREADABLE_CURE,
        )
    if not is_sealed(path):
        raise InputError(
            "frame",
            str(path),
            "undamaged; its bytes are not those that were written",
            UNREADABLE_CURE,
        )
    return header[FRAME], settings_in(header)
