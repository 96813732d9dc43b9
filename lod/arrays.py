"""Array types by shape, and the freezing of arrays in frozen data."""

from typing import Any, TypeVar

import numpy as np
from jaxtyping import Bool, Float64, Int64

Points = Float64[np.ndarray, "n 3"]
Reals = Float64[np.ndarray, " n"]
Ints = Int64[np.ndarray, " n"]
Flags = Bool[np.ndarray, " n"]

Data = TypeVar("Data")


def frozen(values: Any, dtype: Any) -> np.ndarray:
    """A read-only, contiguous array of ``values``; a copy only where one is needed."""
    array = np.ascontiguousarray(values, dtype=dtype)
    if array.flags.writeable:
        array = array.view()
        array.setflags(write=False)
    return array


def freeze(data: Any, **dtypes: Any) -> None:
    """In a frozen dataclass's ``__post_init__``: make the named fields read-only arrays."""
    for name, dtype in dtypes.items():
        object.__setattr__(data, name, frozen(getattr(data, name), dtype))
