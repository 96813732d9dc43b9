"""Keep arrays that are dear to make and depend on nothing but their key, from one run to the next.

``kept`` looks for an entry, and makes the arrays where there is none that can be used. An entry is
one file, named for the hash of its key, of the sources that make it and of the versions of NumPy
and Python, so that nothing old is ever found. It is written beside its place and renamed: whole or
not there, whoever else writes it at the same time, for two makers make the same. A checksum stands
over all its bytes; what is damaged is made again. Nothing needs the cache: where no folder can be
written to, everything is made each time.
"""

import functools
import os
import platform
import shutil
import time
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from scenes.processes.array_file import (
    FORMAT,
    UNFINISHED,
    Arrays,
    decode_arrays,
    encode_arrays,
    read_only,
    write_array_file,
)
from scenes.processes.cache_folder import cache_folders, make_writable
from scenes.processes.content_key import content_key
from scenes.processes.source_digest import ROOT, source_digest

LIMIT_BYTES = 2 * 2**30
"""Size above which the entries that were used longest ago are removed."""

_SUBFOLDER, _SUFFIX = "arrays", ".arrays"
_ABANDONED = 24 * 3600.0  # seconds after which a file that nobody finished is removed


@dataclass(frozen=True)
class CacheContent:
    """What a cache folder holds of one kind: how many entries, and their size [byte]."""

    kind: str
    entries: int
    size_bytes: int


def kept(
    kind: str, key: str, make: Callable[[], Arrays], code: Sequence[str] = ("lod", "scenes")
) -> Arrays:
    """Give the arrays that ``make`` makes, by name and read-only, from the cache where they are.

    ``kind`` is a word for people, such as ``tree``. ``key`` says everything on which the arrays
    depend, but for the code: use ``content_key`` to write one. ``code`` names the packages or files
    of this project, dotted, whose Python, TOML and CSV files take part in the making; a change of
    any makes the arrays anew. By default these are all of the two rooms, which is always right.
    Name less only for what takes minutes to make, and then everything that ``make`` calls or reads.
    Raises TypeError for arrays of Python objects, which no file holds.
    """
    name = Path(_SUBFOLDER, kind, f"{_entry_hash(kind, key, tuple(code))}{_SUFFIX}")
    for folder in cache_folders():
        with suppress(OSError, ValueError, KeyError, TypeError):
            arrays = decode_arrays(np.fromfile(folder / name, np.uint8))
            with suppress(OSError):
                os.utime(folder / name)
            return arrays
    arrays = {each: read_only(values) for each, values in make().items()}
    encoded = encode_arrays(arrays)
    for folder in cache_folders() if sum(map(len, encoded)) <= LIMIT_BYTES else ():
        with suppress(OSError):
            write_array_file(folder / name, encoded)
            _remove_oldest(folder)
            break
    return arrays


def writable_cache() -> Path | None:
    """Give the folder in which entries are kept; None where there is none."""
    for folder in cache_folders():
        with suppress(OSError):
            make_writable(folder)
            return folder
    return None


def cache_contents(folder: Path) -> list[CacheContent]:
    """List what a cache folder holds by kind, with the kernels that Numba keeps beside it."""
    sizes: dict[str, list[int]] = {}
    for path, size, _ in _entries(folder):
        sizes.setdefault(path.parent.name, []).append(size)
    found = [CacheContent(kind, len(each), sum(each)) for kind, each in sorted(sizes.items())]
    kernels = [_size(path) for path in folder.glob("kernels-*/**/*") if path.is_file()]
    return [*found, *([CacheContent("kernels", len(kernels), sum(kernels))] if kernels else [])]


def clear_cache(folder: Path) -> None:
    """Remove all entries and kernels of a cache folder, and nothing else that lies there."""
    shutil.rmtree(folder / _SUBFOLDER, ignore_errors=True)
    for path in folder.glob("kernels-*/**/*"):  # folders stay: a process may be writing there
        with suppress(OSError):
            path.unlink()


@functools.cache
def _code_digest(code: tuple[str, ...]) -> str:
    paths = [ROOT.joinpath(*name.split(".")) for name in code]
    found = [path if path.is_dir() else path.with_suffix(".py") for path in paths]
    if missing := [str(path) for path in found if not path.exists()]:
        raise ValueError(f"no source of this project: {', '.join(missing)}")
    return source_digest(found)


def _entry_hash(kind: str, key: str, code: tuple[str, ...]) -> str:
    made_by = (np.__version__, platform.python_version(), platform.machine(), _code_digest(code))
    return content_key(FORMAT.decode(), kind, key, made_by)[:40]


def _size(path: Path) -> int:
    with suppress(OSError):
        return path.stat().st_size
    return 0


def _entries(folder: Path) -> list[tuple[Path, int, float]]:
    """List the entries of a cache folder: file, size [byte], and when it was last used [s]."""
    found = []
    for path in (folder / _SUBFOLDER).glob(f"*/*{_SUFFIX}"):
        with suppress(OSError):
            state = path.stat()
            found.append((path, state.st_size, state.st_mtime))
    return found


def _remove_oldest(folder: Path) -> None:
    """Remove the entries used longest ago until the rest is within the limit, and old remains."""
    total = 0
    for path, size, _ in sorted(_entries(folder), key=lambda each: -each[2]):
        total += size
        if total > LIMIT_BYTES:
            with suppress(OSError):
                path.unlink()
    for path in (folder / _SUBFOLDER).glob(f"*/*{UNFINISHED}"):
        with suppress(OSError):
            if path.stat().st_mtime < time.time() - _ABANDONED:
                path.unlink()
