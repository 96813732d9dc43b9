"""A stick insect in tables, in centimetres: the first of the paper's two doubtful cases (§2.3).

Of the build of Carausius morosus (Cruse, Biol. Cybern. 24:25, 1976): legs and feelers as long as
the body is thin, walking on alternating tripods. What is between is our own.
"""

from scenes.gait.foot_path import Leg
from scenes.gait.gait import Gait, Wave
from scenes.models.animals.kind import Kind, free, hinge
from scenes.rig.anatomy import Anatomy, Build, Joint, Part, Rod

_CHITIN = {"shell": (0.14, 0.20, 0.05), "joint": (0.28, 0.14, 0.05), "dark": (0.02, 0.02, 0.01)}

_LEGS = {  # where the hip sits (x, y), and the heading of the leg at rest [degrees]
    "fore": ((2.3, 0.25), 48.0),
    "mid": ((0.3, 0.28), 92.0),
    "hind": ((-1.3, 0.28), 132.0),
}

INSECT = Kind(
    anatomy=Anatomy(
        joints={
            "thorax": Joint("", (0, 0, 2.2)),
            "head": Joint("thorax", (2.6, 0, 0.05)),
            "abdomen": Joint("thorax", (-1.5, 0, 0.0)),
            "tip": Joint("abdomen", (-2.2, 0, 0)),
        },
        side_joints={
            "feeler": Joint("head", (0.45, 0.12, 0.12)),
            "feeler end": Joint("feeler", (2.0, 0, 0)),
            "eye": Joint("head", (0.22, 0.20, 0.10)),
            "jaw": Joint("head", (0.42, 0.06, -0.12)),
            **{f"{leg} hip": Joint("thorax", (*at, -0.08)) for leg, (at, _) in _LEGS.items()},
            **{f"{leg} knee": Joint(f"{leg} hip", (0, 0, -2.2)) for leg in _LEGS},
            **{f"{leg} ankle": Joint(f"{leg} knee", (0, 0, -2.7)) for leg in _LEGS},
        },
        parts={
            "insect": Part("", 0, "thorax"),
            "thorax": Part("insect", 1, "thorax"),
            "head": Part("insect", 1, "head"),
            "abdomen": Part("insect", 1, "abdomen"),
            "abdomen front": Part("abdomen", 2, "abdomen"),
            "abdomen tip": Part("abdomen", 2, "tip"),
        },
        side_parts={
            "feeler": Part("head", 2, "feeler"),
            "feeler base": Part("feeler", 3, "feeler"),
            "feeler end": Part("feeler", 3, "feeler end"),
            "eye": Part("head", 2, "eye"),
            "jaw": Part("head", 2, "jaw"),
            **{f"{leg} leg": Part("insect", 1, f"{leg} hip") for leg in _LEGS},
            **{f"{leg} femur": Part(f"{leg} leg", 2, f"{leg} hip") for leg in _LEGS},
            **{f"{leg} tibia": Part(f"{leg} leg", 2, f"{leg} knee") for leg in _LEGS},
            **{f"{leg} tarsus": Part(f"{leg} tibia", 3, f"{leg} ankle") for leg in _LEGS},
        },
        body={
            "thorax": [
                Rod("thorax", (2.45, 0, 0), (0.3, 0, 0), 0.19, 0.24, "shell"),
                Rod("thorax", (0.3, 0, 0), (-1.5, 0, 0), 0.24, 0.30, "shell"),
            ],
            "head": [Rod("head", (0, 0, 0), (0.36, 0, 0), 0.24, 0.21, "shell")],
            "abdomen front": [Rod("abdomen", (0, 0, 0), (-2.2, 0, 0), 0.30, 0.25, "shell")],
            "abdomen tip": [Rod("tip", (0, 0, 0), (-1.5, 0, 0), 0.25, 0.11, "joint")],
        },
        side_body={
            "feeler base": [Rod("feeler", (0, 0, 0), (2.0, 0, 0), 0.070, 0.050, "joint")],
            "feeler end": [Rod("feeler end", (0, 0, 0), (2.0, 0, 0), 0.050, 0.025, "joint")],
            "eye": [Rod("eye", (0, 0, 0), (0.02, 0, 0), 0.075, 0.075, "dark")],
            "jaw": [Rod("jaw", (0, 0, 0), (0.18, -0.03, -0.08), 0.055, 0.025, "dark")],
            **{
                f"{leg} femur": [Rod(f"{leg} hip", (0, 0, 0), (0, 0, -2.2), 0.13, 0.09, "shell")]
                for leg in _LEGS
            },
            **{
                f"{leg} tibia": [Rod(f"{leg} knee", (0, 0, 0), (0, 0, -2.7), 0.090, 0.055, "shell")]
                for leg in _LEGS
            },
            **{
                f"{leg} tarsus": [
                    Rod(f"{leg} ankle", (0, 0, 0), (0.0, 0, -0.05), 0.055, 0.06, "joint"),
                    Rod(f"{leg} ankle", (0.0, 0, -0.045), (0.55, 0, -0.03), 0.05, 0.04, "joint"),
                ]
                for leg in _LEGS
            },
        },
        leaf={
            "insect": [Rod("thorax", (-3.6, 0, 0), (2.6, 0, 0), 0.4, 0.4, "mean")],
            "head": [Rod("head", (0, 0, 0), (0.46, 0, 0.02), 0.26, 0.22, "shell")],
            "abdomen": [Rod("abdomen", (0, 0, 0), (-3.6, 0, 0), 0.30, 0.14, "shell")],
        },
        side_leaf={
            "feeler": [Rod("feeler", (0, 0, 0), (3.8, 0, 0), 0.065, 0.030, "joint")],
            **{
                f"{leg} leg": [
                    Rod(f"{leg} hip", (0, 0, 0), (0, 0, -2.2), 0.13, 0.09, "shell"),
                    Rod(f"{leg} knee", (0, 0, 0), (0, 0, -2.75), 0.09, 0.06, "shell"),
                ]
                for leg in _LEGS
            },
            **{
                f"{leg} tibia": [Rod(f"{leg} knee", (0, 0, 0), (0, 0, -2.75), 0.09, 0.06, "shell")]
                for leg in _LEGS
            },
        },
        rest={
            "feeler": (0, -16, 24),
            "feeler end": (0, 14, 6),
            **{f"{leg} hip": (0, -112, heading) for leg, (_, heading) in _LEGS.items()},
            **{f"{leg} knee": (0, 96, 0) for leg in _LEGS},
            **{f"{leg} ankle": (0, 16, 0) for leg in _LEGS},
        },
        limits={
            "head": free(20, 30, 30),
            "abdomen": free(10, 40, 30),
            "tip": free(10, 40, 30),
            "feeler": ((-30, -80, -40), (30, 60, 90)),
            "feeler end": free(20, 40, 40),
            "jaw": free(0, 10, 25),
            **{
                f"{leg} hip": ((-15, -165, heading - 55), (15, -40, heading + 55))
                for leg, (_, heading) in _LEGS.items()
            },
            **{f"{leg} knee": hinge(10, 165) for leg in _LEGS},
            **{f"{leg} ankle": ((-60, -60, -60), (60, 80, 60)) for leg in _LEGS},
        },
        shift=((-0.4, -0.3, -1.5), (0.4, 0.3, 0.5)),
    ),
    build=Build(0.036, _CHITIN),
    gait=Gait(
        legs=tuple(
            Leg(
                f"{leg} hip",
                f"{leg} knee",
                f"{leg} ankle",
                strike=0.5 if leg == "mid" else 0.0,
                turnout=heading,
                sticks_out=True,
                clearance=0.28,
            )
            for leg, (_, heading) in _LEGS.items()
        ),
        waves=(
            Wave("feeler", 2, 14.0, peak=0.1),
            Wave("feeler", 1, 8.0, peak=0.35),
            Wave("abdomen", 2, 2.0, peak=0.2),
        ),
        duty=0.56,
        stride=1.0,
        period=0.8,
        tilts=True,
    ),
)
