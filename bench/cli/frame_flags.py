"""Which frames are asked for, and where do they go? Checked before anything slow begins."""

import re
from collections.abc import Sequence
from pathlib import Path

from lod.errors import InputError

LAST_FRAME = 999_999
MOST_FRAMES = 100_000
_SPAN = re.compile(r"(\d{1,6})(?:-(\d{1,6})(?:x(\d{1,6}))?)?", re.ASCII)
_MEMORY = re.compile(r"(\d{1,9}(?:\.\d{1,9})?) ?(MB|GB|MiB|GiB)", re.ASCII | re.IGNORECASE)
_UNITS = {"mb": 10**6, "gb": 10**9, "mib": 2**20, "gib": 2**30}


def frame_numbers(text: str) -> tuple[int, ...]:
    """Read the frame numbers of ``1-24``, ``1,5,9`` or ``1-100x10``, each once, ascending.

    ``1-100x10`` is every tenth frame from 1: 1, 11, 21 and so on up to 91.

    Raises InputError for anything else.
    """
    frames: set[int] = set()
    for span in text.split(","):
        match = _SPAN.fullmatch(span.strip())
        if match is None:
            raise InputError("--frames", text, "whole numbers, as 1-24 or 1,5,9", "try 1-24")
        first, last, step = int(match[1]), int(match[2] or match[1]), int(match[3] or 1)
        if step < 1:
            raise InputError("--frames", text, "a step of at least 1", f"write {first}-{last}x10")
        if last < first:
            raise InputError("--frames", text, "a range runs upwards", f"write {last}-{first}")
        if first < 1:
            raise InputError("--frames", text, "frames count from 1", "try 1-24")
        frames.update(range(first, last + 1, step))
    if len(frames) > MOST_FRAMES:
        raise InputError("--frames", text, f"at most {MOST_FRAMES} frames", "render in parts")
    return tuple(sorted(frames))


def memory_size(text: str) -> int:
    """Read the bytes of ``4GB``, ``500 MB`` or ``2.5GiB``, and 0 of ``0``: no limit.

    Raises InputError for anything else.
    """
    if text.strip() == "0":
        return 0
    match = _MEMORY.fullmatch(text.strip())
    if match is None or not float(match[1]):
        rule = "above 0, in MB, GB, MiB or GiB, or 0 for no limit"
        raise InputError("--max-memory", text, rule, "try 4GB")
    return round(float(match[1]) * _UNITS[match[2].lower()])


def check_targets(paths: Sequence[Path]) -> None:
    """Raise InputError where a folder stands in a frame's place."""
    for path in paths:
        if path.is_dir():
            raise InputError("-o", str(path), "a file's place, and a folder is there", "move it")
