"""What are vectors and components of quaternions as plain data? Tuples, which need no library."""

from collections.abc import Sequence

import numpy as np

Vector = tuple[float, float, float]
VectorLike = Sequence[float] | np.ndarray
Components = tuple[float, float, float, float]
"""i, j, k and the real part."""
