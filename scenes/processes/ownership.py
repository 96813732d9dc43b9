"""Claims of processes on a folder: who works there, known to all, and gone with whoever made them.

A claim is a file of its own in FOLDER/.lodbench, so nobody ever writes into that of another. It is
locked while its process lives, and its text changes every BEAT_S. As in Lamport's bakery (1974)
whoever makes one first shows that it chooses a ticket, then takes a higher one than all that it
sees, and gives way to lower tickets: by waiting, or by being refused. The ticket is in the file's
name, which changes at once for all.

A lock that is refused proves life, on any file system. One that is granted proves death only where
the claim was made by this system through this mount: there are file systems without locks (9p,
FUSE), and some that grant each machine its own (sshfs). Elsewhere a claim is dead when its text has
not changed for SILENCE_S, by the clock of whoever watches it, whatever the clocks of others say.
"""

import contextlib
import fcntl
import itertools
import json
import os
import re
import socket
import threading
import time
import uuid
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from pathlib import Path

NAME = ".lodbench"
BEAT_S = 5.0
SILENCE_S = 30.0
_LOOK_S = 0.1
_PAUSE_S = 0.02
_PATIENCE_S = 1.0  # for claims that are themselves being refused
_CHOOSING = ".choosing."
_DIGITS = 12
_TICKET = re.compile(rf"\d{{{_DIGITS}}}\.")
_BYTES = 640
"""Every text is as long, so that no reader sees half of a longer one."""


@dataclass(frozen=True)
class Holder:
    """Who made a claim.

    group   what the claims of others must share, to stand beside it
    system  this start of the machine, and ``mount`` the file system's number on it
    """

    group: str
    host: str
    process: int
    system: str
    mount: int


class Claimed(Exception):
    """Another process holds the folder; ``holder`` says which."""

    def __init__(self, holder: Holder) -> None:
        super().__init__(f"process {holder.process} on {holder.host}")
        self.holder = holder


@contextlib.contextmanager
def claim(folder: Path, what: str, group: str = "", wait: bool = False) -> Iterator[None]:
    """Hold a folder for some purpose, together with claims for it of the same group alone.

    Without a group it is held alone. Where another group's claim stands, raises Claimed, or waits
    until that is gone. Raises OSError where the folder cannot be written to.
    """
    group = group or uuid.uuid4().hex
    with _made(folder, what, group) as mine, mine.beating():
        since = time.monotonic()
        while (path := _first_before(mine, what, group)) is not None:
            holder = _alive(path)
            if holder is not None and not wait and time.monotonic() - since > _PATIENCE_S:
                raise Claimed(holder)
            time.sleep(_PAUSE_S)
        yield


class _Claim:
    """An open claim of this process."""

    def __init__(self, path: Path, handle: int, holder: Holder) -> None:
        self.path, self._handle, self._holder = path, handle, holder
        self._beats = itertools.count()
        self.beat()

    def beat(self) -> None:
        """Write the text anew: the same with another number."""
        text = json.dumps({**asdict(self._holder), "beat": next(self._beats)})
        os.pwrite(self._handle, text.encode().ljust(_BYTES), 0)

    @contextlib.contextmanager
    def beating(self) -> Iterator[None]:
        """Beat until the end of the context, whatever the process does meanwhile."""
        ended = threading.Event()

        def beat() -> None:
            while not ended.wait(BEAT_S):
                with contextlib.suppress(OSError):
                    self.beat()
                    os.fsync(self._handle)  # or other machines would not see it

        thread = threading.Thread(target=beat, daemon=True, name="lodbench-claim")
        thread.start()
        try:
            yield
        finally:
            ended.set()
            thread.join()


