"""The endless field: one species spread over the plane, handed to the pruner as parts (§4.1).

No list of objects exists anywhere. A frame visits only the cells from which a part could pass.
The few objects that a picture is about are placed where a preset says, one by one.

Where walkers that circle their homes are at a time: in closed form, so any frame stands alone.

A walker goes round a circle about its home at an even speed, and the ground it covers drives its
gait: one cycle of the motion a stride. Where homes are a Poisson process and starts and
directions are drawn for each home alone, the walkers are at any time a Poisson process of the same
density (displacement theorem: Kingman, "Poisson Processes", 1993, §5.5), so the law's predictions
hold for them unchanged.

The motion was made for a straight path. On a circle of radius ρ a print that is x ahead and y
aside of the body moves under the foot by about (x²/2 + x·y)/ρ while it stands; which is little
where a circle is many strides round.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import NamedTuple

import numpy as np
from jaxtyping import Float64

from lod.arrays import ArrayData, Flags, FloatArray, Ints, Reals
from lod.camera import GRID_M, Corner
from lod.errors import InputError
from lod.metric import Metric
from lod.pruner import BlendWeights, Cut, Parts, displayed
from lod.shapes import Appearance, Instanced
from lod.view import View, distance, in_view
from scenes.appearance.tone import Illumination
from scenes.field.cells import (
    CellSamples,
    PoissonCells,
    SearchBounds,
    SquareCells,
    candidates,
    cells_in_reach,
    search_bounds,
)
from scenes.field.prototypes import (
    InstancesInView,
    SpeciesPrototypes,
    instances_in_view,
    shutter_times,
    species_prototypes,
)
from scenes.ground.relief import Ground, Relief
from scenes.rig.foot_placement import Placements, place_on_ground
from scenes.rig.pose import Instances
from scenes.rig.rigged_prototype import RiggedPrototype
from scenes.sticks.prototype import Prototype

MIN_STRIDE_FACTOR = 0.82
"""Stride of the walker with the shortest steps, as a share of its prototype's."""


@dataclass(frozen=True, eq=False)
class Walkers(ArrayData):
    """Walkers at one time: offset (n, 2) from their homes [m], cos and sin (n,) of their headings,
    phase (n,) of their motion [cycles].
    """

    offset: FloatArray
    cos: FloatArray
    sin: FloatArray
    phase: FloatArray


class PatrolOrbit(NamedTuple):
    """Circles about their homes on which n walkers patrol, (n,) each.

    radius     of the circle [m]; one for all may be given
    heading    at time 0, anticlockwise from x [rad]; clockwise: which way round
    phase      at time 0 [cycles]
    stride, period  of each one's motion [m, s]; those without a stride stay at home, facing
        ``heading``
    """

    radius: Reals | float
    heading: Reals
    clockwise: np.ndarray
    phase: Reals
    stride: Reals
    period: Reals

    def take(self, rows: np.ndarray) -> "PatrolOrbit":
        """Return the orbits at ``rows``."""
        return PatrolOrbit(self.radius, *(each[rows] for each in self[1:]))

    def at(self, time_s: float | Reals) -> Walkers:
        """Return the walkers at a time, or each at a time of its own, (n,) [s]; any may be below 0.

        Raises InputError for a time that is not finite, or a radius that is not above 0.
        """
        radius = np.broadcast_to(np.asarray(self.radius, np.float64), self.heading.shape)
        if not (np.isfinite(time_s).all() and np.isfinite(radius).all() and np.all(radius > 0)):
            arrived = float(np.max(time_s, initial=0.0)), float(radius.min(initial=math.inf))
            raise InputError("patrol", arrived, "a finite time, a radius above 0 m")
        facing: Reals = self.heading
        away: Reals | float = 0.0
        if (walks := self.stride > 0).any():
            rotations = np.where(self.clockwise, -1.0, 1.0)
            # Whole rounds and whole cycles drop out before they cost any digits.
            rounds = np.fmod(time_s * (self.stride / self.period) / (2 * np.pi * radius), 1.0)
            facing = self.heading + rotations * 2 * np.pi * rounds
            away = np.where(walks, radius, 0.0) * rotations
        cos, sin = np.cos(facing), np.sin(facing)
        offset = np.stack((away * sin, -away * cos), axis=1)
        phase = np.mod(self.phase + np.fmod(time_s / self.period, 1.0), 1.0)
        return Walkers(offset, cos, sin, phase)


