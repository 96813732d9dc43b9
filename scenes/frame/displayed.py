"""What one representation displays in a frame, and how it looks at a moment of it."""

from dataclasses import dataclass, replace

import numpy as np

from lod.pruning.parts import BlendWeights, Parts
from lod.pruning.pruner import Cut
from lod.pruning.representation import Moving, Representation
from lod.pruning.shapes import Sticks, Triangles
from lod.pruning.update_schedule import (
    DrawnState,
    apply_state,
)
from lod.pruning.view import View


@dataclass(frozen=True, eq=False)
class Visible:
    """One representation's cut and its looks; ``shape.owner`` gives rows of ``cut.parts``.

    later  the same sticks as they are in the next frame, in this one's coordinates; None: as now
    """

    name: str
    cut: Cut
    shape: Sticks | Triangles
    later: Sticks | None = None


@dataclass(frozen=True, eq=False)
class Shown:
    """What one representation displays in a frame, whenever it is looked at.

    drawn  what of it is kept as it was drawn; None: nothing
    """

    each: Representation
    cut: Cut
    weights: BlendWeights
    view: View
    drawn: DrawnState | None = None

    def shape(self, time_s: float) -> Sticks | Triangles:
        """What is drawn at a time, in the frame's coordinates."""
        posed = self.posed(time_s)
        return apply_state(self.drawn, posed) if self.drawn and isinstance(posed, Sticks) else posed

    def posed(self, time_s: float) -> Sticks | Triangles:
        """Its looks at a time, nothing of it kept."""
        return self.each.appearance(self.parts(time_s), self.weights)

    def parts(self, time_s: float) -> Parts:
        """The displayed parts as they stand at a time; the very same where nothing moves."""
        if time_s == self.view.time_s or not isinstance(self.each, Moving):
            return self.cut.parts
        return self.each.later(self.cut.parts, self.view, time_s)

    def moves(self, time_s: float) -> bool:
        """Whether anything stands elsewhere at that time."""
        return self.parts(time_s) is not self.cut.parts


def visible_at(shown: Shown, time_s: float, later_s: float | None) -> Visible:
    """A cut at a time, with its sticks at a later one, row by row, where they move till then."""
    later = shown.posed(later_s) if later_s is not None and shown.moves(later_s) else None
    sticks = later if isinstance(later, Sticks) else None
    return Visible(shown.each.name, compact_ids(shown.cut), shown.shape(time_s), sticks)


def compact_ids(cut: Cut) -> Cut:
    """A frame's ids have 32 bits: parts with longer addresses are numbered in their order."""
    part = cut.part
    if not len(part) or part.max() < 2**32:
        return cut
    numbers = np.unique(part, return_inverse=True)[1]
    return replace(cut, part=numbers)
