"""Stochastic simplification: a stable random subset of an object's sticks, each made larger.

After R. L. Cook, J. Halstead, M. Planck and D. Ryu, "Stochastic Simplification of Aggregate
Detail", ACM Trans. Graph. 26(3), 2007. Of an object's n finest sticks, in an order that is drawn
once for each prototype, the first λn are drawn. λ is chosen so that the mean area of what is drawn
does not fall below τ² pixels: λ = min(1, Ā/(m·d)²), with Ā the mean area of a stick. Areas are
multiplied so that the object keeps its own (their §3.2; as sticks are of all sizes, by the sum of
the areas drawn and not by their number); the last ``FADE`` of the drawn sticks
shrink to nothing, so that none pops (their §3.4); and colours are drawn to their mean by √λ, so
that the contrast of what a pixel averages is kept (their §3.3). Objects of which less than one
stick would be drawn are a random subset, too: each is drawn while λn is above a number of its own.
"""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from bench.methods.method import DETAILS_PX, Method, Updater, frame_of
from lod.arrays import ArrayData, FloatArray, IntArray, expand, frozen
from lod.pruner import BlendWeights, Cut
from lod.shapes import Sticks
from lod.view import View, in_view
from lod.viewing import perceptual_limits
from scenes.field.cells import candidates
from scenes.field.part_tables import DisplayedSticks, emit
from scenes.field.prototypes import SpeciesPrototypes
from scenes.field.species_field import SpeciesField
from scenes.frame.frame_input import DisplayedRepresentation
from scenes.rig.pose import Instances
from scenes.scene import Scene

FADE = 0.2  # the share of the drawn sticks that are shrinking
CONTRASTS = 4  # colours are drawn to their mean in so many equal steps


@dataclass(frozen=True, eq=False)
class Elements(ArrayData):
    """The finest sticks of every prototype, each prototype's in its own random order.

    sticks      of all prototypes, one after the other; ``owner`` is not used
    first       (v + 1,) where each prototype's begin, and the end
    area        (k,) mean outline area of each stick [m²]
    mean_tint   (3,) mean albedo of all of them
    """

    sticks: DisplayedSticks
    first: IntArray
    area: FloatArray
    mean_tint: FloatArray

    @property
    def counts(self) -> IntArray:
        """Number of sticks of each prototype, (v,)."""
        return np.diff(self.first)

    @property
    def total_area(self) -> FloatArray:
        """Area of all sticks of each prototype, (v,) [m²]."""
        return np.add.reduceat(self.area, self.first[:-1])


def elements_of(prototypes: SpeciesPrototypes) -> Elements:
    """Collect the sticks that show where everything is displayed, in an order drawn at random."""
    tables, found = prototypes.part_tables, []
    ends = [*tables.root.tolist(), len(tables.part_count)]
    for number in range(len(tables.hierarchies)):
        rows = np.arange(ends[number], ends[number + 1])
        finest = tables.part_count[rows] == 0
        weights = BlendWeights((~finest).astype(np.float64), finest.astype(np.float64))
        mine = tables.sticks_of(rows, weights)
        order = np.random.Generator(np.random.Philox(number)).permutation(len(mine.stick))
        found.append(DisplayedSticks(*(column[order] for column in mine)))
    counts = [len(each.stick) for each in found]
    columns = (np.concatenate(column) for column in zip(*found, strict=True))
    joined = DisplayedSticks(*columns)._replace(owner=np.repeat(np.arange(len(counts)), counts))
    mean_tint = np.asarray(tables.tints)[joined.tint].mean(axis=0)
    return Elements(joined, np.cumsum([0, *counts]), _areas(prototypes, joined), mean_tint)


def _areas(prototypes: SpeciesPrototypes, sticks: DisplayedSticks) -> FloatArray:
    """Compute the mean outline area of each stick, posed once (lod.pruner) [m²]."""
    v = len(prototypes.part_tables.hierarchies)
    kinds = frozen(np.arange(v), np.int64)
    zeros, ones = frozen(np.zeros(v), np.float64), frozen(np.ones(v), np.float64)
    legs = frozen(np.zeros((v, prototypes.pose_tables.max_legs, 6)), np.float64)
    one_each = Instances(frozen(np.zeros((v, 3)), np.float64), ones, zeros, kinds, zeros, legs)
    posed = emit(prototypes.pose_tables, prototypes.part_tables, one_each, kinds, sticks)
    return outline_areas(posed)


def outline_areas(sticks: Sticks) -> FloatArray:
    """Compute the mean outline area of sticks: a quarter of their surface (Cauchy), (n,) [m²]."""
    length = np.linalg.norm(sticks.end - sticks.start, axis=1)
    caps = (sticks.start_radius**2 + sticks.end_radius**2) / 2
    return np.pi * (caps + (sticks.start_radius + sticks.end_radius) * length / 4)


