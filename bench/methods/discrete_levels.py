"""Discrete level of detail: one of four versions of a whole object, by its projected size.

This is what engines do (Luebke et al., "Level of Detail for 3D Graphics", 2003, ch. 2 and 4). The
versions of an object leave out all parts smaller than 0, 1/32, 1/8 and 1/2 of its own size P; an
object uses the coarsest version whose largest omitted part is below τ pixels, and none at all where
it is smaller itself. A switch to a coarser version waits until the object is ``BAND`` farther away
than the switch to a finer one, so that an object at a switching distance does not flicker.
"""

from dataclasses import dataclass, replace

import numpy as np

from bench.methods.method import DETAILS_PX, Method, Updater, frame_of
from lod.arrays import ArrayData, FloatArray, IntArray
from lod.metric import Metric
from lod.pruner import Cut, cut_from_parts, prune
from lod.view import View, distance, in_view
from scenes.field.cells import CellSamples
from scenes.field.species_field import SpeciesField
from scenes.frame.frame_input import DisplayedRepresentation, display
from scenes.scene import Scene

OMITTED = (0.0, 1 / 32, 1 / 8, 1 / 2, 1.0)
"""Size of the largest part that each version leaves out ÷ the whole's; the last leaves out all."""

BAND = 0.1  # how much farther away the switch to a coarser version is, as a share of its distance


def version_limits(P: np.ndarray, R: np.ndarray, m: float) -> np.ndarray:
    """Compute how far away the version in use still holds each part, (n,) [m].

    Row 0 is the whole object. A part of size P is in the versions that leave out less than P, and
    the version that leaves out e is in use up to where the next one's e subtends m.
    """
    steps = np.asarray(OMITTED) * P[0]
    return np.asarray(steps[np.searchsorted(steps, P * (1 - 1e-12))] / m)


VERSIONS = Metric("discrete", version_limits, "one of four versions of the whole object")


@dataclass(frozen=True, eq=False)
class VersionMemory(ArrayData):
    """Which version each object of a field had in the frame before, by sorted keys."""

    keys: IntArray
    versions: IntArray

    def of(self, keys: IntArray, otherwise: IntArray) -> IntArray:
        """Return the version that each key had, or ``otherwise`` where it was not there."""
        at = np.minimum(np.searchsorted(self.keys, keys), max(len(self.keys) - 1, 0))
        known = self.keys[at] == keys if len(self.keys) else np.zeros(len(keys), bool)
        return np.where(known, self.versions[at] if len(self.keys) else 0, otherwise)


NOTHING = VersionMemory(np.zeros(0, np.int64), np.zeros(0, np.int64))
"""What is remembered before the first frame."""


def prepare(scene: Scene, setting: float) -> Updater:
    """Make an updater that remembers the version of every object from frame to frame."""
    memories: dict[str, VersionMemory] = {}

    def versions(view: View) -> View:
        return replace(view, metric=VERSIONS, detail=setting)

    def shown(field: SpeciesField, view: View) -> DisplayedRepresentation:
        mine = versions(view)
        before = memories.get(field.name, NOTHING)
        cut, memories[field.name] = cut_with_hysteresis(field, mine, before)
        return display(field, cut, mine)

    return lambda frame, variant: frame_of(scene, frame, variant, shown, versions)


def cut_with_hysteresis(
    field: SpeciesField, view: View, before: VersionMemory
) -> tuple[Cut, VersionMemory]:
    """Return the cut of a field by versions, and which version each object has now.

    The cut is found ``BAND`` too far; of that, what an object's version leaves out is dropped. An
    object out of view has the version of one that much farther away.
    """
    wide = prune(field, replace(view, detail=view.detail / (1 + BAND)))
    parts = wide.parts
    near = parts.limit / (1 + BAND)
    roots = np.flatnonzero(parts.parent < 0)
    seen = in_view(view, parts.centre[roots], parts.bound[roots])
    apart = np.where(seen, 1.0, 1 / view.offscreen_detail)
    share = apart * distance(view, parts.position[roots]) / near[roots]
    now = versions_at(share)
    keys = object_keys(parts.state.samples.take(parts.object[roots]))
    chosen = np.clip(before.of(keys, now), versions_at(share / (1 + BAND)), now)
    least = np.zeros(int(parts.object.max(initial=0)) + 1)
    least[parts.object[roots]] = np.asarray(OMITTED)[chosen] * near[roots]
    kept = near > least[parts.object]
    rows, taken = np.cumsum(kept) - 1, parts.take(kept)
    taken = replace(taken, parent=np.where(taken.parent < 0, -1, rows[taken.parent]))
    order = np.argsort(keys)
    memory = VersionMemory(keys[order], chosen[order])
    return cut_from_parts(taken, wide.examined_objects, wide.examined_parts), memory


def versions_at(share: FloatArray) -> IntArray:
    """Return the version in use where m·d is this share of the whole's size; 4 is none, (n,)."""
    return np.searchsorted(np.asarray(OMITTED[1:]), share, side="right").astype(np.int64)


def object_keys(samples: CellSamples) -> IntArray:
    """Number objects by cell and index, the same in every frame of a world with an edge, (n,)."""
    half, bits = 1 << 20, 21
    x, y = samples.cell_x + half, samples.cell_y + half
    return np.asarray(((x << bits | y) << bits | samples.index).astype(np.int64))


DISCRETE = Method(
    "discrete",
    "one of four versions of a whole object by its projected size, with hysteresis",
    "Luebke et al. 2003",
    "largest omitted part [px]",
    DETAILS_PX,
    prepare,
)
