"""The ground as everything that stands on it needs it: a height at every point, and its bounds."""

from typing import Protocol, runtime_checkable

import numpy as np

from lod.camera import Corner


@runtime_checkable
class Ground(Protocol):
    """A height field that objects, plumes and cameras stand on."""

    def height(self, corner: Corner, xy: np.ndarray) -> np.ndarray:
        """Height of the ground [m] at points (n, 2) [m] from the corner, (n,)."""

    def bounds(self) -> tuple[float, float]:
        """Lowest and highest that the ground can be anywhere [m]."""
