"""Kinds of tree in tables, in the terms of Weber & Penn (1995).

J. Weber & J. Penn, "Creation and rendering of realistic trees", SIGGRAPH 1995: a trunk and levels
of branches, each level with its own number, angles, length and curvature. The values are our own.
"""

from dataclasses import dataclass

Colour = tuple[float, float, float]


@dataclass(frozen=True)
class BranchLevel:
    """How branches of one level grow from those of the level before. Angles in degrees.

    count     children of the longest parent; shorter parents bear fewer
    first     where along the parent the first child stands, 0 base to 1 tip
    length    greatest length, as a share of the parent's (of the trunk's for limbs)
    fade      how much shorter the last child is than the first, 0 to 1 (0.6 in §4.3); not for limbs
    down_base, down_tip   angle away from the parent at its base and at its tip ("DownAngle")
    turn      angle around the parent from one child to the next ("Rotate"); spread: of all angles
    lift      tropism: how far the tip turns up (above 0) or hangs (below 0)
    wander    random bend from segment to segment
    segments  sticks in the chain ("CurveRes")
    slender   base radius = parent's × (length / parent's length)^slender ("RatioPower")
    """

    count: float
    first: float
    length: float
    fade: float
    down_base: float
    down_tip: float
    turn: float
    spread: float
    lift: float
    wander: float
    segments: int
    slender: float


@dataclass(frozen=True)
class Foliage:
    """Leaves as short plump sticks, several on each twig [m].

    leaves: per twig; length between the two centres; wide, narrow: the two radii
    scatter: how far leaves stand off the twig; upturn: how far they turn up to the light
    """

    leaves: int
    length: float
    wide: float
    narrow: float
    scatter: float
    upturn: float


@dataclass(frozen=True)
class TreeSpecies:
    """A kind of tree.

    height: mean and spread [m]; trunk: its length, as a share of the height; radius: of the trunk,
        as a share of the height ("Ratio")
    flare: widening at the foot ("Flare"); below: how far the foot reaches under the ground [m]
    shape: length of limbs along the crown, from its base 0 to its top 1, as a share of the longest
        ("Shape")
    levels: limbs, branches, branchlets, twigs
    """

    name: str
    height: tuple[float, float]
    trunk: float
    radius: float
    flare: float
    below: float
    trunk_wander: float
    shape: tuple[tuple[float, float], ...]
    levels: tuple[BranchLevel, BranchLevel, BranchLevel, BranchLevel]
    foliage: Foliage
    bark: tuple[Colour, Colour]
    greens: tuple[Colour, ...]


BROADLEAF = TreeSpecies(
    name="broadleaf",
    height=(10.0, 0.9),
    trunk=0.68,
    radius=0.020,
    flare=0.55,
    below=0.35,
    trunk_wander=5.0,
    shape=((0.0, 0.88), (0.3, 1.0), (0.7, 0.97), (1.0, 0.82)),
    levels=(
        BranchLevel(20, 0.28, 0.62, 0.0, 68, 16, 137.5, 7, 0.40, 8, 6, 1.55),
        BranchLevel(6.8, 0.18, 0.54, 0.25, 58, 38, 140, 12, 0.20, 10, 4, 1.25),
        BranchLevel(4.3, 0.15, 0.56, 0.25, 54, 40, 140, 16, 0.10, 12, 3, 1.15),
        BranchLevel(2.9, 0.25, 0.70, 0.25, 50, 38, 140, 20, -0.10, 12, 2, 1.10),
    ),
    foliage=Foliage(leaves=8, length=0.15, wide=0.068, narrow=0.034, scatter=0.22, upturn=0.35),
    bark=((0.105, 0.080, 0.060), (0.135, 0.105, 0.075)),
    greens=(
        (0.050, 0.100, 0.022),
        (0.066, 0.124, 0.026),
        (0.084, 0.150, 0.030),
        (0.106, 0.178, 0.036),
        (0.132, 0.208, 0.044),
    ),
)

SPECIES = {species.name: species for species in (BROADLEAF,)}
