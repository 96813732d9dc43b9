"""Where a species grows: up to a tree line, and where the ground is not too steep.

Objects are kept or left out one by one, by a number that each has drawn for itself, so that what
stays is again a Poisson field, of density K × share (thinning: Kingman 1993, *Poisson Processes*,
§5.1), and the law predicts it with that.
"""

import math
from dataclasses import dataclass

import numpy as np

from lod.arrays import Reals
from lod.camera import Corner
from scenes.terrain.relief import Relief

WAVES_M = 16.0
"""Shortest waves of the slope that roots mind [m]."""


@dataclass(frozen=True)
class Habitat:
    """The ground, and what of it a species takes.

    highest   height above the datum where it grows no more [m]; inf = it grows at every height
    thinning  heights below that over which it thins out [m]
    steepest  tangent of the slope where it stands no more, having thinned out over the last half
    """

    relief: Relief
    highest: float = math.inf
    thinning: float = 100.0
    steepest: float = math.inf

    def share(self, corner: Corner, xy: np.ndarray) -> Reals:
        """Share of it that grows at points (n, 2) [m] from the corner, (n,), 0 to 1."""
        height = self.relief.height(corner, xy)
        by_height = np.clip((self.highest - height) / self.thinning, 0.0, 1.0)
        if math.isinf(self.steepest):
            return by_height
        slope = np.hypot(*self.relief.slopes(corner, xy, np.full(len(xy), WAVES_M)).T)
        return by_height * np.clip(2 - 2 * slope / self.steepest, 0.0, 1.0)
