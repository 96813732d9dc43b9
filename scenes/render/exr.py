"""Layers to and from OpenEXR files: one part, ZIP, nothing in the header but what made the pixels.

Channels: half R G B (linear Rec.709), float Z [m], half N.X N.Y N.Z, half albedo.R albedo.G
albedo.B, uint id.object id.part id.level. Also float A, 1 everywhere: Mitsuba's reader gives every
layer the type of the first by name, and Z and ids would overflow as halves. The only file that
imports OpenEXR.
"""

import contextlib
import errno
import hashlib
import os
import sys
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import OpenEXR

from lod.errors import InputError
from scenes.render.frame import Layers

REC709 = (0.64, 0.33, 0.30, 0.60, 0.15, 0.06, 0.3127, 0.3290)
_HALF_MAX = 65504.0

_CHANNELS: dict[str, tuple[str, int | None, type]] = {
    **{name: ("rgb", i, np.float16) for i, name in enumerate("RGB")},
    "Z": ("Z", None, np.float32),
    **{f"N.{name}": ("N", i, np.float16) for i, name in enumerate("XYZ")},
    **{f"albedo.{name}": ("albedo", i, np.float16) for i, name in enumerate("RGB")},
    **{f"id.{name}": (name, None, np.uint32) for name in ("object", "part", "level")},
}
"""Name in the file: field of Layers, which component, pixel type."""


def write_exr(
    path: str | Path,
    layers: Layers,
    header: Mapping[str, Any],
    before_rename: Callable[[str], object] = lambda digest: None,
) -> str:
    """Write under a temporary name in the same folder, then rename; gives the file's SHA-256.

    ``header`` holds strings, floats, fractions and float32 matrices; ``before_rename`` gets the
    hash. Raises OSError where the disk refuses; whatever stood at ``path`` is then untouched.
    """
    path = Path(path)
    temporary = path.with_name(f".{path.name}.{os.getpid()}.part")
    try:
        temporary.touch(exist_ok=False)  # the system's own error, where it cannot be
        _write(temporary, layers, header)
        digest = _settle(temporary)
        before_rename(digest)
        os.replace(temporary, path)
    finally:
        temporary.unlink(missing_ok=True)
    sync_folder(path.parent)
    return digest


def _write(path: Path, layers: Layers, header: Mapping[str, Any]) -> None:
    fixed = {
        "compression": OpenEXR.ZIP_COMPRESSION,
        "type": OpenEXR.scanlineimage,
        "chromaticities": REC709,
    }
    channels = {name: OpenEXR.Channel(_pixels(layers, name)) for name in _CHANNELS}
    channels["A"] = OpenEXR.Channel(np.ones_like(layers.Z))
    try:
        with _stdout_to_stderr():
            OpenEXR.File({**header, **fixed}, channels).write(str(path))
    except (RuntimeError, ValueError) as error:
        raise OSError(errno.EIO, f"cannot be written as OpenEXR ({error})", str(path)) from error


def _pixels(layers: Layers, name: str) -> np.ndarray:
    field, component, dtype = _CHANNELS[name]
    values = getattr(layers, field)
    values = values if component is None else values[..., component]
    if dtype is np.float16:
        values = np.clip(values, -_HALF_MAX, _HALF_MAX)
    return np.ascontiguousarray(values, dtype=dtype)


def _settle(path: Path) -> str:
    """Have the system keep the file, and hash what it kept."""
    with path.open("r+b") as file:
        digest = hashlib.file_digest(file, "sha256").hexdigest()
        os.fsync(file.fileno())
    return digest


def sync_folder(folder: Path) -> None:
    """Have the system keep a rename; some file systems cannot, and that is no harm."""
    with contextlib.suppress(OSError):
        handle = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(handle)
        finally:
            os.close(handle)


def read_exr(path: str | Path) -> tuple[Layers, dict[str, Any]]:
    """A frame's layers and header. Raises InputError for a file that is not one of ours."""
    if not Path(path).is_file():
        raise InputError("frame", str(path), "an EXR file that exists")
    try:
        with _stdout_to_stderr():
            file = OpenEXR.File(str(path), separate_channels=True)
            pixels = {name: channel.pixels for name, channel in file.channels().items()}
            header = dict(file.header())
    except (RuntimeError, ValueError) as error:
        raise InputError("frame", str(path), f"readable OpenEXR ({error})") from error
    missing = sorted(set(_CHANNELS) - set(pixels))
    if missing:
        raise InputError("frame", str(path), f"every layer of lodbench; missing {missing[0]}")
    return Layers(**_fields(pixels)), header


def _fields(pixels: Mapping[str, np.ndarray]) -> dict[str, Any]:
    columns: dict[str, list[np.ndarray]] = {}
    for name, (field, _, _) in _CHANNELS.items():
        columns.setdefault(field, []).append(pixels[name])
    return {k: v[0] if len(v) == 1 else np.stack(v, axis=-1) for k, v in columns.items()}


@contextlib.contextmanager
def _stdout_to_stderr() -> Iterator[None]:
    """OpenEXR prints warnings to stdout, from Python and from C; it belongs to --json."""
    sys.stdout.flush()
    kept = os.dup(1)
    try:
        os.dup2(2, 1)
        with contextlib.redirect_stdout(sys.stderr):
            yield
    finally:
        os.dup2(kept, 1)
        os.close(kept)
