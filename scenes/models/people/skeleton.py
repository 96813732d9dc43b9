"""Which joints and parts a person has, and how a person stands; lengths are shares of stature.

Segment lengths and heights follow Drillis & Contini, "Body segment parameters" (1966), as given by
Winter, "Biomechanics and Motor Control of Human Movement" (4th ed. 2009, fig. 4.1): ankle 0.039,
knee 0.285, hip 0.530, shoulder 0.818, chin 0.870, eye 0.936; upper arm 0.186, forearm 0.146, hand
0.108, foot 0.152, half the breadth of the shoulders 0.129 and of the hips 0.0955. Girths are our
own.

x is forward, y to the left, z up. ``SIDE_JOINTS`` and ``SIDE_PARTS`` are given for the left and
mirrored for the right.
"""

from scenes.rig.anatomy import Joint, Part

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
