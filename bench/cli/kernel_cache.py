"""Where does a command keep the compiled kernels, so that none of other sources is ever used?

Numba keeps what it compiled in files, and compares only the file that defines a kernel with the
one that was compiled. After a change elsewhere it goes on using machine code that holds the old
functions of other files, or dies because a type that the kept signature names is gone. Commands
therefore keep their kernels in a folder that is named for the digest of all sources: other sources
find it empty and compile again. The environment's ``NUMBA_CACHE_DIR`` has precedence where it can
hold kernels.
"""

import atexit
import errno
import os
import shutil
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path

import click

from lod.errors import InputError
from scenes.processes.cache import PACKAGES, cache_folders, make_writable, source_digest

VARIABLE = "NUMBA_CACHE_DIR"
_ROOM_BYTES = 2**25
"""Room that an empty folder must have: all kernels take 9 MB, and Numba fails where it runs out."""

_TEMPORARY = ".lodbench-"
KEPT = 8  # folders of as many states of the sources are kept, the last used ones


def use_kernel_cache(parents: Sequence[Path] | None = None) -> None:
    """Set ``NUMBA_CACHE_DIR`` for this process, if Numba is not imported yet, and its children.

    ``parents`` are the folders that may hold it, the first writable one is taken; None for those of
    the program's cache. Where none is writable, one line on standard error says so, and kernels are
    kept in a temporary folder until the process ends; raises InputError where none can be made.
    """
    if "numba" in sys.modules:
        return
    if named := os.environ.pop(VARIABLE, None):
        try:
            _make_usable(Path(named))
            os.environ[VARIABLE] = named
            return
        except OSError as error:
            why = f"it cannot hold compiled kernels ({error.strerror})"
            click.echo(f"lodbench: {VARIABLE}={named}: {why}", err=True)
    name = f"kernels-{source_digest(PACKAGES)[:16]}"
    said = []
    for parent in cache_folders() if parents is None else parents:
        try:
            make_writable(parent)
            _make_usable(parent / name)
            os.utime(parent / name)  # marks it as used
            kernels = sorted(parent.glob("kernels-*"), key=lambda each: each.stat().st_mtime)
            for old in kernels[:-KEPT]:
                shutil.rmtree(old, ignore_errors=True)
            os.environ[VARIABLE] = str(parent / name)
            return
        except OSError as error:
            said.append(f"{parent}: {error.strerror}")
    try:
        folder = tempfile.mkdtemp(prefix=_TEMPORARY)
    except OSError:
        rule = "a folder for temporary files that can be written to"
        raise InputError("TMPDIR", os.environ.get("TMPDIR"), rule, "set it to one") from None
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    os.environ[VARIABLE] = folder
    click.echo(
        "lodbench: no writable folder for compiled kernels: they are compiled for this run only"
        f" ({'; '.join(said)}; {VARIABLE} names a folder)",
        err=True,
    )


def kernel_cache_state() -> dict[str, str | bool | None]:
    """Say for ``doctor`` where kernels are kept, and whether longer than this process."""
    folder = os.environ.get(VARIABLE)
    kept = folder is not None and not Path(folder).name.startswith(_TEMPORARY)
    return {"folder": folder, "kept": kept}


def is_first_run() -> bool:
    """Tell whether no kernel is kept yet, so that the first step of a command compiles them all."""
    folder = os.environ.get(VARIABLE)
    return not folder or next(Path(folder).rglob("*.nbi"), None) is None


def _make_usable(folder: Path) -> None:
    """Make a folder for kernels. Raises OSError where it cannot be written to or will not do."""
    make_writable(folder)
    if not any(folder.iterdir()) and shutil.disk_usage(folder).free < _ROOM_BYTES:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), str(folder))
