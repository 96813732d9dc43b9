"""Stochastic simplification: a stable random subset of an object's elements, each made larger.

After R. L. Cook, J. Halstead, M. Planck and D. Ryu, "Stochastic Simplification of Aggregate
Detail", ACM Trans. Graph. 26(3), 2007. The elements of an object are its finest sticks and its
leaves. Of n of them, in an order that is drawn once for each prototype, the first λn are drawn.
λ is chosen so that the mean area of what is drawn does not fall below τ² pixels:
λ = min(1, Ā/(m·d)²), with Ā the mean area of an element. Areas are multiplied so that the object
keeps its own (their §3.2; as elements are of all sizes, by the sum of the areas drawn and not by
their number; a stick by its radii, a leaf about its middle); the last ``FADE`` of them shrink
to nothing, so that none pops (their §3.4); and colours are drawn to their mean by √λ, so
that the contrast of what a pixel averages is kept (their §3.3). Objects of which less than one
element would be drawn are a random subset, too: each is drawn while λn is above a number of its
own.
"""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from bench.methods.method import DETAILS_PX, Method, Updater, frame_of
from lod.arrays import ArrayData, FloatArray, IntArray, Reals, expand, frozen
from lod.pruner import BlendWeights, Cut
from lod.shapes import Sticks, SticksAndTriangles, Triangles, middles, triangle_areas
from lod.view import View, in_view
from lod.viewing import perceptual_limits
from scenes.field.cells import candidates
from scenes.field.part_tables import DisplayedSticks, emit, emit_meshes
from scenes.field.prototypes import SpeciesPrototypes
from scenes.field.species_field import SpeciesField
from scenes.frame.frame_input import DisplayedRepresentation
from scenes.rig.pose import Instances
from scenes.scene import Scene

FADE = 0.2  # the share of the drawn elements that are shrinking
CONTRASTS = 4  # colours are drawn to their mean in so many equal steps


@dataclass(frozen=True, eq=False)
class Elements(ArrayData):
    """The finest sticks and leaves of every prototype, each prototype's in its own random order.

    sticks      of all prototypes, one after the other; ``owner`` is not used
    leaf        (k,) row of the part whose mesh the element is, in place of a stick; −1: none
    first       (v + 1,) where each prototype's begin, and the end
    area        (k,) mean outline area of each element [m²]
    mean_tint   (3,) mean albedo of all of them
    """

    sticks: DisplayedSticks
    leaf: IntArray
    first: IntArray
    area: FloatArray
    mean_tint: FloatArray

    @property
    def counts(self) -> IntArray:
        """Number of elements of each prototype, (v,)."""
        return np.diff(self.first)

    @property
    def total_area(self) -> FloatArray:
        """Area of all elements of each prototype, (v,) [m²]."""
        return np.add.reduceat(self.area, self.first[:-1])


def elements_of(prototypes: SpeciesPrototypes) -> Elements:
    """Collect what shows where everything is displayed, in an order drawn at random."""
    tables, columns, leaves = prototypes.part_tables, [], []
    meshes = tables.meshes
    has_mesh = np.zeros(len(tables.part_count), bool) if meshes is None else meshes.count > 0
    ends = [*tables.root.tolist(), len(tables.part_count)]
    for number in range(len(tables.hierarchies)):
        rows = np.arange(ends[number], ends[number + 1])
        finest = tables.part_count[rows] == 0
        weights = BlendWeights((~finest).astype(np.float64), finest.astype(np.float64))
        mine, own = tables.sticks_of(rows, weights), rows[finest & has_mesh[rows]]
        blank = np.zeros(len(own), np.int64)
        with_blanks = [np.append(each, blank.astype(each.dtype)) for each in mine]
        leaf = np.append(np.full(len(mine.stick), -1), own)
        order = np.random.Generator(np.random.Philox(number)).permutation(len(leaf))
        columns.append([np.full(len(leaf), number), *(each[order] for each in with_blanks[1:])])
        leaves.append(leaf[order])
    first = np.cumsum([0, *map(len, leaves)])
    sticks = DisplayedSticks(*map(np.concatenate, zip(*columns, strict=True)))
    leaf = np.concatenate(leaves)
    area, tint = _areas(prototypes, sticks), np.asarray(tables.tints)[sticks.tint]
    if meshes is not None:
        shown = leaf[leaf >= 0]
        sheets = triangle_areas(meshes.vertices, meshes.faces) / 2  # seen from either side
        area[leaf >= 0] = np.bincount(meshes.owner, sheets, len(meshes.count))[shown]
        tint[leaf >= 0] = meshes.colours[meshes.first_vertex[shown]]
    return Elements(sticks, leaf, first, area, tint.mean(axis=0))


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
    """Order the elements of every prototype once, and make an updater that draws some of them."""
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
    area, step = left * larger[owner], np.rint(np.sqrt(share)[owner] * CONTRASTS).astype(np.int64)
    zeros = np.zeros(n, np.int64)
    cut = Cut(np.arange(n), zeros, zeros, zeros - 1, examined, len(row), _no_parts)
    tables = field.prototypes.pose_tables, field.prototypes.part_tables
    plain = mine.leaf[row] < 0
    own = row[plain]
    sticks = mine.sticks.stick[own], mine.sticks.share[own] * area[plain], mine.sticks.tint[own]
    posed = emit(*tables, instances, np.arange(n), DisplayedSticks(owner[plain], *sticks))
    tints = toward_mean(np.asarray(posed.tints), mine.mean_tint)
    muted = replace(posed, tint=posed.tint + step[plain] * len(posed.tints), tints=tints)
    meshes = field.prototypes.part_tables.meshes
    if meshes is None:
        return DisplayedRepresentation(field.name, cut, muted)
    leaf, own = mine.leaf[row[~plain]], owner[~plain]
    leaves = emit_meshes(*tables, instances, own, leaf, np.ones(len(leaf)))
    corners = np.diff(meshes.first_vertex)[leaf]
    leaves = _larger_and_muted(
        leaves, corners, area[~plain], step[~plain] / CONTRASTS, mine.mean_tint
    )
    shape = SticksAndTriangles(muted, replace(leaves, owner=own[leaves.owner]))
    return DisplayedRepresentation(field.name, cut, shape)


def _larger_and_muted(
    leaves: Triangles, corners: np.ndarray, share: Reals, contrast: Reals, mean: np.ndarray
) -> Triangles:
    """Give each leaf, of so many corners, such a share of its area and of its contrast, (n,) each.

    Areas change about the leaf's middle, and colours toward their mean (3,).
    """
    middle = middles(np.append(0, np.cumsum(corners)), leaves.vertices)
    grown = np.repeat(np.sqrt(share), corners)[:, None]
    vertices = middle + grown * (leaves.vertices - middle)
    colours = mean + np.repeat(contrast, corners)[:, None] * (leaves.colours - mean)
    return replace(leaves, vertices=vertices, colours=colours.astype(np.float32))


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
    "a stable random subset of the finest sticks and leaves, made larger and muted",
    "Cook et al. 2007",
    "side of the mean drawn element [px]",
    DETAILS_PX,
    prepare,
)
