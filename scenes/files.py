"""Files that are whole or not there, that replace nobody else's work, and their names.

Everything that lodbench keeps is written here: to a temporary name in the same folder, which
becomes the file's own when all is written (``whole_file``; of frames,
``scenes.render.exr.frames_on_disk``). By a link, which never replaces, where
nothing may be replaced, so that the file system settles who comes first.
"""

import errno
import itertools
import operator
import os
import socket
import tempfile
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

from lod.errors import InputError

PLACEHOLDER = "####"
"""Stands in a pattern for the frame's number, at least four digits."""

LAST_FRAME, MOST_FRAMES = 999_999, 100_000
"""The highest number of a frame, and how many frames are rendered at once."""

LONGEST_NAME = 255  # bytes of a file's name that every usual file system takes

_LONGEST_NUMBER = 6
_SEARCHED = 2**16

_SAYS = {
    errno.ENOSPC: ("the disk is full", "make room"),
    errno.EDQUOT: ("the quota is used up", "make room"),
    errno.EROFS: ("the disk is read-only", "have it mounted for writing"),
    errno.EACCES: ("writing there is not allowed", "change the folder's permissions"),
    errno.EPERM: ("writing there is not allowed", "change the folder's permissions"),
    errno.ENOENT: ("the folder has gone", "bring it back"),
    errno.ENOTDIR: ("the folder has gone", "bring it back"),
    errno.ESTALE: ("the folder has gone", "mount it again"),
    errno.EIO: ("the disk fails", "look after it"),
}


class DiskError(OSError):
    """The disk refused: which file, why, and the cure, in one line."""

    def __init__(self, error: OSError, path: Path) -> None:
        what, cure = _SAYS.get(error.errno or 0, ("it cannot be written", "see to that"))
        self.line = (
            f"{path}: {what} ({error.strerror}); finished frames are whole: "
            f"{cure}, then give the same command again"
        )
        super().__init__(error.errno, self.line)

    def __str__(self) -> str:
        return self.line


@contextmanager
def whole_file(path: str | Path, overwrite: bool = False, where: str = "-o") -> Iterator[Path]:
    """Give a path beside ``path`` to write to, which gets that name when all is written.

    Its suffix is the same. Raises InputError where a file stands already, or comes meanwhile,
    unless ``overwrite``; and OSError where the disk refuses.
    """
    path = Path(path)
    check_free(path, overwrite, where)
    partial = partial_path(path)
    temporary = partial.with_name(f"{partial.name}{path.suffix}")
    try:
        yield temporary
        with temporary.open("rb+") as file:
            os.fsync(file.fileno())
        give_name(temporary, path, overwrite, where)
    finally:
        temporary.unlink(missing_ok=True)


def give_name(temporary: Path, path: Path, overwrite: bool = False, where: str = "-o") -> None:
    """Give a finished file its name, and have the system keep it; the temporary one may stay.

    Raises InputError where something has that name, unless ``overwrite``.
    """
    try:
        if overwrite:
            raise FileExistsError
        os.link(temporary, path)
    except OSError:  # the name is taken, or the file system has no links
        check_free(path, overwrite, where)
        os.replace(temporary, path)
    with suppress(OSError):  # some file systems cannot, and that is no harm
        handle = os.open(path.parent, os.O_RDONLY)
        try:
            os.fsync(handle)
        finally:
            os.close(handle)


def write_text(path: Path, text: str) -> None:
    """Write a text file whole; an earlier one of that name is replaced. Raises OSError."""
    with whole_file(path, overwrite=True) as temporary:
        temporary.write_text(text, encoding="utf-8")


def check_free(path: str | Path, overwrite: bool = False, where: str = "-o") -> None:
    """Raise InputError where a file, or anything else, stands that may not be replaced."""
    path = Path(path)
    if path.is_dir():
        raise InputError(where, str(path), "a file's place, and a folder is there", "move it")
    if not overwrite and os.path.lexists(path):
        rule = "a file that is not there yet"
        raise InputError(where, str(path), rule, "choose another name, or --overwrite")


def check_ours(paths: Iterable[str | Path], overwrite: bool = False, where: str = "-o") -> None:
    """Raise InputError where something stands that lodbench did not make, unless ``overwrite``."""
    for path in paths:
        check_free(path, overwrite or made_by_lodbench(path), where)


def made_by_lodbench(path: str | Path) -> bool:
    """Say whether a file names lodbench near its beginning or its end, as all of ours do."""
    try:
        with Path(path).open("rb") as file:
            begin = file.read(_SEARCHED)
            file.seek(max(0, os.fstat(file.fileno()).st_size - _SEARCHED))
            return b"lodbench" in begin + file.read()
    except OSError:
        return False


def partial_path(path: Path) -> Path:
    """Where this process writes a file before it is whole: .NAME.HOST-PID.part beside it."""
    return path.with_name(f".{path.name}.{_host()}-{os.getpid()}.part")


def stray_partials(folder: Path) -> Iterator[tuple[str, Path]]:
    """(name of the file it was to become, path) of partial files whose writer is no more.

    A writer on another machine counts as gone: nobody here can tell.
    """
    for path in sorted(folder.glob(".*.part")):
        name, _, writer = path.name[1:].removesuffix(".part").rpartition(".")
        if name and not _alive(writer):
            yield name, path


def _host() -> str:
    return socket.gethostname().replace("/", "-").replace(".", "-")


def _alive(writer: str) -> bool:
    host, _, pid = writer.rpartition("-")
    if host != _host() or not pid.isdecimal() or int(pid) == os.getpid():
        return False  # numbers come back: a file of ours from before we began
    try:
        os.kill(int(pid), 0)
    except (ProcessLookupError, OverflowError):
        return False
    except PermissionError:
        return True
    return True


def check_pattern(pattern: str | Path) -> None:
    """Raise InputError unless a path is like out/name.####.exr."""
    folder, name = os.path.split(pattern)
    cure = "write it as out/name.####.exr"
    if not name.endswith(".exr"):
        raise InputError("-o", str(pattern), "frames are .exr files", cure)
    if name.count("#") != len(PLACEHOLDER) or PLACEHOLDER not in name or "##" in folder:
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


def checked_frames(frames: Any, where: str = "frames", said: object = None) -> tuple[int, ...]:
    """Check an iterable of whole numbers of frames, and give each once, in their order.

    Raises InputError that names ``said`` for others than 1 to 999999, for none and for too many.
    """
    try:
        found = tuple(itertools.islice(map(operator.index, frames), MOST_FRAMES + 1))
    except TypeError:
        found = ()
    if not (0 < len(found) <= MOST_FRAMES and 1 <= min(found) <= max(found) <= LAST_FRAME):
        arrived, cure = (repr(frames)[:80], "range(1, 25)") if said is None else (said, "1-24")
        rule = f"at most {MOST_FRAMES} frames, numbered from 1 to {LAST_FRAME}"
        raise InputError(where, arrived, rule, f"try {cure}")
    return tuple(dict.fromkeys(found))


def frame_path(pattern: str | Path, frame: int) -> Path:
    """Path of one frame's file. Raises InputError for what is no pattern, or a frame below 0."""
    check_pattern(pattern)
    if frame < 0:
        raise InputError("frame", frame, "0 or more", "frames count from 1")
    path = Path(pattern)
    return path.with_name(path.name.replace(PLACEHOLDER, f"{frame:04d}"))


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
