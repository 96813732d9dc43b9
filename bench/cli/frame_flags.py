"""Which frames are asked for, and where do they go? Checked before anything slow begins."""

import os
import re
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import click

from lod.errors import InputError

LAST_FRAME = 999_999
MOST_FRAMES = 100_000
_SPAN = re.compile(r"(\d{1,40})(?:-(\d{1,40})(?:x(\d{1,40}))?)?", re.ASCII)
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
        if max(int(each or 0) for each in match.groups()) > LAST_FRAME:
            rule = f"frames are numbered up to {LAST_FRAME}"
            raise InputError("--frames", text, rule, "render in parts, each in its folder")
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
    """Read the bytes of ``4GB``, ``500 MB`` or ``2.5GiB``; raises InputError for anything else."""
    match = _MEMORY.fullmatch(text.strip())
    if match is None or not float(match[1]):
        raise InputError("--max-memory", text, "above 0, in MB, GB, MiB or GiB", "try 4GB")
    return round(float(match[1]) * _UNITS[match[2].lower()])


def memory_limit_bytes(text: str | None) -> int | None:
    """Read --max-memory: a size in bytes, 0 where ``0`` lifts the limit, None where it is absent.

    Raises InputError for anything else.
    """
    if text is None or text.strip() == "0":
        return None if text is None else 0
    return memory_size(text)


def memory_flag(command: Callable[..., Any]) -> Callable[..., Any]:
    """Add --max-memory to a command (``memory_limit_bytes`` reads it)."""
    about = "Refuse what needs more, as 4GB; 0 = never. By default 80 % of what is free."
    return click.option("--max-memory", metavar="SIZE", help=about)(command)


def memory_flag_of_all(command: Callable[..., Any]) -> Callable[..., Any]:
    """Add --max-memory to a command that renders in many ways: it is kept in the environment."""

    def keep(context: click.Context, option: click.Parameter, text: str | None) -> None:
        most = memory_limit_bytes(text)
        if most is not None:
            from scenes.render.pipeline.memory_limit import VARIABLE

            os.environ[VARIABLE] = str(most)

    about = "Refuse pictures that need more, as 4GB; 0 = never. By default 80 % of what is free."
    return click.option(
        "--max-memory", metavar="SIZE", help=about, expose_value=False, callback=keep
    )(command)


def check_targets(paths: Sequence[Path]) -> None:
    """Raise InputError where a folder stands in a frame's place."""
    for path in paths:
        if path.is_dir():
            raise InputError("-o", str(path), "a file's place, and a folder is there", "move it")
