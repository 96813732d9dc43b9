"""Lengths with their unit and picture sizes as people write them: 20km, 500 m, 640x360."""

import math
import re

from lod.errors import InputError

UNITS_M = {"m": 1.0, "km": 1000.0}
LARGEST_SIDE = 16384

_CURE = "write 20km or 500m"
_LENGTH = re.compile(r"\s*([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)\s*([^\W\d]*)\s*", re.ASCII)
_SIZE = re.compile(r"\s*(\d{1,9})\s*[x×]\s*(\d{1,9})\s*", re.ASCII)


def parse_length(text: object, where: str = "length") -> float:
    """A length with its unit, in metres. Raises InputError without a unit, or unless above 0."""
    match = _LENGTH.fullmatch(text) if isinstance(text, str) else None
    if match is not None and not float(match[1]) > 0:
        raise InputError(where, text, "a length above 0, with its unit", _CURE)
    return parse_height(text, where)


def parse_height(text: object, where: str = "height") -> float:
    """A height with its unit, in metres, of either sign. Raises InputError without a unit."""
    match = _LENGTH.fullmatch(text) if isinstance(text, str) else None
    if match is None:
        rule, cure = "a number with its unit, m or km", _CURE
        if isinstance(text, int | float):
            cure = f'write "{text:g}km" or "{text:g}m"'
        raise InputError(where, text, rule, cure)
    number, unit = match.groups()
    if unit not in UNITS_M:
        rule = "a length names its unit, m or km"
        raise InputError(where, text, rule, f"write {number}km or {number}m")
    length = float(number) * UNITS_M[unit]
    if not math.isfinite(length):
        raise InputError(where, text, "a length above 0 and finite", _CURE)
    return length


def parse_size(text: str, where: str = "size") -> tuple[int, int]:
    """A picture size WIDTHxHEIGHT in pixels. Raises InputError for anything else."""
    match = _SIZE.fullmatch(text)
    if match is None:
        raise InputError(where, text, "WIDTHxHEIGHT in whole pixels", "try 640x360")
    width, height = int(match[1]), int(match[2])
    if not (1 <= width <= LARGEST_SIDE and 1 <= height <= LARGEST_SIDE):
        raise InputError(where, text, f"each side from 1 to {LARGEST_SIDE} px", "try 640x360")
    return width, height
