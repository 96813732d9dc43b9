"""Parameters of a species of tree, in the terms of Weber & Penn (1995).

J. Weber & J. Penn, "Creation and rendering of realistic trees", SIGGRAPH 1995: a trunk and levels
of branches, each level with its own number, angles, length and curvature. Their names stand in
quotes where ours say them otherwise. A species is one TOML file (``species/``), whose keys are the
fields of these classes; a comment beside each key says what it is, and its unit.

Branches of the first level are called limbs and grow from the trunk; those of the last level are
called twigs and bear the foliage; those between are called branches. A tree is a hierarchy of parts
whose levels of detail are numbered like that: 0 is the whole tree, 1 limbs, and so on to the twigs
and the foliage.
"""

import math
from dataclasses import dataclass, field
from functools import cache
from importlib import resources
from importlib.resources.abc import Traversable
from typing import Annotated, Literal

from pydantic import Field

from scenes.model_files import CLOSED, read_model_file

Positive = Annotated[float, Field(gt=0)]
NotNegative = Annotated[float, Field(ge=0)]
Share = Annotated[float, Field(ge=0, le=1)]
Colour = tuple[Share, Share, Share]
"""Linear Rec.709 albedo, 0 to 1."""

Angle = Annotated[float, Field(ge=-360, le=360)]
Season = Literal["spring", "summer", "autumn", "winter"]

SHADES = 5
"""Number of shades that foliage has in one season."""


@dataclass(frozen=True)
class Trunk:
    """The trunk."""

    __pydantic_config__ = CLOSED

    length: Annotated[float, Field(gt=0, le=1)]
    ratio: Annotated[float, Field(gt=0, le=1)]
    taper: Annotated[float, Field(ge=0, lt=1)]
    flare: NotNegative
    curve_v: NotNegative
    root_depth: NotNegative


@dataclass(frozen=True)
class BranchLevel:
    """One level of branches, which grow from those of the level before."""

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
    """The darkest and the lightest albedo of foliage in a season."""

    __pydantic_config__ = CLOSED

    dark: tuple[Positive, Positive, Positive]
    light: tuple[Positive, Positive, Positive]

    def colours(self) -> tuple[tuple[float, float, float], ...]:
        """Make SHADES colours from dark to light, evenly spaced in their logarithms."""

        def mixed(a: float, b: float, share: float) -> float:
            return round(math.exp((1 - share) * math.log(a) + share * math.log(b)), 4)

        (r, s), (g, h), (b, c) = zip(self.dark, self.light, strict=True)
        steps = [k / (SHADES - 1) for k in range(SHADES)]
        return tuple((mixed(r, s, x), mixed(g, h, x), mixed(b, c, x)) for x in steps)


@dataclass(frozen=True)
class Foliage:
    """The foliage: leaves as short cones, several on each twig; for a conifer, shoots with needles.

    The tree is bare in a season that ``albedo`` lacks. Two-ranked leaves stand level on either side
    of the twig, as in a comb. Flat ones are drawn as leaves that cover as much as the cones on
    average, which asks for cones whose length is more than twice the radius of their base: wider
    leaves would reach beyond R, and are refused.
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
    flat: bool = False
    forward_lean: float = 0.5


@dataclass(frozen=True)
class TreeSpecies:
    """A species of tree; ``foliage`` is None where it has none in any season."""

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
    foliage: Foliage | None = None

    def foliage_colours(self, season: str) -> tuple[tuple[float, float, float], ...]:
        """List the colours of the foliage in a season, from dark to light; () for a bare tree."""
        shades = self.foliage.albedo if self.foliage else {}
        return next((each.colours() for name, each in shades.items() if name == season), ())


SEASONS = ("spring", "summer", "autumn", "winter")


@dataclass(frozen=True)
class Weather:
    """season: one of SEASONS; wind: mean speed at the height of crowns [m/s], 0 = calm."""

    season: str = "summer"
    wind: float = 0.0


CALM_SUMMER = Weather()


@cache
def tree_species(name: str) -> TreeSpecies:
    """Read the species of a name (see ``scenes.model_files.tree_species_names``).

    Raises InputError for anything in its file that breaks a rule.
    """
    return read_species(resources.files("scenes.trees") / "species" / f"{name}.toml")


def read_species(parameters: Traversable) -> TreeSpecies:
    """Read a species from its TOML file, which it is named for."""
    name = parameters.name.removesuffix(".toml")
    return read_model_file(parameters, TreeSpecies, {"name": name})
