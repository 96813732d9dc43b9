"""How an animal is written in its TOML file: the keys, what they mean, and what is refused.

One file describes one kind of animal: height and colours, joints, parts with the sticks of their
two appearances, and gait. ``docs/add-an-animal.md`` shows how to write one.

Which animals there are: every TOML file of this folder is one, by the name of the file.

An insect and a windmill stand with the animals: the paper's two doubtful cases (§2.3). Blake
conjectures that parts shrink with depth in the hierarchy for living things of about our size alone;
insects and artifacts are here to put that to the test.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from importlib import resources
from importlib.resources.abc import Traversable
from typing import Annotated

from pydantic import BaseModel, ConfigDict, Field, model_validator

from lod.errors import InputError
from scenes.figures.anatomy import MEAN, SIDES, Anatomy, Build, Joint, Part, Rod, build_prototype
from scenes.figures.gait import Gait, with_gait
from scenes.model_files.names import animal_names
from scenes.model_files.parameter_file import read_model_file
from scenes.rig.rigged_prototype import RiggedPrototype

Number = Annotated[float, Field(strict=True, allow_inf_nan=False)]
Positive = Annotated[Number, Field(gt=0)]
Share = Annotated[Number, Field(ge=0, le=1)]
Triple = tuple[Number, Number, Number]


@dataclass(frozen=True)
class AnimalTables:
    """One kind of animal: its anatomy, its size and colours, and its way of moving."""

    anatomy: Anatomy
    build: Build
    gait: Gait


class _Table(BaseModel):
    """A table of the file: frozen, and closed to keys that it does not know."""

    model_config = ConfigDict(frozen=True, extra="forbid")


class JointTable(_Table):
    """A joint.

    parent  the joint that carries it; "" = the animal's own frame
    at      its origin in the frame of its parent, where everything hangs at angles 0
    rest    angles about x, y, z as the animal stands [degrees]
    limits, free or hinge: (low, high) angles; as many degrees to either side; low and high about y
        alone. Without any of them the joint does not turn.
    """

    parent: str = ""
    at: Triple
    rest: Triple = (0.0, 0.0, 0.0)
    limits: tuple[Triple, Triple] | None = None
    free: Triple | None = None
    hinge: tuple[Number, Number] | None = None

    @model_validator(mode="after")
    def _one_kind_of_limit(self) -> "JointTable":
        if sum(each is not None for each in (self.limits, self.free, self.hinge)) > 1:
            raise ValueError("at most one of limits, free and hinge")
        return self

    def joint(self) -> Joint:
        """Make the joint, with its limits as lowest and highest angles about x, y, z."""
        limits = self.limits
        if self.free is not None:
            x, y, z = self.free
            limits = (0.0 - x, 0.0 - y, 0.0 - z), self.free
        if self.hinge is not None:
            low, high = self.hinge
            limits = (0.0, low, 0.0), (0.0, high, 0.0)
        return Joint(self.parent, self.at, self.rest, limits)


class RodTable(_Table):
    """A stick: a cone with round ends in the frame of a joint.

    joint   by default that of its part
    radii   at start and end; material: a row of ``materials``, or "mean"
    pair    whether its mirror image in y = 0 is there too
    around  how many copies of it stand evenly around z
    """

    joint: str | None = None
    start: Triple
    end: Triple
    radii: tuple[Positive, Positive]
    material: str
    pair: bool = False
    around: Annotated[int, Field(ge=1)] = 1

    def rods(self, part_joint: str) -> list[Rod]:
        """Make the rods of the stick and of its copies around z."""
        joint = part_joint if self.joint is None else self.joint
        turns = [math.radians(360.0 * k / self.around) for k in range(self.around)]
        ends = [(_turned(self.start, turn), _turned(self.end, turn)) for turn in turns]
        return [Rod(joint, *end, *self.radii, self.material, self.pair) for end in ends]


class PartTable(_Table):
    """A part of the detail hierarchy.

    whole  the part that owns it; only the first part of the file has none
    level  of detail; joint: the joint that its origin rides on
    body   sticks of its own, shown beside its parts; leaf: sticks that stand for all of it
    core   sticks hidden inside the parts of a part of the trunk, where it has no body
    """

    whole: str = ""
    level: Annotated[int, Field(ge=0)]
    joint: str
    body: tuple[RodTable, ...] = ()
    leaf: tuple[RodTable, ...] = ()
    core: tuple[RodTable, ...] = ()

    def part(self) -> Part:
        """Make the part, with the rods of its sticks."""
        rods = (
            tuple(rod for stick in sticks for rod in stick.rods(self.joint))
            for sticks in (self.body, self.leaf, self.core)
        )
        return Part(self.whole, self.level, self.joint, *rods)


class AnimalFile(_Table):
    """The whole file. Lengths are in any one unit: ``height`` says what they amount to.

    height  of its highest point as it stands [m]
    shift   (low, high) how far it may sway and bob as it walks on the spot
    materials  linear Rec.709 albedo of each, 0 to 1
    joints, parts  those of the trunk; ``side_``: those of the left side, mirrored on the right
    """

    height: Positive
    shift: tuple[Triple, Triple]
    materials: dict[str, tuple[Share, Share, Share]]
    joints: dict[str, JointTable]
    side_joints: dict[str, JointTable] = {}
    parts: dict[str, PartTable]
    side_parts: dict[str, PartTable] = {}
    gait: Gait

    def tables(self) -> AnimalTables:
        """Make the tables that rig and gait are built from."""
        joints, side_joints = (
            {name: table.joint() for name, table in tables.items()}
            for tables in (self.joints, self.side_joints)
        )
        parts, side_parts = (
            {name: table.part() for name, table in tables.items()}
            for tables in (self.parts, self.side_parts)
        )
        anatomy = Anatomy(joints, side_joints, parts, side_parts, self.shift)
        return AnimalTables(anatomy, Build(self.height, self.materials), self.gait)


def load_animal(file: Traversable) -> AnimalTables:
    """Read the tables of an animal's file. Raises InputError for the first thing wrong with it."""
    animal = read_model_file(file, AnimalFile, {})
    _check_names(animal, file.name)
    return animal.tables()


