"""Ostrich, insect and windmill in tables; lengths in metres, but the insect's in centimetres.

Ostrich: bones of the leg after Rubenson et al., "Running in ostriches (Struthio camelus)", J. Exp. Biol.
210:2548 (2007): femur short and level, hidden in the body; the knee that shows is the ankle. Insect: a stick
insect of the build of Carausius morosus (Cruse, Biol. Cybern. 24:25, 1976): legs and antennae as long as
the body is, walking on alternating tripods. Windmill: a tower mill; its sails hang on a hub that is far
smaller than they are. What is between is our own.
"""

from scenes.animals_kind import Kind, free, hinge
from scenes.figure_tables import Joint, Part, Rod
from scenes.gait import Gait, Wave
from scenes.gait_feet import Leg
from scenes.rig_build import Anatomy, Build

_PLUMAGE = {
    "feather": (0.035, 0.03, 0.03),
    "white": (0.78, 0.76, 0.70),
    "skin": (0.48, 0.30, 0.24),
    "dark": (0.02, 0.02, 0.02),
}
_CHITIN = {"shell": (0.14, 0.20, 0.05), "joint": (0.28, 0.14, 0.05), "dark": (0.02, 0.02, 0.01)}
_MILL = {
    "wall": (0.72, 0.68, 0.60),
    "wood": (0.22, 0.13, 0.07),
    "canvas": (0.80, 0.77, 0.68),
    "door": (0.06, 0.14, 0.10),
}

