"""A preset and its world, bound: the views of its frames, what is displayed, and the pictures.

Everything that looks at a preset goes through a Scene: commands, experiments, the renderer's
sessions and the tests. Its world is the ground, the fields on it, and what is placed one by one.
"""

import math
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cache, partial
from typing import TYPE_CHECKING

import numpy as np

from lod.air import Air, least_extinction
from lod.camera import GRID_M, Camera, Corner
from lod.errors import InputError
from lod.eye import Display, Eye
from lod.metric import METRICS, within_reach
from lod.motion import ShutterInterval, eye_relative_to, integration_time_s, subframe_offsets
from lod.pruner import Cut, Representation, prune
from lod.shapes import Sticks
from lod.update_schedule import (
    DrawnState,
    TruePose,
    refresh_due,
    replay,
    replay_frames,
    threshold_rule,
)
from lod.view import View
from lod.viewing import Defocus, ViewingConditions, blur_widths
from scenes.actors.performance import Cast, Performance
from scenes.appearance.sky import sky_at
from scenes.appearance.tone import Illumination
from scenes.field.far_cover import AggregateCover
from scenes.field.species_field import Habitat, Placed, Species, SpeciesField
from scenes.frame.frame_input import (
    DisplayedRepresentation,
    FrameInput,
    Light,
    Quality,
    Window,
    can_be_copied,
    display,
    display_copies,
)
from scenes.ground.mesh import Terrain
from scenes.models.catalogue import PROTOTYPE_SEED, model_prototypes
from scenes.particles.dust import Dust
from scenes.particles.footfalls import Soil
from scenes.particles.system import KINDS, Plume
from scenes.plugins import make_representation, metric_by_name
from scenes.presets.load import has_acting, load_preset
from scenes.presets.schema import Preset, SpeciesPreset
from scenes.processes.progress import steps, work
from scenes.trees.species import Weather
from scenes.world.camera_path import camera_at, path_pose, placed_camera


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
                    each.model, each.prototype, (each.size,), each.walks, weather, each.model_sha256
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


if TYPE_CHECKING:
    from scenes.frame.layers import Layers

_ARCSECOND = math.radians(1 / 3600)


def sun_and_sky(preset: Preset) -> Light:
    """Return the sun and sky of a preset."""
    light = preset.light
    return Light(light.sun_azimuth, light.sun_elevation, light.turbidity)


