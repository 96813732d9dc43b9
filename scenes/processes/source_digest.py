"""Which sources is the program made of: one digest of the bytes of its files."""

import functools
import hashlib
from collections.abc import Iterable
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PACKAGES = tuple(ROOT / name for name in ("lod", "scenes", "bench"))


def source_digest(paths: Iterable[Path]) -> str:
    """Give the SHA-256 [hex] of the Python, TOML and CSV files at or below the paths, and names.

    A path that is no folder is read as a file, if its suffix is one of the three.
    """
    return hashlib.sha256("".join(map(_digest, paths)).encode()).hexdigest()


@functools.cache
def _digest(place: Path) -> str:
    """Digest one folder or file: what a process runs is what was there when it began."""
    digest = hashlib.sha256()
    for path in sorted(place.rglob("*")) if place.is_dir() else [place]:
        if path.suffix in (".py", ".toml", ".csv"):
            name = path.relative_to(place.parent)
            digest.update(f"{name}\n".encode() + path.read_bytes())
    return digest.hexdigest()
