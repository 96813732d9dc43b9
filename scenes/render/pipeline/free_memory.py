"""How much memory may this process still take, of the machine and of the container it is in?"""

from collections.abc import Iterator
from pathlib import Path

import psutil

_CGROUPS = Path("/sys/fs/cgroup")
_OWN = Path("/proc/self/cgroup")


def free_bytes(cgroups: Path = _CGROUPS, own: Path = _OWN) -> int:
    """Memory that this process may take without any other giving up some [bytes].

    The least of what the machine has available and of what is left of each limit on the control
    groups that the process is in (version 1 or 2), whose file caches count as free.
    """
    left = [int(psutil.virtual_memory().available), *_left_of_groups(cgroups, own)]
    return max(min(left), 0)


def _left_of_groups(cgroups: Path, own: Path) -> Iterator[int]:
    """Yield what is left of each group's limit, from the process's own group up to the root."""
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
                yield int(limit) - int(used) + _cached(folder / "memory.stat", names[2])
            if folder == root:
                break


def _cached(statistics: Path, name: str) -> int:
    rows = (line.split() for line in _text(statistics).splitlines())
    return next((int(value) for key, value in rows if key == name), 0)


def _text(path: Path) -> str:
    try:
        return path.read_text(encoding="ascii", errors="replace")
    except OSError:
        return ""
