"""A prototype: one whole object as a part hierarchy with the sticks of both appearances (§2.4).

The one rule by which priority P, range R, bound B and separation follow from the geometry, for a
rigid object (one that is only placed, turned about the vertical and scaled):

    separation  distance from a part's origin to its whole's origin, as it stands
    extent      farthest that a part's own sticks, of either appearance and radius included, and
        the corners of its mesh are from a point
    P           √ of the largest area over directions that the leaf appearance covers, as it looks
        from each (``largest_area_in_view``), or the part's mesh (``largest_flat_areas``)
    R           the greater of the extent of the part and the extents of its direct parts, from its
        origin
    B           the greater of the extent of the part and, over its parts, separation + B of the
        part

An only part that is no smaller than its whole is one with it (``lod.hierarchy``): its
origin is that of the whole, and the two share the greater P and R.

Inherent contrast of parts: luminance is in units of that of white horizontal ground in sun and sky.
A part has the mean albedo of its leaf appearance, under any irradiance from SHADED to LIT. Its
background is the ground, from the darkest in shade to the driest in the sun, or the sky at the
horizon, which is also the airlight, from HORIZONS' least to its greatest. The greatest contrast of
all these counts, so that nothing visible is dropped. It is seldom below 1/2, because the sky may be
behind anything: objects get the classes 1, 2 and 5. A whole has at least the class of its parts,
because they are in the cut only together with it.

Contrast to the whole: under one light, the modulation of a part's mean albedo and that of the leaf
appearance that is shown in its place. Where they match it is the least class, for the outlines.

What is shown of one object: sticks, and the triangles of parts that are meshes.

A part that owns parts has sticks of its own, which it shows as an inner node, or none; a part that
owns none has what it always looks like: sticks, or a mesh, which small balls stand for where parts
are gathered into fewer and larger ones.
"""

from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import product

import numpy as np
from jaxtyping import Float64, Int64

from lod.arrays import ArrayData, Flags, FloatArray, Ints, Points, Reals, freeze
from lod.errors import InputError
from lod.eye import CONTRAST_CLASSES, contrast_class, inherent_contrast
from lod.hierarchy import Hierarchy, max_over_tied, representative
from lod.shapes import MeshTable, StickTable
from scenes.sticks.areas import (
    ViewDependence,
    largest_area_in_view,
    largest_flat_areas,
    mean_outline_areas,
    with_area_share,
)

SHADED, LIT = 0.1, 2.3
"""Irradiance of the darkest and the brightest face; that of horizontal ground is 1. Sky alone is
0.16 of sun and sky together at turbidity 2, and an upright face sees half of it; a face square to
a sun of 20° gets 2.3 (this project's own measurement of Mitsuba's ``sunsky``)."""

HORIZONS = (0.25, 2.0)
"""Luminance of the sky at the horizon, which is the airlight: from its least over all azimuths,
turbidities and suns of 20° and more, 0.24, to that about a sun of 10° (measured as above)."""

GROUND = (0.08, 0.2)
"""Albedo of the ground, from lush grass in a hollow to dry grass on a ridge.

The colours are in scenes.ground.shading.
"""

LUMINANCE = (0.2126, 0.7152, 0.0722)  # weights of linear Rec.709 red, green and blue (ITU-R BT.709)


def greatest_contrast(albedo: Reals) -> Reals:
    """Compute the greatest inherent contrast C₀ of parts of these mean albedos (n,), (n,)."""
    found = np.zeros_like(albedo)
    for light, horizon in product((SHADED, LIT), HORIZONS):
        behind = (SHADED * GROUND[0], LIT * GROUND[1], horizon)
        for luminance in behind:
            against = np.full_like(albedo, luminance)
            found = np.maximum(found, inherent_contrast(light * albedo, against, horizon))
    return found


GROUND_CONTRAST = int(contrast_class(greatest_contrast(np.array(GROUND))).max())
"""Contrast class of the ground: a bump in the sun against shaded ground, or against the sky."""


def part_contrasts(
    parent: Ints, leaf: StickTable, tints: Float64[np.ndarray, "t 3"]
) -> tuple[Ints, Reals]:
    """Compute ``contrast`` and ``contrast_to_whole`` of a Hierarchy from leaf appearances, (n,).

    ``parent`` (n,) is the row of each part's whole, as there; ``tints`` are linear Rec.709.
    """
    weight = mean_outline_areas(leaf)
    shine = weight * (tints @ np.array(LUMINANCE))[leaf.tint]
    parts = len(parent)
    shone, covered = (np.bincount(leaf.owner, column, parts) for column in (shine, weight))
    albedo = shone / covered
    found = contrast_class(greatest_contrast(albedo))
    to_whole = np.maximum(inherent_contrast(albedo, albedo[parent]), CONTRAST_CLASSES[0])
    to_whole[parent < 0] = 1.0  # in place of the whole object nothing is shown
    for row in range(parts - 1, 0, -1):
        for each in (found, to_whole):
            each[parent[row]] = max(each[parent[row]], each[row])
    return found, to_whole


