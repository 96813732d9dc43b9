"""How much of the light on level ground is the sky's, and how much the sun's."""

import numpy as np

from lod.arrays import Reals

ELEVATIONS_DEG = (10.0, 20.0, 40.0, 60.0, 85.0)
TURBIDITIES = (2.0, 3.0, 5.0)
SHARES = np.array(
    (
        ((0.300, 0.518, 0.805), (0.179, 0.331, 0.575), (0.113, 0.215, 0.405),
         (0.092, 0.173, 0.338), (0.087, 0.166, 0.308)),
        ((0.359, 0.563, 0.821), (0.221, 0.367, 0.594), (0.144, 0.243, 0.423),
         (0.114, 0.197, 0.356), (0.113, 0.184, 0.319)),
        ((0.527, 0.685, 0.866), (0.348, 0.470, 0.648), (0.238, 0.328, 0.478),
         (0.190, 0.271, 0.412), (0.177, 0.250, 0.362)),
    )
)  # fmt: skip
"""Of red, green and blue, by turbidity and elevation: Mitsuba's ``sunsky``, integrated over 4000
directions of equal weight (this project's own measurement)."""


def sky_share(elevation_deg: float, turbidity: float) -> Reals:
    """The sky's share in red, green and blue, (3,); at the table's edge beyond it."""
    by_elevation = [
        [np.interp(elevation_deg, ELEVATIONS_DEG, rows[:, c]) for c in range(3)] for rows in SHARES
    ]
    columns = np.array(by_elevation).T
    return np.array([np.interp(turbidity, TURBIDITIES, column) for column in columns])
