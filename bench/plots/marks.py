"""What does each point of a finished plot say, and where does it stand?"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64


@dataclass(frozen=True)
class Mark:
    """A point of a plot as it is drawn.

    curve  number of its curve; what is drawn below others has numbers of its own
    words  what it says: ``pruned: 3.2 at 1e+04``
    place  where it stands in the SVG, from its left and upper edges
    """

    curve: int
    words: str
    place: tuple[float, float]


def marks_at(
    places: Float64[np.ndarray, "n 2"],
    curve: int,
    label: str,
    x: Sequence[float],
    y: Sequence[float],
) -> Iterator[Mark]:
    """Yield the points of one curve that are drawn: those with finite places."""
    for place, at, value in zip(places.round(1).tolist(), x, y, strict=True):
        if np.isfinite(place).all():
            yield Mark(curve, f"{label}: {value:.4g} at {at:.4g}", (place[0], place[1]))
