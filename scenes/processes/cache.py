"""Named arrays as one file with a checksum, written whole or not at all.

A file is its format, a checksum of all that follows, the length of the header, the header (JSON:
name, dtype, shape and place of each array) and the bytes of the arrays.

Where may the program keep what it would otherwise make again: one folder for one user.

What does a result depend on: one digest of plain data, such as parameters and arrays.

Which sources is the program made of: one digest of the bytes of its files.

Keep arrays that are dear to make and depend on nothing but their key, from one run to the next.

``kept`` looks for an entry, and makes the arrays where there is none that can be used. An entry is
one file, named for the hash of its key, of the sources that make it and of the versions of NumPy
and Python, so that nothing old is ever found. It is written beside its place and renamed: whole or
not there, whoever else writes it at the same time, for two makers make the same. A checksum stands
over all its bytes; what is damaged is made again. Nothing needs the cache: where no folder can be
written to, everything is made each time.

Keep frozen data made of arrays, as prototypes are, from one run to the next.

Data are taken apart into arrays and a description of how they belong together, which the content
cache keeps (``scenes.processes.cache``). What is read back was checked when it was made, so
the checks of ``__post_init__`` are not made again. Only classes of this project are ever made.
"""

import functools
import hashlib
import importlib
import json
import os
import platform
import shutil
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, fields, is_dataclass
from pathlib import Path
from typing import Any, TypeVar

import mmh3
import numpy as np
import platformdirs

UNFINISHED = ".part"
"""How the names of files end that are being written."""

FORMAT = b"lodbench arrays 1\n"
_DIGEST = 16  # bytes of MurmurHash3
_ALIGNMENT = 64

Arrays = Mapping[str, np.ndarray]


def read_only(values: Any) -> np.ndarray:
    """Give a read-only array in C order; raises TypeError for Python objects and for records."""
    array = np.asarray(values, order="C").view()
    if array.dtype.hasobject or array.dtype.names:
        raise TypeError(f"a file holds arrays of numbers and of text, not of {array.dtype}")
    array.setflags(write=False)
    return array


def encode_arrays(arrays: Arrays) -> list[bytes | memoryview]:
    """Give the file's bytes: format, checksum, length of the header, header, aligned arrays."""
    rows, start = [], 0
    body: list[bytes | memoryview] = []
    for name, array in arrays.items():
        rows.append([name, array.dtype.str, list(array.shape), start])
        padding = -array.nbytes % _ALIGNMENT
        body += [array.reshape(-1).view(np.uint8).data, bytes(padding)]
        start += array.nbytes + padding
    header = json.dumps(rows).encode()
    head = len(FORMAT) + _DIGEST + 8
    header += b" " * (-(head + len(header)) % _ALIGNMENT)
    body = [len(header).to_bytes(8, "little"), header, *body]
    hasher = mmh3.mmh3_x64_128()
    for piece in body:
        hasher.update(piece)
    return [FORMAT, hasher.digest(), *body]


def decode_arrays(content: np.ndarray) -> dict[str, np.ndarray]:
    """Read a file's bytes as read-only arrays; raises ValueError where they are damaged."""
    start = len(FORMAT) + _DIGEST
    if content[: len(FORMAT)].tobytes() != FORMAT:
        raise ValueError("another format")
    hasher = mmh3.mmh3_x64_128(content[start:].data)
    if hasher.digest() != content[len(FORMAT) : start].tobytes():
        raise ValueError("damaged")
    content.setflags(write=False)
    begin = start + 8
    first = begin + int.from_bytes(content[start:begin].tobytes(), "little")
    arrays = {}
    for name, kind, shape, offset in json.loads(content[begin:first].tobytes()):
        dtype = np.dtype(kind)
        stop = first + offset + dtype.itemsize * int(np.prod(shape, dtype=np.int64))
        arrays[name] = content[first + offset : stop].view(dtype).reshape(shape)
    return arrays


def write_array_file(path: Path, pieces: list[bytes | memoryview]) -> None:
    """Write an encoded file whole or not at all; raises OSError where it cannot be."""
    path.parent.mkdir(parents=True, exist_ok=True)
    temporary = path.with_name(f"{path.name}.{os.urandom(8).hex()}{UNFINISHED}")
    try:
        with temporary.open("xb") as file:
            file.writelines(pieces)
        os.replace(temporary, path)
    except BaseException:
        with suppress(OSError):
            temporary.unlink()
        raise


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


def content_key(*values: Any) -> str:
    """Give a digest [hex] of numbers, strings, arrays, None, and data made of them.

    Frozen dataclasses, mappings and sequences are read through. Two keys are equal only where all
    values are, to the last bit. Raises TypeError for anything else.
    """
    digest = hashlib.sha256()
    for piece in _pieces(values):
        digest.update(len(piece).to_bytes(8, "little") + piece)
    return digest.hexdigest()


def _pieces(value: Any) -> Iterator[bytes]:
    """Yield the bytes of a value with a mark of its kind, so that no two values read alike."""
    match value:
        case np.ndarray() if not value.dtype.hasobject:
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
                yield from _pieces((name, value[name]))
        case list() | tuple():
            yield f"sequence {len(value)}".encode()
            for each in value:
                yield from _pieces(each)
        case _ if hasattr(type(value), "__dataclass_fields__"):
            yield f"{type(value).__module__}.{type(value).__qualname__}".encode()
            for name in type(value).__dataclass_fields__:
                yield from _pieces((name, getattr(value, name)))
        case _:
            raise TypeError(f"a key is made of plain data, not of {type(value).__name__}")


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


Data = TypeVar("Data")

_ROOMS = ("lod.", "scenes.")
_DESCRIPTION = "description"


def kept_data(
    kind: str, key: str, make: Callable[[], Data], code: Sequence[str] = ("lod", "scenes")
) -> Data:
    """Give the data that ``make`` makes, from the cache where they are.

    They are frozen dataclasses and named tuples of this project's, tuples, strings, numbers, None
    and arrays, nested in any way; ``kind``, ``key`` and ``code`` are as for ``kept``. What a
    dataclass keeps beside its fields, as cached properties, is not kept. Raises TypeError for
    anything else.
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
