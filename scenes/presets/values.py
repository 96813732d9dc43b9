"""Values of a preset's keys: how they are written, their range, and what is refused."""

import math
import re
from collections.abc import Callable
from typing import Annotated, Any

from pydantic import (
    AfterValidator,
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    PlainSerializer,
    model_validator,
)
from pydantic.fields import FieldInfo
from pydantic_core import PydanticCustomError

from lod.errors import InputError

UNITS_M = {"m": 1.0, "km": 1000.0, "cm": 0.01, "mm": 0.001}
LARGEST_SIDE = 16384
_CURE = "write 20km or 500m"
_LENGTH = re.compile(r"\s*([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)\s*([^\W\d]*)\s*", re.ASCII)
_SIZE = re.compile(r"\s*(\d{1,9})\s*[x×]\s*(\d{1,9})\s*", re.ASCII)

_SIDE = r"(\d{1,5}|\d{1,3}(?:\.\d+)?(?=%))(%?)"
_CROP = re.compile(rf"\s*{_SIDE}\s*[x×]\s*{_SIDE}\+{_SIDE}\+{_SIDE}\s*")

LARGEST_SEED = 2**63 - 1
_FARTHEST_CELL = 2**55
_FARTHEST_M = 1e15
FARTHEST_SIGHT_M = 330e3
"""Visibility [m]: in pure air it is 340 km (lod.air)."""


class Table(BaseModel):
    """Frozen, closed to unknown keys, strict about types, finite numbers only.

    A key whose meaning says that it is in metres takes a number of them, or a length as "170cm".
    """

    model_config = ConfigDict(frozen=True, extra="forbid", strict=True, allow_inf_nan=False)

    @model_validator(mode="before")
    @classmethod
    def _in_metres(cls, data: Any) -> Any:
        if not isinstance(data, dict):
            return data
        lengths = {
            name: type(value)(map(_in_metres, value))
            if isinstance(value, list | tuple)
            else _in_metres(value)
            for name, value in data.items()
            if (field := cls.model_fields.get(name)) and "[m]" in (field.title or "")
            if not is_length(field)
        }
        return data | lengths


def _in_metres(value: Any) -> Any:
    found = _LENGTH.fullmatch(value) if isinstance(value, str) else None
    return float(found[1]) * UNITS_M[found[2]] if found and found[2] in UNITS_M else value


def key(
    about: str,
    default: Any = ...,
    *,
    above: float | None = None,
    least: float | None = None,
    below: float | None = None,
    most: float | None = None,
) -> Any:
    """Declare a key's meaning, default and range; errors quote a description of meaning and range.

    Without a default the key is required.
    """
    words = (("above", above), ("at least", least), ("below", below), ("at most", most))
    range_ = " and ".join(f"{word} {bound:.15g}" for word, bound in words if bound is not None)
    bounds: Any = {"gt": above, "ge": least, "lt": below, "le": most}
    return Field(default, **bounds, title=about, description=range_ or None)


def refuse(rule: str, cure: str = "", where: str = "") -> PydanticCustomError:
    """Make what a validator raises: the broken rule, its cure, and the key if it is another."""
    return PydanticCustomError("rule", "{rule}", {"rule": rule, "cure": cure, "key": where})


def _reported(read: Callable[[Any], Any]) -> Callable[[Any], Any]:
    """The rule and cure of an InputError, as pydantic passes them on; it adds the key itself."""

    def reader(value: Any) -> Any:
        try:
            return read(value)
        except InputError as error:
            raise refuse(error.rule, error.cure) from error

    return reader


def _visibility(value: Any) -> Any:
    return None if value is None or value == "clear" else parse_length(value)


def _extent(value: Any) -> Any:
    if value is None or value == "endless":
        return None
    return parse_length(value) if isinstance(value, str) else value


def _power_of_two(value: float) -> float:
    if value <= 0 or math.frexp(value)[0] != 0.5:
        near = 2.0 ** round(math.log2(value)) if value > 0 else 1.0
        raise refuse("a power of two", f"try {near:.15g}")
    return value


def _metres(value: float | None) -> str | None:
    return None if value is None else f"{value!r}m"


def is_length(field: FieldInfo) -> bool:
    """Whether a key is written as a length with its unit, as "20km"."""
    return any(getattr(each, "func", None) is _metres for each in field.metadata)


