"""The pruner: which parts of a representation are displayed in a view (§2.4)."""

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

    Object by object, and within each level by level: parents before their parts.

    object, part, level, parent  (n,) as in Parts; ``parent`` holds rows of this cut
    examined_objects, examined_parts   how many were tested, displayed or not
    load_parts  loader of all columns of the displayed parts, called once, on demand
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
        """Load all columns of the displayed parts, on demand; ``parent`` holds rows of them."""
        return self.load_parts()

    @property
    def displayed_objects(self) -> int:
        """Number of objects of which at least the coarsest part is displayed."""
        return int(np.count_nonzero(self.parent < 0))

    @property
    def displayed_parts(self) -> int:
        """Number of displayed parts, inner and leaf."""
        return len(self)


@runtime_checkable
class CompiledTraversal(Protocol):
    """A representation with a compiled traversal of its own hierarchy, by the same test."""

    def cut(self, view: View) -> Cut:
        """Return the cut that ``prune_by_level`` returns, to the last bit."""


def displayed(parts: Parts, view: View) -> np.ndarray:
    """Apply the test of the metric, d < D, with the coarser D for what is out of view, (n,)."""
    seen = in_view(view, parts.centre, parts.bound)
    limit = np.where(seen, parts.limit, parts.limit_offscreen)
    return distance(view, parts.position) < limit


def prune(representation: Representation, view: View) -> Cut:
    """Compute the cut of a representation, by its compiled traversal or level by level."""
    if isinstance(representation, CompiledTraversal):
        return representation.cut(view)
    return prune_by_level(representation, view)


def prune_by_level(representation: Representation, view: View) -> Cut:
    """Compute the cut level by level: only parts that are displayed are asked for their parts."""
    candidates = representation.roots(view)
    examined_objects = examined_parts = len(candidates)
    batches = [candidates.take(displayed(candidates, view))]
    parents = [batches[0].parent]
    first_row = 0
    while len(batches[-1]):
        candidates = representation.parts_of(batches[-1], view)
        examined_parts += len(candidates)
        passed = candidates.take(displayed(candidates, view))
        parents.append(passed.parent + first_row)
        first_row += len(batches[-1])
        batches.append(passed)
    parts = _by_object(replace(Parts.concatenate(batches), parent=np.concatenate(parents)))
    return cut_from_parts(parts, examined_objects, examined_parts)


def cut_from_parts(parts: Parts, examined_objects: int, examined_parts: int) -> Cut:
    """Return the cut of parts whose columns are loaded already."""
    columns = (parts.object, parts.part, parts.level, parts.parent)
    return Cut(*columns, examined_objects, examined_parts, lambda: parts)


def _by_object(parts: Parts) -> Parts:
    """The same parts, object by object, those of each in the order they have."""
    order = np.argsort(parts.object, kind="stable")
    row = np.empty(len(order), np.int64)
    row[order] = np.arange(len(order))
    ordered = parts.take(order)
    return replace(ordered, parent=np.where(ordered.parent < 0, -1, row[ordered.parent]))
