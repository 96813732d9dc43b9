"""The pruner: from any representation to the parts that this viewer can resolve (§2.4)."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Protocol, runtime_checkable

import numpy as np

from lod.pruning.parts import Parts
from lod.pruning.representation import Representation
from lod.pruning.view import View
from lod.pruning.view_geometry import distance, in_view


@dataclass(frozen=True, eq=False)
class Cut:
    """The parts displayed in one frame, a connected top of every object's tree.

    Object by object, and within each level by level: wholes before their parts.

    object, part, level, whole  (n,) as in Parts; ``whole`` gives rows of this cut
    examined_objects, examined_parts   how many were tested, displayed or not
    tell      everything else that is known of the displayed parts
    """

    object: np.ndarray
    part: np.ndarray
    level: np.ndarray
    parent: np.ndarray
    examined_objects: int
    examined_parts: int
    load_parts: Callable[[], Parts]

    def __len__(self) -> int:
        return len(self.part)

    @cached_property
    def parts(self) -> Parts:
        """The displayed parts; ``whole`` gives rows of this batch. Worked out when asked for."""
        return self.load_parts()

    @property
    def displayed_objects(self) -> int:
        """Objects of which at least the coarsest part is displayed."""
        return int(np.count_nonzero(self.parent < 0))

    @property
    def displayed_parts(self) -> int:
        """All displayed parts, inner and leaf."""
        return len(self)


@runtime_checkable
class CompiledTraversal(Protocol):
    """A representation with a compiled walk over its own hierarchy, by the same comparison."""

    def cut(self, view: View) -> Cut:
        """What ``prune_by_level`` gives for it, to the last bit."""


def displayed(parts: Parts, view: View) -> np.ndarray:
    """The one test of the metric: d < D, with the coarser D for what is out of view, (n,)."""
    seen = in_view(view, parts.centre, parts.bound)
    limit = np.where(seen, parts.limit, parts.limit_offscreen)
    return distance(view, parts.position) < limit


def prune(representation: Representation, view: View) -> Cut:
    """What of a representation is displayed: by its compiled walk, or level by level."""
    if isinstance(representation, CompiledTraversal):
        return representation.cut(view)
    return prune_by_level(representation, view)


def prune_by_level(representation: Representation, view: View) -> Cut:
    """Walk down level by level, asking only what passed for its parts."""
    candidates = representation.roots(view)
    examined_objects = examined_parts = len(candidates)
    batches = [candidates.take(displayed(candidates, view))]
    wholes = [batches[0].parent]
    first_row = 0
    while len(batches[-1]):
        candidates = representation.parts_of(batches[-1], view)
        examined_parts += len(candidates)
        passed = candidates.take(displayed(candidates, view))
        wholes.append(passed.parent + first_row)
        first_row += len(batches[-1])
        batches.append(passed)
    parts = _by_object(_join(batches, np.concatenate(wholes)))
    return cut_from_parts(parts, examined_objects, examined_parts)


def cut_from_parts(parts: Parts, examined_objects: int, examined_parts: int) -> Cut:
    """The cut of parts that are known already."""
    columns = (parts.object, parts.part, parts.level, parts.parent)
    return Cut(*columns, examined_objects, examined_parts, lambda: parts)


def _by_object(parts: Parts) -> Parts:
    """The same parts, object by object, those of each in the order they have."""
    order = np.argsort(parts.object, kind="stable")
    row = np.empty(len(order), np.int64)
    row[order] = np.arange(len(order))
    taken = parts.take(order)
    return replace(taken, parent=np.where(taken.parent < 0, -1, row[taken.parent]))


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
        parent=whole,
        state=batches[0].state,
        **{name: column(name) for name in names},
    )
