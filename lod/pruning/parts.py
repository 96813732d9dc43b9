"""What representations hand to the pruner: batches of parts as arrays, and what shows of them."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, fields
from typing import Any

import numpy as np

from lod.arrays import ArrayData, FloatArray, freeze


@dataclass(frozen=True, eq=False)
class Parts:
    """A batch of parts of one representation, in the frame's coordinates.

    position  (n, 3) the point that d is measured to [m]
    centre    (n, 3) centre of the bounding sphere; usually the same array [m]
    bound     (n,)   radius B of that sphere [m]
    limit, limit_offscreen  (n,) clamped limit distance D in view and out of it [m]
    level     (n,)   detail level
    object    (n,)   which object of this frame the part belongs to
    part      (n,)   which part of its representation it is
    parent    (n,)   row of the part that owns it, in the batch that was asked; -1 for roots
    share     (n,)   its share of the area of all direct parts of its whole, 0 to 1; 1 for roots
    state     data of the representation itself, passed along untouched (poses, seeds, tiles)
    """

    position: np.ndarray
    centre: np.ndarray
    bound: np.ndarray
    limit: np.ndarray
    limit_offscreen: np.ndarray
    level: np.ndarray
    object: np.ndarray
    part: np.ndarray
    parent: np.ndarray
    share: np.ndarray
    state: Any = None

    def __post_init__(self) -> None:
        same = self.centre is self.position
        freeze(self, position=np.float64, bound=np.float64, limit=np.float64)
        freeze(self, limit_offscreen=np.float64, level=np.int64, object=np.int64)
        freeze(self, part=np.int64, parent=np.int64, share=np.float64)
        if same:
            object.__setattr__(self, "centre", self.position)
        else:
            freeze(self, centre=np.float64)

    def __len__(self) -> int:
        return len(self.part)

    def take(self, rows: np.ndarray) -> "Parts":
        """Select the parts at ``rows`` (indices or flags)."""
        return _gather((self,), lambda name: getattr(self, name)[rows])

    @staticmethod
    def concatenate(batches: Sequence["Parts"]) -> "Parts":
        """Lay batches end to end; ``parent`` keeps the rows that it has in each of them."""
        return _gather(batches, lambda k: np.concatenate([getattr(each, k) for each in batches]))


def _gather(batches: Sequence[Parts], column: Callable[[str], np.ndarray]) -> Parts:
    """Parts with these columns; centres that are positions in every batch stay so."""
    names = [each.name for each in fields(Parts) if each.name not in ("centre", "state")]
    columns = {name: column(name) for name in names}
    shared = all(each.centre is each.position for each in batches)
    centre = columns["position"] if shared else column("centre")
    return Parts(**columns, centre=centre, state=batches[0].state)


@dataclass(frozen=True, eq=False)
class BlendWeights(ArrayData):
    """Cross-fade weights: how much of each of its two appearances a displayed part shows (§2.4).

    The inner appearance carries the displayed parts of a part; the leaf appearance stands for the
    hidden ones. Both weights are shares of area, 0 to 1, so that a whole that loses its parts one
    by one covers as much as before; a weight of 0 draws nothing.

    inner          (n,) weight of the inner appearance
    leaf           (n,) weight of the leaf appearance
    sin_elevation  (n,) sine of the elevation of the eye above the part; 0 by default
    cos_azimuth    (n,) cosine of the angle between the line from the part to the eye and the sun's
                   azimuth: 1 where the sun is behind the eye, 0 from right above; NaN by default,
                   which means that the appearance is the same from all sides
    hidden_area    (n,) share of the area of a part's own parts that is hidden; 1 by default
    """

    inner: FloatArray
    leaf: FloatArray
    sin_elevation: FloatArray = field(default_factory=lambda: np.zeros(0))
    cos_azimuth: FloatArray = field(default_factory=lambda: np.zeros(0))
    hidden_area: FloatArray = field(default_factory=lambda: np.zeros(0))

    def __post_init__(self) -> None:
        if not len(self.sin_elevation):
            object.__setattr__(self, "sin_elevation", np.zeros(len(self.inner)))
        if not len(self.cos_azimuth):
            object.__setattr__(self, "cos_azimuth", np.full(len(self.inner), np.nan))
        if not len(self.hidden_area):
            object.__setattr__(self, "hidden_area", np.ones(len(self.inner)))
        super().__post_init__()

    def __len__(self) -> int:
        return len(self.inner)

    def take(self, rows: np.ndarray) -> "BlendWeights":
        """Select the weights of the parts at ``rows`` (indices or flags)."""
        columns = self.inner, self.leaf, self.sin_elevation, self.cos_azimuth, self.hidden_area
        return BlendWeights(*(each[rows] for each in columns))