def drawn_shares(count: IntArray, share: FloatArray) -> tuple[IntArray, IntArray, FloatArray]:
    """Choose what is drawn of objects with ``count`` sticks where a share λ of them is, (n,) each.

    Gives, for each drawn stick, its object, its number in the object's order, and the share of its
    own area that is left where the last ones shrink.
    """
    drawn = np.maximum(share * count, 1.0)
    whole = share >= 1.0
    owner, number = expand(np.where(whole, count, np.ceil(drawn)).astype(np.int64))
    fading = np.clip((drawn[owner] - number) / np.maximum(FADE * drawn[owner], 1.0), 0.0, 1.0)
    return owner, number, np.where(whole[owner], 1.0, fading)


def kept_objects(expected: FloatArray, chance: FloatArray) -> FloatArray:
    """Return the area that each object has ÷ its own, where q sticks of it are expected, (n,).

    One that draws the chance u has clip((q − u)/FADE, 0, 1) ÷ the mean of that over 0 ≤ u ≤ 1, so
    that many together keep their area while they shrink one by one.
    """
    q, over = expected, 1 + FADE - expected
    shown = np.clip((q - chance) / FADE, 0.0, 1.0)
    mean = np.where(q < FADE, q**2 / (2 * FADE), q - FADE / 2)
    mean = np.where(q > 1, 1 - np.maximum(over, 0.0) ** 2 / (2 * FADE), mean)
    return np.asarray(shown / np.maximum(mean, 1e-300))


def _no_parts() -> Any:
    raise NotImplementedError("sticks drawn at random belong to whole objects alone")


def toward_mean(tints: np.ndarray, mean: np.ndarray) -> np.ndarray:
    """Return the tints at every step from their mean (step 0) to themselves, one after another."""
    steps = np.arange(CONTRASTS + 1)[:, None, None] / CONTRASTS
    return (mean + steps * (tints - mean)).reshape(-1, 3)


def prepare(scene: Scene, setting: float) -> Updater:
    """Order the sticks of every prototype once, and make an updater that draws some of them."""
    elements = {field.name: elements_of(field.prototypes) for field in scene.world.fields}

    def shown(field: SpeciesField, view: View) -> DisplayedRepresentation:
        return _shown(field, elements[field.name], view, setting)

    return lambda frame, variant: frame_of(scene, frame, variant, shown)


def _shown(field: SpeciesField, mine: Elements, view: View, detail: float) -> Any:
    samples, examined = candidates(field.cells, view, field.search_bounds(view))
    grown = field.in_habitat(view.camera.corner, samples)
    placed = field.instances_in_view(grown, view)
    wholes = field.prototypes.wholes(placed, view)
    seen = in_view(view, wholes.centre, wholes.bound)
    away = np.linalg.norm(placed.instances.origin - view.camera.eye, axis=1)
    m = detail * view.theta / np.where(seen, 1.0, view.offscreen_detail)
    kind = placed.instances.prototype
    share = mine.total_area[kind] / mine.counts[kind] / np.maximum(m * away, 1e-9) ** 2
    shown = kept_objects(share * mine.counts[kind], np.mod(grown.u[:, 2] + grown.u[:, 7], 1.0))
    shown[away > _farthest_seen(field, view)[kind]] = 0.0
    kept = np.flatnonzero(shown)
    instances = Instances(*(frozen(each[kept], each.dtype) for each in placed.instances))
    kind, share = kind[kept], np.minimum(share[kept], 1.0)
    owner, number, left = drawn_shares(mine.counts[kind], share)
    n, row = len(kind), mine.first[kind][owner] + number
    total = shown[kept] * mine.total_area[kind]
    larger = total / np.bincount(owner, left * mine.area[row], n)
    area = mine.sticks.share[row] * left * larger[owner]
    chosen = DisplayedSticks(owner, mine.sticks.stick[row], area, mine.sticks.tint[row])
    tables = field.prototypes
    posed = emit(tables.pose_tables, tables.part_tables, instances, np.arange(n), chosen)
    zeros = np.zeros(n, np.int64)
    cut = Cut(np.arange(n), zeros, zeros, zeros - 1, examined, len(row), _no_parts)
    step = np.rint(np.sqrt(share)[owner] * CONTRASTS).astype(np.int64)
    tints = toward_mean(np.asarray(posed.tints), mine.mean_tint)
    muted = replace(posed, tint=posed.tint + step * len(posed.tints), tints=tints)
    return DisplayedRepresentation(field.name, cut, muted)


def _farthest_seen(field: SpeciesField, view: View) -> FloatArray:
    """Find the distance from which on air hides every part of each prototype, (v,) [m]."""
    trees = field.prototypes.part_tables.hierarchies
    if view.conditions is None:
        return np.full(len(trees), np.inf)
    seen = [
        perceptual_limits(view.conditions, np.full(len(tree), 1e12), tree.contrast, view.m).max()
        for tree in trees
    ]
    return np.array(seen)


STOCHASTIC = Method(
    "stochastic",
    "a stable random subset of the finest sticks, made larger and muted",
    "Cook et al. 2007",
    "side of the mean drawn stick [px]",
    DETAILS_PX,
    prepare,
)
