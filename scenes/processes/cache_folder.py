"""Where may the program keep what it would otherwise make again: one folder for one user."""

import os
from collections.abc import Iterator
from pathlib import Path

import platformdirs

VARIABLE = "LODBENCH_CACHE"


def cache_folders() -> Iterator[Path]:
    """Yield the folders that may hold the cache, the preferred one first; they may not exist yet.

    The environment's ``LODBENCH_CACHE`` names the only one. Otherwise it is the user's, where the
    system keeps caches, and then the folder of the installation's compiled files, for users who
    have no home or may not write there.
    """
    if named := os.environ.get(VARIABLE):
        yield Path(named).absolute()
        return
    users = platformdirs.user_cache_path("lodbench", appauthor=False)
    if users.is_absolute():  # it is not for a user without a home
        yield users
    yield Path(__file__).resolve().parent / "__pycache__" / "lodbench"


def make_writable(folder: Path) -> None:
    """Make the folder, or raise OSError where no file can be written into it."""
    import tempfile

    folder.mkdir(parents=True, exist_ok=True)
    tempfile.TemporaryFile(dir=folder).close()
