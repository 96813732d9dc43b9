"""Layers to and from OpenEXR files: nothing in the header but what made the pixels.

Channels: R G B (linear Rec.709), A (1 everywhere), albedo.R albedo.G albedo.B, float or half; float
Z [m], half N.X N.Y N.Z, uint id.object id.part detail.level; where asked for, float motion.X
motion.Y [px], denoised.R denoised.G denoised.B like R G B, and Cryptomatte's. One part, or a part
for each group of layers; a channel is called the same in both. What the right eye of a pair sees is
a second view (``multiView``). The only file that imports OpenEXR.

Types and names are such that every reader opens a float file by its plain call: OpenEXR's wants one
type for all of a layer; Mitsuba's gives all layers the type of the first by name (A), and takes any
layer of three channels for R G B or X Y Z, which is why the level is kept beside the other ids.

The header holds a hash of the pixels and one of its own file, which thereby tells alone whether it
is whole. Mattes of objects and species are by Cryptomatte's specification 1.2.0
(https://github.com/Psyop/Cryptomatte), ranked by coverage; the sky has no id and takes no rank.
"""

import contextlib
import errno
import hashlib
import json
import mmap
import os
from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any, BinaryIO, NamedTuple

import mmh3
import numpy as np
import OpenEXR

from lod.errors import InputError
from scenes.frame.layers import Layers, Mattes, add_coverage
from scenes.presets.schema import OutputPreset
from scenes.processes.streams import stdout_to_stderr

PIXELS_SHA256 = "lod:pixels_sha256"  # where a header holds ``pixels_digest`` of the file's channels

FILE_SHA256 = "lod:file_sha256"
"""Where the first header holds the SHA-256 of the whole file, taken with zeros for its digits."""

UNSEALED = "0" * 64
_MARK = FILE_SHA256.encode() + b"\0string\0" + len(UNSEALED).to_bytes(4, "little")


def pixels_digest(pixels: Mapping[str, np.ndarray]) -> str:
    """Hash the channels of a frame, (h, w) each, as they are in its file, to 64 hexadecimal digits.

    It is the SHA-256 of, for each channel in the order of the names' bytes: the name in UTF-8, a
    line feed, ``half``, ``float`` or ``uint``, a line feed, and the numbers in little-endian order,
    row by row from the top. Parts and compression do not count.
    """
    digest = hashlib.sha256()
    for name in sorted(pixels, key=str.encode):
        values = pixels[name]
        digest.update(f"{name}\n{_TYPES[values.dtype.name]}\n".encode())
        digest.update(values.astype(values.dtype.newbyteorder("<"), copy=False).tobytes())
    return digest.hexdigest()


def seal(path: str | Path) -> None:
    """Write a file's own hash over the zeros that its header holds in its place."""
    with open(path, "r+b") as file:
        at, digest = _own_digest(file)
        file.seek(at)
        file.write(digest.encode())


def is_sealed(path: str | Path) -> bool:
    """Whether every byte of a file is as it was when its hash was written into it."""
    with open(path, "rb") as file:
        if not os.fstat(file.fileno()).st_size:
            return False
        at, digest = _own_digest(file)
        file.seek(at)
        return file.read(len(UNSEALED)) == digest.encode()


def _own_digest(file: BinaryIO) -> tuple[int, str]:
    """Where the hash stands, and what it should be; nowhere is the end of the file."""
    with mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ) as data, memoryview(data) as view:
        found = data.find(_MARK)
        at = len(data) if found < 0 else found + len(_MARK)
        digest = hashlib.sha256(view[:at])
        digest.update(UNSEALED.encode())
        digest.update(view[at + len(UNSEALED) :])
    return at, digest.hexdigest()


_TYPES = {"float16": "half", "float32": "float", "uint32": "uint"}

TYPES = ("CryptoObject", "CryptoSpecies")
RANKS = 6  # ids in a pixel, those that cover most of it; the specification suggests six

MATTE_CHANNELS = tuple(
    f"{name}{rank // 2:02d}.{'rgba'[2 * (rank % 2) + i]}"
    for name in TYPES
    for rank in range(RANKS)
    for i in range(2)
)


