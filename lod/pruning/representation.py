"""What the pruner asks of anything that has hierarchical levels of detail."""

from typing import Protocol, runtime_checkable

from lod.pruning.parts import BlendWeights, Parts
from lod.pruning.shapes import Appearance
from lod.pruning.view import View


@runtime_checkable
class Representation(Protocol):
    """Anything with hierarchical levels of detail: it gives its parts and their appearance."""

    @property
    def name(self) -> str:
        """Return the name of the representation in counts and records."""

    def roots(self, view: View) -> Parts:
        """Return every whole near enough that a part of it could be displayed (``parent`` = -1)."""

    def parts_of(self, parts: Parts, view: View) -> Parts:
        """Return the parts that ``parts`` own directly; ``parent`` holds rows of ``parts``."""

    def appearance(self, parts: Parts, weights: BlendWeights) -> Appearance:
        """Return the shape of displayed parts, each appearance thinned to its weight (§2.4)."""


@runtime_checkable
class Moving(Protocol):
    """A representation of which something may move from frame to frame."""

    def later(self, parts: Parts, view: View, time_s: float) -> Parts:
        """Return the same parts in the same coordinates, posed at another time.

        The result is ``parts`` itself where nothing moves. Positions and limits stay those of the
        view.
        """
