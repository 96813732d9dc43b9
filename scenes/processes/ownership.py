"""Ownership of a folder by processes of one kind, which ends with the process that has it.

Every owner has a shared lock on FOLDER/.lodbench/owner, whose text says of what group they are and
who came first. The text is written under a lock of one alone, which nobody gets while someone owns
the folder; whoever then reads another group's text withdraws, and after a while of trying is
refused. So no two groups are ever inside at once. Where a file system has no locks (some of FUSE,
9p), nobody is kept out, and each owner says so.
"""

import contextlib
import errno
import fcntl
import json
import os
import random
import socket
import time
from collections.abc import Callable, Iterator
from pathlib import Path

from lod.errors import InputError

NAME = ".lodbench"
_PATIENCE_S = 1.0  # for those that are themselves about to withdraw


@contextlib.contextmanager
def owned(
    folder: Path, group: str, does: str, note: Callable[[str], object] = lambda text: None
) -> Iterator[None]:
    """Own a folder, together with processes of the same group alone.

    Raises InputError where another group ``does`` something there, and OSError where the folder
    cannot be written to. ``note`` is told where there are no locks.
    """
    path = folder / NAME / "owner"
    start = time.monotonic()
    while True:
        handle = _open(path)
        try:
            there, who = _enter(handle, path, group)
            if not there:
                note(f"lodbench: {folder} has no locks ({who}): nobody else is kept out of it")
            if there in ("", group):
                yield
                return
        finally:
            _leave(handle, path)
        if time.monotonic() - start > _PATIENCE_S:
            cure = "wait for its end, or choose another folder"
            raise InputError("folder", str(folder), f"{who} {does}", cure)
        time.sleep(random.uniform(0.01, 0.1))  # so that of two that came at once one is alone


def _open(path: Path) -> int:
    while True:
        with contextlib.suppress(FileExistsError):
            path.parent.mkdir()
        with contextlib.suppress(FileNotFoundError):  # someone else removed the empty folder
            return os.open(path, os.O_RDWR | os.O_CREAT, 0o666)


def _enter(handle: int, path: Path, group: str) -> tuple[str, str]:
    """Take the locks and give whose group is there and who; "" and why, where none can be had."""
    me = f"process {os.getpid()} on {socket.gethostname()}"
    try:
        with contextlib.suppress(BlockingIOError):
            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
            os.ftruncate(handle, 0)
            os.pwrite(handle, json.dumps([group, me]).encode(), 0)
        # Another may get the lock here, and write: so the text counts that stands afterwards.
        fcntl.flock(handle, fcntl.LOCK_SH | fcntl.LOCK_NB)
    except BlockingIOError:
        return "another", "another process"
    except OSError as error:
        if error.errno not in (errno.ENOSYS, errno.ENOLCK, errno.EOPNOTSUPP, errno.EINVAL):
            raise
        return "", str(error.strerror)
    with contextlib.suppress(OSError, ValueError, TypeError):  # gone, or its writer died at it
        if os.path.samestat(os.fstat(handle), path.stat()):
            there, who = json.loads(os.pread(handle, os.fstat(handle).st_size, 0))
            return there, who
    return "another", "another process"


def _leave(handle: int, path: Path) -> None:
    """Give the locks back; the last one removes the file, and the folder if it is empty."""
    with contextlib.suppress(OSError):
        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
        if os.path.samestat(os.fstat(handle), path.stat()):
            path.unlink()
            path.parent.rmdir()
    os.close(handle)
