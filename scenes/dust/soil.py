"""Colour of dust, from that of the ground that it comes from.

A layer of grains that scatter a share w of what they meet, evenly to all sides, sends back
ρ = (1 − γ)/(1 + γ) of the light, γ = √(1 − w): the diffusive reflectance of B. Hapke,
"Bidirectional reflectance spectroscopy 1. Theory", J. Geophys. Res. 86:3039 (1981). Turned round,
the colour ρ of the ground gives w of one grain: brighter and paler, as raised dust is. What is
drawn stands for a wad of many finer grains, which shade each other, though less than in a deep
layer: it has the geometric mean of both.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Float64

from lod.arrays import Ints
from lod.camera import Corner
from scenes.terrain.colour import GROUND_MATERIALS, SNOW, ground_colours
from scenes.terrain.relief import Relief

SHADES = 8
"""Number of colours of dust from that of hollows to that of ridges."""

_ACROSS_M = 0.25
"""Size of the smallest patches of the ground's colour that show in a puff [m]."""


@dataclass(frozen=True, eq=False)
class Soil:
    """Ground that dust comes from: its relief, and the name of its cover."""

    relief: Relief
    cover: str

    @cached_property
    def ground(self) -> Float64[np.ndarray, "t 3"]:
        """List the colours of the ground that are told apart: moist to dry, steep, snow, (t, 3)."""
        materials = GROUND_MATERIALS[self.cover]
        share = np.linspace(0, 1, SHADES)[:, None]
        between = np.array(materials.moist) * (1 - share) + np.array(materials.dry) * share
        others = [materials.steep] + [SNOW] * (materials.snow_line is not None)
        return np.concatenate((between, others))

    @property
    def tints(self) -> Float64[np.ndarray, "t 3"]:
        """Return the colours of the dust of each colour of the ground, (t, 3)."""
        return np.sqrt(self.ground * self.grain)

    @property
    def grain(self) -> Float64[np.ndarray, "t 3"]:
        """Return the single-scattering albedo of a grain of each colour of the ground, (t, 3)."""
        return 1 - ((1 - self.ground) / (1 + self.ground)) ** 2

    def tint(self, corner: Corner, xy: Float64[np.ndarray, "m 2"]) -> Ints:
        """Return the row of the nearest colour of the ground at points [m] from a corner, (m,)."""
        relief, size = self.relief, np.full(len(xy), _ACROSS_M)
        rise = relief.height(corner, xy) / (relief.amplitude or 1.0)
        slope = np.hypot(*relief.slopes(corner, xy, 2 * size).T)
        materials = GROUND_MATERIALS[self.cover]
        hidden = np.zeros(len(xy))
        colour = ground_colours(relief.seed, corner, xy, rise, slope, hidden, size, materials)
        away = colour[:, None] - self.ground
        return np.asarray((away**2).sum(axis=2).argmin(axis=1))
