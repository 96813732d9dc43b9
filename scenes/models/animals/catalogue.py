"""Which animals there are: every TOML file of this folder is one, by the name of the file.

An insect and a windmill stand with the animals: the paper's two doubtful cases (§2.3). Blake
conjectures that parts shrink with depth in the hierarchy for living things of about our size alone;
insects and artifacts are here to put that to the test.
"""

from functools import lru_cache
from pathlib import Path

from lod.errors import InputError
from scenes.gait.gait import with_gait
from scenes.models.animals.animal_file import AnimalTables, load_animal
from scenes.rig.build import build_prototype
from scenes.rig.rigged_prototype import RiggedPrototype

_FILES = {path.stem: path for path in sorted(Path(__file__).parent.glob("*.toml"))}

ANIMALS = tuple(_FILES)
"""Names of all animals, in alphabetical order."""


@lru_cache(maxsize=16)
def animal_tables(name: str) -> AnimalTables:
    """The tables of one of ``ANIMALS``. Raises InputError for another name or a bad file."""
    if name not in _FILES:
        raise InputError("animal", name, f"one of {', '.join(ANIMALS)}")
    return load_animal(_FILES[name])


@lru_cache(maxsize=16)
def animal(name: str) -> RiggedPrototype:
    """One of ``ANIMALS``, walking, hopping or turning; one prototype, whatever the seed."""
    tables = animal_tables(name)
    return with_gait(build_prototype(name, tables.anatomy, tables.build), tables.gait)
