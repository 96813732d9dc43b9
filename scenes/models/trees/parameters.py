"""Parameters of a species of tree, in the terms of Weber & Penn (1995).

J. Weber & J. Penn, "Creation and rendering of realistic trees", SIGGRAPH 1995: a trunk and levels
of branches, each level with its own number, angles, length and curvature. Their names stand in
quotes where ours say them otherwise. A species is one TOML file (``species/``), whose keys are the
fields of these classes, and the tables that are measured of it (``appearance_tables``).
"""

import math
from dataclasses import dataclass, field, replace
from typing import Annotated, Literal

from pydantic import Field

from lod.errors import InputError
from scenes.model_files.read import CLOSED
from scenes.models.trees.appearance_tables import AppearanceTables

Albedo = Annotated[float, Field(ge=0, le=1)]
Colour = tuple[Albedo, Albedo, Albedo]
"""Linear Rec.709 albedo, 0 to 1."""

Positive = Annotated[float, Field(gt=0)]
NotNegative = Annotated[float, Field(ge=0)]
Share = Annotated[float, Field(ge=0, le=1)]
Angle = Annotated[float, Field(ge=-360, le=360)]
Count = Annotated[int, Field(ge=0, le=100)]
Season = Literal["spring", "summer", "autumn", "winter"]

SHADES = 5
"""Shades of leaves in one season."""


@dataclass(frozen=True)
class Trunk:
    """The trunk.

    length      as a share of the tree's height ("0Length")
    ratio       radius at the foot, as a share of the tree's height ("Ratio")
    taper       how much thinner its top is than its foot, 0 to 1 ("0Taper")
    flare       widening at the foot ("Flare")
    curve_v     random bend from segment to segment [degrees] ("0CurveV")
    root_depth  how far the foot reaches under the ground [m]
    """

    __pydantic_config__ = CLOSED

    length: Annotated[float, Field(gt=0, le=1)]
    ratio: Annotated[float, Field(gt=0, le=1)]
    taper: Annotated[float, Field(ge=0, lt=1)]
    flare: NotNegative
    curve_v: NotNegative
    root_depth: NotNegative


@dataclass(frozen=True)
class BranchLevel:
    """How branches of one level grow from those of the level before. All angles are in degrees.

    branches         children of the longest parent; shorter parents bear fewer ("Branches")
    base_size        where along the parent the first child stands, 0 base to 1 tip ("BaseSize")
    length           greatest length, over the parent's, for limbs the trunk's ("Length")
    length_falloff   how much shorter the last child is than the first, 0 to 1 (0.6 in §4.3); limbs
                     follow the species' shape instead
    down_angle_base, down_angle_tip   angle from the parent's direction at its base and at its tip
                     ("DownAngle")
    rotate           angle around the parent from one child to the next ("Rotate")
    two_ranked       children stand level on either side of the parent in turn, and ``rotate`` does
                     not count
    angle_v          standard deviation of all these angles ("DownAngleV", "RotateV")
    attraction_up    how far the tip turns up, above 0, or hangs, below 0 ("AttractionUp")
    curve_v          random bend from segment to segment ("CurveV")
    curve_res        segments of the chain ("CurveRes")
    ratio_power      radius over the parent's = (length over the parent's)^ratio_power
                     ("RatioPower")
    """

    __pydantic_config__ = CLOSED

    branches: Annotated[float, Field(gt=0, le=1000)]
    base_size: Annotated[float, Field(ge=0, lt=1)]
    length: Positive
    down_angle_base: Angle
    down_angle_tip: Angle
    angle_v: NotNegative
    attraction_up: float
    curve_v: NotNegative
    curve_res: Annotated[int, Field(ge=1, le=20)]
    ratio_power: NotNegative
    length_falloff: Share = 0.0
    rotate: Angle = 137.5
    two_ranked: bool = False


@dataclass(frozen=True)
class Shades:
    """The darkest and the lightest leaves of a season."""

    __pydantic_config__ = CLOSED

    dark: tuple[Positive, Positive, Positive]
    light: tuple[Positive, Positive, Positive]

    def colours(self) -> tuple[tuple[float, float, float], ...]:
        """SHADES colours from dark to light, evenly spaced in their logarithms."""
        steps = [k / (SHADES - 1) for k in range(SHADES)]
        pairs = list(zip(self.dark, self.light, strict=True))
        return tuple(
            (_log_mix(*pairs[0], s), _log_mix(*pairs[1], s), _log_mix(*pairs[2], s)) for s in steps
        )


def _log_mix(a: float, b: float, share: float) -> float:
    """The mean of two numbers in their logarithms, to four decimals."""
    return round(math.exp((1 - share) * math.log(a) + share * math.log(b)), 4)


