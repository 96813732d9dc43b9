"""Who stands in a crowd: posable adults and children, with limits of their joints.

Ranges of motion, rounded to the wider of Boone & Azen, "Normal range of motion of joints in male
subjects", J. Bone Joint Surg. 61-A:756 (1979), and the handbook of the American Academy of
Orthopaedic Surgeons (1965). Under load and with the knee bent the ankle bends further up, by 30° at
least (weight-bearing lunge: Bennell et al., Aust. J. Physiother. 44:175, 1998). The spine's and
the neck's are shared out evenly over their two joints. Signs, on the left: about x outwards, about
y back (the spine forwards), about z to the left.

Children: the head takes up a larger share of the stature and the legs a smaller one. Head 1/6 at
six years and 1/7 at twelve against 1/7.7 in the tables (Stratz, "Der Körper des Kindes", 1909;
Medawar, "Size, shape and age", 1945); sitting height 0.55 and 0.525 of stature against 0.52
(Bogin & Varela-Silva, "Leg length, body proportion, and health", Int. J. Environ. Res. Public
Health 7:1047, 2010).
"""

from dataclasses import replace
from functools import cache, lru_cache

import numpy as np

from lod.errors import InputError
from scenes.models.people.body_sticks import (
    BUST,
    LONG_HAIR,
    PERSON_CORE,
    SIDE_BODY,
    SIDE_LEAF,
    TRUNK_BODY,
    TRUNK_LEAF,
)
from scenes.models.people.skeleton import (
    FINGERS,
    SIDE_JOINTS,
    SIDE_PARTS,
    STANDING,
    TOES,
    TRUNK_JOINTS,
    TRUNK_PARTS,
)
from scenes.models.people.variation import Person, random_adult
from scenes.rig.anatomy import Anatomy, Build, Limits
from scenes.rig.build import build_prototype
from scenes.rig.rigged_prototype import RiggedPrototype
from scenes.sticks.prototype import Prototype

_FINGERS = list(FINGERS)[:4]

LIMITS: dict[str, Limits] = {
    "pelvis": ((-10, -15, -15), (10, 15, 15)),
    "waist": ((-18, -13, -23), (18, 40, 23)),
    "chest": ((-18, -13, -23), (18, 40, 23)),
    "neck": ((-23, -23, -35), (23, 23, 35)),
    "head": ((-23, -23, -35), (23, 23, 35)),
    "shoulder": ((-35, -165, -70), (150, 57, 90)),
    "elbow": ((-10, -141, -80), (5, 0, 80)),
    "wrist": ((-75, -21, -15), (74, 35, 5)),
    "hip": ((-27, -121, -44), (45, 30, 44)),
    "knee": ((0, 0, 0), (0, 141, 0)),
    "ankle": ((-36, -30, -25), (20, 54, 25)),
    "thumb joint 1": ((-50, -60, -10), (15, 15, 10)),
    "thumb joint 2": ((-50, -5, 0), (5, 25, 0)),
    "thumb joint 3": ((-80, -5, 0), (20, 25, 0)),
    **{f"{f} joint 1": ((-90, -20, 0), (30, 20, 0)) for f in _FINGERS},
    **{f"{f} joint 2": ((-100, 0, 0), (0, 0, 0)) for f in _FINGERS},
    **{f"{f} joint 3": ((-90, 0, 0), (10, 0, 0)) for f in _FINGERS},
    **{f"{toe} toe": ((0, -70, 0), (0, 45, 0)) for toe in TOES},
}

_HEAD, _LEG = 0.13, 0.525
"""Shares of stature in the tables: chin to crown, and sole to hip."""


@cache
def human_anatomy() -> Anatomy:
    """The tables of people: skeleton, parts, sticks, rest pose and limits."""
    return Anatomy(
        joints=TRUNK_JOINTS,
        side_joints=SIDE_JOINTS,
        parts=TRUNK_PARTS,
        side_parts=SIDE_PARTS,
        body=TRUNK_BODY,
        side_body=SIDE_BODY,
        leaf=TRUNK_LEAF,
        side_leaf=SIDE_LEAF,
        core={"person": PERSON_CORE},
        rest=STANDING,
        limits=LIMITS,
        shift=((-0.02, -0.03, -0.12), (0.02, 0.03, 0.03)),
    )


def person_build(who: Person, age: float | None = None) -> Build:
    """How this person differs from the tables; ``age`` in years for a child, None for an adult."""
    shape = {"shoulder": who.shoulders, "hip": who.hips}
    return Build(who.stature, who.materials, who.girth, shape, child_sizes(age) if age else {})


def child_sizes(age: float) -> dict[str, float]:
    """Factors on lengths in the frames of joints, for a child of 4 to 16 years."""
    head = np.interp(age, (4, 6, 12, 16), (1 / 5.5, 1 / 6, 1 / 7, _HEAD))
    sitting = np.interp(age, (4, 6, 12, 16), (0.565, 0.55, 0.525, 0.52))
    leg = _LEG * (1 - sitting) / (1 - 0.52)
    whole = (1 - _HEAD - _LEG) / (1 - head - leg)
    skull, shank = float(head * whole / _HEAD), float(leg * whole / _LEG)
    return {
        **dict.fromkeys(("head", "eye", "ear", "nose", "mouth"), skull),
        **dict.fromkeys(("hip", "knee", "ankle", *(f"{toe} toe" for toe in TOES)), shank),
    }


def person_anatomy(who: Person) -> Anatomy:
    """The tables of people, with bust and long hair where this person has them."""
    tables = human_anatomy()
    body = dict(tables.body)
    body["chest"] = body["chest"] + (BUST if who.bust else [])
    body["cranium"] = body["cranium"] + (LONG_HAIR if who.long_hair else [])
    return replace(tables, body=body)


@lru_cache(maxsize=16)
def people_at_rest(seed: int, count: int, children: float = 0.2) -> tuple[RiggedPrototype, ...]:
    """``count`` people at rest, a share of them children; the k-th depends on the seed and k only.

    Raises InputError for a count below 1 or a share outside 0 to 1.
    """
    if count < 1:
        raise InputError("species.figure.prototypes", count, "at least one prototype")
    if not 0 <= children <= 1:
        raise InputError("species.figure.children", children, "a share, 0 to 1")
    return tuple(_random_person(seed, k, children) for k in range(count))


@lru_cache(maxsize=16)
def standing_people(seed: int, count: int) -> tuple[Prototype, ...]:
    """``count`` adults in the one pose of figs 1 and 2; the k-th depends on the seed and k only.

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
