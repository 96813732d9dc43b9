"""Settings as attributes of OpenEXR, typed where it has the type, and read back without loss."""

import json
from collections.abc import Mapping
from typing import Any

import numpy as np

_LEAST, _MOST = -(2**31), 2**31 - 1


def to_attribute(value: Any) -> Any:
    """Turn plain data into what OpenEXR writes, and from_attribute reads back the same.

    A whole number within 32 bits becomes an ``int``, a float a ``double``, two or three of either
    ``v2i``, ``v3i``, ``v2d`` or ``v3d``. Text stays text, unless it could be read as JSON. All else
    (true, null, longer lists and larger whole numbers) becomes text in JSON.
    """
    if isinstance(value, str):
        return value if _from_json(value) is _NOT_JSON else json.dumps(value)
    if type(value) is int and _LEAST <= value <= _MOST:
        return value
    if isinstance(value, float):
        return np.array([value])
    if isinstance(value, list | tuple) and len(value) in (2, 3):
        if all(type(each) is int and _LEAST <= each <= _MOST for each in value):
            return np.array(value, np.int32)
        if all(isinstance(each, float) for each in value):
            return np.array(value, np.float64)
    return json.dumps(value, sort_keys=True)


def from_attribute(value: Any) -> Any:
    """Turn what OpenEXR read back into plain data."""
    if isinstance(value, np.ndarray):
        return value.item() if value.size == 1 else value.tolist()
    found = _from_json(value) if isinstance(value, str) else value
    return value if found is _NOT_JSON else found


def flatten_attributes(table: Mapping[str, Any], prefix: str) -> dict[str, Any]:
    """Make attributes of nested tables, by dotted keys; an empty table is a key of its own."""
    found: dict[str, Any] = {}
    for key, value in table.items():
        if isinstance(value, Mapping) and value:
            found |= flatten_attributes(value, f"{prefix}{key}.")
        else:
            found[f"{prefix}{key}"] = to_attribute(value)
    return found


def nest_attributes(header: Mapping[str, Any], prefix: str) -> dict[str, Any]:
    """Make nested tables of the attributes whose names begin with a prefix."""
    tables: dict[str, Any] = {}
    for name in sorted(name for name in header if name.startswith(prefix)):
        *above, key = name.removeprefix(prefix).split(".")
        inner = tables
        for each in above:
            table = inner.get(each)  # no table where a name is damaged
            inner[each] = inner = table if isinstance(table, dict) else {}
        inner[key] = from_attribute(header[name])
    return tables


_NOT_JSON = object()


def _from_json(text: str) -> Any:
    try:
        return json.loads(text)
    except (ValueError, RecursionError):
        return _NOT_JSON
