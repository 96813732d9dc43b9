"""The ostrich in tables, a pipe-cleaner figure as in Marr & Nishihara (1978) [17]; in metres.

Bones of the leg after Rubenson et al., "Running in ostriches (Struthio camelus)", J. Exp. Biol.
210:2548 (2007): a short level femur, hidden in the body; the joint that looks like a knee bent
backwards is the ankle. What is between is our own, limits of joints, too: an ankle goes as far past
straight as a shank that leans with a slope of 0.3 takes it, since no joint between shank and toes
yields here. All bones of a leg hang straight down at angles 0.
"""

from scenes.gait.foot_path import Leg
from scenes.gait.gait import Gait, Wave
from scenes.models.animals.kind import Kind, free, hinge
from scenes.rig.anatomy import Anatomy, Build, Joint, Part, Rod

_PLUMAGE = {
    "feather": (0.035, 0.03, 0.03),
    "white": (0.78, 0.76, 0.70),
    "skin": (0.48, 0.30, 0.24),
    "dark": (0.02, 0.02, 0.02),
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
            "knee": hinge(10, 150),
            "ankle": ((-30, -140, -25), (30, 45, 25)),
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
