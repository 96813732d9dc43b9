"""The species of trees that there are: each one TOML file."""

from functools import cache
from importlib import resources
from importlib.resources.abc import Traversable

from scenes.model_files.read import read_model_file
from scenes.models.trees.parameters import TreeSpecies


def species_folder() -> Traversable:
    """Return the folder of the files."""
    return resources.files("scenes.models.trees") / "species"


@cache
def tree_species(name: str) -> TreeSpecies:
    """Read the species of a name (see ``scenes.model_files.names.tree_species_names``).

    Raises InputError for anything in its file that breaks a rule.
    """
    return read_species(species_folder() / f"{name}.toml")


def read_species(parameters: Traversable) -> TreeSpecies:
    """Read a species from its TOML file, which it is named for."""
    name = parameters.name.removesuffix(".toml")
    return read_model_file(parameters, TreeSpecies, {"name": name})