def with_mattes(layers: Layers, names: Mapping[int, tuple[str, str]]) -> Layers:
    """Turn the coverage of layers into mattes; ``names``: of each object, its own and species'."""
    coverage = layers.coverage
    assert coverage is not None
    met = np.flatnonzero(coverage.object)
    objects, row = np.unique(coverage.object[met], return_inverse=True)
    channels: dict[str, np.ndarray] = {}
    attributes: dict[str, str] = {}
    for number, name in enumerate(TYPES):
        of_object = [names[each][number] for each in objects.tolist()]
        ids = {each: matte_id(each) for each in of_object}
        numbers = np.array([ids[each] for each in of_object], np.uint32)
        shares = add_coverage(coverage.pixel[met], numbers[row], coverage.share[met])
        # Ids and coverage of each pixel by rank, 0 where there are fewer.
        order = np.lexsort((shares.object, -shares.share, shares.pixel))
        pixel = shares.pixel[order]
        begins = np.flatnonzero(np.diff(pixel, prepend=-1))
        rank = np.arange(len(pixel)) - np.repeat(begins, np.diff(begins, append=len(pixel)))
        found = np.zeros((2 * RANKS, *layers.Z.shape), np.float32)
        flat, kept = found.reshape(2 * RANKS, -1), rank < RANKS
        flat[2 * rank[kept], pixel[kept]] = shares.object[order].view(np.float32)[kept]
        flat[2 * rank[kept] + 1, pixel[kept]] = shares.share[order][kept]
        own = [each for each in MATTE_CHANNELS if each.startswith(name)]
        channels |= dict(zip(own, found, strict=True))
        key = f"cryptomatte/{matte_id(name):08x}"[:-1]
        manifest = {each: f"{number:08x}" for each, number in sorted(ids.items())}
        attributes |= {
            f"{key}/name": name,
            f"{key}/hash": "MurmurHash3_32",
            f"{key}/conversion": "uint32_to_float32",
            f"{key}/manifest": json.dumps(manifest, separators=(",", ":"), ensure_ascii=False),
        }
    return replace(layers, coverage=None, mattes=Mattes(channels, attributes))


def matte_id(name: str) -> int:
    """Hash a name to the 32 bits of a float that is neither NaN, infinite, 0 nor subnormal."""
    number: int = mmh3.hash(name, signed=False)
    return number ^ 1 << 23 if number >> 23 & 255 in (0, 255) else number


REC709 = (0.64, 0.33, 0.30, 0.60, 0.15, 0.06, 0.3127, 0.3290)
DEFAULT_OUTPUT = OutputPreset()  # one part, ZIP, float

_HALF_MAX = 65504.0
UNREADABLE_CURE = "render it again, or give the path of another frame"
_COLOUR = np.floating  # half or float, as the preset's output table says


class _Channel(NamedTuple):
    """Which part it is in where there are several, field and component of Layers, pixel type."""

    part: str
    field: str
    component: int | None
    dtype: Any


_CHANNELS: dict[str, _Channel] = {
    **{name: _Channel("rgba", "rgb", i, _COLOUR) for i, name in enumerate("RGB")},
    "Z": _Channel("depth", "Z", None, np.float32),
    **{f"N.{name}": _Channel("N", "N", i, np.float16) for i, name in enumerate("XYZ")},
    **{f"albedo.{n}": _Channel("albedo", "albedo", i, _COLOUR) for i, n in enumerate("RGB")},
    **{f"id.{n}": _Channel("id", n, None, np.uint32) for n in ("object", "part")},
    "detail.level": _Channel("id", "level", None, np.uint32),
}
_ASKED_FOR: dict[str, _Channel] = {
    **{f"motion.{n}": _Channel("motion", "motion", i, np.float32) for i, n in enumerate("XY")},
    **{f"denoised.{n}": _Channel("denoised", "denoised", i, _COLOUR) for i, n in enumerate("RGB")},
}
_COMPRESSION = {
    "zip": OpenEXR.ZIP_COMPRESSION,
    "zips": OpenEXR.ZIPS_COMPRESSION,
    "piz": OpenEXR.PIZ_COMPRESSION,
    "rle": OpenEXR.RLE_COMPRESSION,
    "none": OpenEXR.NO_COMPRESSION,
}


