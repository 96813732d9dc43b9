"""The names of models: what a preset may say that an object is, and where the user's models lie.

Animals and species of trees are found by listing the folders of their files, so that a preset may
use a new one at once. Models that the user has added lie in the user's data folder, in the form of
``scenes.imported.library``: they need neither the file they came from nor a library that reads it.
Presets are checked by these names before any model is built, so nothing is built or read here.
"""

import re
from contextlib import suppress
from functools import cache
from importlib import resources
from pathlib import Path

import platformdirs

from lod.errors import InputError

SUFFIXES = (".usda", ".usdc", ".usd", ".usdz", ".gltf", ".glb")
"""Of scene files that can be read."""

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


BUILT_IN = ("figure", "boulder", "sward")
"""Models that Python code describes."""


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
