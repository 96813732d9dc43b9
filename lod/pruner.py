"""The pruner: which parts of a representation are displayed in a view (§2.4).

A representation is anything that has hierarchical levels of detail; it hands its parts to the
pruner in batches, as arrays.

Cross-fading: parts shrink before their limit distance, and their wholes take over their area.

Within a band before its limit distance D a part shrinks from its full area to none (Rubin 1982,
the paper's ref. 8), and what hangs on it with it. Out of view D is less; what is displayed only
because it is in view grows while the sphere that holds it enters the pyramid of view. The area
that a part's own parts no longer cover is the share λ of its leaf appearance; what of the two lies
in one another is made up for where they are drawn (``leaf_area_share``). Counts are those of the
cut: fading changes no part of it.

Parts that thin out are not followed by a leaf appearance: those that are left become wider as the
others shrink, so that all together cover the same area (Cook et al. 2007, "Stochastic
simplification of aggregate detail", SIGGRAPH).
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, fields, replace
from functools import cached_property
from typing import Any, Protocol, runtime_checkable

import numpy as np

from lod.arrays import ArrayData, FloatArray, Points, Reals, freeze
from lod.kernels import map_chunks, njit
from lod.shapes import Appearance
from lod.view import (
    View,
    compile_view,
    distance,
    distance_to,
    entry_fraction,
    in_view,
    sphere_in_frustum,
)


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
    kept      (n,)   of parts that thin out, the share that is left at its distance, above 0: what
                     is left is so much wider. 0 for the whole of such parts, which shows nothing;
                     None where nothing thins out
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
    kept: np.ndarray | None = None

    def __post_init__(self) -> None:
        same = self.centre is self.position
        freeze(self, position=np.float64, bound=np.float64, limit=np.float64)
        freeze(self, limit_offscreen=np.float64, level=np.int64, object=np.int64)
        freeze(self, part=np.int64, parent=np.int64, share=np.float64)
        if self.kept is not None:
            freeze(self, kept=np.float64)
        if same:
            object.__setattr__(self, "centre", self.position)
        else:
            freeze(self, centre=np.float64)

    def __len__(self) -> int:
        return len(self.part)

    def take(self, rows: np.ndarray) -> "Parts":
        """Select the parts at ``rows`` (indices or flags)."""
        return Parts._gather((self,), lambda name: getattr(self, name)[rows])

    @staticmethod
    def concatenate(batches: Sequence["Parts"]) -> "Parts":
        """Lay batches end to end; ``parent`` keeps the rows that it has in each of them."""
        return Parts._gather(
            batches, lambda name: np.concatenate([getattr(each, name) for each in batches])
        )

    @staticmethod
    def _gather(batches: Sequence["Parts"], column: Callable[[str], np.ndarray]) -> "Parts":
        # Centres that are positions in every batch stay so.
        names = {each.name for each in fields(Parts)} - {"centre", "state"}
        if batches[0].kept is None:
            names -= {"kept"}
        columns = {name: column(name) for name in names}
        shared = all(each.centre is each.position for each in batches)
        centre = columns["position"] if shared else column("centre")
        return Parts(**columns, centre=centre, state=batches[0].state)


@dataclass(frozen=True, eq=False)
class BlendWeights(ArrayData):
    """Cross-fade weights: how much of each of its two appearances a displayed part shows (§2.4).

    The inner appearance carries the displayed parts of a part; the leaf appearance stands for the
    hidden ones. Both weights are shares of area, 0 to 1, so that a whole that loses its parts one
    by one covers as much as before; a weight of 0 draws nothing. A part that stands for others like
    it, which have been thinned out, has more than 1.

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
        for name, usual in (("sin_elevation", 0.0), ("cos_azimuth", np.nan), ("hidden_area", 1.0)):
            if not len(getattr(self, name)):
                object.__setattr__(self, name, np.full(len(self.inner), usual))
        super().__post_init__()

    def __len__(self) -> int:
        return len(self.inner)

    def take(self, rows: np.ndarray) -> "BlendWeights":
        """Select the weights of the parts at ``rows`` (indices or flags)."""
        return BlendWeights(*(getattr(self, each.name)[rows] for each in fields(self)))


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
    parts = replace(Parts.concatenate(batches), parent=np.concatenate(parents))
    # Object by object, those of each in the order they have.
    order = np.argsort(parts.object, kind="stable")
    row = np.empty(len(order), np.int64)
    row[order] = np.arange(len(order))
    parts = parts.take(order)
    parts = replace(parts, parent=np.where(parts.parent < 0, -1, row[parts.parent]))
    return cut_from_parts(parts, examined_objects, examined_parts)


def cut_from_parts(parts: Parts, examined_objects: int, examined_parts: int) -> Cut:
    """Return the cut of parts whose columns are loaded already."""
    columns = (parts.object, parts.part, parts.level, parts.parent)
    return Cut(*columns, examined_objects, examined_parts, lambda: parts)


_INNER_GAIN = 4.0
"""Gain of the inner appearance, which thins only while less than a quarter of its parts is left:
it and the leaf appearance mostly overlap, and halves of both would not make a whole."""

_SHORTEST_RUN = 16384
"""Parts for which another thread is worth its start."""

_ROUNDING = 1e-9
"""Hidden shares below this are what sums of shares leave over."""


def blend_weights(cut: Cut, view: View) -> BlendWeights:
    """Compute the cross-fade weights of both appearances of every displayed part of a cut."""
    parts = cut.parts
    fades = view.fade > 0 or parts.kept is not None
    shown = fade_factors(cut, view) if fades else np.ones(len(parts))
    inner, leaf, hidden = cross_fade(parts.parent, parts.share, shown)
    return BlendWeights(inner, leaf, *view_angles(parts.position, view), hidden)


