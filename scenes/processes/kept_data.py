"""Keep frozen data made of arrays, as prototypes are, from one run to the next.

Data are taken apart into arrays and a description of how they belong together, which the content
cache keeps (``scenes.processes.content_cache``). What is read back was checked when it was made, so
the checks of ``__post_init__`` are not made again. Only classes of this project are ever made.
"""

import importlib
import json
from collections.abc import Callable, Sequence
from dataclasses import fields, is_dataclass
from typing import Any, TypeVar

import numpy as np

from scenes.processes.array_file import Arrays
from scenes.processes.content_cache import kept

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
