"""A palette with darker tones: how a stick can change its brightness with the direction of view.

Sticks have a row of a palette for a colour, and no brightness of their own. So each colour of a
stick whose brightness depends on the view is followed by as many darker tones as it can need.
"""

import numpy as np
from jaxtyping import Float64

from lod.arrays import Ints
from scenes.sticks.view_dependence import TONE_STEP, ViewDependence


def with_tone_steps(
    tint: Ints, tints: np.ndarray, views: ViewDependence
) -> tuple[Ints, Float64[np.ndarray, "t 3"]]:
    """Give sticks whose brightness depends on the view tints in a longer palette.

    Returns their tints (k,) and that palette: all tones of a stick, from the lightest to the
    darkest, follow the tint that it is given.
    """
    steps = np.ceil(views.tone_steps.max(axis=(1, 2), initial=0.0)).astype(np.int64)
    dependent = views.table_row >= 0
    pairs, pair = np.unique(
        np.stack((views.table_row[dependent], tint[dependent])), axis=1, return_inverse=True
    )
    blocks = [
        np.minimum(
            views.brightest[row] * tints[colour] * TONE_STEP ** np.arange(steps[row] + 1)[:, None],
            1.0,
        )
        for row, colour in pairs.T
    ]
    first = len(tints) + np.cumsum([0] + [len(block) for block in blocks])[:-1]
    toned = tint.copy()
    toned[dependent] = first[pair.reshape(-1)]
    return toned, np.concatenate((tints, *blocks))
