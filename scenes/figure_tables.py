"""The standing figure in tables: joints, parts and sticks, all lengths as shares of stature.

Segment lengths and heights follow Drillis & Contini, "Body segment parameters" (1966), as given by Winter,
"Biomechanics and Motor Control of Human Movement" (4th ed. 2009, fig. 4.1): ankle 0.039, knee 0.285, hip
0.530, shoulder 0.818, chin 0.870, eye 0.936; upper arm 0.186, forearm 0.146, hand 0.108, foot 0.152,
half the breadth of the shoulders 0.129 and of the hips 0.0955. Girths are our own.

x forward, y to the left, z up. What is named of a ``SIDE`` is given for the left and mirrored for the right.
"""

from typing import NamedTuple

Vector = tuple[float, float, float]


class Joint(NamedTuple):
    """A joint of the modelling skeleton (§2.3): where it sits in the frame of its parent."""

    parent: str
    offset: Vector


class Part(NamedTuple):
    """A part of the detail hierarchy (figs 1 and 2): its whole, detail level, and the joint at its origin."""

    whole: str
    level: int
    joint: str


class Rod(NamedTuple):
    """A stick in a joint's frame: two ends, their radii, a material; ``pair`` = its mirror image too."""

    joint: str
    start: Vector
    end: Vector
    start_radius: float
    end_radius: float
    material: str
    pair: bool = False


TRUNK_JOINTS = {
    "pelvis": Joint("", (0, 0, 0.545)),
    "waist": Joint("pelvis", (0, 0, 0.07)),
    "chest": Joint("waist", (0, 0, 0.105)),
    "neck": Joint("chest", (-0.006, 0, 0.105)),
    "head": Joint("neck", (0.010, 0, 0.06)),
    "nose": Joint("head", (0.053, 0, 0.046)),
    "mouth": Joint("head", (0.0475, 0, 0.0105)),
}

FINGERS = {  # knuckle in the frame of the wrist, three lengths, radius
    "index": ((0.0135, 0, -0.054), (0.0210, 0.0138, 0.0110), 0.0049),
    "middle": ((0.0040, 0, -0.056), (0.0240, 0.0155, 0.0122), 0.0051),
    "ring": ((-0.0055, 0, -0.054), (0.0220, 0.0145, 0.0115), 0.0048),
    "little": ((-0.0145, 0, -0.049), (0.0170, 0.0112, 0.0090), 0.0042),
    "thumb": ((0.0100, -0.004, -0.014), (0.0225, 0.0170, 0.0135), 0.0062),
}

TOES = {  # base and tip (x, y) in the frame of the ankle, radius
    "big": ((0.068, -0.0125), (0.1030, -0.0090), 0.0085),
    "second": ((0.067, -0.0010), (0.1020, 0.0035), 0.0060),
    "third": ((0.064, 0.0070), (0.0960, 0.0125), 0.0057),
    "fourth": ((0.060, 0.0140), (0.0880, 0.0200), 0.0053),
    "fifth": ((0.055, 0.0195), (0.0790, 0.0260), 0.0050),
}

ANKLE_HEIGHT = 0.042

SIDE_JOINTS = {
    "eye": Joint("head", (0.0508, 0.0165, 0.048)),
    "ear": Joint("head", (-0.003, 0.043, 0.042)),
    "shoulder": Joint("chest", (-0.004, 0.105, 0.088)),
    "elbow": Joint("shoulder", (0, 0, -0.186)),
    "wrist": Joint("elbow", (0, 0, -0.146)),
    "hip": Joint("pelvis", (0, 0.050, -0.02)),
    "knee": Joint("hip", (0, 0, -0.240)),
    "ankle": Joint("knee", (0, 0, -0.243)),
    **{
        f"{finger} joint {k + 1}": Joint(
            f"{finger} joint {k}" if k else "wrist", (0, 0, -lengths[k - 1]) if k else knuckle
        )
        for finger, (knuckle, lengths, _) in FINGERS.items()
        for k in range(3)
    },
    **{
        f"{toe} toe": Joint("ankle", (*base, 0.004 - ANKLE_HEIGHT))
        for toe, (base, _, _) in TOES.items()
    },
}

