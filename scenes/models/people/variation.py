"""What people vary in: stature, build, and the tints of skin, hair and clothes."""

from dataclasses import dataclass

import numpy as np

SKINS = (
    (0.60, 0.38, 0.27),
    (0.52, 0.31, 0.20),
    (0.38, 0.21, 0.13),
    (0.24, 0.13, 0.08),
    (0.12, 0.065, 0.04),
)
HAIRS = (
    (0.018, 0.014, 0.012),
    (0.055, 0.032, 0.020),
    (0.14, 0.075, 0.035),
    (0.34, 0.23, 0.11),
    (0.30, 0.29, 0.28),
)
CLOTHES = (
    (0.62, 0.60, 0.55),  # linen
    (0.42, 0.06, 0.05),  # madder
    (0.05, 0.11, 0.30),  # indigo
    (0.09, 0.20, 0.24),  # petrol
    (0.52, 0.33, 0.06),  # ochre
    (0.16, 0.19, 0.10),  # olive
    (0.06, 0.06, 0.07),  # charcoal
    (0.25, 0.19, 0.13),  # brown
)
HAIR_OF_SKIN = ((0, 1, 2, 3, 4), (0, 1, 2, 4), (0, 1, 4), (0, 1, 4), (0, 4))
TOPS = (0, 1, 2, 3, 4, 5)
BOTTOMS = (2, 6, 7, 5, 0)


@dataclass(frozen=True)
class Person:
    """One person. Lengths are factors on those of ``skeleton``, stature in metres.

    materials: linear albedo of every material that the tables name.
    """

    stature: float
    girth: float
    shoulders: float
    hips: float
    bust: bool
    long_hair: bool
    materials: dict[str, tuple[float, float, float]]


def random_adult(rng: np.random.Generator) -> Person:
    """Draw an adult; mean statures are after NCD-RisC (eLife 5:e13410, 2016), rounded."""
    woman = bool(rng.random() < 0.5)
    stature = rng.normal(1.63 if woman else 1.76, 0.06)
    return Person(
        stature=float(np.clip(stature, 1.48, 1.96)),
        girth=float(np.clip(rng.normal(1.0, 0.06), 0.90, 1.15)),
        shoulders=float(rng.normal(0.94 if woman else 1.02, 0.02)),
        hips=float(rng.normal(1.05 if woman else 0.99, 0.02)),
        bust=woman,
        long_hair=bool(rng.random() < (0.75 if woman else 0.08)),
        materials=_materials(rng),
    )


def _materials(rng: np.random.Generator) -> dict[str, tuple[float, float, float]]:
    tone = int(rng.integers(len(SKINS)))
    skin, hair = SKINS[tone], HAIRS[rng.choice(HAIR_OF_SKIN[tone])]
    top, bottom = CLOTHES[rng.choice(TOPS)], CLOTHES[rng.choice(BOTTOMS)]
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
