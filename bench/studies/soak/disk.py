"""What disk do the frames of a round lie on, and how is it made small or read-only?"""

import contextlib
import os
import subprocess
import time
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path

_ROOM_KB = 8192
_BUSY_S = 10.0


@cache
def mounts() -> bool:
    """Say whether this process may mount disks of its own, by trying."""
    import tempfile

    if os.geteuid() != 0:
        return False
    with tempfile.TemporaryDirectory() as folder:
        command = ["mount", "-t", "tmpfs", "-o", "size=16k", "tmpfs", folder]
        if subprocess.run(command, capture_output=True).returncode:
            return False
        subprocess.run(["umount", folder], check=True)
    return True


@dataclass(frozen=True)
class Disk:
    """A small disk of its own, at a folder; nothing where ``folder`` is on the soak's own disk."""

    folder: Path | None = None

    def freeze(self) -> bool:
        """Make it read-only, as soon as no file is open for writing; gives whether it is."""
        deadline = time.monotonic() + _BUSY_S
        while self.folder is not None and time.monotonic() < deadline:
            if self._remount("ro"):
                return True
            time.sleep(0.001)
        return False

    def thaw(self) -> None:
        """Make it writable again."""
        if self.folder is not None:
            self._remount("rw")

    def heal(self) -> None:
        """Make it writable, with room for everything."""
        if self.folder is not None:
            self._remount(f"rw,size={_ROOM_KB}k")

    def _remount(self, how: str) -> bool:
        words = ["mount", "-o", f"remount,{how}", str(self.folder)]
        return subprocess.run(words, capture_output=True).returncode == 0


@contextlib.contextmanager
def small_disk(folder: Path, size_kb: int | None) -> Iterator[Disk]:
    """Mount a disk of so many kilobytes at a folder, for as long as the context lasts."""
    if size_kb is None or not mounts():
        yield Disk()
        return
    folder.mkdir(parents=True, exist_ok=True)
    size = f"size={size_kb}k"
    subprocess.run(["mount", "-t", "tmpfs", "-o", size, "tmpfs", str(folder)], check=True)
    try:
        yield Disk(folder)
    finally:
        subprocess.run(["umount", "--lazy", str(folder)], check=True)
