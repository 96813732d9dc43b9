"""The species of trees that there are: each one TOML file, and the CSV file measured of it."""

from dataclasses import replace
from functools import cache
from importlib import resources
from importlib.resources.abc import Traversable

from scenes.model_files.read import read_model_file
from scenes.models.trees.appearance_tables import read_tables
from scenes.models.trees.parameters import TreeSpecies


def species_folder() -> Traversable:
    """Return the folder of the files."""
    return resources.files("scenes.models.trees") / "species"


@cache
def tree_species(name: str) -> TreeSpecies:
    """Read the species of a name (see ``scenes.model_files.names.tree_species_names``).

    Raises InputError for anything in its files that breaks a rule.
    """
    return read_species(species_folder() / f"{name}.toml", species_folder() / f"{name}.csv")


def read_species(parameters: Traversable, measured: Traversable) -> TreeSpecies:
    """Read a species from its TOML file, named for it, and the CSV file measured of it, if any."""
    tables = read_tables(measured)
    name = parameters.name.removesuffix(".toml")
    given = {"name": name, "tables": {}, "bare_tables": {}}
    species = read_model_file(parameters, TreeSpecies, given)
    in_leaf = tables["leaf" if species.foliage else "bare"]
    return replace(species, tables=in_leaf, bare_tables=tables["bare"])