@dataclass(frozen=True, eq=False)
class Prototype:
    """One whole object, in its own frame (see StickTable).

    inner  what a part looks like while some of its own parts are displayed; may be nothing
    leaf   its leaf appearance; never nothing. A part that owns none is always a leaf
    tints  (t, 3) linear Rec.709 albedo, 0 to 1
    view_dependence  tables of the sticks of ``leaf`` that look otherwise from elsewhere
    meshes of parts that own none, which they show in place of ``leaf``; None where none has one
    """

    name: str
    hierarchy: Hierarchy
    inner: StickTable
    leaf: StickTable
    tints: np.ndarray
    view_dependence: ViewDependence = field(default_factory=ViewDependence)
    meshes: MeshTable | None = None

    def __post_init__(self) -> None:
        freeze(self, tints=np.float64)
        _check(self)

    def scaled(self, factor: float) -> "Prototype":
        """Return the object made ``factor`` times as large."""
        hierarchy = self.hierarchy.scaled(factor)  # refuses a bad factor
        inner, leaf = self.inner.scaled(factor), self.leaf.scaled(factor)
        meshes = None if self.meshes is None else self.meshes.scaled(factor)
        return replace(self, hierarchy=hierarchy, inner=inner, leaf=leaf, meshes=meshes)

    @property
    def has_mesh(self) -> Flags:
        """Tell which parts show a mesh, (n,)."""
        if self.meshes is None:
            return np.zeros(len(self.hierarchy), np.bool_)
        found: Flags = self.meshes.count > 0
        return found


@dataclass(frozen=True, eq=False)
class PartPlaces:
    """Where the parts of an object stand in its hierarchy and in its frame, wholes before parts.

    parent (n,)     row of the part that owns each part, −1 for the whole object
    level (n,)      level of detail
    origin (n, 3)   origin in the object's frame [m]
    overlap (n,)    as in Hierarchy; by default 0
    """

    parent: np.ndarray
    level: np.ndarray
    origin: np.ndarray
    overlap: np.ndarray | None = None

    def __len__(self) -> int:
        return len(self.parent)


def assemble_prototype(
    name: str,
    places: PartPlaces,
    inner: StickTable,
    leaf: StickTable,
    tints: Float64[np.ndarray, "t 3"],
    view_dependence: ViewDependence | None = None,
    meshes: MeshTable | None = None,
) -> Prototype:
    """Make a prototype from the places, sticks and meshes of its parts, by the rule above."""
    sizes = {"inner": len(inner.count), "leaf": len(leaf.count), "origin": len(places.origin)}
    for key, size in sizes.items():
        if size != len(places):
            raise InputError(f"{name}.{key}", size, f"one entry for each of {len(places)} parts")
    view_dependence = view_dependence or ViewDependence()
    area = largest_area_in_view(leaf, view_dependence)
    if meshes is not None:
        area = np.maximum(area, largest_flat_areas(meshes))
    P = np.sqrt(area)
    tied = representative(places.parent, P)
    parent, origin = places.parent, places.origin[tied]
    part = np.flatnonzero(parent >= 0)
    owner = parent[part]
    separation = np.zeros(len(parent))
    separation[part] = _distance(origin[part], origin[owner])
    own = _extent((inner, leaf), meshes, np.arange(len(parent)), origin)
    R = own.copy()
    np.maximum.at(R, owner, _extent((inner, leaf), meshes, part, origin[owner]))
    B = bounds_of_all_below(parent, own, separation)
    lengths = max_over_tied(P, tied), max_over_tied(R, tied), B, separation
    hierarchy = Hierarchy(parent, places.level, origin, *lengths)
    if places.overlap is not None:
        hierarchy = replace(hierarchy, overlap=places.overlap)
    # Prototype refuses what is bad, of which no contrast could be computed.
    prototype = Prototype(name, hierarchy, inner, leaf, tints, view_dependence, meshes)
    found = (each[tied] for each in part_contrasts(parent, leaf, tints))
    contrasts = dict(zip(("contrast", "contrast_to_whole"), found, strict=True))
    return replace(prototype, hierarchy=replace(hierarchy, **contrasts))