@dataclass(frozen=True)
class Foliage:
    """Leaves as short cones, several on each twig; of a conifer shoots with their needles.

    leaves        on the longest twig; shorter twigs bear fewer ("Leaves")
    length        between the centres of a leaf's two round ends [m] ("LeafScale")
    base_radius, tip_radius   of its two ends [m]
    offset        how far leaves stand off the twig [m]
    upturn        how far they turn up to the light, below 0 down
    albedo        shades of leaves by season; the tree is bare in a season that is absent
    two_ranked    they stand level on either side of the twig, as in a comb
    forward_lean  how far they lean to the tip of the twig
    """

    __pydantic_config__ = CLOSED

    leaves: Annotated[int, Field(ge=1, le=1000)]
    length: Positive
    base_radius: Positive
    tip_radius: Positive
    offset: NotNegative
    upturn: float
    albedo: dict[Season, Shades] = field(hash=False)
    two_ranked: bool = False
    forward_lean: float = 0.5


@dataclass(frozen=True)
class LeafAppearance:
    """Of how many shapes the leaf appearances are made, level by level: of the tree, a limb, a
    branch and so on to a twig.

    blob_count     shapes that stand for what is hidden
    kept_segments  sticks of the branch itself that stay
    clear_trunk_segments  how many of the trunk's 8 sticks, from the foot up, are seen from afar
    """

    __pydantic_config__ = CLOSED

    blob_count: tuple[Annotated[int, Field(ge=1, le=100)], ...]
    kept_segments: tuple[Count, ...]
    clear_trunk_segments: Annotated[int, Field(ge=1, le=8)]


@dataclass(frozen=True)
class TreeSpecies:
    """A species of tree.

    scale, scale_v  mean and standard deviation of the height [m] ("Scale", "ScaleV")
    shape         length of limbs along the crown, from its base 0 to its top 1, as a share of the
                  longest ("Shape")
    min_radius    radius of the thinnest twig [m]
    broken_share  share of branches that have snapped
    bark_albedo   of the trunk and of branches
    levels        limbs, branches and so on to twigs
    foliage       None where the species has no leaves in any season
    leaf_appearance  shapes of the leaf appearances
    tables        what is measured of the leaf appearances in leaf; bare_tables: of bare trees
    """

    __pydantic_config__ = CLOSED

    name: str
    scale: Positive
    scale_v: NotNegative
    shape: Annotated[tuple[tuple[Share, Share], ...], Field(min_length=2)]
    min_radius: Positive
    broken_share: Share
    bark_albedo: tuple[Colour, Colour]
    trunk: Trunk
    levels: Annotated[tuple[BranchLevel, ...], Field(min_length=1, max_length=4)]
    leaf_appearance: LeafAppearance
    tables: AppearanceTables
    bare_tables: AppearanceTables
    foliage: Foliage | None = None

    def __post_init__(self) -> None:
        shapes = self.leaf_appearance
        for key in ("blob_count", "kept_segments"):
            arrived, wanted = len(getattr(shapes, key)), len(self.levels) + 1
            if arrived != wanted:
                rule = f"{wanted} entries: the tree's, and one for each of its [[levels]]"
                raise InputError(f"{self.name}.toml: leaf_appearance.{key}", arrived, rule)
        hiding = len(self.levels) + 1 if self.foliage else len(self.levels)
        self.tables.check(f"{self.name}.csv", hiding)
        self.bare_tables.check(f"{self.name}.csv", len(self.levels))

    def leaf_colours(self, season: str) -> tuple[tuple[float, float, float], ...]:
        """Colours of leaves in a season, from dark to light; () where the tree stands bare."""
        shades = self.foliage.albedo if self.foliage else {}
        return next((each.colours() for name, each in shades.items() if name == season), ())

    def uncorrected(self) -> "TreeSpecies":
        """The species without what is measured of the colour and the view dependence of its leaf
        appearances: they look the same from everywhere, and have the albedo of what they hide."""
        tables = AppearanceTables(overlap=self.tables.overlap)
        bare_tables = AppearanceTables(overlap=self.bare_tables.overlap)
        return replace(self, tables=tables, bare_tables=bare_tables)

    def bare(self) -> "TreeSpecies":
        """The species without its leaves; its leaf appearances are then made of wood."""
        shapes = self.leaf_appearance
        kept = (shapes.kept_segments[0], *(max(1, each) for each in shapes.kept_segments[1:]))
        more = tuple(each + 1 for each in shapes.blob_count)
        wooden = LeafAppearance(more, kept, clear_trunk_segments=8)
        return replace(self, foliage=None, leaf_appearance=wooden, tables=self.bare_tables)
