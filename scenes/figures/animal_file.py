"""How an animal is written in its TOML file, what is refused, and which animals there are.

One file describes one kind of animal: height and colours, joints, parts with the sticks of their
two appearances (``scenes.figures.anatomy``), and gait (``scenes.figures.gait``).
``docs/extend.md`` shows how to write one. Every TOML file of the folder ``animals`` is one,
by the name of the file.

An insect and a windmill stand with the animals: the paper's two doubtful cases (§2.3). Blake
conjectures that parts shrink with depth in the hierarchy for living things of about our size alone;
insects and artifacts are here to put that to the test.

Who stands and walks in a crowd: posable adults and children, each with a gait of their own.

A person is written as an animal is: ``person.toml`` holds skeleton, sticks, limits and gait, and
says where they are from.

Children: the head takes up a larger share of the stature and the legs a smaller one. Head 1/6 at
six years and 1/7 at twelve against 1/7.7 in the tables (Stratz, "Der Körper des Kindes", 1909;
Medawar, "Size, shape and age", 1945); sitting height 0.55 and 0.525 of stature against 0.52
(Bogin & Varela-Silva, "Leg length, body proportion, and health", Int. J. Environ. Res. Public
Health 7:1047, 2010).

Gaits are after Perry & Burnfield, "Gait Analysis" (2nd ed. 2010), and Winter, "Biomechanics and
Motor Control of Human Movement" (4th ed. 2009): the pelvis turns 5° and lists 3° to each side, the
chest turns against it, the head stays. Arms swing against the legs; ``person.toml`` says how these
move.
"""

from collections.abc import Sequence
from dataclasses import replace
from functools import cache, lru_cache
from importlib import resources
from importlib.resources.abc import Traversable
from typing import TypeVar

import numpy as np

from lod.errors import InputError
from scenes.figures.anatomy import (
    MEAN,
    SIDES,
    Anatomy,
    Build,
    Colour,
    Positive,
    Rod,
    Table,
    build_prototype,
)
from scenes.figures.gait import AXES, Gait, Wave, with_gait
from scenes.model_files import animal_names, read_model_file
from scenes.rig.rigged_prototype import RiggedPrototype
from scenes.sticks.prototype import Prototype


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
    """Return the tables of the animal of a name (see ``scenes.model_files.animal_names``).

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


class Variation(Table):
    """What people vary in: linear albedos, rows of them that go together, and sticks of some."""

    skins: tuple[Colour, ...]
    hairs: tuple[Colour, ...]
    clothes: tuple[Colour, ...]
    hair_of_skin: tuple[tuple[int, ...], ...]
    tops: tuple[int, ...]
    bottoms: tuple[int, ...]
    bust: tuple[Rod, ...]
    long_hair: tuple[Rod, ...]


class PersonFile(AnimalFile):
    """The file of people: an animal's, and what they vary in."""

    variation: Variation


def _materials(rng: np.random.Generator) -> dict[str, tuple[float, float, float]]:
    of = human_tables().variation
    tone = int(rng.integers(len(of.skins)))
    skin, hair = of.skins[tone], of.hairs[rng.choice(of.hair_of_skin[tone])]
    top, bottom = of.clothes[rng.choice(of.tops)], of.clothes[rng.choice(of.bottoms)]
    short_sleeves, shorts = rng.random() < 0.5, rng.random() < 0.25
    return {
        "skin": skin,
        "hair": hair,
        "top": top,
        "sleeve": skin if short_sleeves else top,
        "bottom": bottom,
        "shin": skin if shorts else bottom,
        "eye": (0.02, 0.015, 0.012),
        "lip": tuple(np.round(np.multiply(skin, (0.85, 0.55, 0.55)), 4).tolist()),
    }


_HEAD, _LEG = 0.13, 0.525  # shares of stature in the tables: chin to crown, and sole to hip


@cache
def human_tables() -> PersonFile:
    """Return the tables of people: anatomy, rest pose, limits, and the gait of their legs."""
    return load_animal(resources.files("scenes.figures") / "person.toml", PersonFile)


def child_sizes(age: float) -> dict[str, float]:
    """Compute the factors on lengths in the frames of joints, for a child of 4 to 16 years."""
    head = np.interp(age, (4, 6, 12, 16), (1 / 5.5, 1 / 6, 1 / 7, _HEAD))
    sitting = np.interp(age, (4, 6, 12, 16), (0.565, 0.55, 0.525, 0.52))
    leg = _LEG * (1 - sitting) / (1 - 0.52)
    whole = (1 - _HEAD - _LEG) / (1 - head - leg)
    skull, shank = float(head * whole / _HEAD), float(leg * whole / _LEG)
    toes = human_tables().gait.legs[0].toes
    return {
        **dict.fromkeys(("head", "eye", "ear", "nose", "mouth"), skull),
        **dict.fromkeys(("hip", "knee", "ankle", *toes), shank),
    }


@lru_cache(maxsize=16)
def people_at_rest(seed: int, count: int, children: float = 0.2) -> tuple[RiggedPrototype, ...]:
    """Make ``count`` people at rest, a share of them children; the k-th follows from seed and k."""
    return tuple(_random_person(seed, k, children) for k in range(count))


@lru_cache(maxsize=16)
def standing_people(seed: int, count: int) -> tuple[Prototype, ...]:
    """Make ``count`` adults in the one pose of figs 1 and 2; the k-th follows from seed and k.

    The origin of a person (and of its torso) is the pelvis; every other part's is the joint at its
    near end. The person faces +x, both soles on z = 0. P, R and B hold for every pose.
    """
    return tuple(person.posed() for person in people_at_rest(seed, count, children=0.0))


