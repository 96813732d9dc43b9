"""The names of models: what a preset may say that an object is.

Animals and species of trees are found by listing the folders of their files, so that a preset may
use a new one at once. Presets are checked by these names before any model is built, so nothing is
built here.
"""

from functools import cache
from importlib import resources

from scenes.model_files.user_models import user_model_names

BUILT_IN = ("figure", "boulder", "sward")
"""Models that Python code describes."""


@cache
def animal_names() -> tuple[str, ...]:
    """Names of the animals, one for each TOML file in their folder, in alphabetical order."""
    return _listed("scenes.models.animals", ".")


@cache
def tree_species_names() -> tuple[str, ...]:
    """Names of the species of trees, one for each TOML file in their folder, in alphabetical
    order."""
    return _listed("scenes.models.trees", "species")


def built_in_names() -> tuple[str, ...]:
    """Names of the models that come with the program."""
    return (*BUILT_IN, *animal_names(), *tree_species_names())


def model_names() -> tuple[str, ...]:
    """Names of all models, those that the user has added last."""
    ours = built_in_names()
    return (*ours, *(name for name in user_model_names() if name not in ours))


def _listed(package: str, folder: str) -> tuple[str, ...]:
    """Names of the TOML files in a folder of a package."""
    files = (each.name for each in (resources.files(package) / folder).iterdir())
    return tuple(sorted(name.removesuffix(".toml") for name in files if name.endswith(".toml")))
