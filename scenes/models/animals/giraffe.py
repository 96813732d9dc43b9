"""The giraffe in tables, a pipe-cleaner figure as in Marr & Nishihara (1978) [17]; in metres.

Neck and foreleg are about as long as one another (Mitchell, van Sittert & Skinner, J. Zool.
278:281, 2009). It walks as Basu, Wilson & Hutchinson found (J. Exp. Biol. 222:jeb159277, 2019):
feet down for 0.7 of a long slow cycle, each forefoot landing soon after the hind foot of its side.
What is between is our own, limits of joints, too: cannon, pastern and hoof of a hind leg are one
piece, so that its hock goes as far past straight as the three of them would on a slope of 0.3. All
bones of a leg hang straight down at angles 0.
"""

from scenes.gait.foot_path import Leg
from scenes.gait.gait import Gait, Wave
from scenes.models.animals.kind import Kind, free, hinge
from scenes.rig.anatomy import Anatomy, Build, Joint, Part, Rod

_COAT = {"coat": (0.50, 0.31, 0.13), "pale": (0.62, 0.52, 0.38), "dark": (0.05, 0.04, 0.03)}

GIRAFFE = Kind(
    anatomy=Anatomy(
        joints={
            "trunk": Joint("", (0, 0, 2.25)),
            "neck": Joint("trunk", (0.62, 0, 0.22)),
            "nape": Joint("neck", (0, 0, 0.85)),
            "head": Joint("nape", (0, 0, 0.85)),
            "muzzle": Joint("head", (0.30, 0, -0.02)),
            "tail": Joint("trunk", (-0.74, 0, 0.16)),
            "tuft": Joint("tail", (0, 0, -0.62)),
        },
        side_joints={
            "ear": Joint("head", (-0.06, 0.10, 0.05)),
            "horn": Joint("head", (0.03, 0.06, 0.10)),
            "eye": Joint("head", (0.10, 0.10, 0.05)),
            "shoulder": Joint("trunk", (0.50, 0.17, -0.02)),
            "carpus": Joint("shoulder", (0, 0, -1.12)),
            "fetlock": Joint("carpus", (0, 0, -0.86)),
            "hip": Joint("trunk", (-0.55, 0.17, -0.02)),
            "stifle": Joint("hip", (0, 0, -0.72)),
            "hock": Joint("stifle", (0, 0, -0.72)),
        },
        parts={
            "giraffe": Part("", 0, "trunk"),
            "torso": Part("giraffe", 1, "trunk"),
            "neck": Part("giraffe", 1, "neck"),
            "lower neck": Part("neck", 2, "neck"),
            "upper neck": Part("neck", 2, "nape"),
            "head": Part("neck", 2, "head"),
            "muzzle": Part("head", 3, "muzzle"),
            "tail": Part("giraffe", 2, "tail"),
            "tuft": Part("tail", 3, "tuft"),
        },
        side_parts={
            "ear": Part("head", 3, "ear"),
            "horn": Part("head", 3, "horn"),
            "eye": Part("head", 4, "eye"),
            "foreleg": Part("giraffe", 1, "shoulder"),
            "forearm": Part("foreleg", 2, "shoulder"),
            "fore cannon": Part("foreleg", 2, "carpus"),
            "fore hoof": Part("fore cannon", 3, "fetlock"),
            "hind leg": Part("giraffe", 1, "hip"),
            "thigh": Part("hind leg", 2, "hip"),
            "gaskin": Part("hind leg", 2, "stifle"),
            "hind cannon": Part("gaskin", 3, "hock"),
        },
        body={
            "torso": [
                Rod("trunk", (0.46, 0, 0.02), (0.05, 0, -0.02), 0.37, 0.38, "coat"),
                Rod("trunk", (0.05, 0, -0.02), (-0.52, 0, -0.02), 0.38, 0.29, "coat"),
                Rod("trunk", (0.42, 0, 0.20), (0.62, 0, 0.22), 0.26, 0.20, "coat"),
            ],
            "lower neck": [Rod("neck", (0, 0, 0), (0, 0, 0.85), 0.21, 0.125, "coat")],
            "upper neck": [Rod("nape", (0, 0, 0), (0, 0, 0.83), 0.125, 0.095, "coat")],
            "head": [
                Rod("head", (-0.03, 0, 0), (0.12, 0, 0), 0.12, 0.105, "coat"),
                Rod("head", (0.12, 0, 0), (0.30, 0, -0.02), 0.105, 0.075, "coat"),
            ],
            "muzzle": [Rod("muzzle", (0, 0, 0), (0.13, 0, -0.02), 0.074, 0.062, "pale")],
            "tail": [Rod("tail", (0, 0, 0), (0, 0, -0.62), 0.045, 0.022, "coat")],
            "tuft": [Rod("tuft", (0, 0, 0), (0, 0, -0.38), 0.040, 0.030, "dark")],
        },
        side_body={
            "ear": [Rod("ear", (0, 0, 0), (-0.05, 0.16, 0.03), 0.040, 0.020, "coat")],
            "horn": [Rod("horn", (0, 0, 0), (-0.03, 0.01, 0.16), 0.024, 0.030, "dark")],
            "eye": [Rod("eye", (0, 0, 0), (0.01, 0, 0), 0.022, 0.022, "dark")],
            "forearm": [
                Rod("shoulder", (0, 0, -0.05), (0, 0, -0.45), 0.19, 0.125, "coat"),
                Rod("shoulder", (0, 0, -0.45), (0, 0, -1.12), 0.125, 0.075, "coat"),
            ],
            "fore cannon": [Rod("carpus", (0, 0, 0), (0, 0, -0.86), 0.075, 0.058, "pale")],
            "fore hoof": [
                Rod("fetlock", (0, 0, 0), (0, 0, -0.16), 0.060, 0.070, "pale"),
                Rod("fetlock", (0, 0, -0.16), (0.02, 0, -0.21), 0.080, 0.085, "dark"),
            ],
            "thigh": [Rod("hip", (0, 0, -0.02), (0, 0, -0.72), 0.23, 0.13, "coat")],
            "gaskin": [Rod("stifle", (0, 0, 0), (0, 0, -0.72), 0.13, 0.072, "coat")],
            "hind cannon": [
                Rod("hock", (0, 0, 0), (0, 0, -0.76), 0.074, 0.058, "pale"),
                Rod("hock", (0, 0, -0.80), (0.02, 0, -0.85), 0.078, 0.085, "dark"),
            ],
        },
        leaf={
            "giraffe": [Rod("trunk", (-0.60, 0, -0.45), (0.75, 0, 0.55), 0.5, 0.5, "mean")],
            "neck": [
                Rod("neck", (0, 0, 0), (0, 0, 0.85), 0.21, 0.125, "coat"),
                Rod("nape", (0, 0, 0), (0, 0, 0.88), 0.125, 0.10, "coat"),
                Rod("head", (0, 0, 0), (0.36, 0, -0.02), 0.11, 0.075, "coat"),
            ],
            "head": [Rod("head", (-0.05, 0, 0), (0.38, 0, -0.02), 0.12, 0.07, "coat")],
            "tail": [Rod("tail", (0, 0, 0), (0, 0, -0.90), 0.040, 0.030, "coat")],
        },
        side_leaf={
            "foreleg": [
                Rod("shoulder", (0, 0, -0.05), (0, 0, -1.12), 0.16, 0.08, "coat"),
                Rod("carpus", (0, 0, 0), (0, 0, -1.02), 0.08, 0.065, "pale"),
            ],
            "fore cannon": [Rod("carpus", (0, 0, 0), (0, 0, -1.03), 0.075, 0.065, "pale")],
            "hind leg": [
                Rod("hip", (0, 0, -0.02), (0, 0, -0.72), 0.23, 0.13, "coat"),
                Rod("stifle", (0, 0, 0), (0, 0, -0.72), 0.13, 0.075, "coat"),
                Rod("hock", (0, 0, 0), (0, 0, -0.84), 0.075, 0.07, "pale"),
            ],
            "gaskin": [
                Rod("stifle", (0, 0, 0), (0, 0, -0.72), 0.13, 0.075, "coat"),
                Rod("hock", (0, 0, 0), (0, 0, -0.84), 0.075, 0.07, "pale"),
            ],
        },
        rest={
            "neck": (0, 38, 0),
            "nape": (0, -8, 0),
            "head": (0, -2, 0),
            "tail": (0, 12, 0),
            "hip": (0, -24, 0),
            "stifle": (0, 50, 0),
            "hock": (0, -26, 0),
        },
        limits={
            "trunk": free(6, 8, 6),
            "neck": ((-20, 0, -40), (20, 110, 40)),
            "nape": free(30, 45, 40),
            "head": ((-25, -60, -40), (25, 70, 40)),
            "tail": free(40, 60, 40),
            "tuft": free(40, 60, 40),
            "shoulder": ((-20, -65, -10), (20, 45, 10)),
            "carpus": hinge(0, 110),
            "fetlock": ((-20, -80, -20), (20, 100, 20)),
            "hip": ((-20, -82, -10), (20, 25, 10)),
            "stifle": hinge(5, 120),
            "hock": ((-20, -110, -20), (20, 35, 20)),
        },
        shift=((-0.1, -0.1, -0.5), (0.1, 0.1, 0.1)),
    ),
    build=Build(4.7, _COAT),
    gait=Gait(
        legs=(
            Leg(
                "hip",
                "stifle",
                "hock",
                pitch=((0, 12), (0.35, 0), (0.7, -32), (0.78, -40), (0.9, 0)),
                clearance=0.05,
            ),
            Leg(
                "shoulder",
                "carpus",
                "fetlock",
                pitch=((0, 4), (0.1, 0), (0.55, 0), (0.7, -40), (0.78, -55), (0.92, 4)),
                strike=0.22,
                ahead=-0.04,
                clearance=0.05,
            ),
        ),
        waves=(
            Wave("", 2, 0.008, cycles=2, peak=0.3),
            Wave("", 1, 0.012, peak=0.3),
            Wave("trunk", 0, 1.5, peak=0.2),
            Wave("trunk", 2, 1.5, peak=0.0),
            Wave("neck", 1, 3.0, cycles=2, peak=0.55),
            Wave("head", 1, -2.5, cycles=2, peak=0.55),
            Wave("tail", 0, 12.0, peak=0.25),
        ),
        duty=0.70,
        froude=0.04,
    ),
)
