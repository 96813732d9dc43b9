"""Ownership of a folder by processes of one kind, which ends with the process that has it.

Whoever wants a folder makes a file of its own in FOLDER/.lodbench, and only then looks at those of
others: of two that come at once at least one sees the other. Whoever sees an owner of another group
withdraws its file, and after a while of trying is refused. So no two groups are ever inside at
once, without any order among them.

The file is locked while its process lives, and its text changes every BEAT_S. A lock that is
refused proves life, on any file system. One that is granted proves death only where the file was
made by this system through this mount: there are file systems without locks (9p, FUSE), and some
that grant each machine its own (sshfs). Elsewhere an owner is dead when its text has not changed
for SILENCE_S, by the clock of whoever watches it, whatever the clocks of others say.
"""

import contextlib
import fcntl
import json
import os
import random
import socket
import threading
import time
import uuid
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, NamedTuple

from lod.errors import InputError

NAME = ".lodbench"
BEAT_S = 5.0
SILENCE_S = 30.0
TOLD_S = 10.0
_LOOK_S = 0.1
_PATIENCE_S = 1.0
"""For owners that are themselves about to withdraw."""

_BYTES = 640
"""Every text is as long, so that no reader sees half of a longer one."""


class Owner(NamedTuple):
    """Who owns a folder.

    group   what other owners must share, to stand beside it
    system  this start of the machine, and ``mount`` the file system's number on it
    """

    group: str
    host: str
    process: int
    system: str
    mount: int


class Owned(Exception):
    """Another process owns the folder; ``owner`` says which."""

    def __init__(self, owner: Owner) -> None:
        super().__init__(f"process {owner.process} on {owner.host}")
        self.owner = owner


@contextlib.contextmanager
def owned(
    folder: Path, group: str, does: str, note: Callable[[str], object] = lambda text: None
) -> Iterator[None]:
    """Own a folder as ``ownership`` does; raise InputError where another ``does`` something there.

    Raises OSError where the folder cannot be written to.
    """
    with contextlib.ExitStack() as stack:
        try:
            stack.enter_context(ownership(folder, group, note))
        except Owned as other:
            cure = "wait for its end, or choose another folder"
            raise InputError("folder", str(folder), f"{other} {does}", cure) from None
        yield


@contextlib.contextmanager
def ownership(
    folder: Path, group: str, note: Callable[[str], object] = lambda text: None
) -> Iterator[None]:
    """Own a folder, together with processes of the same group alone.

    ``note`` is told of an owner that is watched for TOLD_S. Raises Owned where another group owns
    it, and OSError where the folder cannot be written to.
    """
    since = time.monotonic()
    while True:
        with _made(folder, group) as (mine, beating):
            other = next(_others(mine, group), None)
            if other is None:
                with beating:
                    yield
                return
        if time.monotonic() - since > _PATIENCE_S and (owner := _alive(other, note)):
            raise Owned(owner)
        time.sleep(random.uniform(0.01, 0.1))  # so that of two that came at once one is alone


@contextlib.contextmanager
def _made(
    folder: Path, group: str
) -> Iterator[tuple[Path, contextlib.AbstractContextManager[None]]]:
    """Make this process's file, whose name nobody sees before it is locked and has its text."""
    path = folder / NAME / f"{uuid.uuid4().hex}.owner"
    temporary = path.with_suffix(".new")
    handle = None
    while handle is None:
        with contextlib.suppress(FileExistsError):
            path.parent.mkdir()
        with contextlib.suppress(FileNotFoundError):  # someone else removed the empty folder
            handle = os.open(temporary, os.O_RDWR | os.O_CREAT | os.O_EXCL, 0o666)
    try:
        _lock(handle)
        mount = os.fstat(handle).st_dev
        owner = Owner(group, socket.gethostname()[:200], os.getpid(), _system(), mount)
        _write(handle, owner, 0)
        os.rename(temporary, path)
        yield path, _beating(handle, owner)
    finally:
        for each in (temporary, path):
            with contextlib.suppress(OSError):
                each.unlink()
        with contextlib.suppress(OSError):
            os.close(handle)
        with contextlib.suppress(OSError):
            path.parent.rmdir()  # which only succeeds if it is empty