def parse_crop(text: str, size: tuple[int, int], where: str = "crop") -> tuple[int, ...]:
    """Parse a crop WIDTHxHEIGHT+LEFT+TOP of a picture of that size; gives left, top, right, bottom.

    Each number is of pixels, or a share of the picture's width or height in percent. Raises
    InputError for anything else, and for a crop that is not inside the picture.
    """
    match = _CROP.fullmatch(text)
    if match is None:
        rule = "WIDTHxHEIGHT+LEFT+TOP in whole pixels or in percent"
        raise InputError(where, text, rule, "try 320x180+160+90 or 50%x50%+25%+25%")
    width, height, left, top = (
        float(number) * (side / 100 if percent else 1)
        for (number, percent), side in zip(
            zip(match.groups()[::2], match.groups()[1::2], strict=True), size * 2, strict=True
        )
    )
    edges = tuple(round(each) for each in (left, top, left + width, top + height))
    if not (edges[0] < edges[2] <= size[0] and edges[1] < edges[3] <= size[1]):
        rule = f"a window with pixels in it, inside the picture of {size[0]}x{size[1]}"
        raise InputError(where, text, rule, "width and height come first, then left and top")
    return edges


def parse_length(text: object, where: str = "length") -> float:
    """Parse a length with its unit, in metres. Raises InputError without one, or unless above 0."""
    match = _LENGTH.fullmatch(text) if isinstance(text, str) else None
    if match is None:
        rule, cure = "a number with its unit, m or km", _CURE
        if isinstance(text, int | float):
            cure = f'write "{text:g}km" or "{text:g}m"'
        raise InputError(where, text, rule, cure)
    number, unit = match.groups()
    if not float(number) > 0:
        raise InputError(where, text, "a length above 0, with its unit", _CURE)
    if unit not in UNITS_M:
        rule = "a length names its unit, m or km"
        raise InputError(where, text, rule, f"write {number}km or {number}m")
    length = float(number) * UNITS_M[unit]
    if not math.isfinite(length):
        raise InputError(where, text, "a length above 0 and finite", _CURE)
    return length


def parse_size(text: str, where: str = "size") -> tuple[int, int]:
    """Parse a picture size WIDTHxHEIGHT in pixels. Raises InputError for anything else."""
    match = _SIZE.fullmatch(text)
    if match is None:
        raise InputError(where, text, "WIDTHxHEIGHT in whole pixels", "try 640x360")
    width, height = int(match[1]), int(match[2])
    if not (1 <= width <= LARGEST_SIDE and 1 <= height <= LARGEST_SIDE):
        raise InputError(where, text, f"each side from 1 to {LARGEST_SIDE} px", "try 640x360")
    return width, height


Visibility = Annotated[
    Annotated[float, Field(ge=1, le=FARTHEST_SIGHT_M)] | None,
    BeforeValidator(_reported(_visibility)),
    PlainSerializer(_metres),
    key("distance at which 2 % of contrast is left, 1m to 330km; absent or 'clear' = no haze"),
]
Extent = Annotated[
    Annotated[float, Field(gt=0, le=_FARTHEST_M)] | None,
    BeforeValidator(_reported(_extent)),
    key("side of the window on the field [m], at most 1e15; absent or 'endless' = no edge"),
]
Side = Annotated[int, Field(ge=1, le=LARGEST_SIDE)]
MostParts = Annotated[
    Annotated[int, Field(ge=1, le=10**12)] | None,
    key("parts displayed at most, 1 to 1e12: they choose the detail; absent = no limit"),
]
Size = Annotated[
    tuple[Side, Side],
    BeforeValidator(_reported(lambda x: x if isinstance(x, tuple) else parse_size(str(x)))),
    key(f"WIDTHxHEIGHT in pixels, each side from 1 to {LARGEST_SIDE}"),
]
Metres = Annotated[float, Field(ge=-_FARTHEST_M, le=_FARTHEST_M)]
Cell = Annotated[int, Field(ge=-_FARTHEST_CELL, le=_FARTHEST_CELL)]
PowerOfTwo = Annotated[float, AfterValidator(_power_of_two)]
SizeFactor = Annotated[float, Field(ge=1e-3, le=1e3)]