def _random_person(seed: int, k: int, children: float) -> RiggedPrototype:
    rng = np.random.Generator(np.random.Philox(np.random.SeedSequence((seed, 0xF16, k))))
    woman = bool(rng.random() < 0.5)
    # Mean statures of adults are after NCD-RisC (eLife 5:e13410, 2016), rounded.
    stature = float(np.clip(rng.normal(1.63 if woman else 1.76, 0.06), 1.48, 1.96))
    girth = float(np.clip(rng.normal(1.0, 0.06), 0.90, 1.15))
    shoulders = float(rng.normal(0.94 if woman else 1.02, 0.02))
    hips = float(rng.normal(1.05 if woman else 0.99, 0.02))
    has_long_hair = bool(rng.random() < (0.75 if woman else 0.08))
    materials, sizes = _materials(rng), dict[str, float]()
    if rng.random() < children:
        age = float(rng.uniform(5.0, 12.0))
        # Median statures: CDC growth charts (2000), rounded; spread 4.5 %.
        median = np.interp(age, (4, 6, 8, 10, 12), (1.02, 1.15, 1.28, 1.385, 1.50))
        stature = float(median * np.clip(rng.normal(1.0, 0.045), 0.9, 1.1))
        woman, shoulders, hips, sizes = False, 0.93, 0.95, child_sizes(age)
    tables = human_tables()
    bust, long_hair = tables.variation.bust, tables.variation.long_hair
    more = {"chest": bust if woman else (), "cranium": long_hair if has_long_hair else ()}
    worn = {
        name: tables.parts[name].model_copy(update={"body": tables.parts[name].body + rods})
        for name, rods in more.items()
    }
    anatomy = tables.model_copy(update={"parts": {**tables.parts, **worn}})
    build = Build(stature, materials, girth, {"shoulder": shoulders, "hip": hips}, sizes)
    return build_prototype(f"figure {k}", anatomy, build)


def walking_gait(
    froude: float = 0.22,
    swing: float = 20.0,
    elbow: float = 24.0,
    lean: float = 2.0,
    spread: float = 0.055,
    nod: float = 0.0,
) -> Gait:
    """Make a gait of a person.

    swing  of the arms to each side; elbow, lean, nod: how bent [degrees]
    froude  speed²/(g·hip height); spread: of the feet from the middle [shares of hip height]
    """
    gait = human_tables().gait
    x, y, z = AXES
    waves = (
        Wave("", y, 0.016, peak=0.31),  # over the foot that stands
        Wave("", z, 0.024, cycles=2, peak=0.50),  # highest in mid-stance
        Wave("pelvis", z, -5.0, peak=0.02),
        Wave("pelvis", x, 3.0, peak=0.20),
        Wave("pelvis", y, 0.0, mean=lean),
        Wave("waist", z, 5.0, peak=0.02),
        Wave("waist", x, -2.0, peak=0.20),
        Wave("chest", z, 4.0, peak=0.02),
        Wave("chest", x, -1.5, peak=0.20),
        Wave("chest", y, 0.0, mean=lean),
        Wave("neck", z, -2.0, peak=0.02),
        Wave("neck", y, 0.0, mean=nod - lean),
        Wave("head", z, -2.0, peak=0.02),
        Wave("head", x, 0.5, peak=0.20),
        Wave("head", y, 1.0, cycles=2, peak=0.50, mean=nod - lean),
        Wave("shoulder", y, swing, peak=0.02, mean=4.0),
        Wave("shoulder", x, 0.0, mean=7.0),
        Wave("elbow", y, -0.5 * elbow, peak=0.55, mean=-elbow),
        Wave("wrist", x, 3.0, peak=0.1, mean=-6.0),
    )
    legs = (replace(gait.legs[0], spread=spread),)
    return replace(gait, legs=legs, waves=waves, froude=froude)


def random_gait(rng: np.random.Generator) -> Gait:
    """Draw a random gait of one person: speed, arms, bearing.

    The stride is the longest of all who walk with this gait: theirs (``patrol.stride_factors``)
    have 0.74 of its Froude number on average. People out walking are then near Froude 0.21 or
    1.35 m/s: adults up to 69 years choose 1.24 (women over 60) to 1.43 m/s (men in their forties;
    Bohannon & Andrews, "Normal walking speed: a descriptive meta-analysis", Physiotherapy 97:182,
    2011).
    """
    return walking_gait(
        froude=float(np.clip(rng.normal(0.28, 0.04), 0.18, 0.36)),
        swing=float(rng.uniform(12.0, 26.0)),
        elbow=float(rng.uniform(12.0, 34.0)),
        lean=float(rng.uniform(0.5, 3.5)),
        spread=float(rng.uniform(0.04, 0.075)),
        nod=float(rng.uniform(-3.0, 6.0)),
    )


def walking_people(people: tuple[RiggedPrototype, ...], seed: int) -> tuple[RiggedPrototype, ...]:
    """Give each of the people a gait of their own; the k-th depends on the seed and k only."""
    seeds = (np.random.SeedSequence((seed, 0x3A17, k)) for k in range(len(people)))
    gaits = (random_gait(np.random.Generator(np.random.Philox(each))) for each in seeds)
    return tuple(with_gait(who, gait) for who, gait in zip(people, gaits, strict=True))
