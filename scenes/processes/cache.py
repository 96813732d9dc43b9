"""Results that are expensive to make, kept from one run to the next in one folder of the user's.

``kept`` looks for arrays by a key, and makes them where there are none that can be used;
``kept_data`` does so for frozen data made of arrays, as prototypes are. An entry is one file, an
uncompressed .npz, named for the hash of its key and for that of the sources that make it and of the
versions of NumPy and Python, so that nothing old is ever found. It is whole or not there
(``whole_file``), whoever else writes it at the same time, for two makers make the same; what is
damaged is made again. Nothing needs the cache: where no folder can be written to, everything is
made each time.

What is fitted for the presets comes with the package, in ``FITTED``, where it is found by its key
alone: entries of a cache that the program filled from nothing. ``python -m tests.tools.fitted``
writes the file; with ``--check`` it makes all of it again and compares, as a slow test does for
one preset.
"""

import errno
import functools
import hashlib
import importlib
import io
import json
import math
import os
import platform
import shutil
import tempfile
import threading
import time
import zipfile
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, fields, is_dataclass
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
import platformdirs

from lod.errors import InputError
from scenes.files import whole_file

Arrays = Mapping[str, np.ndarray]
Data = TypeVar("Data")

VARIABLE = "LODBENCH_CACHE"
ROOT = Path(__file__).resolve().parents[2]
PACKAGES = tuple(ROOT / name for name in ("lod", "scenes", "bench"))

LIMIT_BYTES = 2 * 2**30  # size above which the entries that were used longest ago are removed

FITTED = ROOT / "scenes" / "appearance" / "fitted.zip"
FITTED_KINDS = ("appearance", "overlap", "tone", "stand", "sky")

_FORMAT = "arrays 4"
_SUBFOLDER, _SUFFIX = "arrays", ".arrays"
_ABANDONED_S = 24 * 3600.0  # after which a file that nobody finished is removed

_WRITING = threading.Lock()
_ROOMS = ("lod.", "scenes.")
_DESCRIPTION, _MEMBERS = "description", "members"
"""Of an entry: ZIP's own list of its members may be damaged and name fewer."""


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
    entry_key = content_key(kind, key)[:40]
    if found := _fitted().get(f"{kind}/{entry_key}"):
        with suppress(Exception):  # damage may appear as any error at all
            return _read_members(FITTED, found)
    made_by = (np.__version__, platform.python_version(), platform.machine())
    sources = content_key(_FORMAT, made_by, _code_digest(tuple(code)))[:24]
    name = Path(_SUBFOLDER, kind, f"{entry_key}-{sources}{_SUFFIX}")
    folders = [each for each in cache_folders() if is_private(each)]
    for folder in folders:
        with suppress(Exception):
            arrays = _read_members(folder / name)
            arrays = {each: arrays[each] for each in arrays[_MEMBERS].tolist()}
            with suppress(OSError):
                os.utime(folder / name)
            return arrays
    arrays = {each: _read_only(values) for each, values in make().items()}
    for folder in folders if sum(a.nbytes for a in arrays.values()) < LIMIT_BYTES else ():
        with suppress(OSError, InputError), _WRITING:
            make_writable(folder)
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
            with whole_file(folder / name, overwrite=True) as temporary:
                with temporary.open("wb") as entry:
                    np.savez(entry, **arrays, **{_MEMBERS: np.array([*arrays])})  # type: ignore[arg-type]
            _remove_oldest(folder)
            break
    return arrays


@functools.cache
def _fitted() -> dict[str, list[str]]:
    found: dict[str, list[str]] = {}
    with suppress(OSError, zipfile.BadZipFile):
        with zipfile.ZipFile(FITTED) as file:
            for path in file.namelist():
                found.setdefault(path.rpartition("/")[0], []).append(path)
    return found


def _read_members(path: Path, members: Sequence[str] = ()) -> dict[str, np.ndarray]:
    """Read arrays of an .npz file by name: those of some members, or of all."""
    with zipfile.ZipFile(path) as file:
        chosen = {each: file.read(each) for each in members or file.namelist()}
    names = (each.rpartition("/")[2].removesuffix(".npy") for each in chosen)
    return dict(zip(names, map(_read_array, chosen.values()), strict=True))