class Scene:
    """A checked preset and its world, which is built when it is first asked for.

    preset          or the name or path of one
    performance     gives what its actors do, where that is known already
    prototype_seed  every seed gives other individuals of the species; frames are made with the
                    default, so that only experiments meet others

    Frames are numbered from 1. Raises InputError for a preset that cannot be.
    """

    def __init__(
        self,
        preset: Preset | str,
        performance: Callable[[], Performance] | None = None,
        prototype_seed: int = PROTOTYPE_SEED,
    ) -> None:
        self.preset = load_preset(preset) if isinstance(preset, str) else preset
        self._build = cache(partial(build_world, self.preset, performance, prototype_seed))

    @property
    def world(self) -> World:
        """Return the world, of which no part exists before a view asks for it."""
        return self._build()

    def with_preset(self, preset: Preset) -> "Scene":
        """Return the same world under another preset: another camera, air, detail or quality."""
        other = Scene(preset)
        other._build = self._build
        return other

    def with_world(self, world: World) -> "Scene":
        """Return the same preset with another world."""
        other = Scene(self.preset)
        other._build = cache(lambda: world)
        return other

    @property
    def air(self) -> Air:
        """Return the air that frames are rendered in, and that the same frames are pruned by."""
        return Air(self.preset.air.visibility)

    @property
    def light(self) -> Light:
        """Return the sun and sky."""
        return sun_and_sky(self.preset)

    def time_s(self, frame: float) -> float:
        """Compute when a frame begins [s]: frame 1 at 0."""
        return (frame - 1) / self.preset.camera.fps

    def camera(self, frame: float, corner: Corner | None = None) -> Camera:
        """Return the camera of a frame or between two: where messages put it, or on its path.

        corner  in whose coordinates; None = the one that is near the camera
        """
        preset, world = self.preset, self.world
        size = preset.render.size
        acted = world.cast.performance.between(frame).eye if world.cast else None
        if acted is None:
            camera = camera_at(preset.camera, size, frame, world.terrain)
        else:
            on_path = path_pose(preset.camera, frame, world.terrain)
            x, y = (at - GRID_M * n for at, n in zip(acted[:2], preset.camera.cell, strict=True))
            height, heading, pitch = acted[2:]
            stand = replace(on_path, x=x, y=y, height=height, heading=heading, pitch=pitch)
            camera = placed_camera(preset.camera, stand, size, world.terrain)
        if corner is None:
            return camera
        return replace(camera, corner=corner, eye=eye_relative_to(corner, camera))

    def view(self, frame: int) -> View:
        """Make the view of a frame: all that decides what of the world is displayed."""
        settings, azimuth = self.preset.view, math.radians(self.preset.light.sun_azimuth)
        camera, metric = self.camera(frame), metric_by_name(settings.metric)
        if settings.reach is not None:
            metric = within_reach(metric, settings.reach)
        return View(
            camera=camera,
            metric=metric,
            detail=settings.detail,
            offscreen_detail=settings.offscreen_detail,
            look_around=settings.look_around or camera.panorama,
            fade=settings.fade,
            time_s=self.time_s(frame),
            conditions=self._viewing_conditions(camera),
            shutter=self._shutter_interval(frame),
            sun=(math.sin(azimuth), math.cos(azimuth)),
        )

    def _viewing_conditions(self, camera: Camera) -> ViewingConditions | None:
        """Collect what limits sight beyond the pixel; None where nothing does.

        A table [display] or [eye] says that somebody will look.
        """
        preset, air = self.preset, self.air
        hazy = preset.view.haze_aware and air != Air()
        watched = preset.display is not None or preset.eye is not None
        if not (hazy or watched or preset.air.seeing or camera.lens):
            return None
        display = Display(**preset.display.model_dump()) if preset.display else Display()
        eye = Eye(**preset.eye.model_dump()) if preset.eye else Eye()
        seeing = preset.air.seeing * _ARCSECOND
        widths = blur_widths(camera.pixel_angle, display, eye if watched else None, seeing)
        beta = least_extinction(air) if hazy else 0.0
        defocus = Defocus(camera.lens, camera.corner_secant) if camera.lens else None
        return ViewingConditions(widths, beta, display, eye, acuity=watched, defocus=defocus)

    def _shutter_interval(self, frame: int) -> ShutterInterval | None:
        """Find the interval over which motion blurs a frame, half before its time and half after.

        The shutter is open so long, or an eye behind it integrates; None where motion hides
        nothing.
        """
        view, fps = self.preset.view, self.preset.camera.fps
        open_s = view.shutter / 360 / fps
        if view.smear == "window":
            open_s = integration_time_s(open_s)
        half = open_s * fps / 2
        if half == 0 or view.smear == "off":
            return None

        @cache
        def at(later: int) -> ShutterInterval:
            ends = frame + later - half, frame + later + half
            opens, closes = (self.camera(end) for end in ends)
            opens_s, closes_s = (self.time_s(end) for end in ends)
            return ShutterInterval(opens, closes, opens_s, closes_s)

        return replace(at(0), neighbour=at)

    def copied_from(self, view: View, quality: Quality) -> float:
        """How many times the detail still objects subtend that are copies; 0: none are."""
        return (self.preset.view.copies if view.metric.finite else 1.0) * quality.draws_copies

    def cut(self, frame: int) -> tuple[Cut, ...]:
        """Prune every representation of the world for a frame, the ground first."""
        view = self.view(frame)
        return tuple(prune(each, view) for each in self.world.representations)

    def input(self, frame: int, variant: str | None = None) -> FrameInput:
        """Prune every representation for a frame, and make the shapes of the parts displayed.

        variant  a Mitsuba variant that works here; None = the one that the preset asks for
        """
        if variant is None:
            from scenes.render.variants import choose

            variant = choose(self.preset.render.variant, self.preset.render.spectral)
        view, displayed, quality = self.view(frame), [], frame_quality(self.preset, variant)
        after = self.view(frame + 1) if self.preset.output.motion else None
        from_size = self.copied_from(view, quality)
        seconds = {"prune": 0.0, "appearance": 0.0}
        with work("fitting brightness", len(self.world.representations)):
            for each in self.world.representations:
                start = pruned = time.perf_counter()
                if from_size and can_be_copied(each, view):
                    one = display_copies(each, view, from_size)
                else:
                    cut = prune(each, view)
                    pruned = time.perf_counter()
                    with steps(1):
                        one = self.scheduled(frame, display(each, cut, view))
                displayed.append(one.at(view.time_s, after.time_s) if after else one)
                seconds["prune"] += pruned - start
                seconds["appearance"] += time.perf_counter() - pruned
        frame_input = FrameInput(
            camera=view.camera,
            displayed=tuple(displayed),
            air=self.air,
            light=self.light,
            quality=quality,
            after=after.camera if after else None,
            denoise=self.preset.output.denoise,
            seconds=seconds,
            counts=update_counts([each.drawn for each in displayed if each.drawn]),
        )
        if inputs := self._subframes(frame, frame_input):
            return replace(frame_input, subframes=inputs)
        at_rest = tuple(replace(each, posing=None) for each in displayed)  # which holds memory
        return replace(frame_input, displayed=at_rest)

    def _subframes(
        self, frame: int, frame_input: FrameInput
    ) -> tuple[Callable[[], FrameInput], ...]:
        """Make the inputs of the sub-frames, all of one cut; there are none where all is still.

        There are as many as ``render.subframes`` says, or as there are samples a pixel if those are
        fewer. Where only the camera moves they all hold the same tuple of what is displayed.
        """
        preset, here, displayed = self.preset, frame_input.camera, frame_input.displayed
        count = min(preset.render.subframes, preset.render.spp)
        frames = (frame + preset.view.shutter / 360 * subframe_offsets(count)).tolist()
        cameras = [self.camera(at, here.corner) for at in frames]
        moves = any(each.moves(self.time_s(at)) for at in frames for each in displayed)
        if not moves and all(_same_place(here, each) for each in cameras):
            return ()

        def at_one(number: int) -> FrameInput:
            at, now, after = frames[number], displayed, None
            later = self.time_s(at + 1) if preset.output.motion else None
            if later is not None:
                after = self.camera(at + 1, here.corner)
            if moves or later is not None:
                now = tuple(each.at(self.time_s(at), later) for each in displayed)
            return replace(frame_input, camera=cameras[number], displayed=now, after=after)

        return tuple(partial(at_one, number) for number in range(count))

    def scheduled(self, frame: int, displayed: DisplayedRepresentation) -> DisplayedRepresentation:
        """Leave sticks as they were drawn earlier, where they moved less than the threshold."""
        threshold = self.preset.view.update_threshold
        if threshold == 0 or not is_scheduled(displayed, self.time_s(frame + 1)):
            return displayed
        poses = self.poses(replay_frames(frame), displayed)
        (drawn,) = replay(poses, [threshold_rule(threshold)])
        return displayed.with_drawn(drawn)

    def poses(
        self, frames: Iterable[int], displayed: DisplayedRepresentation
    ) -> Iterator[TruePose]:
        """Compute where its sticks truly are in each frame; nothing of what has no sticks."""
        if displayed.posing is None:
            return
        posing, view = displayed.posing, displayed.posing.view
        for frame in frames:
            shape = posing.shape_at(self.time_s(frame))
            due = refresh_due(posing.parts.part, frame)
            eye = self.camera(frame, view.camera.corner).eye
            if isinstance(shape, Sticks):
                yield TruePose(shape.start, shape.end, shape.owner, due, eye, view.theta)

    def render(self, frame: int, variant: str | None = None) -> "Layers":
        """Render a frame in this process, into arrays."""
        from scenes.render.render import render_frame

        return render_frame(self.input(frame, variant), frame)


