"""How people walk, each with a gait of their own.

After Perry & Burnfield, "Gait Analysis" (2nd ed. 2010), and Winter, "Biomechanics and Motor Control
of Human Movement" (4th ed. 2009): the pelvis turns 5° and lists 3° to each side, the chest turns
against it, the head stays. Arms swing against the legs; ``person.toml`` says how these move.
"""

from dataclasses import replace

import numpy as np

from scenes.gait.gait import with_gait
from scenes.gait.parameters import AXES, Gait, Wave
from scenes.models.people.people import human_tables
from scenes.rig.rigged_prototype import RiggedPrototype


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
    legs, waves = (replace(gait.legs[0], spread=spread),), _waves(swing, elbow, lean, nod)
    return replace(gait, legs=legs, waves=waves, froude=froude)


def _waves(swing: float, elbow: float, lean: float, nod: float) -> tuple[Wave, ...]:
    x, y, z = AXES
    return (
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


def random_gait(rng: np.random.Generator, child: bool = False) -> Gait:
    """Draw a random gait of one person: speed, arms, bearing.

    The stride is the longest of all who walk with this gait: theirs (``patrol.stride_factors``)
    have 0.74 of its Froude number on average. People out walking are then near Froude 0.21 or
    1.35 m/s: adults up to 69 years choose 1.24 (women over 60) to 1.43 m/s (men in their forties;
    Bohannon & Andrews, "Normal walking speed: a descriptive meta-analysis", Physiotherapy 97:182,
    2011).
    """
    return walking_gait(
        froude=float(np.clip(rng.normal(0.28, 0.04), 0.18, 0.36)),
        swing=float(rng.uniform(12.0, 26.0) * (1.15 if child else 1.0)),
        elbow=float(rng.uniform(12.0, 34.0)),
        lean=float(rng.uniform(0.5, 3.5)),
        spread=float(rng.uniform(0.04, 0.075)),
        nod=float(rng.uniform(-3.0, 6.0)),
    )


def walking_people(people: tuple[RiggedPrototype, ...], seed: int) -> tuple[RiggedPrototype, ...]:
    """Give each of the people a gait of their own; the k-th depends on the seed and k only."""
    styles = (
        random_gait(
            np.random.Generator(np.random.Philox(np.random.SeedSequence((seed, 0x3A17, k))))
        )
        for k in range(len(people))
    )
    return tuple(with_gait(who, gait) for who, gait in zip(people, styles, strict=True))
