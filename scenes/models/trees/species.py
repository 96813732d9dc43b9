"""What a kind of tree is, in the terms of Weber & Penn (1995).

J. Weber & J. Penn, "Creation and rendering of realistic trees", SIGGRAPH 1995: a trunk and levels
of branches, each level with its own number, angles, length and curvature.
"""

from dataclasses import dataclass, field, replace

from scenes.sticks.view_dependence import ElevationTable

Colour = tuple[float, float, float]
"""Linear Rec.709 albedo, 0 to 1."""


@dataclass(frozen=True)
class BranchLevel:
    """How branches of one level grow from those of the level before. Angles in degrees.

    count     children of the longest parent; shorter parents bear fewer
    first     where along the parent the first child stands, 0 base to 1 tip
    length    greatest length, as a share of the parent's (of the trunk's for limbs)
    fade      how much shorter the last child is than the first, 0 to 1 (0.6 in §4.3); not for limbs
    down_base, down_tip   angle away from the parent at its base and at its tip ("DownAngle")
    turn      angle around the parent from one child to the next; below 0: the children stand level
        on either side in turn ("Rotate")
    spread    of all angles
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
    """Leaves as short cones, several on each twig [m]; of a conifer shoots with their needles.

    leaves: on the longest twig; length between the two centres; wide, narrow: the two radii
    scatter: how far leaves stand off the twig; upturn: how far they turn up to the light
    flat: they stand level on either side of the twig, as in a comb; ahead: how far they lean to
        its tip
    """

    leaves: int
    length: float
    wide: float
    narrow: float
    scatter: float
    upturn: float
    flat: bool = False
    ahead: float = 0.5


@dataclass(frozen=True)
class TreeSpecies:
    """A kind of tree.

    height: mean and spread [m]; trunk: its length, as a share of the height; radius: of the trunk,
        as a share of the height ("Ratio")
    taper: how much thinner the trunk's top is than its foot, 0 to 1 ("Taper")
    flare: widening at the foot ("Flare"); below: how far the foot reaches under the ground [m]
    shape: length of limbs along the crown, from its base 0 to its top 1, as a share of the longest
        ("Shape")
    levels: limbs, branches, …, twigs; foliage: None where it has none in any season
    porous: shapes in the leaf appearance of the tree, a limb, a branch, …; wood: sticks kept there
        of the branch itself
    leafy: colours of leaves in each season, () where it stands bare
    broken: share of branches that have snapped; thinnest: radius of the thinnest twig [m]
    clear: how many of the trunk's 8 sticks, from the foot up, are seen from afar
    lit: share of its colour that a leaf appearance of the tree, a limb, a branch, … has, so that it
        sends as much light as what it hides, which shades itself; measured
        (``bench.calibrate.leaf_light``);
        () for all of it; lit_bare: the same without leaves
    heights: how the leaf appearances of the tree, a limb, … look from heights, measured likewise;
        () for the same from all; ``lit`` is then the share where they are brightest
    sides: tone of the shapes of the tree, a limb, … by the angle between eye and sun
        (``scenes.sticks.view_angles.AZIMUTHS_DEG``), over that of all sides, ``lit``; measured
        likewise; () for 1
    overlap: how much of the leaf appearance of the tree, a limb, … and of the parts that it stands
        for lies in one another, half of each shown (``lod.pruning.area_scaling.leaf_area_share``),
        for trees in leaf, and bare; measured (``bench.calibrate.leaf_overlap``)
    """

    name: str
    height: tuple[float, float]
    trunk: float
    radius: float
    flare: float
    below: float
    trunk_wander: float
    shape: tuple[tuple[float, float], ...]
    levels: tuple[BranchLevel, ...]
    foliage: Foliage | None
    porous: tuple[int, ...]
    wood: tuple[int, ...]
    bark: tuple[Colour, Colour]
    leafy: dict[str, tuple[Colour, ...]] = field(hash=False)
    taper: float = 0.8
    broken: float = 0.0
    thinnest: float = 0.006
    clear: int = 4
    lit: tuple[float, ...] = ()
    lit_bare: tuple[float, ...] = ()
    heights: tuple[ElevationTable, ...] = ()
    sides: tuple[tuple[float, ...], ...] = ()
    overlap: tuple[float, ...] = ()
    overlap_bare: tuple[float, ...] = ()

    def unshaded(self) -> "TreeSpecies":
        """The same tree, whose leaf appearances look the same from everywhere and are not darker
        for what shades itself in what they hide."""
        return replace(self, lit=(), lit_bare=(), heights=(), sides=())

    def bare(self) -> "TreeSpecies":
        """The same tree without its leaves; its looks are then all of wood."""
        keep = (self.wood[0], *(max(1, each) for each in self.wood[1:]))
        more = tuple(each + 1 for each in self.porous)
        bare = replace(self.unshaded(), foliage=None, porous=more, wood=keep)
        return replace(bare, clear=8, lit=self.lit_bare, overlap=self.overlap_bare)