def _turned(point: Triple, angle: float) -> Triple:
    """The point turned about z by an angle [rad]."""
    x, y, z = point
    cos, sin = math.cos(angle), math.sin(angle)
    return cos * x - sin * y, sin * x + cos * y, z


def _check_names(file: AnimalFile, source: str) -> None:
    """Raise InputError where a table names a joint, part or material that is not there."""
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
    where: str, sticks: Sequence[RodTable], joints: Sequence[str], file: AnimalFile
) -> None:
    """Raise InputError where a stick names a joint or a material that is not there."""
    for k, stick in enumerate(sticks):
        if stick.joint is not None:
            _check_name(f"{where}[{k}].joint", stick.joint, joints, "of this file")
        materials = (*file.materials, MEAN)
        _check_name(f"{where}[{k}].material", stick.material, materials, "of this file")


def _check_name(where: str, name: str, known: Sequence[str], which: str) -> None:
    if name not in known:
        raise InputError(where, name, f"one of {', '.join(map(repr, known))}, {which}")


@lru_cache(maxsize=16)
def animal_tables(name: str) -> AnimalTables:
    """Return the tables of the animal of a name (see ``scenes.model_files.names.animal_names``).

    Raises InputError for another name or a bad file.
    """
    if name not in animal_names():
        raise InputError("animal", name, f"one of {', '.join(animal_names())}")
    return load_animal(resources.files("scenes.figures") / "animals" / f"{name}.toml")


@lru_cache(maxsize=16)
def animal(name: str) -> RiggedPrototype:
    """Make the animal of a name, walking, hopping or turning; it is the same for every seed."""
    tables = animal_tables(name)
    return with_gait(build_prototype(name, tables.anatomy, tables.build), tables.gait)
