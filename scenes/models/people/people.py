"""Who stands in a crowd: posable adults and children, with limits of their joints.

A person is written as an animal is: ``person.toml`` holds skeleton, sticks, limits and gait, and
says where they are from.

Children: the head takes up a larger share of the stature and the legs a smaller one. Head 1/6 at
six years and 1/7 at twelve against 1/7.7 in the tables (Stratz, "Der Körper des Kindes", 1909;
Medawar, "Size, shape and age", 1945); sitting height 0.55 and 0.525 of stature against 0.52
(Bogin & Varela-Silva, "Leg length, body proportion, and health", Int. J. Environ. Res. Public
Health 7:1047, 2010).
"""

from dataclasses import replace
from functools import cache, lru_cache
from importlib import resources

import numpy as np

from lod.errors import InputError
from scenes.models.animals.animal_file import AnimalTables, load_animal
from scenes.models.people.variation import Person, random_adult
from scenes.rig.anatomy import Anatomy, Build, Rod
from scenes.rig.build import build_prototype
from scenes.rig.rigged_prototype import RiggedPrototype
from scenes.sticks.prototype import Prototype

BUST = (Rod("chest", (0.010, 0.034, 0.032), (0.019, 0.037, 0.008), 0.046, 0.042, "top", True),)
LONG_HAIR = (
    Rod("head", (-0.022, 0.022, 0.055), (-0.034, 0.030, -0.030), 0.0320, 0.0220, "hair", True),
    Rod("head", (-0.034, 0, 0.040), (-0.044, 0, -0.045), 0.0330, 0.0240, "hair"),
)

_HEAD, _LEG = 0.13, 0.525
"""Shares of stature in the tables: chin to crown, and sole to hip."""


@cache
def human_tables() -> AnimalTables:
    """Return the tables of people: anatomy, rest pose, limits, and the gait of their legs."""
    return load_animal(resources.files("scenes.models.people") / "person.toml")


def person_build(who: Person, age: float | None = None) -> Build:
    """Say how this person differs from the tables; ``age`` is None for an adult, else in years."""
    shape = {"shoulder": who.shoulders, "hip": who.hips}
    return Build(who.stature, who.materials, who.girth, shape, child_sizes(age) if age else {})


def child_sizes(age: float) -> dict[str, float]:
    """Return the factors on lengths in the frames of joints, for a child of 4 to 16 years."""
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


def person_anatomy(who: Person) -> Anatomy:
    """Return the tables of people, with bust and long hair where this person has them."""
    tables = human_tables().anatomy
    more = {"chest": BUST if who.bust else (), "cranium": LONG_HAIR if who.long_hair else ()}
    own = {name: tables.parts[name] for name in more}
    worn = {name: part._replace(body=(*part.body, *more[name])) for name, part in own.items()}
    return replace(tables, parts={**tables.parts, **worn})


@lru_cache(maxsize=16)
def people_at_rest(seed: int, count: int, children: float = 0.2) -> tuple[RiggedPrototype, ...]:
    """Make ``count`` people at rest, a share of them children; the k-th follows from seed and k.

    Raises InputError for a count below 1 or a share outside 0 to 1.
    """
    if count < 1:
        raise InputError("species.figure.prototypes", count, "at least one prototype")
    if not 0 <= children <= 1:
        raise InputError("species.figure.children", children, "a share, 0 to 1")
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
    who, age = random_adult(rng), None
    if rng.random() < children:
        age = float(rng.uniform(5.0, 12.0))
        who = _as_child(who, age, rng)
    return build_prototype(f"figure {k}", person_anatomy(who), person_build(who, age))


def _as_child(who: Person, age: float, rng: np.random.Generator) -> Person:
    """The person as a child. Median statures: CDC growth charts (2000), rounded; spread 4.5 %."""
    median = np.interp(age, (4, 6, 8, 10, 12), (1.02, 1.15, 1.28, 1.385, 1.50))
    stature = float(median * np.clip(rng.normal(1.0, 0.045), 0.9, 1.1))
    return replace(who, stature=stature, bust=False, shoulders=0.93, hips=0.95)
