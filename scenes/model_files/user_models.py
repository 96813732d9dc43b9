"""The names of the models that a user has brought, and where they lie; nothing is read here.

Those kept lie in the user's data folder, in the form of ``scenes.model_files.compiled``: they need
neither the file they came from nor a library that reads it.
"""

import re
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
    return tuple(sorted(each.stem for each in models_folder().glob("*.npz")))


def user_model_path(name: str) -> Path:
    """Return where the model of that name lies. Raises InputError for what cannot be a name."""
    if not _NAME.fullmatch(name):
        rule = "a name of letters, digits, - and _, letter first, at most 64 of them"
        raise InputError("NAME", name, rule, "say another with --name")
    return models_folder() / f"{name}.npz"
