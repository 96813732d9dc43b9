"""Where the pixels of a film look."""

import math
from typing import Any

import numpy as np


def pixel_directions(camera: dict[str, Any], side: int, rows: tuple[int, int]) -> np.ndarray:
    """Unit directions through the centres of a band of film pixels, (rows, columns, 3) float32."""
    width, height = camera["size"]
    tan_x = math.tan(math.radians(camera["fov_x_deg"]) / 2)
    tan_y = tan_x * height / width
    x = ((np.arange(width * side) + 0.5) / (width * side) * 2 - 1) * tan_x
    y = (1 - (np.arange(rows[0] * side, rows[1] * side) + 0.5) / (height * side) * 2) * tan_y
    forward, up = camera["forward"], camera["up"]
    right = np.cross(forward, up)
    across, down = forward + x[:, None] * right, y[:, None] * up
    directions = across.astype(np.float32)[None] + down.astype(np.float32)[:, None]
    directions /= np.sqrt(np.sum(directions**2, axis=2, keepdims=True))
    return directions
