"""Files that are whole or not there, and that replace nobody else's work."""

import os
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from lod.errors import InputError
from scenes.render.files.disk import partial_path

_LOOKED_AT = 2**16


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
        _name(temporary, path, overwrite, where)
    finally:
        temporary.unlink(missing_ok=True)


def _name(temporary: Path, path: Path, overwrite: bool, where: str) -> None:
    """Give a file its name: by a link, which never replaces, where nothing may be replaced."""
    if not overwrite:
        with suppress(OSError):  # a name that is taken, or a file system without links
            os.link(temporary, path)
            return
        check_free(path, overwrite, where)
    os.replace(temporary, path)


def made_by_lodbench(path: str | Path) -> bool:
    """Say whether a file names lodbench near its beginning or its end, as all of ours do."""
    try:
        with Path(path).open("rb") as file:
            begin = file.read(_LOOKED_AT)
            file.seek(max(0, os.fstat(file.fileno()).st_size - _LOOKED_AT))
            return b"lodbench" in begin + file.read()
    except OSError:
        return False
