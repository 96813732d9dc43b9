"""The names of models: what a preset may say that an object is, and where the user's models lie.

Animals and species of trees are found by listing the folders of their files, so that a preset may
use a new one at once. Models that the user has added lie in the user's data folder, in the form of
``scenes.imported.library``: they need neither the file they came from nor a library that reads it.
Presets are checked by these names before any model is built, so nothing is built here. A model's
TOML file is read into a frozen dataclass or a Pydantic model whose fields are the keys of the file:
their annotations say type and range.
"""

import difflib
import json
import re
import tomllib
from collections.abc import Mapping
from contextlib import suppress
from functools import cache
from importlib import resources
from importlib.resources.abc import Traversable
from pathlib import Path
from typing import Any, TypeVar

import platformdirs
from pydantic import ConfigDict, TypeAdapter, ValidationError

from lod.errors import InputError

SUFFIXES = (".usda", ".usdc", ".usd", ".usdz", ".gltf", ".glb")  # of scene files that can be read

_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_-]{0,63}")


def is_model_file(name: str) -> bool:
    """Tell whether a name is that of a scene file, by its suffix."""
    return Path(name).suffix.lower() in SUFFIXES


def models_folder() -> Path:
    """Return the folder of the user's models; it may not be there yet."""
    return platformdirs.user_data_path("lodbench", appauthor=False) / "models"


def user_model_names() -> tuple[str, ...]:
    """List the names of the models that the user has added, in alphabetical order."""
    with suppress(OSError):  # of a home that this user may not read
        return tuple(sorted(each.stem for each in models_folder().glob("*.npz")))
    return ()


def user_model_path(name: str) -> Path:
    """Return where the model of that name lies. Raises InputError for what cannot be a name."""
    if not _NAME.fullmatch(name):
        rule = "a name of letters, digits, - and _, letter first, at most 64 of them"
        raise InputError("NAME", name, rule, "say another with --name")
    return models_folder() / f"{name}.npz"


BUILT_IN = ("figure", "boulder", "sward")  # models that Python code describes


@cache
def animal_names() -> tuple[str, ...]:
    """List the animals, one for each TOML file in their folder, in alphabetical order."""
    return _toml_names("scenes.figures", "animals")


@cache
def tree_species_names() -> tuple[str, ...]:
    """List the species of trees, one for each TOML file in their folder, in alphabetical order."""
    return _toml_names("scenes.trees", "species")


def _toml_names(package: str, folder: str) -> tuple[str, ...]:
    files = (each.name for each in (resources.files(package) / folder).iterdir())
    return tuple(sorted(name.removesuffix(".toml") for name in files if name.endswith(".toml")))


def built_in_names() -> tuple[str, ...]:
    """Names of the models that come with the program."""
    return (*BUILT_IN, *animal_names(), *tree_species_names())


def model_names() -> tuple[str, ...]:
    """Names of all models, those that the user has added last."""
    ours = built_in_names()
    return (*ours, *(name for name in user_model_names() if name not in ours))


CLOSED = ConfigDict(extra="forbid", strict=True, allow_inf_nan=False)
"""``__pydantic_config__`` of a dataclass that a file describes: no unknown key, no other type."""

_UNKNOWN_KEY = ("unexpected_keyword_argument", "extra_forbidden")  # of a dataclass, of a model

T = TypeVar("T")


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
        raise first_error(f"{file.name}: ", error) from None


def first_error(where: str, error: ValidationError) -> InputError:
    """Return the first thing that is wrong, an unknown key before all else.

    ``where`` goes before its key.
    """
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
        arrived, rule, cure = "missing", "a required key", "add it"
    # ('levels', 0, 'length') → levels[0].length; the whole file has no key.
    steps = [f"[{step}]" if isinstance(step, int) else f".{step}" for step in first["loc"]]
    key = "".join(steps).lstrip(".") or "the file"
    return InputError(f"{where}{key}", arrived, rule, cure)
