"""Which sticks a person consists of: bodies of parts and leaf appearances, as shares of stature.

Each stick is given in the frame of a joint of ``skeleton``, for the left side where there are two.
Lengths follow that skeleton; girths were chosen by eye.
"""

from scenes.models.people.skeleton import FINGERS, TOES
from scenes.rig.anatomy import Rod


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
        Rod("chest", (0, 0.024, 0.050), (0.002, 0.022, -0.060), 0.058, 0.053, "top", True),
        Rod("chest", (-0.006, 0.060, 0.058), (0, 0.050, -0.060), 0.049, 0.044, "top", True),
        Rod("chest", (-0.006, 0.070, 0.094), (-0.008, 0.018, 0.112), 0.022, 0.026, "top", True),
    ],
    "abdomen": [
        Rod("waist", (0.002, 0.022, 0.06), (0, 0.024, 0), 0.0535, 0.0515, "top", True),
        Rod("waist", (0, 0.050, 0.06), (0, 0.052, 0), 0.0445, 0.0455, "top", True),
    ],
    "pelvis": [
        Rod("pelvis", (0, -0.044, 0.008), (0, 0.044, 0.008), 0.0550, 0.0550, "bottom"),
        Rod(
            "pelvis",
            (-0.018, 0.040, -0.005),
            (-0.016, 0.042, -0.030),
            0.0460,
            0.0440,
            "bottom",
            True,
        ),
        Rod("pelvis", (-0.004, -0.032, -0.026), (-0.004, 0.032, -0.026), 0.0480, 0.0480, "bottom"),
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
        Rod("eye", (0.0006, -0.004, 0), (-0.0019, 0.004, 0), 0.0034, 0.0034, "eye"),
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

# Leaf appearances, where they differ: they stand for what they hide, and are fitted to its mean
# area.
TRUNK_LEAF = {
    "torso": [
        Rod("chest", (-0.004, -0.090, 0.080), (-0.004, 0.090, 0.080), 0.036, 0.036, "top"),
        Rod("chest", (-0.002, 0.042, 0.055), (0, 0.036, -0.11), 0.060, 0.055, "top", True),
        Rod("pelvis", (-0.004, -0.046, -0.005), (-0.004, 0.046, -0.005), 0.062, 0.062, "bottom"),
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
        Rod("elbow", (0, 0, 0), (0, 0, -0.138), 0.0235, 0.0150, "sleeve"),
        Rod("wrist", (0, 0, -0.01), (0, -0.003, -0.085), 0.0150, 0.0120, "skin"),
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

# The person's own core: hidden inside its parts, it stands in for those that are not displayed.
PERSON_CORE = [
    Rod("chest", (-0.002, 0.036, 0.062), (-0.002, 0.032, -0.160), 0.052, 0.050, "top", True),
    Rod("neck", (-0.002, 0, 0), (0.010, 0, 0.110), 0.027, 0.040, "skin"),
    *(
        rod._replace(joint=f"{side} {rod.joint}")
        for side in ("left", "right")
        for rod in (
            Rod("shoulder", (0, 0, -0.005), (0, 0, -0.180), 0.0275, 0.0200, "top"),
            Rod("elbow", (0, 0, -0.005), (0, 0, -0.140), 0.0190, 0.0125, "sleeve"),
            Rod("hip", (0, 0, -0.02), (0, -0.001, -0.235), 0.0440, 0.0280, "bottom"),
            Rod("knee", (-0.003, 0, -0.005), (-0.001, 0, -0.235), 0.0285, 0.0160, "shin"),
        )
    ),
]

BUST = [Rod("chest", (0.010, 0.034, 0.032), (0.019, 0.037, 0.008), 0.046, 0.042, "top", True)]

LONG_HAIR = [
    Rod("head", (-0.022, 0.022, 0.055), (-0.034, 0.030, -0.030), 0.0320, 0.0220, "hair", True),
    Rod("head", (-0.034, 0, 0.040), (-0.044, 0, -0.045), 0.0330, 0.0240, "hair"),
]
