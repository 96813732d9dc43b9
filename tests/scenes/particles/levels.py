"""Parts of a level of a particle system, and what is drawn for them, as its tests need them."""

import numpy as np

from lod.pruner import BlendWeights


def level(it, wanted, at):
    """All parts of a level."""
    parts = it.roots(at)
    for _ in range(wanted):
        parts = it.parts_of(parts, at)
    return parts


def drawn(it, parts):
    return it.appearance(parts, BlendWeights(np.zeros(len(parts)), np.ones(len(parts))))
