"""The habitat of a species: it grows up to a tree line, and where the ground is not too steep.

Each object is kept or left out by a random number of its own. The objects that stay are therefore
again a Poisson field, of density K × share (thinning: Kingman 1993, *Poisson Processes*, §5.1), and
the law's prediction takes that density.

A species: what grows or walks in a field, how densely, and where.

How finely is the ground's height taken under each object: per sole, per print, or per body?

    SOLE       height and slope under each sole: where a foot could be displayed
    FOOTPRINT  height under each footprint: where any part besides the whole could be
    BODY       height under the body alone: where the whole is all that could be

``scenes.rig.foot_placement`` then places bodies and feet. What decides is the distance in plan,
less what a part's origin can be away from where its object stands, against the limit distances of
the parts: a function of the eye and the object alone, and never coarser than the cut. Feet are then
off the ground by less than a quarter of m·d (which a test repeats, on the presets' hills).

Where the objects of a species stand at a time: homes, patrols, and feet on the ground.
"""

import math
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float64

from lod.arrays import Ints, Reals
from lod.camera import Corner
from lod.errors import InputError
from lod.metric import Metric
from lod.view import View
from scenes.field.cells import CellSamples
from scenes.field.prototypes import SpeciesPrototypes
from scenes.figures.patrol import PatrolOrbit, stride_factors
from scenes.ground.relief import Relief
from scenes.rig.foot_placement import Heights, Placements, place_on_ground
from scenes.rig.pose import Instances
from scenes.rig.rigged_prototype import RiggedPrototype
from scenes.sticks.prototype import Prototype

WAVES_M = 16.0
"""Shortest waves of the relief that count in the slope [m]."""


@dataclass(frozen=True)
class Habitat:
    """The parts of the ground on which a species grows.

    relief    the ground
    highest   height above the datum from which on it does not grow [m]; inf: it grows at any height
    thinning  range of heights below ``highest`` over which it thins out [m]
    steepest  tangent of the slope from which on it does not grow; it thins out from half of that
    """

    relief: Relief
    highest: float = math.inf
    thinning: float = 100.0
    steepest: float = math.inf

    def share(self, corner: Corner, xy: np.ndarray) -> Reals:
        """Compute the share of its density at points (n, 2) [m] from the corner, (n,), 0 to 1."""
        height = self.relief.height(corner, xy)
        by_height = np.clip((self.highest - height) / self.thinning, 0.0, 1.0)
        if math.isinf(self.steepest):
            return by_height
        slope = np.hypot(*self.relief.slopes(corner, xy, np.full(len(xy), WAVES_M)).T)
        return by_height * np.clip(2 - 2 * slope / self.steepest, 0.0, 1.0)


@dataclass(frozen=True, eq=False)
class Species:
    """Objects of a kind: equally likely prototypes, spread with density K [1/m²].

    patrol_m  what has a stride walks circles of this radius about its home; 0 = it stays there
    habitat   where it grows, thinning the density; None = everywhere
    metric    which member of the family decides, in place of the view's; None = the view's

    Raises InputError for a density or a radius that cannot be, and where no prototype is given.
    """

    name: str
    prototypes: tuple[Prototype | RiggedPrototype, ...]
    density: float
    patrol_m: float = 0.0
    habitat: Habitat | None = None
    metric: Metric | None = None

    def __post_init__(self) -> None:
        if not (math.isfinite(self.density) and self.density > 0):
            where = f"species.{self.name}.density"
            raise InputError(where, self.density, "objects per m², finite and above 0")
        if not (math.isfinite(self.patrol_m) and self.patrol_m >= 0):
            raise InputError(f"species.{self.name}.patrol", self.patrol_m, "0 m or more, finite")
        if not self.prototypes:
            raise InputError(f"species.{self.name}.prototypes", 0, "at least one prototype")

    def seen_in(self, view: View) -> View:
        """Return the view with this species' own metric, where it has one.

        A view that displays everything, or measures depth along its axis, does so for all species.
        """
        if self.metric is None or view.metric.along_axis or not view.metric.finite:
            return view
        return replace(view, metric=self.metric)


def ground_contact_detail(
    prototypes: SpeciesPrototypes, view: View, xy: Float64[np.ndarray, "n 2"], prototype: Ints
) -> Ints:
    """Choose SOLE, FOOTPRINT or BODY for objects at xy (n, 2) [m] of the frame, (n,).

    prototype  (n,) row of each in ``prototypes``
    """
    nodes = prototypes.traversal_tables
    offset = nodes.extent[:, 0] + np.hypot(nodes.rest[:, 0], nodes.rest[:, 1])
    near = np.hypot(*(xy - view.camera.eye[:2]).T) - offset[prototype]
    limits = _greatest_limits(prototypes, view)[prototype]
    return np.count_nonzero(limits - near[:, None] > 0, axis=1)


def _greatest_limits(prototypes: SpeciesPrototypes, view: View) -> Float64[np.ndarray, "v 2"]:
    """Greatest limit distance of the parts besides the whole, and of the parts of feet, of each
    prototype [m]; where no part is a foot's, that of all parts stands for it.
    """
    tables = prototypes.part_tables
    if view.metric.along_axis:
        return np.full((len(tables.root), 2), np.inf)  # what is far can be of little depth
    limit = np.maximum(*tables.limits(view))
    limit[tables.root] = -np.inf
    parts = np.maximum.reduceat(limit, tables.root)
    soles = np.maximum.reduceat(np.where(prototypes.foot_parts, limit, -np.inf), tables.root)
    return np.column_stack((parts, np.where(soles > -np.inf, soles, parts)))


def patrol_orbits(
    species: Species, prototypes: SpeciesPrototypes, samples: CellSamples
) -> tuple[Ints, Reals, PatrolOrbit]:
    """Draw prototype and stride (a share of that one's) of each object, and how it goes round,
    (n,).

    All three follow from the object's own uniform numbers.
    """
    u = samples.u
    prototype = (u[:, 3] * len(species.prototypes)).astype(np.int64)
    motions = [each.motion for each in prototypes.rigged]
    stride, period = (np.array([getattr(m, k) for m in motions]) for k in ("stride", "period"))
    stride_factor, tempo = stride_factors(u[:, 6])
    orbits = PatrolOrbit(
        species.patrol_m or 1.0,  # what has no patrol has no stride either
        2 * np.pi * u[:, 2],
        u[:, 5] < 0.5,
        u[:, 4],
        stride[prototype] * stride_factor * (species.patrol_m > 0),
        period[prototype] * np.where(stride[prototype] > 0, tempo, 1.0),
    )
    return prototype, stride_factor, orbits


def place_instances(
    species: Species,
    prototypes: SpeciesPrototypes,
    heights: Heights,
    homes: Float64[np.ndarray, "n 2"],
    samples: CellSamples,
    time_s: float,
    view: View | None = None,
) -> Instances:
    """Compute how the objects of a species stand at a time [s].

    heights: of the ground at points of the frame [m]; homes (n, 2) in the frame [m]
    view: feet meet the ground as closely as it could show; None = as closely as they can
    """
    prototype, stride_factor, orbits = patrol_orbits(species, prototypes, samples)
    walkers = orbits.at(time_s)
    xy = homes + walkers.offset
    facing, phase = (walkers.cos, walkers.sin), walkers.phase
    placements = Placements(xy, *facing, prototype, phase, stride_factor)
    if view is not None:
        detail = ground_contact_detail(prototypes, view, xy, prototype)
        placements = placements._replace(contact_detail=detail)
    return place_on_ground(prototypes.pose_tables, heights, placements)
