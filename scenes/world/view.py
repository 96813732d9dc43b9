"""From a preset to the view of a frame: camera, viewing conditions, shutter interval and air."""

import math
from dataclasses import replace
from functools import cache

from lod.air import Air, Mist, least_extinction
from lod.camera import GRID_M, Camera, Corner
from lod.eye import Display, Eye
from lod.motion import ShutterInterval, eye_relative_to, integration_time_s
from lod.view import View
from lod.viewing import Defocus, ViewingConditions, blur_widths
from scenes.plugins.entry_points import metric_by_name
from scenes.preset.tables import Preset
from scenes.world.camera_path import camera_at, path_pose, placed_camera
from scenes.world.world import World

_ARCSECOND = math.radians(1 / 3600)


def preset_air(preset: Preset) -> Air:
    """Return the air that frames are rendered in, and that the same frames are pruned by."""
    keys = preset.air
    mist = None if keys.mist is None else Mist(keys.mist, keys.mist_base, keys.mist_scale)
    return Air(keys.visibility, mist)


def viewing_conditions(
    preset: Preset, camera: Camera, highest_m: float
) -> ViewingConditions | None:
    """Collect what limits sight beyond the pixel; None where nothing does.

    ``highest_m``: height above the datum that neither the eye nor anything it sees is above, for β
    there is the least of any path. A table [display] or [eye] says that somebody will look.
    """
    air, keys = preset_air(preset), preset.air
    hazy = preset.view.haze_aware and air != Air()
    watched = preset.display is not None or preset.eye is not None
    if not (hazy or watched or keys.seeing or camera.lens):
        return None
    display = Display(**preset.display.model_dump()) if preset.display else Display()
    eye = Eye(**preset.eye.model_dump()) if preset.eye else Eye()
    seeing = keys.seeing * _ARCSECOND
    widths = blur_widths(camera.pixel_angle, display, eye if watched else None, seeing)
    beta = least_extinction(air, highest_m) if hazy else 0.0
    defocus = Defocus(camera.lens, camera.corner_secant) if camera.lens else None
    return ViewingConditions(widths, beta, display, eye, acuity=watched, defocus=defocus)


def frame_time(preset: Preset, frame: float) -> float:
    """Compute when a frame begins [s]: frame 1 at 0."""
    return (frame - 1) / preset.camera.fps


def shutter_interval(world: World, preset: Preset, frame: int) -> ShutterInterval | None:
    """Find the interval over which motion blurs a frame, half before its time and half after.

    The shutter is open so long, or an eye behind it integrates; None where motion hides nothing.
    """
    open_s = preset.view.shutter / 360 / preset.camera.fps
    if preset.view.smear == "window":
        open_s = integration_time_s(open_s)
    half = open_s * preset.camera.fps / 2
    if half == 0 or preset.view.smear == "off":
        return None

    @cache
    def at(later: int) -> ShutterInterval:
        ends = frame + later - half, frame + later + half
        opens, closes = (frame_camera(world, preset, end) for end in ends)
        opens_s, closes_s = (frame_time(preset, end) for end in ends)
        return ShutterInterval(opens, closes, opens_s, closes_s)

    return replace(at(0), neighbour=at)


def view_at(world: World, preset: Preset, frame: int) -> View:
    """Make the view of a frame, numbered from 1: all that decides what of a world is displayed."""
    settings, azimuth = preset.view, math.radians(preset.light.sun_azimuth)
    camera = frame_camera(world, preset, frame)
    return View(
        camera=camera,
        metric=metric_by_name(settings.metric),
        detail=settings.detail,
        offscreen_detail=settings.offscreen_detail,
        look_around=settings.look_around or camera.panorama,
        fade=settings.fade,
        time_s=frame_time(preset, frame),
        conditions=viewing_conditions(preset, camera, max(world.top_m, float(camera.eye[2]))),
        shutter=shutter_interval(world, preset, frame),
        sun=(math.sin(azimuth), math.cos(azimuth)),
    )


def frame_camera(world: World, preset: Preset, frame: float) -> Camera:
    """Return the camera of a frame or between two: where messages put it, or on its path."""
    size = preset.render.size
    acted = world.cast.performance.between(frame).eye if world.cast else None
    if acted is None:
        return camera_at(preset.camera, size, frame, world.terrain)
    on_path = path_pose(preset.camera, frame, world.terrain)
    x, y = (at - GRID_M * n for at, n in zip(acted[:2], preset.camera.cell, strict=True))
    height, heading, pitch = acted[2:]
    stand = replace(on_path, x=x, y=y, height=height, heading=heading, pitch=pitch)
    return placed_camera(preset.camera, stand, size, world.terrain)


def camera_between(world: World, preset: Preset, frame: float, corner: Corner) -> Camera:
    """Return the camera at a frame or between two, in the coordinates of a corner."""
    camera = frame_camera(world, preset, frame)
    return replace(camera, corner=corner, eye=eye_relative_to(corner, camera))
