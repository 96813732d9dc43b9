"""How an animal is written in its TOML file, what is refused, and which animals there are.

One file describes one kind of animal: height and colours, joints, parts with the sticks of their
two appearances (``scenes.figures.anatomy``), and gait (``scenes.figures.gait``).
``docs/extend.md`` shows how to write one. Every TOML file of the folder ``animals`` is one,
by the name of the file.

An insect and a windmill stand with the animals: the paper's two doubtful cases (§2.3). Blake
conjectures that parts shrink with depth in the hierarchy for living things of about our size alone;
insects and artifacts are here to put that to the test.
"""

from collections.abc import Sequence
from functools import lru_cache
from importlib import resources
from importlib.resources.abc import Traversable
from typing import TypeVar

from lod.errors import InputError
from scenes.figures.anatomy import (
    MEAN,
    SIDES,
    Anatomy,
    Build,
    Colour,
    Positive,
    Rod,
    build_prototype,
)
from scenes.figures.gait import Gait, with_gait
from scenes.model_files.names import animal_names
from scenes.model_files.parameter_file import read_model_file
from scenes.rig.rigged_prototype import RiggedPrototype


class AnimalFile(Anatomy):
    """The whole file. Lengths are in any one unit: ``height`` says what they amount to.

    height  of its highest point as it stands [m]
    materials  linear Rec.709 albedo of each, 0 to 1
    """

    height: Positive
    materials: dict[str, Colour]
    gait: Gait


File = TypeVar("File", bound=AnimalFile)


def load_animal(file: Traversable, kind: type[File]) -> File:
    """Read the tables of an animal's file. Raises InputError for the first thing wrong with it."""
    animal = read_model_file(file, kind, {})
    _check_names(animal, file.name)
    return animal


def _check_names(file: AnimalFile, source: str) -> None:
    joints = [""]
    for table, own in (("joints", file.joints), ("side_joints", file.side_joints)):
        for name, joint in own.items():
            _check_name(f"{source}: {table}.{name}.parent", joint.parent, joints, "above it")
            joints.append(name)
    parts: list[str] = []
    sided = [f"{side} {name}" for side in SIDES for name in file.side_joints]
    for table, tables in (("parts", file.parts), ("side_parts", file.side_parts)):
        for name, part in tables.items():
            where = f"{source}: {table}.{name}"
            _check_name(f"{where}.whole", part.whole, parts or ("",), "above it")
            _check_name(f"{where}.joint", part.joint, joints[1:], "of this file")
            _check_sticks(f"{where}.body", part.body, joints[1:], file)
            _check_sticks(f"{where}.leaf", part.leaf, joints[1:], file)
            _check_sticks(f"{where}.core", part.core, joints[1:] + sided, file)
            parts.append(name)
    gait = file.gait
    for k, leg in enumerate(gait.legs):
        bones = {"hip": leg.hip, "knee": leg.knee, "ankle": leg.ankle}
        bones |= {f"toes[{i}]": toe for i, toe in enumerate(leg.toes)}
        for key, bone in bones.items():
            where = f"{source}: gait.legs[{k}].{key}"
            _check_name(where, bone, tuple(file.side_joints), "of side_joints")
    for k, wave in enumerate(gait.waves):
        _check_name(f"{source}: gait.waves[{k}].joint", wave.joint, joints, "of this file")
    for k, spin in enumerate(gait.spins):
        _check_name(f"{source}: gait.spins[{k}].joint", spin.joint, joints[1:], "of this file")


def _check_sticks(
    where: str, sticks: Sequence[Rod], joints: Sequence[str], file: AnimalFile
) -> None:
    for k, stick in enumerate(sticks):
        if stick.joint is not None:
            _check_name(f"{where}[{k}].joint", stick.joint, joints, "of this file")
        materials = (*file.materials, MEAN)
        _check_name(f"{where}[{k}].material", stick.material, materials, "of this file")


def _check_name(where: str, name: str, known: Sequence[str], which: str) -> None:
    if name not in known:
        raise InputError(where, name, f"one of {', '.join(map(repr, known))}, {which}")


@lru_cache(maxsize=16)
def animal_tables(name: str) -> AnimalFile:
    """Return the tables of the animal of a name (see ``scenes.model_files.names.animal_names``).

    Raises InputError for another name or a bad file.
    """
    if name not in animal_names():
        raise InputError("animal", name, f"one of {', '.join(animal_names())}")
    return load_animal(resources.files("scenes.figures") / "animals" / f"{name}.toml", AnimalFile)


@lru_cache(maxsize=16)
def animal(name: str) -> RiggedPrototype:
    """Make the animal of a name, walking, hopping or turning; it is the same for every seed."""
    tables = animal_tables(name)
    return with_gait(
        build_prototype(name, tables, Build(tables.height, tables.materials)), tables.gait
    )
