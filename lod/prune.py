"""The pruner: from any representation to the parts that this viewer can resolve (§2.4)."""

from dataclasses import dataclass

import numpy as np

from lod.parts import Parts, Representation
from lod.view import View, distance, in_view


@dataclass(frozen=True, eq=False)
class Cut:
    """The parts displayed in one frame, a connected top of every object's tree.

    parts     the displayed parts, wholes before their parts; ``whole`` gives rows of this batch
    examined_objects, examined_parts   how many were tested, displayed or not
    """

    parts: Parts
    examined_objects: int
    examined_parts: int

    @property
    def displayed_objects(self) -> int:
        """Objects of which at least the coarsest part is displayed."""
        return int(np.count_nonzero(self.parts.whole < 0))

    @property
    def displayed_parts(self) -> int:
        """All displayed parts, inner and leaf."""
        return len(self.parts)


def displayed(parts: Parts, view: View) -> np.ndarray:
    """The one test of the metric: d < D, with the coarser D for what is out of view, (n,)."""
    seen = in_view(view, parts.centre, parts.bound)
    limit = np.where(seen, parts.limit, parts.limit_offscreen)
    return distance(view, parts.position) < limit


def prune(representation: Representation, view: View) -> Cut:
    """Walk down level by level, asking only what passed for its parts."""
    candidates = representation.roots(view)
    examined_objects = examined_parts = len(candidates)
    batches = [candidates.take(displayed(candidates, view))]
    wholes = [batches[0].whole]
    first_row = 0
    while len(batches[-1]):
        candidates = representation.parts_of(batches[-1], view)
        examined_parts += len(candidates)
        passed = candidates.take(displayed(candidates, view))
        wholes.append(passed.whole + first_row)
        first_row += len(batches[-1])
        batches.append(passed)
    parts = _join(batches, np.concatenate(wholes))
    return Cut(parts, examined_objects, examined_parts)


def _join(batches: list[Parts], whole: np.ndarray) -> Parts:
    if len(batches) == 1:
        return batches[0]

    def column(name: str) -> np.ndarray:
        return np.concatenate([getattr(batch, name) for batch in batches])

    position = column("position")
    shared = all(batch.centre is batch.position for batch in batches)
    names = ("bound", "limit", "limit_offscreen", "level", "object", "part", "share")
    return Parts(
        position=position,
        centre=position if shared else column("centre"),
        whole=whole,
        state=batches[0].state,
        **{name: column(name) for name in names},
    )