@contextlib.contextmanager
def _made(folder: Path, what: str, group: str) -> Iterator[_Claim]:
    """Make a claim, which nobody sees before it is locked; it is gone after the context."""
    name, path = uuid.uuid4().hex, folder / NAME
    temporary, choosing = path / f"{name}.new", path / f"{name}{_CHOOSING}{what}"
    handle, made = _create(temporary), None
    try:
        _lock(handle)
        host, mount = socket.gethostname()[:200], os.fstat(handle).st_dev
        made = _Claim(choosing, handle, Holder(group, host, os.getpid(), _system(), mount))
        os.rename(temporary, choosing)
        made.path = path / f"{_next_ticket(path):0{_DIGITS}d}.{name}.{what}"
        os.rename(choosing, made.path)
        yield made
    finally:
        for each in (temporary, choosing, *([made.path] if made else [])):
            with contextlib.suppress(OSError):
                each.unlink()
        with contextlib.suppress(OSError):
            os.close(handle)
        with contextlib.suppress(OSError):
            path.rmdir()  # which only succeeds if it is empty


def _create(path: Path) -> int:
    while True:
        with contextlib.suppress(FileExistsError):
            path.parent.mkdir()
        with contextlib.suppress(FileNotFoundError):  # someone else removed the empty folder
            return os.open(path, os.O_RDWR | os.O_CREAT | os.O_EXCL, 0o666)


def _first_before(mine: _Claim, what: str, group: str) -> Path | None:
    """Find the first claim of another group that this one gives way to, if there is any.

    What is left of dead processes is removed on the way.
    """
    for name in _listed(mine.path.parent):
        path = mine.path.with_name(name)
        if name.endswith(".new"):
            _remove_unfinished(path)
        before = _CHOOSING in name or name < mine.path.name
        if path != mine.path and name.endswith(f".{what}") and before:
            found = _read(path)
            if found is not None and found[1].group != group:
                return path
            if found is not None:
                _is_proven_dead(path, found[1])
    return None


def _listed(folder: Path) -> list[str]:
    """List a folder as it is now: a change to it makes network file systems look again."""
    probe = folder / f"{uuid.uuid4().hex}.new"
    os.close(os.open(probe, os.O_CREAT | os.O_EXCL))
    probe.unlink()
    return sorted(os.listdir(folder))


def _next_ticket(folder: Path) -> int:
    return 1 + max(
        (int(name[:_DIGITS]) for name in _listed(folder) if _TICKET.match(name)), default=0
    )


def _alive(path: Path) -> Holder | None:
    """Give the holder of a claim that shows life, if need be after watching it; None of others."""
    first, start = _read(path), time.monotonic()
    while first is not None and not _is_proven_dead(path, first[1]):
        if _is_locked(path):
            return first[1]
        time.sleep(_LOOK_S)
        now = _read(path)
        if now is not None and now[0] != first[0]:
            return now[1]
        if now is None or time.monotonic() - start > SILENCE_S:
            path.unlink(missing_ok=True)
            return None
    return None


def _read(path: Path) -> tuple[bytes, Holder] | None:
    """Read a claim's text and holder; None where it is gone, or its writer died before a word."""
    try:
        text = path.read_bytes()
        data = json.loads(text)
        del data["beat"]
        return text, Holder(**data)
    except FileNotFoundError:
        return None
    except (ValueError, TypeError, KeyError):
        return b"", Holder("", "unknown", 0, "", 0)


def _is_proven_dead(path: Path, holder: Holder) -> bool:
    """Say whether a claim's process is dead for sure, or gone, and remove its claim."""
    try:
        handle = os.open(path, os.O_RDWR)
    except FileNotFoundError:
        return True
    try:
        here = (_system(), os.fstat(handle).st_dev) == (holder.system, holder.mount)
        if dead := here and _lock(handle) is True:
            path.unlink(missing_ok=True)
        return dead
    finally:
        os.close(handle)


def _remove_unfinished(path: Path) -> None:
    """Remove what a process left that died while it made a claim."""
    with contextlib.suppress(FileNotFoundError):
        if time.time() - path.stat().st_mtime > SILENCE_S and not _is_locked(path):
            path.unlink()


def _is_locked(path: Path) -> bool:
    try:
        handle = os.open(path, os.O_RDWR)
    except FileNotFoundError:
        return False
    try:
        return _lock(handle) is False
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
