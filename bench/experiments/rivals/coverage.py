"""What share of the picture do things cover, by their distance?

A pixel counts where its first sample meets something that is not level ground: ground's normal is
straight up there, and a stick's hardly ever is. Pictures with the same seed have the same samples.
"""

from collections.abc import Sequence

import numpy as np

from bench.experiments.fidelity.image_errors import BAND_EDGES_M, band_name
from bench.records.points import Column
from scenes.frame.layers import SKY_Z, Layers

LEVEL = 1.0 - 1e-4
"""A normal that points up by this or more is the ground's."""


def covered(tested: Sequence[Layers], whole: Sequence[Layers]) -> list[Column]:
    """Count the covered pixels of every picture, by bands of what they show."""
    made = []
    for low, high in zip(BAND_EDGES_M, (*BAND_EDGES_M[1:], float(SKY_Z)), strict=True):
        for which, row in (("tested", tested), ("reference", whole)):
            counts = [int(np.count_nonzero(_things(each, low, high))) for each in row]
            made.append(Column("covered", counts, {"picture": which, "band": band_name(low)}))
    return made


def _things(layers: Layers, low: float, high: float) -> np.ndarray:
    inside = (layers.Z >= low) & (layers.Z < high)
    return np.asarray(inside & (layers.N[..., 2] < LEVEL))
