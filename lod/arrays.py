"""Array types by shape, and the freezing and checking of the columns of frozen data."""

from dataclasses import fields
from functools import cache
from typing import Annotated, Any

import numpy as np
from jaxtyping import Bool, Float64, Int64

from lod.errors import InputError

Points = Float64[np.ndarray, "n 3"]
Reals = Float64[np.ndarray, " n"]
Ints = Int64[np.ndarray, " n"]
Flags = Bool[np.ndarray, " n"]

FloatArray = Annotated[np.ndarray, np.float64]
SingleArray = Annotated[np.ndarray, np.float32]
IntArray = Annotated[np.ndarray, np.int64]
FlagArray = Annotated[np.ndarray, np.bool_]
"""Arrays of any shape, as fields of ``ArrayData``."""


def frozen(values: Any, dtype: Any) -> np.ndarray:
    """Return ``values`` as a read-only, contiguous array; copied only where that is needed."""
    array = np.ascontiguousarray(values, dtype=dtype)
    if array.flags.writeable:
        array = array.view()
        array.setflags(write=False)
    return array


def freeze(data: Any, **dtypes: Any) -> None:
    """Make the named fields read-only arrays; for the ``__post_init__`` of a frozen dataclass."""
    for name, dtype in dtypes.items():
        object.__setattr__(data, name, frozen(getattr(data, name), dtype))


class ArrayData:
    """Base of frozen dataclasses of arrays: their FloatArray, SingleArray, IntArray and FlagArray
    are read-only.

    What is given for such a field becomes an array of its kind when the data is made.
    """

    def __post_init__(self) -> None:
        kind: Any = type(self)
        freeze(self, **_array_fields(kind))


@cache
def _array_fields(data: Any) -> dict[str, Any]:
    """Name the fields of a class that are arrays, with their kinds of numbers."""
    kinds = {each.name: getattr(each.type, "__metadata__", ()) for each in fields(data)}
    return {name: kind[0] for name, kind in kinds.items() if kind}


def check_columns(where: str, data: Any, **shapes: tuple[int, ...]) -> None:
    """Check that the named fields of ``data`` are finite arrays of the given shapes.

    ``where`` is what error messages call the data, as in ``where.field``. Raises InputError for the
    first field that has another shape, and the first row that is not finite.
    """
    for name, shape in shapes.items():
        values = getattr(data, name)
        if values.shape != shape:
            raise InputError(f"{where}.{name}", values.shape, f"its shape is {shape}")
        finite = np.isfinite(values)
        if not finite.all():
            first = np.argwhere(~finite)[0]
            row, arrived = int(first[0]), float(values[tuple(first)])
            raise InputError(f"{where}.{name}[{row}]", arrived, "every number is finite")


def expand(count: np.ndarray) -> tuple[Ints, Ints]:
    """Give the owner of each item, where owner i has count[i] items, and its number there, (k,)."""
    owner = np.repeat(np.arange(len(count)), count)
    return owner, np.arange(len(owner)) - np.repeat(np.cumsum(count) - count, count)
