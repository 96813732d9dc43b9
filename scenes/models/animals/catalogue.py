"""Which animals there are: every TOML file of this folder is one, by the name of the file.

An insect and a windmill stand with the animals: the paper's two doubtful cases (§2.3). Blake
conjectures that parts shrink with depth in the hierarchy for living things of about our size alone;
insects and artifacts are here to put that to the test.
"""

from functools import lru_cache
from importlib import resources

from lod.errors import InputError
from scenes.gait.gait import with_gait
from scenes.model_files.names import animal_names
from scenes.models.animals.animal_file import AnimalTables, load_animal
from scenes.rig.build import build_prototype
from scenes.rig.rigged_prototype import RiggedPrototype


@lru_cache(maxsize=16)
def animal_tables(name: str) -> AnimalTables:
    """Return the tables of the animal of a name (see ``scenes.model_files.names.animal_names``).

    Raises InputError for another name or a bad file.
    """
    if name not in animal_names():
        raise InputError("animal", name, f"one of {', '.join(animal_names())}")
    return load_animal(resources.files("scenes.models.animals") / f"{name}.toml")


@lru_cache(maxsize=16)
def animal(name: str) -> RiggedPrototype:
    """Make the animal of a name, walking, hopping or turning; it is the same for every seed."""
    tables = animal_tables(name)
    return with_gait(build_prototype(name, tables.anatomy, tables.build), tables.gait)