def bounds_of_all_below(parent: Ints, extent: Reals, separation: Reals) -> Reals:
    """Compute the bound B of every part from its own extent and that of all below it, (n,) [m]."""
    B = extent.copy()
    for row in range(len(parent) - 1, 0, -1):
        B[parent[row]] = max(B[parent[row]], separation[row] + B[row])
    return B


def box_middles(
    parent: Ints, owner: Int64[np.ndarray, " k"], points: Float64[np.ndarray, "k 3"]
) -> Points:
    """Find the middle of the box about the points of each part and of all below it, (n, 3) [m].

    owner (k,) part of each point (k, 3); parent (n,) as in Hierarchy
    """
    low, high = np.full((len(parent), 3), np.inf), np.full((len(parent), 3), -np.inf)
    np.minimum.at(low, owner, points)
    np.maximum.at(high, owner, points)
    for row in range(len(parent) - 1, 0, -1):
        above = parent[row]
        low[above] = np.minimum(low[above], low[row])
        high[above] = np.maximum(high[above], high[row])
    return (low + high) / 2


def _extent(
    tables: tuple[StickTable, ...], meshes: MeshTable | None, rows: Ints, centre: Points
) -> Reals:
    """Farthest that the sticks and the mesh of each part in ``rows`` are from its point in
    ``centre``, (n,) [m].

    The farthest point of a convex hull of two spheres lies on one of the spheres.
    """
    n = len(tables[0].count)
    seen_from, farthest = np.full((n, 3), np.nan), np.zeros(n)
    seen_from[rows] = centre
    for table in tables:
        owner, (place, radius) = np.tile(table.owner, 2), table.spheres
        np.fmax.at(farthest, owner, _distance(place, seen_from[owner]) + radius)
    if meshes is not None:
        owner = meshes.vertex_owner
        np.fmax.at(farthest, owner, _distance(meshes.vertices, seen_from[owner]))
    return farthest[rows]


def _distance(a: Points, b: Points) -> Reals:
    return np.sqrt(((a - b) ** 2).sum(axis=1))


def _check(prototype: Prototype) -> None:
    name, h, tints = prototype.name, prototype.hierarchy, prototype.tints
    n, views, sticks = len(h), prototype.view_dependence, len(prototype.leaf)
    rows = views.rows(sticks)
    if len(rows) != sticks or rows.max(initial=-1) >= len(views.area_share):
        rule = f"a row or -1 for each of {sticks} sticks"
        raise InputError(f"{name}.view_dependence", len(rows), rule)
    if tints.ndim != 2 or tints.shape[1:] != (3,):
        raise InputError(f"{name}.tints", tints.shape, "one row of three for each tint")
    if not (np.isfinite(tints).all() and np.all((tints >= 0) & (tints <= 1))):
        raise InputError(f"{name}.tints", "an albedo outside 0 to 1", "linear Rec.709, 0 to 1")
    for key, table in (("inner", prototype.inner), ("leaf", prototype.leaf)):
        if len(table.first) != n + 1:
            rule = f"one entry for each of {n} parts"
            raise InputError(f"{name}.{key}", len(table.first) - 1, rule)
        if len(table) and table.tint.max() >= len(tints):
            raise InputError(f"{name}.{key}.tint", int(table.tint.max()), f"0 to {len(tints) - 1}")
    empty = np.flatnonzero(prototype.leaf.count == 0)
    if len(empty):
        rule = "a leaf appearance is never empty"
        raise InputError(f"{name}.leaf", f"nothing for part {empty[0]}", rule)
    tables = prototype.inner, prototype.leaf
    extent = _extent(tables, prototype.meshes, np.arange(n), h.position)
    outside = np.flatnonzero(extent > h.R * (1 + 1e-9))
    if len(outside):
        row = int(outside[0])
        rule = f"what it looks like reaches {extent[row]:.6g} m"
        raise InputError(f"{name}.R[{row}]", float(h.R[row]), rule)


