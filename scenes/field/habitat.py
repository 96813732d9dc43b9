"""The habitat of a species: it grows up to a tree line, and where the ground is not too steep.

Each object is kept or left out by a random number of its own. The objects that stay are therefore
again a Poisson field, of density K × share (thinning: Kingman 1993, *Poisson Processes*, §5.1), and
the law's prediction takes that density.
"""

import math
from dataclasses import dataclass

import numpy as np

from lod.arrays import Reals
from lod.camera import Corner
from scenes.terrain.relief import Relief

WAVES_M = 16.0
"""Shortest waves of the relief that count in the slope [m]."""


@dataclass(frozen=True)
class Habitat:
    """The parts of the ground on which a species grows.

    relief    the ground
    highest   height above the datum from which on it does not grow [m]; inf: it grows at any height
    thinning  range of heights below ``highest`` over which it thins out [m]
    steepest  tangent of the slope from which on it does not grow; it thins out from half of that
    """

    relief: Relief
    highest: float = math.inf
    thinning: float = 100.0
    steepest: float = math.inf

    def share(self, corner: Corner, xy: np.ndarray) -> Reals:
        """Compute the share of its density at points (n, 2) [m] from the corner, (n,), 0 to 1."""
        height = self.relief.height(corner, xy)
        by_height = np.clip((self.highest - height) / self.thinning, 0.0, 1.0)
        if math.isinf(self.steepest):
            return by_height
        slope = np.hypot(*self.relief.slopes(corner, xy, np.full(len(xy), WAVES_M)).T)
        return by_height * np.clip(2 - 2 * slope / self.steepest, 0.0, 1.0)
