"""What a disk refuses, in words; names of files that are not finished."""

import errno
import os
import socket
from collections.abc import Iterator
from pathlib import Path

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