def stride_factors(u: Reals) -> tuple[Reals, Reals]:
    """Return each one's stride and period as shares of its prototype's, from uniform numbers (n,).

    By the rule that gaits are made by (``gait``): stride goes as Froude^0.3 and speed as its root,
    so that one whose stride is s times as long takes s^(−2/3) times as long over it.
    """
    stride = MIN_STRIDE_FACTOR + (1.0 - MIN_STRIDE_FACTOR) * u
    return stride, stride ** (-2 / 3)


@dataclass(frozen=True)
class Habitat:
    """Where a species grows: up to a tree line, and where the ground is not too steep.

    Each object is kept or left out by a random number of its own. The objects that stay are
    therefore again a Poisson field, of density K × share (thinning: Kingman 1993, *Poisson
    Processes*, §5.1), and the law's prediction takes that density.

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
        by_height = np.ones(len(xy))
        if not math.isinf(self.highest):
            height = self.relief.height(corner, xy)
            by_height = np.clip((self.highest - height) / self.thinning, 0.0, 1.0)
        if math.isinf(self.steepest):
            return by_height
        shortest_waves_m = np.full(len(xy), 16.0)
        slope = np.hypot(*self.relief.slopes(corner, xy, shortest_waves_m).T)
        return by_height * np.clip(2 - 2 * slope / self.steepest, 0.0, 1.0)


@dataclass(frozen=True, eq=False)
class Species:
    """Objects of a kind: equally likely prototypes, spread with density K [1/m²].

    patrol_m  what has a stride walks circles of this radius about its home; 0 = it stays there
    habitat   where it grows, thinning the density; None = everywhere
    metric    which member of the family decides, in place of the view's; None = the view's
    pattern   function from seed, name and density to the process by which it is spread
    """

    name: str
    prototypes: tuple[Prototype | RiggedPrototype, ...]
    density: float
    patrol_m: float = 0.0
    habitat: Habitat | None = None
    metric: Metric | None = None
    pattern: Callable[[int, str, float], SquareCells] = PoissonCells

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
    """How finely the ground's height is taken under objects at xy (n, 2) [m] of the frame, (n,).

        SOLE       height and slope under each sole: where a foot could be displayed
        FOOTPRINT  height under each footprint: where any part besides the whole could be
        BODY       height under the body alone: where the whole is all that could be

    ``scenes.rig.foot_placement`` then places bodies and feet. What decides is the distance in plan,
    less what a part's origin can be away from where its object stands, against the limit distances
    of the parts: a function of the eye and the object alone, and never coarser than the cut. Feet
    are then off the ground by less than a quarter of m·d (which a test repeats, on the presets'
    hills). ``prototype`` (n,) is the row of each in ``prototypes``.
    """
    nodes, tables = prototypes.traversal_tables, prototypes.part_tables
    offset = nodes.extent[:, 0] + np.hypot(nodes.rest[:, 0], nodes.rest[:, 1])
    near = np.hypot(*(xy - view.camera.eye[:2]).T) - offset[prototype]
    if view.metric.along_axis:
        return np.full(len(xy), 2)  # what is far can be of little depth
    # The greatest limits of parts besides the whole, and of parts of feet; where no part is a
    # foot's, that of all parts stands for it.
    limit = np.maximum(*tables.limits(view))
    limit[tables.root] = -np.inf
    parts = np.maximum.reduceat(limit, tables.root)
    soles = np.maximum.reduceat(np.where(prototypes.foot_parts, limit, -np.inf), tables.root)
    limits = np.column_stack((parts, np.where(soles > -np.inf, soles, parts)))[prototype]
    return np.count_nonzero(limits - near[:, None] > 0, axis=1)


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


@dataclass(frozen=True, eq=False)
class SpeciesField:
    """A Representation: one species on the ground, endless or within a window.

    extent: side L of a square window about the plane's origin [m]; None = no edge. What has its
    home in the window is there.
    illumination: light that leaf appearances have the tone for; None = they have their own albedo.
    """

    species: Species
    seed: int
    ground: Ground
    extent: float | None = None
    illumination: Illumination | None = None

    @property
    def name(self) -> str:
        """Return the species' name."""
        return self.species.name

    @cached_property
    def prototypes(self) -> SpeciesPrototypes:
        """Return the prototypes with their tables."""
        return species_prototypes(self.species.prototypes)

    @cached_property
    def cells(self) -> SquareCells:
        """Return the process that says where objects are at home."""
        return self.species.pattern(self.seed, self.species.name, self.species.density)

    @property
    def moves(self) -> bool:
        """Tell whether any of it moves, by itself or as it walks."""
        return bool(self.species.patrol_m or self.prototypes.moves)

    def roots(self, view: View) -> Parts:
        """Find the wholes of every cell from which one could be displayed."""
        view = self.species.seen_in(view)
        cells = cells_in_reach(self.cells, view, self.search_bounds(view))
        samples = self.sample_cells(view.camera.corner, *cells)
        return self.prototypes.wholes(self.instances_in_view(samples, view), view)

    def cut(self, view: View) -> Cut:
        view = self.species.seen_in(view)
        samples, examined = candidates(self.cells, view, self.search_bounds(view))
        grown = self.in_habitat(view.camera.corner, samples)
        return self.prototypes.cut(self.instances_in_view(grown, view), view, examined)

    def cut_and_copies(
        self, view: View, from_size: float, chosen: CellSamples | None = None
    ) -> tuple[Cut, Parts, Instanced]:
        """Draw whole, as copies, what subtends ``from_size`` times the detail; cut the rest.

        Gives the cut of the rest, and the wholes and the copies, of all objects or of those
        ``chosen``; all have one numbering of objects. Nothing may move.
        """
        view = self.species.seen_in(view)
        if chosen is None:
            samples, examined = candidates(self.cells, view, self.search_bounds(view))
            chosen = self.in_habitat(view.camera.corner, samples)
        else:
            examined = len(chosen)
        objects = self.instances_in_view(chosen, view)
        near = self.copied(objects, view, from_size)
        far, rows = (np.flatnonzero(each) for each in (~near, near))
        cut = self.prototypes.cut(objects.take(far), view, examined - len(rows))

        def load_parts() -> Parts:
            return replace(cut.parts, object=far[cut.parts.object], state=objects)

        wholes = self.prototypes.wholes(objects, view).take(rows)
        copies = self.prototypes.copies(objects, rows, view, self.illumination)
        return replace(cut, object=far[cut.object], load_parts=load_parts), wholes, copies

    def copied(self, objects: InstancesInView, view: View, from_size: float) -> Flags:
        """Tell which objects are displayed and subtend so many times the detail, (n,); 0: none.

        What an object subtends is the diameter of its sphere by its distance, and the detail is
        that in view or out of it. In a view that prunes nothing all that is displayed does.
        """
        wholes = self.prototypes.wholes(objects, view)
        m = np.where(in_view(view, wholes.centre, wholes.bound), view.m, view.m_offscreen)
        large = 2 * wholes.bound >= from_size * m * distance(view, wholes.position)
        return displayed(wholes, view) & (from_size > 0) & (large | (not view.metric.finite))

    def parts_of(self, parts: Parts, view: View) -> Parts:
        return self.prototypes.parts_of(parts, self.species.seen_in(view))

    def appearance(self, parts: Parts, weights: BlendWeights) -> Appearance:
        return self.prototypes.appearance(parts, weights, self.illumination)

    def later(self, parts: Parts, view: View, time_s: float) -> Parts:
        """Return the same parts, posed as they are at another time [s]."""
        if not self.moves:
            return parts
        instances = self._place(view.camera.corner, parts.state.samples, time_s, view)
        return replace(parts, state=replace(parts.state, instances=instances))

    def search_bounds(self, view: View) -> SearchBounds:
        """Find where wholes can be displayed at all, prototype by prototype."""
        view = self.species.seen_in(view)
        tables, sway = self.prototypes.part_tables, self.prototypes.max_sway_m
        inside, outside = (limit[tables.root] for limit in tables.limits(view))
        rest, (low, high) = tables.rest[tables.root], self.ground.bounds()
        offset = float(np.hypot(rest[:, 0], rest[:, 1]).max()) + sway + self.species.patrol_m
        heights = low + float(rest[:, 2].min()) - sway, high + float(rest[:, 2].max()) + sway
        bound = tables.bound[tables.root]
        return search_bounds(view, (inside, outside), bound, offset, heights, self.extent)

    def sample_cells(self, corner: Corner, cell_x: np.ndarray, cell_y: np.ndarray) -> CellSamples:
        """Draw the objects of cells that have their homes in the window and grow there."""
        samples = self.cells.sample(cell_x, cell_y)
        if self.extent is not None:
            samples = samples.take(self.cells.in_window(samples, self.extent / 2))
        return self.in_habitat(corner, samples)

    def in_habitat(self, corner: Corner, samples: CellSamples) -> CellSamples:
        """Return those objects that have their home where the species grows."""
        if self.species.habitat is None:
            return samples
        share = self.species.habitat.share(corner, self.cells.positions(corner, samples))
        return samples.take(samples.u[:, 7] < share)

    def instances_in_view(self, samples: CellSamples, view: View) -> InstancesInView:
        """Return these objects as a view has them, and how much motion hides of each."""
        times, corner = shutter_times(view), view.camera.corner
        if self.moves:
            placed = [self._place(corner, samples, time_s, view) for time_s in times]
        else:  # the same in every frame, to the last bit
            placed = [self._place(corner, samples, 0.0, view)] * len(times)
        return instances_in_view(self.prototypes, samples, view, placed)

    def _place(
        self, corner: Corner, samples: CellSamples, time_s: float, view: View | None
    ) -> Instances:
        """How the objects stand at a time [s].

        view: feet meet the ground as closely as it could show; None = as closely as they can
        """
        prototype, stride_factor, orbits = patrol_orbits(self.species, self.prototypes, samples)
        walkers = orbits.at(time_s)
        xy = self.cells.positions(corner, samples) + walkers.offset
        facing, phase = (walkers.cos, walkers.sin), walkers.phase
        placements = Placements(xy, *facing, prototype, phase, stride_factor)
        if view is not None and self.prototypes.pose_tables.max_legs:
            detail = ground_contact_detail(self.prototypes, view, xy, prototype)
            placements = placements._replace(contact_detail=detail)
        heights = partial(self.ground.height, corner)
        return place_on_ground(self.prototypes.pose_tables, heights, placements)