OSTRICH = Kind(
    anatomy=Anatomy(
        joints={
            "trunk": Joint("", (0, 0, 1.22)),
            "neck": Joint("trunk", (0.42, 0, 0.08)),
            "mid neck": Joint("neck", (0, 0, 0.42)),
            "head": Joint("mid neck", (0, 0, 0.50)),
            "beak": Joint("head", (0.075, 0, -0.005)),
            "tail": Joint("trunk", (-0.42, 0, 0.05)),
        },
        side_joints={
            "eye": Joint("head", (0.035, 0.036, 0.020)),
            "wing": Joint("trunk", (0.16, 0.24, 0.08)),
            "plumes": Joint("wing", (-0.34, 0, -0.05)),
            "hip": Joint("trunk", (0.02, 0.15, 0.0)),
            "knee": Joint("hip", (0, 0, -0.29)),
            "ankle": Joint("knee", (0, 0, -0.52)),
            "big toe": Joint("ankle", (0, 0, -0.45)),
            "small toe": Joint("ankle", (0, 0, -0.45)),
        },
        parts={
            "ostrich": Part("", 0, "trunk"),
            "torso": Part("ostrich", 1, "trunk"),
            "neck": Part("ostrich", 1, "neck"),
            "lower neck": Part("neck", 2, "neck"),
            "upper neck": Part("neck", 2, "mid neck"),
            "head": Part("neck", 2, "head"),
            "beak": Part("head", 3, "beak"),
            "tail": Part("ostrich", 1, "tail"),
        },
        side_parts={
            "eye": Part("head", 3, "eye"),
            "wing": Part("ostrich", 1, "wing"),
            "plumes": Part("wing", 2, "plumes"),
            "leg": Part("ostrich", 1, "hip"),
            "thigh": Part("leg", 2, "hip"),
            "drumstick": Part("leg", 2, "knee"),
            "shank": Part("drumstick", 2, "ankle"),
            "big toe": Part("shank", 3, "big toe"),
            "small toe": Part("shank", 3, "small toe"),
        },
        body={
            "torso": [
                Rod("trunk", (0.26, 0, 0.0), (-0.08, 0, 0.03), 0.23, 0.29, "feather"),
                Rod("trunk", (-0.08, 0, 0.03), (-0.38, 0, 0.04), 0.29, 0.17, "feather"),
                Rod("trunk", (0.26, 0, 0.0), (0.42, 0, 0.07), 0.21, 0.09, "feather"),
            ],
            "lower neck": [Rod("neck", (0, 0, 0), (0, 0, 0.42), 0.075, 0.042, "skin")],
            "upper neck": [Rod("mid neck", (0, 0, 0), (0, 0, 0.50), 0.042, 0.034, "skin")],
            "head": [Rod("head", (-0.01, 0, 0.01), (0.05, 0, 0.005), 0.048, 0.040, "skin")],
            "beak": [Rod("beak", (0, 0, 0), (0.09, 0, -0.012), 0.026, 0.013, "dark")],
            "tail": [
                Rod("tail", (0, 0.03, 0), (-0.22, 0.06, 0.12), 0.09, 0.06, "white", True),
                Rod("tail", (0, 0, 0), (-0.26, 0, 0.02), 0.09, 0.05, "white"),
            ],
        },
        side_body={
            "eye": [Rod("eye", (0, 0, 0), (0.005, 0, 0), 0.017, 0.017, "dark")],
            "wing": [Rod("wing", (0, 0, 0), (-0.34, 0, -0.05), 0.11, 0.10, "feather")],
            "plumes": [
                Rod("plumes", (0, 0, 0), (-0.16, 0.02, -0.12), 0.09, 0.05, "white"),
                Rod("plumes", (0.08, 0, -0.02), (-0.02, 0.03, -0.18), 0.08, 0.05, "white"),
            ],
            "thigh": [Rod("hip", (0, 0, 0), (0, 0, -0.29), 0.15, 0.11, "skin")],
            "drumstick": [
                Rod("knee", (0, 0, 0), (0, 0, -0.20), 0.112, 0.070, "skin"),
                Rod("knee", (0, 0, -0.20), (0, 0, -0.52), 0.070, 0.040, "skin"),
            ],
            "shank": [Rod("ankle", (0, 0, 0), (0, 0, -0.45), 0.042, 0.030, "skin")],
            "big toe": [Rod("big toe", (0, 0, 0), (0.17, -0.015, -0.005), 0.030, 0.025, "dark")],
            "small toe": [
                Rod("small toe", (0, 0.02, 0), (0.11, 0.06, -0.01), 0.024, 0.020, "dark")
            ],
        },
        leaf={
            "ostrich": [Rod("trunk", (-0.24, 0, -0.22), (0.22, 0, 0.18), 0.35, 0.32, "mean")],
            "neck": [
                Rod("neck", (0, 0, 0), (0, 0, 0.42), 0.075, 0.042, "skin"),
                Rod("mid neck", (0, 0, 0), (0, 0, 0.54), 0.042, 0.042, "skin"),
            ],
            "head": [Rod("head", (-0.01, 0, 0.01), (0.14, 0, -0.005), 0.046, 0.020, "skin")],
        },
        side_leaf={
            "wing": [Rod("wing", (0, 0, 0), (-0.40, 0, -0.10), 0.11, 0.09, "feather")],
            "leg": [
                Rod("hip", (0, 0, 0), (0, 0, -0.29), 0.15, 0.11, "skin"),
                Rod("knee", (0, 0, 0), (0, 0, -0.52), 0.10, 0.042, "skin"),
                Rod("ankle", (0, 0, 0), (0, 0, -0.45), 0.045, 0.040, "skin"),
            ],
            "drumstick": [
                Rod("knee", (0, 0, 0), (0, 0, -0.52), 0.10, 0.042, "skin"),
                Rod("ankle", (0, 0, 0), (0, 0, -0.45), 0.045, 0.040, "skin"),
            ],
            "shank": [
                Rod("ankle", (0, 0, 0), (0, 0, -0.45), 0.042, 0.032, "skin"),
                Rod("big toe", (0, 0, 0), (0.15, 0, -0.005), 0.034, 0.026, "dark"),
            ],
        },
        rest={
            "neck": (0, 34, 0),
            "mid neck": (0, -34, 0),
            "head": (0, 6, 0),
            "wing": (6, 0, 0),
            "hip": (4, -52, 0),
            "knee": (0, 84, 0),
            "ankle": (-4, -44, 0),
            "big toe": (0, 12, 0),
            "small toe": (0, 12, 0),
        },
        limits={
            "trunk": free(8, 15, 10),
            "neck": ((-30, -10, -60), (30, 120, 60)),
            "mid neck": ((-40, -70, -60), (40, 80, 60)),
            "head": ((-40, -60, -70), (40, 80, 70)),
            "tail": free(20, 40, 20),
            "wing": ((-10, -60, -80), (100, 30, 30)),
            "plumes": free(30, 40, 40),
            "hip": ((-25, -95, -20), (30, 5, 20)),
            "knee": hinge(15, 150),
            "ankle": ((-30, -140, -25), (30, 10, 25)),
            "big toe": hinge(-70, 90),
            "small toe": hinge(-70, 90),
        },
        shift=((-0.08, -0.08, -0.2), (0.08, 0.08, 0.08)),
    ),
    build=Build(2.35, _PLUMAGE),
    gait=Gait(
        legs=(
            Leg(
                "hip",
                "knee",
                "ankle",
                toes=("big toe", "small toe"),
                flat_toes=True,
                curl=35.0,
                pitch=((0, 30), (0.3, 14), (0.62, -38), (0.72, -45), (0.9, 28)),
                clearance=0.13,
                spread=0.07,
                ahead=0.0,
            ),
        ),
        waves=(
            Wave("", 2, 0.012, cycles=2, peak=0.6),
            Wave("", 1, 0.015, peak=0.31),
            Wave("trunk", 2, -3.0, peak=0.02),
            Wave("trunk", 0, 2.0, peak=0.25),
            Wave("neck", 1, 4.0, cycles=2, peak=0.1),
            Wave("mid neck", 1, -6.0, cycles=2, peak=0.1),
            Wave("head", 1, 2.0, cycles=2, peak=0.1),
        ),
        duty=0.62,
        froude=0.16,
    ),
)

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
    ),
)

_SAILS = {f"sail {k + 1}": 90.0 * k + 20.0 for k in range(4)}

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
                Rod("foot", (1.9, 0, 0.45), (-1.9, 0, 0.45), 0.45, 0.45, "wall"),
                Rod("foot", (0.95, 1.65, 0.45), (-0.95, -1.65, 0.45), 0.45, 0.45, "wall"),
                Rod("foot", (0.95, -1.65, 0.45), (-0.95, 1.65, 0.45), 0.45, 0.45, "wall"),
                Rod("foot", (0, 0, 2.3), (0, 0, 5.5), 2.3, 1.9, "wall"),
                Rod("foot", (0, 0, 5.5), (0, 0, 8.6), 1.9, 1.5, "wall"),
            ],
            "door": [Rod("foot", (2.05, 0, 0.6), (2.0, 0, 1.5), 0.42, 0.42, "door")],
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
