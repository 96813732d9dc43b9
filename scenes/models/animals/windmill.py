"""A tower mill in tables, in metres: the second of the paper's two doubtful cases, an artifact
(§2.3).

Its sails hang on a hub far smaller than they are: "artifacts can always have big bits tacked
on".
A hub does not stand for its sails, so it has no leaf appearance but its own.
"""

import math

import numpy as np

from scenes.gait.gait import Gait
from scenes.models.animals.kind import Kind
from scenes.rig.anatomy import Anatomy, Build, Joint, Part, Rod

_MILL = {
    "wall": (0.72, 0.68, 0.60),
    "wood": (0.22, 0.13, 0.07),
    "canvas": (0.80, 0.77, 0.68),
    "door": (0.06, 0.14, 0.10),
}

_SAILS = {f"sail {k + 1}": 90.0 * k + 20.0 for k in range(4)}

_ROUND = [(math.cos(a), math.sin(a)) for a in np.radians(np.arange(0.0, 360.0, 45.0)).tolist()]

WINDMILL = Kind(
    anatomy=Anatomy(
        joints={
            "foot": Joint("", (0, 0, 0)),
            "cap": Joint("foot", (0, 0, 9.4)),
            "hub": Joint("cap", (2.2, 0, 0.7)),
            "fantail": Joint("cap", (-2.6, 0, 0.6)),
            **{sail: Joint("hub", (0.25, 0, 0)) for sail in _SAILS},
        },
        side_joints={},
        parts={
            "windmill": Part("", 0, "foot"),
            "tower": Part("windmill", 1, "foot"),
            "door": Part("tower", 3, "foot"),
            "cap": Part("windmill", 1, "cap"),
            "fantail": Part("cap", 2, "fantail"),
            "hub": Part("cap", 2, "hub"),
            **{sail: Part("hub", 2, sail) for sail in _SAILS},
            **{f"{sail} stock": Part(sail, 3, sail) for sail in _SAILS},
            **{f"{sail} canvas": Part(sail, 3, sail) for sail in _SAILS},
        },
        side_parts={},
        body={
            "tower": [
                *(
                    Rod("foot", (1.5 * x, 1.5 * y, 0.8), (0.9 * x, 0.9 * y, 6.5), 0.8, 0.8, "wall")
                    for x, y in _ROUND
                ),
                Rod("foot", (0, 0, 2.3), (0, 0, 5.5), 2.3, 1.9, "wall"),
                Rod("foot", (0, 0, 5.5), (0, 0, 8.6), 1.9, 1.5, "wall"),
            ],
            "door": [Rod("foot", (2.02, 0, 0.45), (1.90, 0, 1.6), 0.45, 0.45, "door")],
            "cap": [Rod("cap", (-0.5, 0, 0.1), (0.7, 0, 0.2), 1.50, 1.30, "wood")],
            "fantail": [
                Rod("fantail", (1.2, 0, 0), (0, 0, 0), 0.09, 0.07, "wood"),
                Rod("fantail", (0, 0, -0.8), (0, 0, 0.8), 0.16, 0.16, "canvas"),
                Rod("fantail", (0, -0.8, 0), (0, 0.8, 0), 0.16, 0.16, "canvas"),
            ],
            "hub": [Rod("hub", (-0.7, 0, -0.1), (0.25, 0, 0), 0.24, 0.28, "wood")],
            **{
                f"{sail} stock": [Rod(sail, (0, 0, 0), (0, 0, 7.6), 0.16, 0.07, "wood")]
                for sail in _SAILS
            },
            **{
                f"{sail} canvas": [
                    Rod(
                        sail,
                        (0, 0.25 + 0.36 * i, 1.6),
                        (0, 0.25 + 0.36 * i, 7.3),
                        0.19,
                        0.19,
                        "canvas",
                    )
                    for i in range(4)
                ]
                for sail in _SAILS
            },
        },
        side_body={},
        leaf={
            "tower": [Rod("foot", (0, 0, 2.3), (0, 0, 8.6), 2.3, 1.5, "wall")],
            **{
                sail: [Rod(sail, (0, 0.55, 1.2), (0, 0.75, 7.0), 0.6, 0.6, "canvas")]
                for sail in _SAILS
            },
        },
        side_leaf={},
        rest={sail: (angle, 0, 0) for sail, angle in _SAILS.items()},
        limits={"cap": ((0, 0, -180), (0, 0, 180)), "hub": ((-180, 0, 0), (180, 0, 0))},
        shift=((0, 0, 0), (0, 0, 0)),
    ),
    build=Build(18.0, _MILL),
    gait=Gait(legs=(), waves=(), stride=0.0, period=6.0, spins=(("hub", 0, 1),)),
)