def write_exr(
    path: str | Path,
    layers: Layers,
    header: Mapping[str, Any],
    output: OutputPreset = DEFAULT_OUTPUT,
) -> str:
    """Write a new file, have the system keep it, read it back; gives its SHA-256.

    ``header`` holds attributes, as of ``frame_header``; hashes of pixels and file are added.
    ``output`` says how the file is laid out; nothing of that loses more than half's rounding.
    Raises OSError where the disk refuses or ``path`` exists; what was begun is then removed.
    """
    path = Path(path)
    path.touch(exist_ok=False)  # the system's own error, where it cannot be
    try:
        _write(path, layers, header, output)
        seal(path)
        return _settle(path)
    except BaseException:
        with contextlib.suppress(OSError):
            path.unlink()
        raise


def _write(path: Path, layers: Layers, header: Mapping[str, Any], output: OutputPreset) -> None:
    channels = _parts(layers, output)
    pixels = {name: each for part in channels.values() for name, each in part.items()}
    every = {
        **header,
        **(layers.mattes.attributes if layers.mattes else {}),
        PIXELS_SHA256: pixels_digest(pixels),
        "compression": _COMPRESSION[output.compression],
        "type": OpenEXR.scanlineimage,
        "chromaticities": REC709,
    }
    if "envmap" in every:
        every["envmap"] = OpenEXR.ENVMAP_LATLONG
    if "timeCode" in every:
        every["timeCode"] = OpenEXR.TimeCode(
            *every["timeCode"], *[0] * 14
        )  # no flags, no user bits
    parts: list[OpenEXR.Part] = []
    for name, part in channels.items():
        arrays = {k: OpenEXR.Channel(v) for k, v in part.items()}
        own = dict(every) if parts else {**every, FILE_SHA256: UNSEALED}
        parts.append(OpenEXR.Part(own, arrays, name))
    try:
        with stdout_to_stderr():
            OpenEXR.File(parts).write(str(path))
    except (RuntimeError, ValueError) as error:
        _ask_the_system(path, layers.rgb.nbytes)
        raise OSError(errno.EIO, f"cannot be written as OpenEXR ({error})", str(path)) from error


def _ask_the_system(path: Path, size: int) -> None:
    """OpenEXR does not say why it could not write; writing about as much does, as an OSError."""
    with path.open("wb") as file:
        file.write(bytes(2 * size))
        file.flush()
        os.fsync(file.fileno())


def _parts(layers: Layers, output: OutputPreset) -> dict[str, dict[str, np.ndarray]]:
    """Channels by part; all in one without a name unless the output has several."""
    asked = {name: c for name, c in _ASKED_FOR.items() if getattr(layers, c.field) is not None}
    parts: dict[str, dict[str, np.ndarray]] = {}
    for name, channel in {**_CHANNELS, **asked}.items():
        part = parts.setdefault(channel.part if output.multipart else "", {})
        part[name] = _pixels(layers, channel, output)
        if layers.right:
            part[of_right_eye(name)] = _pixels(layers.right, channel, output)
    if layers.mattes:
        parts.setdefault("cryptomatte" if output.multipart else "", {}).update(
            layers.mattes.channels
        )
    opaque = np.ones_like(layers.Z, _colour_type(output))
    names = ["A", of_right_eye("A")] if layers.right else ["A"]
    next(iter(parts.values())).update(dict.fromkeys(names, opaque))
    return parts


def of_right_eye(channel: str) -> str:
    """Name a channel of the second view as OpenEXR does: R is right.R, and N.X is N.right.X."""
    layer, dot, name = channel.rpartition(".")
    return f"{layer}{dot}right.{name}"


def _pixels(layers: Layers, channel: _Channel, output: OutputPreset) -> np.ndarray:
    values = getattr(layers, channel.field)
    values = values if channel.component is None else values[..., channel.component]
    dtype = channel.dtype
    if dtype is _COLOUR:
        dtype = _colour_type(output)
    if dtype is np.float16:
        values = np.clip(values, -_HALF_MAX, _HALF_MAX)
    return np.ascontiguousarray(values, dtype=dtype)


