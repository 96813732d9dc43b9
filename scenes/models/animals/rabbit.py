"""The rabbit in tables, a pipe-cleaner figure as in Marr & Nishihara (1978) [17]; in metres.

An adult Oryctolagus: hind legs about twice as long as forelegs, and a half-bound, in which the
forefeet land one after the other and the hind feet together. Lengths are our own. All bones of a
leg hang straight down at angles 0, but for feet, which lie flat.
"""

from scenes.gait.foot_path import Leg
from scenes.gait.gait import Gait, Wave
from scenes.models.animals.kind import Kind, free, hinge
from scenes.rig.anatomy import Anatomy, Build, Joint, Part, Rod

_FUR = {"fur": (0.27, 0.20, 0.14), "white": (0.75, 0.72, 0.68), "dark": (0.03, 0.02, 0.02)}

RABBIT = Kind(
    anatomy=Anatomy(
        joints={
            "trunk": Joint("", (0, 0, 0.150)),
            "chest": Joint("trunk", (0.060, 0, 0.005)),
            "neck": Joint("chest", (0.075, 0, 0.020)),
            "head": Joint("neck", (0.035, 0, 0.030)),
            "nose": Joint("head", (0.062, 0, -0.012)),
            "tail": Joint("trunk", (-0.115, 0, 0.015)),
        },
        side_joints={
            "ear": Joint("head", (-0.012, 0.016, 0.026)),
            "ear tip": Joint("ear", (0, 0, 0.055)),
            "eye": Joint("head", (0.022, 0.026, 0.008)),
            "shoulder": Joint("chest", (0.045, 0.034, -0.020)),
            "elbow": Joint("shoulder", (0, 0, -0.070)),
            "wrist": Joint("elbow", (0, 0, -0.074)),
            "hip": Joint("trunk", (-0.060, 0.040, -0.005)),
            "knee": Joint("hip", (0, 0, -0.085)),
            "ankle": Joint("knee", (0, 0, -0.098)),
            "toes": Joint("ankle", (0.070, 0, -0.018)),
        },
        parts={
            "rabbit": Part("", 0, "trunk"),
            "torso": Part("rabbit", 1, "trunk"),
            "rump": Part("torso", 2, "trunk"),
            "chest": Part("torso", 2, "chest"),
            "head": Part("rabbit", 1, "neck"),
            "nose": Part("head", 3, "nose"),
            "tail": Part("rabbit", 2, "tail"),
        },
        side_parts={
            "ear": Part("head", 2, "ear"),
            "ear base": Part("ear", 3, "ear"),
            "ear tip": Part("ear", 3, "ear tip"),
            "eye": Part("head", 3, "eye"),
            "foreleg": Part("rabbit", 2, "shoulder"),
            "upper arm": Part("foreleg", 3, "shoulder"),
            "forearm": Part("foreleg", 3, "elbow"),
            "paw": Part("forearm", 3, "wrist"),
            "hind leg": Part("rabbit", 1, "hip"),
            "thigh": Part("hind leg", 2, "hip"),
            "shank": Part("hind leg", 2, "knee"),
            "foot": Part("shank", 2, "ankle"),
            "toes": Part("foot", 3, "toes"),
        },
        body={
            "rump": [
                Rod("trunk", (-0.060, 0, 0.005), (0.010, 0, 0.008), 0.074, 0.070, "fur"),
                Rod("trunk", (-0.060, 0, -0.02), (0.050, 0, -0.022), 0.050, 0.046, "white"),
            ],
            "chest": [
                Rod("chest", (-0.05, 0, 0.002), (0.030, 0, -0.002), 0.068, 0.055, "fur"),
                Rod("chest", (0.030, 0, -0.002), (0.075, 0, 0.020), 0.055, 0.034, "fur"),
            ],
            "head": [
                Rod("neck", (0, 0, 0), (0.035, 0, 0.030), 0.036, 0.034, "fur"),
                Rod("head", (-0.008, 0, 0.002), (0.028, 0, -0.004), 0.034, 0.029, "fur"),
                Rod("head", (0.028, 0, -0.004), (0.056, 0, -0.014), 0.029, 0.017, "fur"),
            ],
            "nose": [Rod("nose", (0, -0.003, 0), (0, 0.003, 0), 0.015, 0.015, "white")],
            "tail": [Rod("tail", (0, 0, 0), (-0.018, 0, 0.014), 0.022, 0.024, "white")],
        },
        side_body={
            "ear base": [Rod("ear", (0, 0, 0), (0, 0, 0.055), 0.011, 0.017, "fur")],
            "ear tip": [Rod("ear tip", (0, 0, 0), (0, 0, 0.050), 0.017, 0.006, "fur")],
            "eye": [Rod("eye", (0, 0, 0), (0.002, 0, 0), 0.008, 0.008, "dark")],
            "upper arm": [Rod("shoulder", (0, 0, 0), (0, 0, -0.070), 0.026, 0.016, "fur")],
            "forearm": [Rod("elbow", (0, 0, 0), (0, 0, -0.074), 0.016, 0.011, "fur")],
            "paw": [Rod("wrist", (0, 0, 0), (0.018, 0, -0.010), 0.011, 0.010, "white")],
            "thigh": [Rod("hip", (0, 0, -0.005), (0, 0, -0.085), 0.050, 0.026, "fur")],
            "shank": [Rod("knee", (0, 0, 0), (0, 0, -0.098), 0.027, 0.014, "fur")],
            "foot": [Rod("ankle", (0, 0, -0.006), (0.070, 0, -0.008), 0.014, 0.012, "white")],
            "toes": [Rod("toes", (0, 0, 0.010), (0.030, 0, 0.008), 0.012, 0.010, "white")],
        },
        leaf={
            "rabbit": [Rod("trunk", (-0.060, 0, 0), (0.130, 0, 0.010), 0.08, 0.07, "mean")],
            "torso": [
                Rod("trunk", (-0.060, 0, 0.005), (0.030, 0, 0.006), 0.074, 0.072, "fur"),
                Rod("chest", (-0.02, 0, 0.002), (0.060, 0, 0.010), 0.070, 0.045, "fur"),
            ],
            "head": [
                Rod("neck", (0, 0, 0), (0.035, 0, 0.030), 0.036, 0.034, "fur"),
                Rod("head", (-0.012, 0, 0.012), (0.055, 0, -0.014), 0.036, 0.020, "fur"),
                Rod("head", (-0.012, 0, 0.03), (-0.05, 0, 0.10), 0.020, 0.012, "fur"),
            ],
        },
        side_leaf={
            "ear": [Rod("ear", (0, 0, 0), (0, 0, 0.100), 0.015, 0.010, "fur")],
            "foreleg": [
                Rod("shoulder", (0, 0, 0), (0, 0, -0.070), 0.026, 0.016, "fur"),
                Rod("elbow", (0, 0, 0), (0, 0, -0.082), 0.016, 0.012, "fur"),
            ],
            "forearm": [Rod("elbow", (0, 0, 0), (0, 0, -0.082), 0.016, 0.012, "fur")],
            "hind leg": [
                Rod("hip", (0, 0, -0.005), (0, 0, -0.085), 0.050, 0.026, "fur"),
                Rod("knee", (0, 0, 0), (0, 0, -0.098), 0.027, 0.014, "fur"),
                Rod("ankle", (0, 0, -0.006), (0.070, 0, -0.008), 0.014, 0.012, "white"),
                Rod("toes", (0, 0, 0.010), (0.024, 0, 0.009), 0.012, 0.010, "white"),
            ],
            "shank": [
                Rod("knee", (0, 0, 0), (0, 0, -0.098), 0.027, 0.014, "fur"),
                Rod("ankle", (0, 0, -0.006), (0.070, 0, -0.008), 0.014, 0.012, "white"),
                Rod("toes", (0, 0, 0.010), (0.024, 0, 0.009), 0.012, 0.010, "white"),
            ],
            "foot": [
                Rod("ankle", (0, 0, -0.006), (0.070, 0, -0.008), 0.014, 0.012, "white"),
                Rod("toes", (0, 0, 0.010), (0.024, 0, 0.009), 0.012, 0.010, "white"),
            ],
        },
        rest={
            "trunk": (0, -14, 0),
            "chest": (0, 24, 0),
            "neck": (0, -20, 0),
            "head": (0, 22, 0),
            "ear": (-10, -22, 0),
            "shoulder": (0, 20, 0),
            "elbow": (0, -44, 0),
            "wrist": (0, 14, 0),
            "hip": (0, -60, 0),
            "knee": (0, 112, 0),
            "ankle": (0, -38, 0),
        },
        limits={
            "trunk": ((-15, -45, -20), (15, 30, 20)),
            "chest": ((-15, -25, -20), (15, 60, 20)),
            "neck": ((-30, -70, -50), (30, 40, 50)),
            "head": ((-30, -30, -50), (30, 60, 50)),
            "ear": ((-60, -80, -40), (30, 30, 40)),
            "ear tip": free(20, 40, 20),
            "tail": free(30, 50, 40),
            "shoulder": ((-20, -80, -15), (25, 100, 15)),
            "elbow": hinge(-140, -5),
            "wrist": ((-25, -80, -20), (25, 110, 20)),
            "hip": ((-25, -135, -20), (25, 60, 20)),
            "knee": hinge(10, 165),
            "ankle": ((-25, -90, -20), (25, 90, 20)),
            "toes": hinge(-80, 40),
        },
        shift=((-0.05, -0.03, -0.06), (0.05, 0.03, 0.08)),
    ),
    build=Build(0.36, _FUR),
    gait=Gait(
        legs=(
            Leg(
                "hip",
                "knee",
                "ankle",
                toes=("toes",),
                pitch=((0, 6), (0.08, 0), (0.16, 0), (0.40, -55), (0.5, -58), (0.8, -8), (0.93, 8)),
                strike=0.0,
                apart=0.0,
                ahead=-0.20,
                clearance=0.16,
            ),
            Leg(
                "shoulder",
                "elbow",
                "wrist",
                pitch=((0, 5), (0.1, 0), (0.25, 0), (0.40, -50), (0.55, -60), (0.9, 5)),
                strike=0.55,
                apart=0.10,
                ahead=0.0,
                bend=-1,
                clearance=0.16,
            ),
        ),
        waves=(
            Wave("", 2, 0.14, peak=0.50, mean=0.10),
            Wave("trunk", 1, 11.0, peak=0.72, mean=-14.0),
            Wave("chest", 1, -8.0, peak=0.45, mean=22.0),
            Wave("neck", 1, -7.0, peak=0.75, mean=-24.0),
            Wave("ear", 1, -10.0, peak=0.65, mean=-34.0, apart=0.0),
        ),
        duty=0.31,
        stride=2.4,
        period=0.40,
    ),
)
