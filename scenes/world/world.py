"""From a preset to a world: the ground, the fields that stand on it, and the eye that walks."""

import math
from dataclasses import dataclass, replace
from functools import cache, cached_property

from lod.motion.shutter import ShutterInterval
from lod.motion.window_of_visibility import integration_time_s
from lod.pruning.parts import Representation
from lod.pruning.view import View
from scenes.dust.dust import Dust
from scenes.dust.soil import Soil
from scenes.far_cover.aggregate_cover import AggregateCover
from scenes.far_cover.sky import sky_at
from scenes.field.habitat import Habitat
from scenes.field.placed_object import Placed
from scenes.field.species_field import Species, SpeciesField
from scenes.frame.types import Light
from scenes.models.catalogue import model_prototypes
from scenes.models.trees.weather import Weather
from scenes.particles.kinds import KINDS
from scenes.particles.plume import Plume
from scenes.plugins.entry_points import metric_named
from scenes.plugins.representation import Standing, standing_of
from scenes.preset.load import PlacedPreset, PlumePreset, Preset, SpeciesPreset
from scenes.terrain.terrain import Terrain
from scenes.world.camera_path import camera_at
from scenes.world.viewing_conditions import sight_of


@dataclass(frozen=True, eq=False)
class World:
    """The ground, one field per species of some density, what is placed one by one, and what other
    packages make."""

    terrain: Terrain
    fields: tuple[SpeciesField, ...]
    placed: tuple[Placed, ...] = ()
    plumes: tuple[Plume, ...] = ()
    dust: tuple[Dust, ...] = ()
    others: tuple[Standing, ...] = ()

    @property
    def representations(self) -> tuple[Representation, ...]:
        """Everything that the pruner and the renderer ask."""
        return (self.terrain, *self.fields, *self.beside)

    @property
    def beside(self) -> tuple[Representation, ...]:
        """All of it that is neither the ground nor a field of some species."""
        return (*self.placed, *self.plumes, *self.dust, *self.others)

    @cached_property
    def top_m(self) -> float:
        """Height above the datum that nothing in it is above [m]."""
        troupes = [each.troupe for each in self.fields] + [each.troupe for each in self.placed]
        trees = (tree for troupe in troupes for tree in troupe.atlas.hierarchies)
        tallest = max((float(tree.position[0, 2] + tree.B[0]) for tree in trees), default=0.0)
        rising: tuple[Standing, ...] = (*self.plumes, *self.dust, *self.others)
        highest = max((each.top_m for each in rising), default=0.0)
        return self.terrain.bounds()[1] + max(tallest, highest)


def build_world(preset: Preset) -> World:
    """The preset's world; no part of it exists before a view asks for it."""
    terrain = Terrain(seed=preset.seed, **preset.terrain.model_dump())
    weather = Weather(preset.world.season, preset.wind.speed)
    fields = tuple(
        SpeciesField(
            species_of(name, table, weather, terrain), preset.seed, terrain, preset.world.extent
        )
        for name, table in preset.species.items()
        if table.density > 0
    )
    placed = tuple(
        placed_of(name, table, terrain, weather) for name, table in preset.placed.items()
    )
    plumes = tuple(
        plume_of(name, table, preset.seed, terrain) for name, table in preset.plumes.items()
    )
    others = tuple(
        standing_of(name, table.kind, preset.seed, terrain, dict(table.options))
        for name, table in preset.representations.items()
    )
    cover = aggregate_cover(preset, fields)
    dust = tuple(
        Dust(each, Soil(terrain.relief, terrain.cover), preset.wind.speed)
        for each in fields
        if preset.species[each.name].dust
    )
    return World(replace(terrain, aggregate_cover=cover), fields, placed, plumes, dust, others)


def aggregate_cover(preset: Preset, fields: tuple[SpeciesField, ...]) -> AggregateCover | None:
    """What the fields leave on the ground beyond the limit, in the preset's light."""
    if not fields:
        return None
    light = preset.light
    to_sun = Light(light.sun_azimuth, light.sun_elevation, light.turbidity).to_sun
    sky = sky_at(light.sun_elevation, light.turbidity)
    return AggregateCover(tuple(each.species for each in fields), to_sun, sky)


def species_of(name: str, table: SpeciesPreset, weather: Weather, terrain: Terrain) -> Species:
    """Every prototype in every size, all equally likely, where the species grows."""
    walks = table.patrol > 0
    prototypes = model_prototypes(table.model, table.prototypes, table.sizes, walks, weather)
    return Species(name, prototypes, table.density, table.patrol, habitat_of(table, terrain))


def habitat_of(table: SpeciesPreset, terrain: Terrain) -> Habitat | None:
    """Where a species grows; None = everywhere."""
    if table.highest is None and table.steepest is None:
        return None
    highest, steepest = (
        math.inf if limit is None else limit for limit in (table.highest, table.steepest)
    )
    return Habitat(terrain.relief, highest, table.thinning, steepest)


def placed_of(name: str, table: PlacedPreset, terrain: Terrain, weather: Weather) -> Placed:
    """One object as a preset places it, on the spot even where it walks."""
    sizes = (table.size,)
    *_, prototype = model_prototypes(table.model, table.prototype, sizes, table.walks, weather)
    return Placed(name, prototype, *table.position, table.heading, terrain)


def time_of(preset: Preset, frame: float) -> float:
    """When a frame is taken [s]: frame 1 at 0."""
    return (frame - 1) / preset.camera.fps


def exposure_at(world: World, preset: Preset, frame: int) -> ShutterInterval | None:
    """While the shutter is open, or an eye behind it takes things together: half before a frame's
    time and half after; None where no heed is paid to motion."""
    open_s = preset.view.shutter / 360 / preset.camera.fps
    if preset.view.smear == "window":
        open_s = integration_time_s(open_s)
    half = open_s * preset.camera.fps / 2
    if half == 0 or preset.view.smear == "off":
        return None

    @cache
    def at(later: int) -> ShutterInterval:
        ends = frame + later - half, frame + later + half
        size = preset.render.size
        opens, closes = (camera_at(preset.camera, size, end, world.terrain) for end in ends)
        opens_s, closes_s = (time_of(preset, end) for end in ends)
        return ShutterInterval(opens, closes, opens_s, closes_s)

    return replace(at(0), near=at)


def plume_of(name: str, table: PlumePreset, seed: int, terrain: Terrain) -> Plume:
    """Smoke or flames as a preset places them."""
    return Plume(name, KINDS[table.kind], seed, *table.position, terrain, table.size, table.wind)


def view_at(world: World, preset: Preset, frame: int) -> View:
    """The view of a frame, numbered from 1."""
    settings, azimuth = preset.view, math.radians(preset.light.sun_azimuth)
    camera = camera_at(preset.camera, preset.render.size, frame, world.terrain)
    return View(
        camera=camera,
        metric=metric_named(settings.metric),
        detail=settings.detail,
        offscreen_detail=settings.offscreen_detail,
        look_around=settings.look_around,
        fade=settings.fade,
        time_s=time_of(preset, frame),
        sight=sight_of(preset, camera, max(world.top_m, float(camera.eye[2]))),
        exposure=exposure_at(world, preset, frame),
        sun=(math.sin(azimuth), math.cos(azimuth)),
    )