def _write(handle: int, owner: Owner, beat: int) -> None:
    text = json.dumps({**owner._asdict(), "beat": beat})
    os.pwrite(handle, text.encode().ljust(_BYTES), 0)


@contextlib.contextmanager
def _beating(handle: int, owner: Owner) -> Iterator[None]:
    """Change the text now and then until the end of the context, whatever the process does."""
    ended = threading.Event()

    def beat() -> None:
        count = 0
        while not ended.wait(BEAT_S):
            count += 1
            with contextlib.suppress(OSError):
                _write(handle, owner, count)
                os.fsync(handle)  # or other machines would not see it

    thread = threading.Thread(target=beat, daemon=True, name="lodbench-owner")
    thread.start()
    try:
        yield
    finally:
        ended.set()
        thread.join()


def _others(mine: Path, group: str) -> Iterator[Path]:
    """Find the files of other groups; those of the dead are removed on the way."""
    # A change to a folder makes network file systems look at it again.
    probe = mine.parent / f"{uuid.uuid4().hex}.new"
    os.close(os.open(probe, os.O_CREAT | os.O_EXCL))
    probe.unlink()
    for path in sorted(mine.parent.iterdir()):
        if path.suffix == ".new":  # its maker is at it, or died
            with contextlib.suppress(FileNotFoundError):
                if time.time() - path.stat().st_mtime > SILENCE_S and not _is_locked(path):
                    path.unlink()
        elif path != mine and path.is_file():
            found = _read(path)
            if found and not _is_proven_dead(path, found[1]) and found[1].group != group:
                yield path


def _alive(path: Path, note: Callable[[str], object]) -> Owner | None:
    """Give an owner that shows life, if need be after watching it; None of others."""
    first, start, told = _read(path), time.monotonic(), False
    while first and not _is_proven_dead(path, first[1]):
        if _is_locked(path):
            return first[1]
        time.sleep(_LOOK_S)
        now = _read(path)
        if now and now[0] != first[0]:
            return now[1]
        if not told and (told := time.monotonic() - start > TOLD_S):
            who = f"{Owned(first[1])} owns {path.parent.parent} and may be dead"
            note(f"lodbench: {who}: waiting for a sign of life, {SILENCE_S:g} s at most")
        if now is None or time.monotonic() - start > SILENCE_S:
            path.unlink(missing_ok=True)
            return None
    return None


def _read(path: Path) -> tuple[bytes, Owner] | None:
    """Read a file's text and owner; None where it is gone, or its writer died before a word."""
    try:
        text = path.read_bytes()
        data: dict[str, Any] = json.loads(text)
        del data["beat"]
        return text, Owner(**data)
    except FileNotFoundError:
        return None
    except (ValueError, TypeError, KeyError):
        return b"", Owner("", "unknown", 0, "", 0)


def _is_locked(path: Path) -> bool:
    return _looked_at(path)[0] is False


def _is_proven_dead(path: Path, owner: Owner) -> bool:
    """Say whether an owner is dead for sure, or gone, and remove its file."""
    locks, mount = _looked_at(path)
    if dead := locks is True and (_system(), mount) == (owner.system, owner.mount):
        path.unlink(missing_ok=True)
    return dead or mount == 0


def _looked_at(path: Path) -> tuple[bool | None, int]:
    """Whether a file can be locked (``_lock``), and its mount; None and 0 where it is gone."""
    try:
        handle = os.open(path, os.O_RDWR)
    except FileNotFoundError:
        return None, 0
    try:
        return _lock(handle), os.fstat(handle).st_dev
    finally:
        os.close(handle)


def _lock(handle: int) -> bool | None:
    """Lock an open file: whether that succeeds; None where the file system has no locks."""
    try:
        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    except OSError:
        return None
    return True


def _system() -> str:
    """Name this start of this machine."""
    with contextlib.suppress(OSError):
        return Path("/proc/sys/kernel/random/boot_id").read_text(encoding="ascii").strip()
    return socket.gethostname()