def _read_array(data: bytes) -> np.ndarray:
    """Read an array as np.load does, which would parse every one's type and shape anew."""
    end = 10 + int.from_bytes(data[8:10], "little")
    shape, is_fortran, dtype = _type_and_shape(data[:end])
    values = np.frombuffer(data, dtype, math.prod(shape), end)
    return _read_only(values.reshape(shape, order="F" if is_fortran else "C"))


@functools.cache
def _type_and_shape(head: bytes) -> tuple[tuple[int, ...], bool, np.dtype[Any]]:
    return np.lib.format.read_array_header_1_0(io.BytesIO(head[8:]))


def _read_only(values: Any) -> np.ndarray:
    array = np.asarray(values, order="C").view()
    if array.dtype.hasobject or array.dtype.names:
        raise TypeError(f"a file holds arrays of numbers and of text, not of {array.dtype}")
    array.setflags(write=False)
    return array


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
    kernels = [path.stat().st_size for path in folder.glob("kernels-*/**/*") if path.is_file()]
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


def _entries(folder: Path) -> list[tuple[Path, int, float]]:
    """List the entries of a cache folder: file, size [byte], and when it was last used [s]."""
    found = []
    for path in (folder / _SUBFOLDER).glob(f"*/*{_SUFFIX}"):
        with suppress(OSError):
            state = path.stat()
            if not path.name.startswith("."):
                found.append((path, state.st_size, state.st_mtime))
            elif state.st_mtime < time.time() - _ABANDONED_S:
                path.unlink()
    return found


def _remove_oldest(folder: Path) -> None:
    """Remove the entries used longest ago until the rest is within the limit."""
    total = 0
    for path, size, _ in sorted(_entries(folder), key=lambda each: -each[2]):
        total += size
        if total > LIMIT_BYTES:
            with suppress(OSError):
                path.unlink()


def kept_data(
    kind: str, key: str, make: Callable[[], Data], code: Sequence[str] = ("lod", "scenes")
) -> Data:
    """Give the data that ``make`` makes, from the cache where they are.

    They are frozen dataclasses and named tuples of this project's, tuples, strings, numbers, None
    and arrays, nested in any way, which are taken apart into arrays and a description of how they
    belong together; ``kind``, ``key`` and ``code`` are as for ``kept``. What a dataclass keeps
    beside its fields, as cached properties, is not kept; what is read back was checked when it was
    made, so that ``__post_init__`` is not called again. Raises TypeError for anything else.
    """
    made: list[Data] = []

    def arrays() -> Arrays:
        made.append(make())
        return pack(made[0])

    found = kept(kind, key, arrays, code)
    return made[0] if made else unpack(found)


def pack(data: Any) -> dict[str, np.ndarray]:
    """Take data apart into arrays by name; one of them describes the rest. Equal arrays are one."""
    arrays: dict[str, np.ndarray] = {}
    names: dict[int, str] = {}
    described = _described(data, arrays, names)
    text = json.dumps(described).encode()
    return {_DESCRIPTION: np.frombuffer(text, np.uint8), **arrays}


def unpack(arrays: Arrays) -> Any:
    """Put data together again. Raises ValueError for a class that is not of this project."""
    return _restored(json.loads(arrays[_DESCRIPTION].tobytes()), arrays)


def _described(value: Any, arrays: dict[str, np.ndarray], names: dict[int, str]) -> Any:
    """Describe a value as JSON; its arrays go into ``arrays``, each object once by its ``id``."""
    match value:
        case np.generic():
            return {"number": _named(np.asarray(value), arrays, names)}
        case None | bool() | int() | float() | str():
            return value
        case np.ndarray():
            return {"array": _named(value, arrays, names)}
    columns: list[Any]
    if is_dataclass(value) and not isinstance(value, type):
        columns = [getattr(value, each.name) for each in fields(value)]
    elif isinstance(value, tuple | list):
        columns = list(value)
    else:
        raise TypeError(f"frozen data hold no {type(value).__name__}")
    name = f"{type(value).__module__}:{type(value).__qualname__}"
    return {"class": name, "of": [_described(each, arrays, names) for each in columns]}


