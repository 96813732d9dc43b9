"""Memory of this process: what it may take, and what it has held at most."""

import os
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import psutil

VARIABLE = "LODBENCH_MAX_MEMORY"
"""Environment variable of a limit for a command that renders in many ways, and its children."""

DEFAULT_SHARE = 0.8
"""Of the memory that is free, what a command takes at most unless it is told otherwise."""


@dataclass(frozen=True)
class MemoryLimit:
    """Bytes that this process may hold; None = as many as it needs. ``told``: in words."""

    bytes: int | None
    told: str = ""


def memory_limit(most: int | None = None) -> MemoryLimit:
    """Make the limit that --max-memory sets: bytes, 0 for no limit, None for the default.

    The default is what the environment's ``LODBENCH_MAX_MEMORY`` says in bytes; without it
    DEFAULT_SHARE of what is free, and what the process holds already counts as free.
    """
    told = os.environ.get(VARIABLE, "")
    if most is None and told.isdecimal():
        most = int(told)
    if most == 0:
        return MemoryLimit(None)
    if most is not None:
        return MemoryLimit(most, size_text(most))
    free = free_bytes() + psutil.Process().memory_info().rss
    allowed = round(DEFAULT_SHARE * free)
    return MemoryLimit(allowed, f"{size_text(allowed)}, {DEFAULT_SHARE:.0%} of what is free")


def size_text(size: float) -> str:
    """Write bytes in MB or GB with three digits, as ``1 MB`` or ``2.51 GB``."""
    if size < 1e9:
        return f"{size / 1e6:.3g} MB"
    return f"{size / 1e9:.3g} GB" if size < 1e12 else f"{size / 1e9:,.0f} GB"


_CGROUPS = Path("/sys/fs/cgroup")
_OWN = Path("/proc/self/cgroup")


def free_bytes(cgroups: Path = _CGROUPS, own: Path = _OWN) -> int:
    """Memory that this process may take without any other giving up some [bytes].

    The least of what the machine has available and of what is left of each limit on the control
    groups that the process is in (version 1 or 2), whose file caches count as free, and of its own
    limit on data (``ulimit -d``, Linux).
    """
    left = [int(psutil.virtual_memory().available), *_left_of_groups(cgroups, own)]
    return max(min([*left, *_left_of_data()]), 0)


def _left_of_data() -> Iterator[int]:
    if sys.platform.startswith("linux"):
        import resource

        most, _ = resource.getrlimit(resource.RLIMIT_DATA)
        if most != resource.RLIM_INFINITY:
            yield most - _of_status("VmData")


def _of_status(name: str) -> int:
    """Bytes that Linux has under a name of this process's status; 0 where it has none."""
    rows = _text(Path("/proc/self/status")).splitlines()
    return next((int(row.split()[1]) * 1024 for row in rows if row.startswith(name)), 0)


def _left_of_groups(cgroups: Path, own: Path) -> Iterator[int]:
    for line in _text(own).splitlines():
        _, controllers, path = line.split(":", 2)
        if controllers == "":
            root, names = cgroups, ("memory.max", "memory.current", "inactive_file")
        elif "memory" in controllers.split(","):
            root = cgroups / "memory"
            names = ("memory.limit_in_bytes", "memory.usage_in_bytes", "total_inactive_file")
        else:
            continue
        # In a container the path may be the host's, of which only the root is mounted.
        group = root / path.lstrip("/")
        for folder in (group, *group.parents):
            limit, used = (_text(folder / name).strip() for name in names[:2])
            if limit.isdecimal() and used.isdecimal():
                rows = (line.split() for line in _text(folder / "memory.stat").splitlines())
                cached = next((int(value) for key, value in rows if key == names[2]), 0)
                yield int(limit) - int(used) + cached
            if folder == root:
                break


def _text(path: Path) -> str:
    try:
        return path.read_text(encoding="ascii", errors="replace")
    except OSError:
        return ""


def peak_rss_bytes() -> int:
    """Most memory that this process has held [bytes]; 0 where the system does not say.

    On Linux ``ru_maxrss`` would start from what the process held that started it.
    """
    if held := _of_status("VmHWM"):
        return held
    try:
        import resource
    except ImportError:
        return 0
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return peak if sys.platform == "darwin" else peak * 1024
