"""How an animal is written in its TOML file: the keys, what they mean, and what is refused.

One file describes one kind of animal: height and colours, joints, parts with the sticks of their
two appearances, and gait. ``docs/add-an-animal.md`` shows how to write one.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from importlib.resources.abc import Traversable
from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field, model_validator

from lod.errors import InputError
from scenes.gait.foot_path import Leg
from scenes.gait.gait import Gait, Wave
from scenes.model_files.read import read_model_file
from scenes.rig.anatomy import MEAN, SIDES, Anatomy, Build, Joint, Limits, Part, Rod

Number = Annotated[float, Field(strict=True, allow_inf_nan=False)]
Positive = Annotated[Number, Field(gt=0)]
Share = Annotated[Number, Field(ge=0, le=1)]
Triple = tuple[Number, Number, Number]
Axis = Literal["x", "y", "z"]
_Sticks = Literal["body", "leaf", "core"]


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
    rest: Triple | None = None
    limits: tuple[Triple, Triple] | None = None
    free: Triple | None = None
    hinge: tuple[Number, Number] | None = None

    @model_validator(mode="after")
    def _one_kind_of_limit(self) -> "JointTable":
        if sum(each is not None for each in (self.limits, self.free, self.hinge)) > 1:
            raise ValueError("at most one of limits, free and hinge")
        return self

    @property
    def angles(self) -> Limits | None:
        """Lowest and highest angles about x, y, z [degrees]; None = it stays as it rests."""
        if self.free is not None:
            x, y, z = self.free
            return (0.0 - x, 0.0 - y, 0.0 - z), self.free
        if self.hinge is not None:
            low, high = self.hinge
            return (0.0, low, 0.0), (0.0, high, 0.0)
        return self.limits


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
        """The stick and its copies around z."""
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


class WaveTable(_Table):
    """A swing of a joint, as ``scenes.gait.gait.Wave`` has it, with its axis by name."""

    joint: str
    axis: Axis
    amplitude: Number
    peak: Number = Wave.peak
    cycles: int = Wave.cycles
    mean: Number | None = Wave.mean
    apart: Number = Wave.apart

    def wave(self) -> Wave:
        """The wave by number of its axis."""
        return Wave(**{**self.model_dump(), "axis": "xyz".index(self.axis)})


class SpinTable(_Table):
    """A joint that goes round: whole rounds about an axis in one cycle."""

    joint: str
    axis: Axis
    rounds: int


class GaitTable(_Table):
    """How the animal moves, as ``scenes.gait.gait.Gait`` has it; absent keys have its defaults."""

    legs: tuple[Leg, ...] = ()
    waves: tuple[WaveTable, ...] = ()
    spins: tuple[SpinTable, ...] = ()
    duty: Annotated[Number, Field(gt=0, le=1)] = Gait.duty
    froude: Positive = Gait.froude
    stride: Annotated[Number, Field(ge=0)] | None = Gait.stride
    period: Positive | None = Gait.period
    steepest: Annotated[Number, Field(ge=0)] = Gait.steepest
    tilts: bool = Gait.tilts

    def gait(self) -> Gait:
        """The gait of these tables."""
        return Gait(
            legs=self.legs,
            waves=tuple(wave.wave() for wave in self.waves),
            spins=tuple((s.joint, "xyz".index(s.axis), s.rounds) for s in self.spins),
            **self.model_dump(exclude={"legs", "waves", "spins"}),
        )


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
    gait: GaitTable

    def tables(self) -> AnimalTables:
        """What the rig and the gait are made from."""
        joints = self.joints | self.side_joints
        limits = {name: joint.angles for name, joint in joints.items()}
        anatomy = Anatomy(
            joints=_joints(self.joints),
            side_joints=_joints(self.side_joints),
            parts=_parts(self.parts),
            side_parts=_parts(self.side_parts),
            body=_rods(self.parts, "body"),
            side_body=_rods(self.side_parts, "body"),
            leaf=_rods(self.parts, "leaf"),
            side_leaf=_rods(self.side_parts, "leaf"),
            core=_rods(self.parts, "core"),
            rest={name: joint.rest for name, joint in joints.items() if joint.rest is not None},
            limits={name: angles for name, angles in limits.items() if angles is not None},
            shift=self.shift,
        )
        return AnimalTables(anatomy, Build(self.height, self.materials), self.gait.gait())


def load_animal(file: Traversable) -> AnimalTables:
    """The tables of an animal's file. Raises InputError for the first thing wrong with it."""
    animal = read_model_file(file, AnimalFile, {})
    _check_names(animal, file.name)
    return animal.tables()


def _joints(tables: dict[str, JointTable]) -> dict[str, Joint]:
    return {name: Joint(table.parent, table.at) for name, table in tables.items()}


def _parts(tables: dict[str, PartTable]) -> dict[str, Part]:
    return {name: Part(t.whole, t.level, t.joint) for name, t in tables.items()}


def _rods(tables: dict[str, PartTable], key: _Sticks) -> dict[str, list[Rod]]:
    """The sticks under one key of every part that has any."""
    sticks = {name: getattr(table, key) for name, table in tables.items()}
    return {
        name: [rod for stick in own for rod in stick.rods(tables[name].joint)]
        for name, own in sticks.items()
        if own
    }


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
