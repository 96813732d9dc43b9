"""What representations hand to the pruner and to the renderer: arrays, never one object per
part.
"""

from dataclasses import dataclass, field
from typing import Any, Protocol, runtime_checkable

import numpy as np

from lod.arrays import freeze
from lod.pruning.view import View


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
    parent    (n,)   row, in the batch that was asked, of the part that owns it; -1 for roots
    share     (n,)   its share of the area of all direct parts of its whole, 0 to 1; 1 for roots
    state     the representation's own, passed along untouched (poses, seeds, tiles)
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
        """The parts at ``rows`` (indices or flags)."""
        position = self.position[rows]
        centre = position if self.centre is self.position else self.centre[rows]
        return Parts(
            position=position,
            centre=centre,
            bound=self.bound[rows],
            limit=self.limit[rows],
            limit_offscreen=self.limit_offscreen[rows],
            level=self.level[rows],
            object=self.object[rows],
            part=self.part[rows],
            parent=self.parent[rows],
            share=self.share[rows],
            state=self.state,
        )


@dataclass(frozen=True, eq=False)
class BlendWeights:
    """How much of each of its two appearances a displayed part shows (§2.4).

    What of a part's own parts is hidden, its leaf appearance stands for; what of them is displayed
    hangs on its inner one. Both are shares of area, 0 to 1, so that a whole that loses its parts
    one by one covers as much as before; a share of 0 draws nothing.

    inner  (n,) of the inner appearance
    leaf   (n,) of the leaf appearance
    rise   (n,) sine of the angle at which the line from the part to the eye rises; by default 0
    turn   (n,) cosine of the angle between that line and where the sun stands on the map: 1 where
           it stands behind the eye, 0 from right above; by default NaN, from all sides alike
    hidden (n,) how much of the area of its own parts is hidden; by default all
    """

    inner: np.ndarray
    leaf: np.ndarray
    sin_elevation: np.ndarray = field(default_factory=lambda: np.zeros(0))
    cos_azimuth: np.ndarray = field(default_factory=lambda: np.zeros(0))
    hidden_area: np.ndarray = field(default_factory=lambda: np.zeros(0))

    def __post_init__(self) -> None:
        if not len(self.sin_elevation):
            object.__setattr__(self, "sin_elevation", np.zeros(len(self.inner)))
        if not len(self.cos_azimuth):
            object.__setattr__(self, "cos_azimuth", np.full(len(self.inner), np.nan))
        if not len(self.hidden_area):
            object.__setattr__(self, "hidden_area", np.ones(len(self.inner)))
        freeze(self, inner=np.float64, leaf=np.float64, sin_elevation=np.float64)
        freeze(self, cos_azimuth=np.float64, hidden_area=np.float64)

    def __len__(self) -> int:
        return len(self.inner)

    def take(self, rows: np.ndarray) -> "BlendWeights":
        """Of the parts at ``rows`` (indices or flags)."""
        columns = self.inner, self.leaf, self.sin_elevation, self.cos_azimuth, self.hidden_area
        return BlendWeights(*(each[rows] for each in columns))


@dataclass(frozen=True, eq=False)
class Sticks:
    """Round cones with round ends: limbs, branches, blobs.

    start, end              (n, 3) ends of the axis, in the frame's coordinates [m]
    start_radius, end_radius (n,) [m]
    tint    (n,)   row of ``tints``
    tints   (k, 3) linear Rec.709 albedo of each tint, 0 to 1
    owner   (n,)   row of the part that each stick belongs to
    """

    start: np.ndarray
    end: np.ndarray
    start_radius: np.ndarray
    end_radius: np.ndarray
    tint: np.ndarray
    tints: np.ndarray
    owner: np.ndarray

    def __post_init__(self) -> None:
        freeze(self, start=np.float64, end=np.float64, tints=np.float64)
        freeze(self, start_radius=np.float64, end_radius=np.float64)
        freeze(self, tint=np.int64, owner=np.int64)

    def __len__(self) -> int:
        return len(self.tint)


@dataclass(frozen=True, eq=False)
class Triangles:
    """A triangle mesh with its own normals and colours: terrain, leaves.

    vertices (v, 3) [m]; normals (v, 3) unit; colours (v, 3) linear Rec.709 albedo, 0 to 1
    faces (f, 3) rows of ``vertices``, counter-clockwise seen from outside; owner (f,) row of the
    part; what gives light itself has also
    glow (f,) row of ``glows``; glows (k, 3) linear Rec.709 radiance outwards, at least 0, in units
    of the sky
    """

    vertices: np.ndarray
    normals: np.ndarray
    colours: np.ndarray
    faces: np.ndarray
    owner: np.ndarray
    glow: np.ndarray = field(default_factory=lambda: np.zeros(0))
    glows: np.ndarray = field(default_factory=lambda: np.zeros((0, 3)))

    def __post_init__(self) -> None:
        freeze(self, vertices=np.float64, normals=np.float64, colours=np.float64)
        freeze(self, faces=np.int64, owner=np.int64, glow=np.int64, glows=np.float64)

    def __len__(self) -> int:
        return len(self.faces)


@runtime_checkable
class Representation(Protocol):
    """Anything with hierarchical levels of detail: it hands out parts, and knows what they look
    like.
    """

    @property
    def name(self) -> str:
        """What it is called in counts and records."""

    def roots(self, view: View) -> Parts:
        """Every whole near enough that a part of it could be displayed (``whole`` = -1)."""

    def parts_of(self, parts: Parts, view: View) -> Parts:
        """The parts that ``parts`` own directly; ``whole`` gives rows of ``parts``."""

    def appearance(self, parts: Parts, weights: BlendWeights) -> Sticks | Triangles:
        """What displayed parts look like: so much of each appearance as they show (§2.4)."""


@runtime_checkable
class Moving(Protocol):
    """A representation of which something may move from frame to frame."""

    def later(self, parts: Parts, view: View, time_s: float) -> Parts:
        """The same parts in the same coordinates, to look as they do at another time; ``parts``
        itself where nothing moves. Positions and limits stay those of the view.
        """