STANDING = {  # degrees about x (left hand moves outwards), y (bends back), z (turns left)
    "shoulder": (8.0, 2.0, 0.0),
    "elbow": (-3.0, -14.0, -8.0),
    "wrist": (-4.0, 0.0, -12.0),
    "hip": (2.5, 0.0, 9.0),
    "ankle": (-2.5, 0.0, 0.0),
    "thumb joint 1": (-14.0, -38.0, 0.0),
    "thumb joint 2": (-6.0, 12.0, 0.0),
    "thumb joint 3": (-4.0, 14.0, 0.0),
    "index joint 1": (-10.0, -3.0, 0.0),
    "middle joint 1": (-13.0, 0.0, 0.0),
    "ring joint 1": (-16.0, 2.0, 0.0),
    "little joint 1": (-19.0, 5.0, 0.0),
    **{f"{f} joint {k}": (-16.0, 0.0, 0.0) for f in list(FINGERS)[:4] for k in (2, 3)},
}

TRUNK_PARTS = {
    "person": Part("", 0, "pelvis"),
    "torso": Part("person", 1, "pelvis"),
    "chest": Part("torso", 2, "chest"),
    "abdomen": Part("torso", 2, "waist"),
    "pelvis": Part("torso", 2, "pelvis"),
    "head": Part("person", 1, "neck"),
    "neck": Part("head", 2, "neck"),
    "cranium": Part("head", 2, "head"),
    "nose": Part("cranium", 3, "nose"),
    "mouth": Part("cranium", 3, "mouth"),
}

SIDE_PARTS = {
    "eye": Part("cranium", 3, "eye"),
    "ear": Part("cranium", 3, "ear"),
    "arm": Part("person", 1, "shoulder"),
    "upper arm": Part("arm", 2, "shoulder"),
    "forearm": Part("arm", 2, "elbow"),
    "hand": Part("forearm", 2, "wrist"),
    **{f"{finger} finger": Part("hand", 3, f"{finger} joint 1") for finger in FINGERS},
    **{
        f"{finger} phalanx {k}": Part(f"{finger} finger", 4, f"{finger} joint {k}")
        for finger in FINGERS
        for k in (1, 2, 3)
    },
    "leg": Part("person", 1, "hip"),
    "thigh": Part("leg", 2, "hip"),
    "lower leg": Part("leg", 2, "knee"),
    "foot": Part("lower leg", 2, "ankle"),
    **{f"{toe} toe": Part("foot", 3, f"{toe} toe") for toe in TOES},
}


def _phalanx(finger: str, k: int) -> Rod:
    _, lengths, radius = FINGERS[finger]
    thick, thin = radius * (1 - 0.10 * (k - 1)), radius * (1 - 0.10 * k)
    tip = (0, 0, -lengths[k - 1] + (thin if k == 3 else 0))
    return Rod(f"{finger} joint {k}", (0, 0, 0), tip, thick, thin, "skin")


def _toe(toe: str) -> Rod:
    base, tip, radius = TOES[toe]
    ahead = (tip[0] - base[0], tip[1] - base[1], radius - 0.004)
    return Rod(f"{toe} toe", (0, 0, radius), ahead, radius * 1.1, radius, "skin")


# What each part looks like by itself. A part absent here has no body of its own, only its parts.
TRUNK_BODY = {
    "chest": [
        Rod("chest", (-0.004, -0.084, 0.083), (-0.004, 0.084, 0.083), 0.034, 0.034, "top"),
        Rod("chest", (-0.004, 0.050, 0.055), (0, 0.040, -0.055), 0.056, 0.050, "top", True),
        Rod("chest", (0.006, 0, 0.05), (0.006, 0, -0.055), 0.056, 0.052, "top"),
        Rod("chest", (-0.006, 0.070, 0.094), (-0.006, 0.016, 0.118), 0.022, 0.024, "top", True),
    ],
    "abdomen": [
        Rod("waist", (0, 0.036, 0.06), (0, 0.038, -0.03), 0.049, 0.050, "top", True),
        Rod("waist", (0.006, 0, 0.06), (0.006, 0, -0.03), 0.052, 0.053, "top"),
    ],
    "pelvis": [
        Rod("pelvis", (0, -0.042, 0.005), (0, 0.042, 0.005), 0.054, 0.054, "bottom"),
        Rod(
            "pelvis", (-0.018, 0.040, -0.005), (-0.016, 0.042, -0.035), 0.046, 0.044, "bottom", True
        ),
        Rod("pelvis", (0.004, 0.018, -0.02), (0, 0.024, -0.035), 0.046, 0.040, "bottom", True),
    ],
    "neck": [Rod("neck", (-0.004, 0, -0.005), (0.006, 0, 0.055), 0.031, 0.028, "skin")],
    "cranium": [
        Rod("head", (-0.012, 0, 0.062), (0.014, 0, 0.060), 0.0445, 0.0415, "skin"),
        Rod("head", (0.020, 0, 0.038), (0.029, 0, 0.004), 0.0345, 0.0200, "skin"),
        Rod("head", (0.008, 0.020, 0.020), (0.016, 0.014, 0.006), 0.0200, 0.0180, "skin", True),
        Rod("head", (-0.017, 0, 0.062), (0.002, 0, 0.0725), 0.0455, 0.0425, "hair"),
        Rod("head", (-0.024, 0, 0.050), (-0.022, 0, 0.032), 0.0390, 0.0330, "hair"),
    ],
    "nose": [Rod("nose", (0, 0, 0), (0.0075, 0, -0.020), 0.0040, 0.0068, "skin")],
    "mouth": [Rod("mouth", (0, -0.010, 0), (0, 0.010, 0), 0.0032, 0.0032, "lip")],
}