@dataclass(frozen=True, eq=False)
class Placed:
    """A Representation: one object at (x, y) metres from the plane's origin, facing a heading.

    heading_deg: clockwise from north; period of its motion as the prototype's, from phase 0;
    illumination as in SpeciesField
    """

    name: str
    prototype: Prototype | RiggedPrototype
    x: float
    y: float
    heading_deg: float
    ground: Ground
    illumination: Illumination | None = None

    @cached_property
    def prototypes(self) -> SpeciesPrototypes:
        """Return its prototype with its tables."""
        return species_prototypes((self.prototype,))

    def roots(self, view: View) -> Parts:
        return self.prototypes.wholes(self._instances_in_view(view), view)

    def cut(self, view: View) -> Cut:
        return self.prototypes.cut(self._instances_in_view(view), view, 1)

    def parts_of(self, parts: Parts, view: View) -> Parts:
        return self.prototypes.parts_of(parts, view)

    def appearance(self, parts: Parts, weights: BlendWeights) -> Appearance:
        return self.prototypes.appearance(parts, weights, self.illumination)

    def later(self, parts: Parts, view: View, time_s: float) -> Parts:
        if not self.prototypes.moves:
            return parts
        instances = self._place(view.camera.corner, time_s)
        return replace(parts, state=replace(parts.state, instances=instances))

    def _instances_in_view(self, view: View) -> InstancesInView:
        placed = [self._place(view.camera.corner, time_s) for time_s in shutter_times(view)]
        return instances_in_view(self.prototypes, None, view, placed)

    def _place(self, corner: Corner, time_s: float) -> Instances:
        xy = np.array([[self.x - corner.x * GRID_M, self.y - corner.y * GRID_M]])
        facing = math.radians(90.0 - self.heading_deg)
        return place_on_ground(
            self.prototypes.pose_tables,
            partial(self.ground.height, corner),
            Placements(
                xy,
                cos=np.array([math.cos(facing)]),
                sin=np.array([math.sin(facing)]),
                prototype=np.zeros(1, np.int64),
                phase=np.array([time_s / self.prototypes.rigged[0].motion.period]),
                stride_factor=np.ones(1),
            ),
        )