def write_channels(path: str | Path, channels: Mapping[str, np.ndarray], notes: str = "") -> None:
    """Write a new file of channels (h, w), half or float each as it is, linear Rec.709.

    Raises OSError where the disk refuses.
    """
    header = {
        "compression": OpenEXR.ZIP_COMPRESSION,
        "type": OpenEXR.scanlineimage,
        "chromaticities": REC709,
        "comments": notes,
    }
    try:
        with stdout_to_stderr():
            OpenEXR.File(header, {k: np.ascontiguousarray(v) for k, v in channels.items()}).write(
                str(path)
            )
    except (RuntimeError, ValueError) as error:
        _ask_the_system(Path(path), sum(each.nbytes for each in channels.values()))
        raise OSError(errno.EIO, f"cannot be written as OpenEXR ({error})", str(path)) from error


def _settle(path: Path) -> str:
    """Have the system keep the file, and hash what it kept.

    It is read back: the library closes a file without asking whether its end was written.
    """
    with path.open("r+b") as file:
        digest = hashlib.file_digest(file, "sha256").hexdigest()
        os.fsync(file.fileno())
    try:
        read_exr(path)
    except InputError as error:
        _ask_the_system(path, path.stat().st_size)
        raise OSError(errno.EIO, f"not kept whole ({error.rule})", str(path)) from None
    return digest


def read_exr(path: str | Path) -> tuple[Layers, dict[str, Any]]:
    """A frame's layers and header. Raises InputError for a file that is not one of ours."""
    pixels, header = read_pixels(path)
    missing = sorted(set(_CHANNELS) - set(pixels))
    if missing:
        raise InputError(
            "frame", str(path), f"every layer of lodbench; missing {missing[0]}", UNREADABLE_CURE
        )
    right = None
    if all(of_right_eye(name) in pixels for name in _CHANNELS):
        named = [*_CHANNELS, *_ASKED_FOR]
        seen = {name: pixels.get(of_right_eye(name)) for name in named}
        right = Layers(**_fields({k: each for k, each in seen.items() if each is not None}))
    return Layers(**_fields(pixels), right=right), header


def read_pixels(path: str | Path) -> tuple[dict[str, np.ndarray], dict[str, Any]]:
    """A file's channels by name, of all its parts, (h, w) each, and the first part's header.

    Raises InputError for what is no whole OpenEXR file.
    """
    with _opened(path, separate_channels=True) as file:
        parts = [file.channels(number) for number in range(len(file.parts))]
        pixels = {name: each.pixels for part in parts for name, each in part.items()}
        return pixels, dict(file.header())


def read_header(path: str | Path) -> dict[str, Any]:
    """Read the first part's header alone. Raises InputError for what is no OpenEXR file."""
    with _opened(path, header_only=True) as file:
        return dict(file.header())


@contextlib.contextmanager
def _opened(path: str | Path, **how: bool) -> Iterator[OpenEXR.File]:
    if not Path(path).is_file():
        raise InputError("frame", str(path), "an EXR file that exists", "see what is there")
    try:
        with stdout_to_stderr():
            yield OpenEXR.File(str(path), **how)
    except (RuntimeError, ValueError, ArithmeticError) as error:  # a rational may be n/0
        raise InputError(
            "frame", str(path), f"readable OpenEXR ({error})", UNREADABLE_CURE
        ) from error


def channel_types(output: OutputPreset, stereo: bool = False) -> dict[str, np.dtype]:
    """Pixel types by channel in a file of that output, with the layers that it asks for."""
    asked = {"motion": output.motion, "denoised": output.denoise}
    extra = {name: each for name, each in _ASKED_FOR.items() if asked[each.part]}
    types = {name: each.dtype for name, each in {**_CHANNELS, **extra}.items()} | {"A": _COLOUR}
    types |= dict.fromkeys(MATTE_CHANNELS if output.cryptomatte else (), np.float32)
    colour = _colour_type(output)
    if stereo:
        types |= {of_right_eye(name): each for name, each in types.items()}
    return {k: np.dtype(colour if each is _COLOUR else each) for k, each in types.items()}


def _colour_type(output: OutputPreset) -> Any:
    return np.float32 if output.colour == "float" else np.float16


def _fields(pixels: Mapping[str, np.ndarray]) -> dict[str, Any]:
    columns: dict[str, list[np.ndarray]] = {}
    for name, channel in {**_CHANNELS, **_ASKED_FOR}.items():
        if name in pixels:
            columns.setdefault(channel.field, []).append(pixels[name])
    return {k: v[0] if len(v) == 1 else np.stack(v, axis=-1) for k, v in columns.items()}