SIDE_BODY = {
    "eye": [
        Rod("eye", (0.0012, -0.004, 0), (-0.0013, 0.004, 0), 0.0040, 0.0040, "eye"),
        Rod("eye", (0.0032, -0.0065, 0.0100), (-0.0008, 0.0065, 0.0105), 0.0024, 0.0020, "hair"),
    ],
    "ear": [Rod("ear", (-0.001, 0.0005, 0.008), (0.002, -0.001, -0.010), 0.0085, 0.0065, "skin")],
    "upper arm": [
        Rod("shoulder", (0, 0, -0.002), (0, 0, -0.075), 0.0325, 0.0285, "top"),
        Rod("shoulder", (0, 0, -0.075), (0, 0, -0.186), 0.0285, 0.0225, "top"),
    ],
    "forearm": [
        Rod("elbow", (0, 0, 0), (0, 0, -0.045), 0.0225, 0.0235, "sleeve"),
        Rod("elbow", (0, 0, -0.045), (0, 0, -0.132), 0.0235, 0.0160, "sleeve"),
        Rod("elbow", (0, 0, -0.125), (0, 0, -0.146), 0.0148, 0.0140, "skin"),
    ],
    "hand": [
        Rod("wrist", (0.004, 0, -0.008), (0.0130, 0, -0.052), 0.0120, 0.0078, "skin"),
        Rod("wrist", (0.001, 0, -0.008), (0.0040, 0, -0.054), 0.0120, 0.0082, "skin"),
        Rod("wrist", (-0.002, 0, -0.008), (-0.0050, 0, -0.052), 0.0120, 0.0078, "skin"),
        Rod("wrist", (-0.004, 0, -0.008), (-0.0130, 0, -0.047), 0.0115, 0.0070, "skin"),
    ],
    **{f"{f} phalanx {k}": [_phalanx(f, k)] for f in FINGERS for k in (1, 2, 3)},
    "thigh": [
        Rod("hip", (0, 0, -0.01), (0.002, -0.002, -0.10), 0.0510, 0.0445, "bottom"),
        Rod("hip", (0.002, -0.002, -0.10), (0, 0, -0.24), 0.0445, 0.0325, "bottom"),
    ],
    "lower leg": [
        Rod("knee", (0, 0, 0), (-0.008, 0, -0.075), 0.0325, 0.0320, "shin"),
        Rod("knee", (-0.008, 0, -0.075), (-0.002, 0, -0.205), 0.0320, 0.0225, "shin"),
        Rod("knee", (-0.002, 0, -0.195), (0, 0, -0.240), 0.0195, 0.0175, "skin"),
    ],
    "foot": [
        Rod("ankle", (0, 0, -0.006), (0.060, 0.001, -0.0270), 0.0205, 0.0145, "skin"),
        Rod("ankle", (-0.022, 0, -0.0250), (0.067, -0.009, -0.0290), 0.0170, 0.0130, "skin"),
        Rod("ankle", (-0.022, 0, -0.0250), (0.057, 0.0130, -0.0310), 0.0170, 0.0110, "skin"),
    ],
    **{f"{toe} toe": [_toe(toe)] for toe in TOES},
}

