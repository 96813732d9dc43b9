"""Where the frames of a sequence go: the pattern of their names, and their folder."""

import os
import tempfile
from pathlib import Path

from lod.errors import InputError
from scenes.render.files.disk import partial_path

PLACEHOLDER = "####"
"""Stands in a pattern for the frame's number, at least four digits."""

LONGEST_NAME = 255
"""Bytes of a file's name that every usual file system takes."""

_LONGEST_NUMBER = 6


def check_pattern(pattern: str | Path) -> None:
    """Raise InputError unless a path is like out/name.####.exr."""
    folder, name = os.path.split(pattern)
    cure = "write it as out/name.####.exr"
    if not name.endswith(".exr"):
        raise InputError("-o", str(pattern), "frames are .exr files", cure)
    if name.count("#") != len(PLACEHOLDER) or PLACEHOLDER not in name or "#" in folder:
        rule = "the file's name holds #### once, for the number"
        raise InputError("-o", str(pattern), rule, cure)
    check_name(os.path.join(folder, name.replace(PLACEHOLDER, "0" * _LONGEST_NUMBER)))


def check_name(path: str | Path, where: str = "-o") -> None:
    """Raise InputError for a file whose name no file system takes, before anything is rendered.

    While it is written a file has a longer name (``partial_path``), which must not be too long.
    """
    cure = "choose another name"
    try:
        os.fspath(path).encode("utf-8")
    except UnicodeEncodeError:
        raise InputError(where, str(path), "a name is UTF-8 text", cure) from None
    if "\0" in os.fspath(path):
        raise InputError(where, str(path), "a name has no zero byte", cure)
    name = Path(path).name
    longest = LONGEST_NAME - len(partial_path(Path(path)).name.encode()) + len(name.encode())
    if len(name.encode()) > longest:
        raise InputError(where, name, f"a name of at most {longest} bytes", cure)


def frame_path(pattern: str | Path, frame: int) -> Path:
    """Path of one frame's file. Raises InputError for what is no pattern, or a frame below 0."""
    check_pattern(pattern)
    if frame < 0:
        raise InputError("frame", frame, "0 or more", "frames count from 1")
    path = Path(pattern)
    return path.with_name(path.name.replace(PLACEHOLDER, f"{frame:04d}"))


def may_name(name: str, frame: int) -> bool:
    """Say whether a file of that name may be that frame: its number, of four digits, is in it."""
    return f"{frame:04d}" in name


def make_folder(folder: str | Path, where: str = "-o") -> Path:
    """Make a folder that can be written to, or raise InputError and leave nothing behind."""
    folder = Path(folder)
    new: list[Path] = []
    try:
        for each in [*reversed(folder.parents), folder]:
            if not each.exists():
                each.mkdir()
                new.append(each)
        with tempfile.TemporaryFile(dir=folder):
            return folder
    except (OSError, ValueError) as error:
        for each in reversed(new):
            each.rmdir()
        why = getattr(error, "strerror", None) or str(error)
        rule = f"a folder that can be written to ({why})"
        raise InputError(where, str(folder), rule, "choose another") from None