@dataclass(frozen=True, eq=False)
class Shapes(ArrayData):
    """Sticks of one part, and f flat triangles after them, seen from both sides.

    corners (f, 3, 3)  of each triangle, in the frame of the sticks [m]
    colours (f, 3)     linear Rec.709 albedo of each
    """

    sticks: StickTable
    corners: FloatArray
    colours: FloatArray

    def __len__(self) -> int:
        return len(self.sticks) + len(self.corners)

    @staticmethod
    def of(sticks: StickTable, meshes: MeshTable | None = None) -> "Shapes":
        """Gather sticks, of whichever parts, and the triangles of meshes in the same frame."""
        one = StickTable.as_one_part([sticks])
        if meshes is None:
            return Shapes(one, np.zeros((0, 3, 3)), np.zeros((0, 3)))
        return Shapes(one, meshes.vertices[meshes.faces], meshes.face_colours)

    def with_sticks(self, *tables: StickTable) -> "Shapes":
        """Return the same with the sticks of these tables after its own."""
        table = StickTable.as_one_part([self.sticks, *tables])
        return Shapes(table, self.corners, self.colours)

    def merged(self, other: "Shapes") -> "Shapes":
        """Return these shapes and others together."""
        flat = np.concatenate((self.corners, other.corners))
        colours = np.concatenate((self.colours, other.colours))
        return Shapes(self.with_sticks(other.sticks).sticks, flat, colours)

    def albedos(self, palette: Float64[np.ndarray, "t 3"]) -> Points:
        """Return the albedo of every stick, from a palette, and of every triangle, (k + f, 3)."""
        return np.concatenate((palette[self.sticks.tint], self.colours))

    @cached_property
    def box(self) -> tuple[np.ndarray, np.ndarray]:
        """Return the lowest and the highest corner of the box about all of it, (3,) each [m]."""
        points, reach = self.spheres
        reach = reach[:, None]
        return (points - reach).min(axis=0), (points + reach).max(axis=0)

    @property
    def spheres(self) -> tuple[Points, np.ndarray]:
        """Return centres (n, 3) and radii (n,) of spheres whose hulls hold all of it [m]."""
        (centre, radius), flat = self.sticks.spheres, self.corners.reshape(-1, 3)
        return np.concatenate((centre, flat)), np.append(radius, np.zeros(len(flat)))


@dataclass(frozen=True, eq=False)
class PartSticks:
    """Everything that an object of n parts is made of.

    parent (n,)  row of the part that owns each part, −1 for the whole object; wholes before parts
    level (n,)   level of detail, 0 for the whole object and more for the parts of a part
    own          sticks of each part alone, and of a mesh the balls that stand for its surface
    palette (t, 3)  linear Rec.709 albedo of each tint
    meshes       of parts that own none, in the same frame; None where none has one
    chosen       leaf appearances of the parts that own parts, where they are chosen and only their
                 thickness and tint are fitted; None where all is
    """

    parent: Ints
    level: Ints
    own: StickTable
    palette: Float64[np.ndarray, "t 3"]
    meshes: MeshTable | None = None
    chosen: StickTable | None = None

    @cached_property
    def owns(self) -> Flags:
        """Tell whether each part owns parts, (n,)."""
        found = np.zeros(len(self.parent), np.bool_)
        found[self.parent[self.parent >= 0]] = True
        return found

    @property
    def finest(self) -> int:
        """Return the finest level of detail."""
        return int(self.level.max())

    def inner_rows(self, level: int) -> Ints:
        """Find the parts of a level that own parts, (m,)."""
        return np.flatnonzero((self.level == level) & self.owns)

    @cached_property
    def shows_sticks(self) -> Flags:
        """Tell which sticks of ``own`` are seen, for no mesh is in their place, (k,)."""
        if self.meshes is None:
            return np.ones(len(self.own), np.bool_)
        found: Flags = (self.meshes.count == 0)[self.own.owner]
        return found

    def shown(self, parts: Flags, share: float = 1.0) -> Shapes:
        """Return what the flagged parts (n,) themselves look like, with a share of their area."""
        sticks = self.own.take(parts[self.own.owner] & self.shows_sticks)
        sticks = sticks if share == 1.0 else with_area_share(sticks, share)
        meshes = None if self.meshes is None else self.meshes.only(parts).with_area_share(share)
        return Shapes.of(sticks, meshes)

    def above(self, level: int) -> Flags:
        """Tell which parts show whatever becomes of the parts that inner parts of a level own.

        They are those above the level, and those down to it that own nothing, (n,).
        """
        return (self.level < level) | ((self.level == level) & ~self.owns)

    def bearer(self, level: int) -> Ints:
        """Find which of ``inner_rows`` each stick is part of, itself or by its parts, (k,).

        It is −1 for sticks of none.
        """
        whole = np.arange(len(self.parent))
        for _ in range(self.finest - level):
            whole = np.where(self.level[whole] > level, self.parent[whole], whole)
        rows = self.inner_rows(level)
        number = np.full(len(self.parent), -1)
        number[rows] = np.arange(len(rows))
        found: Ints = number[whole[self.own.owner]]
        return found
