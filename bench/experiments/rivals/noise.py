"""How noisy is one sample of a pixel? The variance of pictures with different seeds says it."""

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from bench.experiments.fidelity.image_errors import EPSILON, Picture
from scenes.render.pictures.tone_map import auto_exposure


def noise(pictures: Sequence[Picture], spp: int) -> list[int]:
    """Return the relative variance of a sample, from each picture and the next [millionths].

    It is the variance of a pixel times its samples, ÷ squared light, by ``rel_mse``'s rule; a
    stratified sampler has less than independent samples would have.
    """
    mean = np.mean(pictures, axis=0)
    exposure = auto_exposure(mean)
    over = (mean * exposure) ** 2 + EPSILON
    squares = (((a - b) * exposure) ** 2 / over for a, b in pairwise(pictures))
    found = (spp * np.mean(each) / 2 for each in squares)
    return [round(1e6 * float(each)) for each in found]
