"""Flat ground, for tests of what stands on it."""

import numpy as np


class FlatGround:
    """Ground of height 0 everywhere."""

    def height(self, corner, xy):
        return np.zeros(len(xy))

    def bounds(self):
        return 0.0, 0.0