def is_scheduled(displayed: DisplayedRepresentation, later_s: float) -> bool:
    """Tell whether it has sticks of something that moves, which may stay as they were drawn."""
    return displayed.moves(later_s) and isinstance(displayed.shape, Sticks)


def update_counts(drawn: Sequence[DrawnState]) -> dict[str, int]:
    """Count the parts that could move and those redrawn; nothing where there is no schedule.

    ``farthest_off_mpx`` is the largest error of those that stay as they were drawn [px/1000].
    """
    if not drawn:
        return {}
    return {
        "parts_scheduled": sum(len(each.updated) for each in drawn),
        "parts_redrawn": sum(int(each.updated.sum()) for each in drawn),
        "farthest_off_mpx": max(
            round(1000 * float(each.error_px.max(initial=0))) for each in drawn
        ),
    }


def frame_quality(preset: Preset, variant: str) -> Quality:
    """Return how frames of a preset are sampled, in a variant that works here.

    Raises InputError for a panorama in a scalar variant, which has no such camera.
    """
    render = preset.render
    if preset.camera.projection == "panorama" and variant.startswith("scalar_"):
        rule = f"a panorama needs a JIT variant, as llvm_ad_rgb, and not {variant}"
        raise InputError("camera.projection", "panorama", rule, "see `lodbench doctor`")
    window = None if render.crop is None else Window(*render.window)
    return Quality(
        variant,
        render.spp,
        preset.seed,
        render.max_depth,
        render.haze,
        coverage=preset.output.cryptomatte,
        window=window,
    )


def _same_place(a: Camera, b: Camera) -> bool:
    pairs = ((a.eye, b.eye), (a.forward, b.forward), (a.up, b.up))
    return all(np.array_equal(one, other) for one, other in pairs)