def _named(array: np.ndarray, arrays: dict[str, np.ndarray], names: dict[int, str]) -> str:
    if id(array) not in names:
        names[id(array)] = str(len(names))
        arrays[names[id(array)]] = array
    return names[id(array)]


def _restored(described: Any, arrays: Arrays) -> Any:
    if not isinstance(described, dict):
        return described
    if "array" in described:
        return arrays[described["array"]]
    if "number" in described:
        return arrays[described["number"]][()]
    columns = [_restored(each, arrays) for each in described["of"]]
    module, _, name = described["class"].partition(":")
    if module == "builtins":
        return {"tuple": tuple, "list": list}[name](columns)
    if not module.startswith(_ROOMS):
        raise ValueError(f"{module} is not of this project")
    kind: Any = getattr(importlib.import_module(module), name)
    if issubclass(kind, tuple):
        return kind(*columns)
    data: Any = kind.__new__(kind)
    for each, column in zip(fields(kind), columns, strict=True):
        object.__setattr__(data, each.name, column)
    return data


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


def is_private(folder: Path) -> bool:
    """Say whether nobody but its owner, this user or root, may write into a folder, or it is new.

    What is kept is believed, and compiled kernels are run.
    """
    with suppress(FileNotFoundError):
        state = folder.stat()
        return state.st_uid in (0, os.geteuid()) and not state.st_mode & 0o022
    return True


def make_writable(folder: Path) -> None:
    """Make the folder for this user alone, or raise OSError where no file is to be written there.

    It is not where it cannot be, and where others may write as well.
    """
    folder.mkdir(mode=0o700, parents=True, exist_ok=True)
    if not is_private(folder):
        raise PermissionError(errno.EPERM, "others may write there: chmod go-w", str(folder))
    tempfile.TemporaryFile(dir=folder).close()


def content_key(*values: Any) -> str:
    """Give a digest [hex] of numbers, strings, arrays, None, and data made of them.

    Frozen dataclasses, mappings and sequences are read through. Two keys are equal only where all
    values are, to the last bit. Raises TypeError for anything else.
    """
    return _digest_of(_pieces(values))


def _digest_of(pieces: Iterable[bytes]) -> str:
    digest = hashlib.sha256()
    for piece in pieces:
        digest.update(len(piece).to_bytes(8, "little") + piece)
    return digest.hexdigest()


def rounded_key(*values: Any) -> str:
    """Give a digest [hex] like that of ``content_key``, of arrays of reals to a millionth.

    Machines differ in the last bits of what is grown, and then fits are the same to them. Steps of
    the rounding lie beside numbers of few decimals, which a last bit would carry over them. Of
    dataclasses the values alone count.
    """
    return _digest_of(_pieces((values,), rounded=True))


def _pieces(value: Any, rounded: bool = False) -> Iterator[bytes]:
    """Yield the bytes of a value with a mark of its kind, so that no two values read alike."""
    match value:
        case np.ndarray() if not value.dtype.hasobject:
            if rounded and value.dtype.kind == "f":
                value = np.floor(value * 1e6 + math.e / 10)
            yield f"array {value.dtype.str} {value.shape}".encode()
            yield np.ascontiguousarray(value).tobytes()
        case None | bool() | int() | str() | bytes() | Path():
            yield f"{type(value).__name__} {value!r}".encode()
        case float():
            yield f"float {float(value).hex()}".encode()
        case np.generic():
            yield from _pieces(np.asarray(value))
        case Mapping():
            yield f"mapping {len(value)}".encode()
            for name in sorted(value):
                yield from _pieces((name, value[name]), rounded)
        case list() | tuple():
            yield f"sequence {len(value)}".encode()
            for each in value:
                yield from _pieces(each, rounded)
        case _ if is_dataclass(value):
            if rounded:
                yield from _pieces([getattr(value, each.name) for each in fields(value)], rounded)
                return
            yield f"{type(value).__module__}.{type(value).__qualname__}".encode()
            for each in fields(value):
                yield from _pieces((each.name, getattr(value, each.name)))
        case _:
            raise TypeError(f"a key is made of plain data, not of {type(value).__name__}")


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