def view_angles(position: Points, view: View) -> tuple[Reals, Reals]:
    """Compute from which side the eye sees each point (n, 3): two columns of length n.

    The first is the sine of the eye's elevation above the point, the second the cosine of the angle
    between the line to the eye and the sun's azimuth (NaN in a view without a sun).
    """
    eye, sun = view.camera.eye, (math.nan, math.nan) if view.sun is None else view.sun
    rise, turn = np.empty((2, len(position)))

    def run(first: int, last: int) -> None:
        _view_angles(position[first:last], eye, sun, rise[first:last], turn[first:last])

    map_chunks(run, len(position), _SHORTEST_RUN)
    return rise, turn


def fade_factors(cut: Cut, view: View) -> Reals:
    """Compute which share of its area each part shows by itself: (D − d)/(fade·D), at most 1, (n,).

    In view times how far its sphere has entered it, but no less than it would show out of view.
    What thins out shows more than 1: its share over the share of all that is left.
    """
    parts = cut.parts
    columns = parts.position, parts.centre, parts.bound, parts.limit, parts.limit_offscreen
    vantage = compile_view(view)
    kept = np.broadcast_to(0.0, 0) if parts.kept is None else parts.kept  # both read-only

    shown = np.ones(len(parts))

    def run(first: int, last: int) -> None:
        rows = slice(first, last)
        own = [each[rows] for each in (*columns, kept)]
        _fade_factors(vantage, *own, view.fade, shown[rows])

    map_chunks(run, len(parts), _SHORTEST_RUN)
    return shown


@njit(cache=True, nogil=True)
def _fade_factors(vantage, position, centre, bound, limit, limit_offscreen, kept, fade, shown):  # type: ignore[no-untyped-def]
    for i in range(len(bound)):
        if len(kept) and kept[i] == 0.0:
            continue  # the whole of what thins out shows nothing
        d = distance_to(vantage, position[i, 0], position[i, 1], position[i, 2])
        # Where it is well within the coarser limit it is whole, in view or not.
        if d < limit_offscreen[i] * (1.0 - fade) and limit_offscreen[i] <= limit[i]:
            continue
        x, y, z = centre[i, 0], centre[i, 1], centre[i, 2]
        shown[i] = _band_factor(d, limit_offscreen[i], fade)
        if sphere_in_frustum(vantage, x, y, z, bound[i]):
            inside = _band_factor(d, limit[i], fade) * entry_fraction(vantage, x, y, z, bound[i])
            shown[i] = max(shown[i], inside)
        if len(kept):
            shown[i] /= kept[i]


@njit(cache=True, nogil=True)
def _view_angles(position, eye, sun, rise, turn):  # type: ignore[no-untyped-def]
    for i in range(len(position)):
        x, y, z = eye[0] - position[i, 0], eye[1] - position[i, 1], eye[2] - position[i, 2]
        d = math.sqrt(x * x + y * y + z * z)
        rise[i] = z / d if d > 0.0 else 0.0
        turn[i] = (x * sun[0] + y * sun[1]) / d if d > 0.0 else math.nan


@njit(cache=True)
def _band_factor(d, D, fade):  # type: ignore[no-untyped-def]
    if D == math.inf or fade == 0.0:
        return 1.0 if d < D else 0.0
    return min(max((D - d) / (fade * D), 0.0), 1.0) if D > 0.0 else 0.0


@njit(cache=True)
def cross_fade(parent, share, shown):  # type: ignore[no-untyped-def]
    """Compute weights (inner, leaf, hidden area) of every part from its fade factor, (n,) each.

    Rows: parents before children. The displayed parts of a part hang on its inner appearance,
    which stays while any of them does.
    """
    n = len(parent)
    shown = shown.copy()
    inner, leaf, hidden = np.zeros(n), np.zeros(n), np.ones(n)
    for i in range(n):
        if parent[i] >= 0:
            hidden[parent[i]] -= share[i] * shown[i]
            inner[parent[i]] = max(inner[parent[i]], shown[i])
    for i in range(n):
        if parent[i] >= 0:
            shown[i] *= shown[parent[i]]
        inner[i] = min(1.0, _INNER_GAIN * inner[i]) * shown[i]
        if hidden[i] <= _ROUNDING:
            hidden[i] = 0.0
        leaf[i] = hidden[i] * shown[i]
    return inner, leaf, hidden


@njit(cache=True)
def radius_factor(r0, r1, length, share):  # type: ignore[no-untyped-def]
    """Compute the factor on radii of a stick that leaves a share of its mean outline area.

    A stick of radii r₀, r₁ and length L has a quarter of its surface as mean outline (Cauchy):
    caps π(r₀² + r₁²)/2 and a flank π(r₀ + r₁)L/4, but for a term of (r₀ − r₁)². Radii times f
    make that f²·caps + f·flank: f is about the share for long sticks, its root for round blobs.
    """
    caps = (r0 * r0 + r1 * r1) / 2
    flank = (r0 + r1) * length / 4
    area = share * (caps + flank)
    return 2 * area / (flank + math.sqrt(flank * flank + 4 * caps * area))


@njit(cache=True)
def leaf_area_share(hidden, overlap):  # type: ignore[no-untyped-def]
    """Compute which share s of its area a leaf appearance shows while a share h of parts is hidden.

    The share s of the leaf appearance and the share 1 − h of the parts overlap by c·s·(1 − h), with
    c the overlap of the two at full size. Covering the same area as before asks for
    s + (1 − h) − c·s·(1 − h) = 1, so that s = h/(1 − c·(1 − h)), which is 0 for h = 0 and 1 for
    h = 1. The overlap c is below 1; it is below 0 where both together cover more than their sum.
    """
    return hidden / (1.0 - overlap * (1.0 - hidden))
