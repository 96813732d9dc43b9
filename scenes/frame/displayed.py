"""What one representation displays in a frame, and how it looks at any time near the frame's."""

from dataclasses import dataclass, replace

import numpy as np

from lod.crossfade import blend_weights
from lod.pruner import BlendWeights, Cut, Moving, Parts, Representation
from lod.shapes import Appearance, Sticks, SticksAndTriangles
from lod.update_schedule import DrawnState, apply_state
from lod.view import View


@dataclass(frozen=True, eq=False)
class Posing:
    """How the displayed parts of a representation are posed and drawn at other times.

    parts    the displayed parts as they stand at the view's time
    weights  by which inner and leaf appearances are blended, whenever they are drawn
    """

    representation: Representation
    parts: Parts
    weights: BlendWeights
    view: View

    def parts_at(self, time_s: float) -> Parts:
        """Return the displayed parts as they stand at a time; the very same where nothing moves."""
        if time_s == self.view.time_s or not isinstance(self.representation, Moving):
            return self.parts
        return self.representation.later(self.parts, self.view, time_s)

    def shape_at(self, time_s: float) -> Appearance:
        """Return their appearance at a time, in the coordinates of the view's frame."""
        return self.representation.appearance(self.parts_at(time_s), self.weights)

    def moves(self, time_s: float) -> bool:
        """Tell whether any of them stands elsewhere at that time."""
        return self.parts_at(time_s) is not self.parts


@dataclass(frozen=True, eq=False)
class DisplayedRepresentation:
    """What one representation displays at one time, in the coordinates of its frame.

    cut     the displayed parts; ``shape.owner`` gives their rows
    shape   their appearance
    later   the same sticks and meshes a frame later, row by row; None where nothing moves till then
    posing  gives the appearance at other times; None for what never moves
    drawn   which sticks are still drawn as they were in an earlier frame; None: none are
    """

    name: str
    cut: Cut
    shape: Appearance
    later: Sticks | SticksAndTriangles | None = None
    posing: Posing | None = None
    drawn: DrawnState | None = None

    def moves(self, time_s: float) -> bool:
        """Tell whether any displayed part stands elsewhere at that time."""
        return self.posing is not None and self.posing.moves(time_s)

    def at(self, time_s: float, later_s: float | None = None) -> "DisplayedRepresentation":
        """Return the same parts drawn at a time, with where their sticks are at a later one."""
        if self.posing is None:
            return self
        shape, later = self.shape, None
        if self.moves(time_s):
            shape = _drawn(self.drawn, self.posing.shape_at(time_s))
        if later_s is not None and self.moves(later_s):
            later = self.posing.shape_at(later_s)
        if not isinstance(later, Sticks | SticksAndTriangles):
            later = None
        return replace(self, shape=shape, later=later)

    def with_drawn(self, drawn: DrawnState) -> "DisplayedRepresentation":
        """Return the same parts, of which some sticks are still drawn as they were."""
        return replace(self, shape=_drawn(drawn, self.shape), drawn=drawn)


def display(representation: Representation, cut: Cut, view: View) -> DisplayedRepresentation:
    """Ask a representation for the appearance of the parts of a cut, at the view's time."""
    posing = Posing(representation, cut.parts, blend_weights(cut, view), view)
    shape = posing.shape_at(view.time_s)
    return DisplayedRepresentation(representation.name, compact_ids(cut), shape, posing=posing)


def compact_ids(cut: Cut) -> Cut:
    """Number parts in their order where their addresses are longer than a frame's 32 bits."""
    part = cut.part
    if not len(part) or part.max() < 2**32:
        return cut
    numbers = np.unique(part, return_inverse=True)[1]
    return replace(cut, part=numbers)


def _drawn(drawn: DrawnState | None, shape: Appearance) -> Appearance:
    return apply_state(drawn, shape) if drawn and isinstance(shape, Sticks) else shape
