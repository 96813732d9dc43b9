"""From a preset to a world: the ground, the fields that stand on it, and the eye that walks."""

import math
from dataclasses import dataclass

import numpy as np

from lod.camera import look, split
from lod.metric import metric_named
from lod.parts import Representation
from lod.view import View
from scenes.field import Species, SpeciesField
from scenes.models import made
from scenes.preset import Preset, SpeciesPreset
from scenes.terrain import Terrain


@dataclass(frozen=True, eq=False)
class World:
    """The ground, and one field per species of some density."""

    terrain: Terrain
    fields: tuple[SpeciesField, ...]

    @property
    def representations(self) -> tuple[Representation, ...]:
        """Everything that the pruner and the renderer ask."""
        return (self.terrain, *self.fields)


def build_world(preset: Preset) -> World:
    """The preset's world; no part of it exists before a view asks for it."""
    terrain = Terrain(seed=preset.seed, **preset.terrain.model_dump())
    fields = tuple(
        SpeciesField(species_of(name, table), preset.seed, terrain, preset.world.extent)
        for name, table in preset.species.items()
        if table.density > 0
    )
    return World(terrain, fields)


def species_of(name: str, table: SpeciesPreset) -> Species:
    """Every prototype in every size, all equally likely."""
    prototypes = made(table.model, table.prototypes, table.sizes, walks=table.patrol > 0)
    return Species(name, prototypes, table.density, table.patrol)


def view_at(world: World, preset: Preset, frame: int) -> View:
    """The view of a frame, from 1; the camera walks along its heading, above the ground."""
    camera, settings = preset.camera, preset.view
    walked = camera.speed * (frame - 1) / camera.fps
    heading = math.radians(camera.heading)
    x = camera.position[0] + walked * math.sin(heading)
    y = camera.position[1] + walked * math.cos(heading)
    corner, x, y = split(x, y, *camera.cell)
    ground = float(world.terrain.height(corner, np.array([[x, y]]))[0])
    eye = np.array((x, y, ground + camera.height))
    camera_made = look(corner, eye, camera.heading, camera.pitch, camera.fov, preset.render.size)
    return View(
        camera=camera_made,
        metric=metric_named(settings.metric),
        detail=settings.detail,
        offscreen_detail=settings.offscreen_detail,
        look_around=settings.look_around,
        time_s=(frame - 1) / camera.fps,
    )