# Leaf appearances, where they differ: they stand for what they hide, and are fitted to its mean area.
TRUNK_LEAF = {
    "torso": [
        Rod("chest", (-0.004, -0.090, 0.080), (-0.004, 0.090, 0.080), 0.036, 0.036, "top"),
        Rod("chest", (0, 0.050, 0.055), (0, 0.040, -0.10), 0.058, 0.052, "top", True),
        Rod("pelvis", (-0.004, -0.044, 0.0), (-0.004, 0.044, 0.0), 0.060, 0.060, "bottom"),
    ],
    "head": [
        Rod("neck", (0, 0, -0.005), (0.010, 0, 0.070), 0.031, 0.034, "skin"),
        Rod("head", (0.010, 0, 0.020), (0.012, 0, 0.060), 0.036, 0.044, "skin"),
        Rod("head", (-0.016, 0, 0.045), (-0.008, 0, 0.068), 0.044, 0.045, "hair"),
    ],
}

SIDE_LEAF = {
    "arm": [
        Rod("shoulder", (0, 0, 0), (0, 0, -0.186), 0.0315, 0.0235, "top"),
        Rod("elbow", (0, 0, 0), (0, 0, -0.230), 0.0235, 0.0150, "sleeve"),
    ],
    "forearm": [
        Rod("elbow", (0, 0, 0), (0, 0, -0.140), 0.0235, 0.0150, "sleeve"),
        Rod("wrist", (0, 0, 0), (0, 0, -0.090), 0.0170, 0.0140, "skin"),
    ],
    "hand": [
        Rod("wrist", (0.003, 0, -0.010), (0.0065, -0.004, -0.088), 0.0130, 0.0095, "skin"),
        Rod("wrist", (-0.003, 0, -0.010), (-0.0075, -0.004, -0.084), 0.0130, 0.0085, "skin"),
        Rod("wrist", (0.008, -0.004, -0.015), (0.028, -0.008, -0.045), 0.0090, 0.0060, "skin"),
    ],
    **{
        f"{f} finger": [
            Rod(f"{f} joint 1", (0, 0, 0), (0, 0, -lengths[0]), radius, radius * 0.9, "skin"),
            Rod(
                f"{f} joint 2",
                (0, 0, 0),
                (0, 0, -0.85 * sum(lengths[1:])),
                radius * 0.9,
                radius * 0.7,
                "skin",
            ),
        ]
        for f, (_, lengths, radius) in FINGERS.items()
    },
    "leg": [
        Rod("hip", (0, 0, -0.01), (0, 0, -0.24), 0.0510, 0.0325, "bottom"),
        Rod("knee", (-0.004, 0, 0), (0, 0, -0.240), 0.0335, 0.0195, "shin"),
        Rod("ankle", (-0.015, 0, -0.0230), (0.090, 0.004, -0.0300), 0.0190, 0.0120, "skin"),
    ],
    "lower leg": [
        Rod("knee", (0, 0, 0), (-0.006, 0, -0.09), 0.0325, 0.0315, "shin"),
        Rod("knee", (-0.006, 0, -0.09), (0, 0, -0.240), 0.0315, 0.0185, "shin"),
        Rod("ankle", (-0.015, 0, -0.0230), (0.090, 0.004, -0.0300), 0.0190, 0.0120, "skin"),
    ],
    "foot": [
        Rod("ankle", (0, 0, -0.006), (0.060, 0.001, -0.0270), 0.0205, 0.0145, "skin"),
        Rod("ankle", (-0.022, 0, -0.0250), (0.094, -0.004, -0.0300), 0.0170, 0.0120, "skin"),
        Rod("ankle", (-0.022, 0, -0.0250), (0.076, 0.0160, -0.0320), 0.0170, 0.0100, "skin"),
    ],
}

BUST = [Rod("chest", (0.030, 0.036, 0.022), (0.034, 0.036, 0.016), 0.036, 0.035, "top", True)]

LONG_HAIR = [
    Rod("head", (-0.022, 0.022, 0.055), (-0.034, 0.030, -0.030), 0.0320, 0.0220, "hair", True),
    Rod("head", (-0.034, 0, 0.040), (-0.044, 0, -0.045), 0.0330, 0.0240, "hair"),
]
