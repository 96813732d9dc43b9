"""From a preset to a world: the ground, the fields on it, and what is placed one by one."""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

from lod.metric import METRICS
from lod.pruner import Representation
from scenes.actors.performance import Cast, Performance
from scenes.appearance.sky import sky_at
from scenes.appearance.tone import Illumination
from scenes.field.far_cover import AggregateCover
from scenes.field.species_field import Habitat, Placed, Species, SpeciesField
from scenes.ground.terrain import Terrain
from scenes.models.catalogue import PROTOTYPE_SEED, model_prototypes
from scenes.particles.dust import Dust
from scenes.particles.footfalls import Soil
from scenes.particles.plume import KINDS, Plume
from scenes.plugins import make_representation
from scenes.presets.load import has_acting
from scenes.presets.schema import Preset
from scenes.presets.things import SpeciesPreset
from scenes.processes.progress import work
from scenes.trees.species import Weather
from scenes.world.sun_and_sky import sun_and_sky


@dataclass(frozen=True, eq=False)
class World:
    """Everything that there is to see.

    The ground, a field for each species, what is placed one by one, and what plug-ins make.
    """

    terrain: Terrain
    fields: tuple[SpeciesField, ...]
    placed: tuple[Placed, ...] = ()
    plumes: tuple[Plume, ...] = ()
    dust: tuple[Dust, ...] = ()
    others: tuple[Representation, ...] = ()
    cast: Cast | None = None

    @property
    def representations(self) -> tuple[Representation, ...]:
        """Return all representations, the ground first."""
        return (self.terrain, *self.fields, *self.beside)

    @property
    def beside(self) -> tuple[Representation, ...]:
        """Return all representations but the ground and the fields of species."""
        actors = (self.cast,) if self.cast and self.cast.prototypes else ()
        return (*self.placed, *self.plumes, *self.dust, *self.others, *actors)


def build_world(
    preset: Preset,
    performance: Callable[[], Performance] | None = None,
    prototype_seed: int = PROTOTYPE_SEED,
) -> World:
    """Build a preset's world, of which no part exists before a view asks for it.

    performance     gives what its actors do, where that is known already
    prototype_seed  every seed gives other individuals of the species; frames are made with the
                    default, so that only experiments meet others
    """
    terrain, keys = make_terrain(preset), preset.light
    to_sun = sun_and_sky(preset).to_sun
    weather = Weather(preset.world.season, preset.wind.speed)
    depth = preset.render.max_depth
    light = Illumination(round(keys.sun_elevation, 3), keys.turbidity, depth)
    growing = {name: table for name, table in preset.species.items() if table.density > 0}
    fits = [each.prototypes for each in growing.values()]
    fits += [each.prototype for each in preset.placed.values()]
    with work("fitting appearances", sum(fits)):
        fields = tuple(
            SpeciesField(
                _species(name, table, weather, terrain, prototype_seed),
                preset.seed,
                terrain,
                preset.world.extent,
                light,
            )
            for name, table in growing.items()
        )
        placed = tuple(
            Placed(
                name,
                model_prototypes(
                    each.model,
                    each.prototype,
                    (each.size,),
                    each.walks,
                    weather,
                    each.model_sha256,
                )[-1],
                *each.position,
                each.heading,
                terrain,
                light,
            )
            for name, each in preset.placed.items()
        )
    wind = preset.wind
    plumes = tuple(
        Plume(
            name,
            KINDS[each.kind],
            preset.seed,
            *each.position,
            terrain,
            each.size,
            wind.direction if each.wind is None else each.wind,
        )
        for name, each in preset.plumes.items()
    )
    others = tuple(
        make_representation(name, table.kind, preset.seed, terrain, dict(table.options))
        for name, table in preset.representations.items()
    )
    dust = tuple(
        Dust(each, Soil(terrain.relief, terrain.cover), wind.speed, wind.direction)
        for each in fields
        if preset.species[each.name].dust
    )
    species = tuple(each.species for each in fields)
    cover = None
    if fields:
        sky = sky_at(keys.sun_elevation, keys.turbidity)
        cover = AggregateCover(species, to_sun, sky, depth)
    ground = replace(terrain, aggregate_cover=cover, to_sun=tuple(to_sun.tolist()))
    cast = None
    if has_acting(preset):  # what makes actors is only imported where there are any
        from scenes.world.cast import make_cast

        cast = make_cast(preset, terrain, performance and performance())
    return World(ground, fields, placed, plumes, dust, others, cast)


def make_terrain(preset: Preset) -> Terrain:
    """Make the ground of a preset, without what stands for far objects on it."""
    return Terrain(seed=preset.seed, **preset.terrain.model_dump())


def _species(
    name: str, table: SpeciesPreset, weather: Weather, terrain: Terrain, seed: int
) -> Species:
    walks, digest = table.patrol > 0, table.model_sha256
    prototypes = model_prototypes(
        table.model, table.prototypes, table.sizes, walks, weather, digest, seed
    )
    metric = None if table.metric is None else METRICS[table.metric]
    habitat = None  # it grows everywhere
    if table.highest is not None or table.steepest is not None:
        highest, steepest = (
            math.inf if limit is None else limit for limit in (table.highest, table.steepest)
        )
        habitat = Habitat(terrain.relief, highest, table.thinning, steepest)
    return Species(name, prototypes, table.density, table.patrol, habitat, metric)
