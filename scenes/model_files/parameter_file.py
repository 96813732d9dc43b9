"""Reading a model's TOML file into a frozen dataclass or a Pydantic model, every key checked.

Its fields are the keys of the file: their annotations say type and range.
"""

import difflib
import json
import tomllib
from collections.abc import Mapping
from importlib.resources.abc import Traversable
from typing import Any, TypeVar

from pydantic import ConfigDict, TypeAdapter, ValidationError

from lod.errors import InputError

CLOSED = ConfigDict(extra="forbid", strict=True, allow_inf_nan=False)
"""``__pydantic_config__`` of a dataclass that a file describes: no unknown key, no other type."""

_UNKNOWN_KEY = ("unexpected_keyword_argument", "extra_forbidden")  # of a dataclass, of a model

T = TypeVar("T")


def first_error(where: str, error: ValidationError) -> InputError:
    """Return the first thing that is wrong, as Pydantic says it; ``where`` goes before its key."""
    first = error.errors(include_url=False)[0]
    key = ".".join(map(str, first["loc"]))
    return InputError(f"{where}{key}", first["input"], first["msg"])


def read_model_file(file: Traversable, kind: type[T], given: Mapping[str, Any]) -> T:
    """Read a ``kind`` from a TOML file, and from values ``given`` by the program.

    ``kind`` is a dataclass or a Pydantic model. A value that is given may not stand in the file.

    Raises InputError that names the file, the key, what arrived, the rule and the cure.
    """
    try:
        keys = tomllib.loads(file.read_text("utf-8-sig"))
        text = json.dumps({**keys, **given}, default=str)
    except (ValueError, RecursionError) as error:
        raise InputError(file.name, str(error), "a TOML file in UTF-8") from None
    for key in keys.keys() & given.keys():
        raise InputError(f"{file.name}: {key}", keys[key], "no such key", "take it out")
    try:
        return TypeAdapter(kind).validate_json(text)
    except ValidationError as error:
        raise _explain(error, file.name) from None


def _explain(error: ValidationError, file: str) -> InputError:
    """The first thing that is wrong, in one line; an unknown key before all else."""
    errors = error.errors(include_url=False)
    unknown = [each for each in errors if each["type"] in _UNKNOWN_KEY]
    first = (unknown or errors)[0]
    if first["type"] == "value_error" and isinstance(first["ctx"]["error"], InputError):
        return first["ctx"]["error"]
    arrived, cure = first["input"], ""
    rule = first["msg"].replace("Input should be ", "")
    if unknown:
        missing = [str(each["loc"][-1]) for each in errors if each["type"] == "missing"]
        near = difflib.get_close_matches(str(first["loc"][-1]), missing, 1)
        rule, cure = "no such key", f"did you mean {near[0]}?" if near else "take it out"
    elif first["type"] == "missing":
        arrived, rule, cure = "missing", "a required key", "copy it from another file"
    # ('levels', 0, 'length') → levels[0].length; the whole file has no key.
    steps = [f"[{step}]" if isinstance(step, int) else f".{step}" for step in first["loc"]]
    key = "".join(steps).lstrip(".") or "the file"
    return InputError(f"{file}: {key}", arrived, rule, cure)
