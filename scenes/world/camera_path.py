"""Where the camera is in a frame, and on what its lens is focused: walking, or flying by keys."""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any

import numpy as np

from lod.arrays import Reals
from lod.camera import FULL_TURN, Camera, ThinLens, camera_from_heading, split_position
from lod.errors import InputError
from scenes.ground.relief import Ground
from scenes.presets.schema import FARTHEST_FOCUS_M, NEAREST_FOCUS_M, CameraKey, CameraPreset


@dataclass(frozen=True)
class CameraPose:
    """A camera's place and direction in plan: metres from a cell's corner, degrees.

    f_stop  of its lens; None = a pinhole
    focus   distance in focus, or a point with its height above the ground there [m]; None = far
    """

    x: float
    y: float
    height: float
    heading: float
    pitch: float
    fov: float
    roll: float
    f_stop: float | None
    focus: float | tuple[float, float, float] | None


def camera_at(preset: CameraPreset, size: tuple[int, int], frame: float, ground: Ground) -> Camera:
    """Place the camera of a frame, numbered from 1, above the ground it stands on.

    Between two frames it is where it is then: frame 1.5 is half a frame's time after frame 1.
    """
    return placed_camera(preset, path_pose(preset, frame, ground), size, ground)


def path_pose(preset: CameraPreset, frame: float, ground: Ground) -> CameraPose:
    """Find where the preset has the camera in a frame, or between two."""
    return _between_keys(preset, frame, ground) if preset.keys else _walked(preset, frame)


def placed_camera(
    preset: CameraPreset, stand: CameraPose, size: tuple[int, int], ground: Ground
) -> Camera:
    """Place a camera above the ground it stands on, with the preset's lens, in a picture [px]."""
    corner, x, y = split_position(stand.x, stand.y, *preset.cell)
    eye = np.array((x, y, height_at(ground, stand.x, stand.y, preset.cell) + stand.height))
    angles = stand.heading, stand.pitch, stand.fov
    camera = camera_from_heading(corner, eye, *angles, size, stand.roll)
    if preset.projection == "panorama":
        return replace(camera, panorama=True, fov_x=FULL_TURN)
    if preset.stereo:
        camera = replace(camera, baseline_m=preset.stereo)
    if stand.f_stop is None:
        return camera
    diameter = preset.aperture_m(stand.fov, stand.f_stop)
    return replace(camera, lens=ThinLens(diameter, _focus(preset, stand, camera, ground)))


def _focus(preset: CameraPreset, stand: CameraPose, camera: Camera, ground: Ground) -> float:
    if stand.focus is None:
        return FARTHEST_FOCUS_M
    if isinstance(stand.focus, float):
        return stand.focus
    x, y, height = stand.focus
    here, there = (height_at(ground, *at, preset.cell) for at in ((stand.x, stand.y), (x, y)))
    offset = np.array((x - stand.x, y - stand.y, there + height - here - stand.height))
    ahead = float(offset @ camera.forward)
    if ahead < NEAREST_FOCUS_M:
        rule = f"a point at least {NEAREST_FOCUS_M:g} m before the camera; it is {ahead:.3g} m"
        raise InputError("camera.focus", stand.focus, rule, "turn the camera, or give a distance")
    return ahead


def height_at(ground: Ground, x: float, y: float, cell: tuple[int, int] = (0, 0)) -> float:
    """Compute the height of the ground at one point, metres from a cell's corner [m]."""
    corner, x, y = split_position(x, y, *cell)
    return float(ground.height(corner, np.array([[x, y]]))[0])


def _walked(preset: CameraPreset, frame: float) -> CameraPose:
    walked = preset.speed * (frame - 1) / preset.fps
    turned = preset.heading + preset.turn * (frame - 1) / preset.fps
    heading = math.radians(preset.heading)
    x = preset.position[0] + walked * math.sin(heading)
    y = preset.position[1] + walked * math.cos(heading)
    lens = preset.fov_x_deg, preset.roll, preset.f_stop, preset.focus
    return CameraPose(x, y, preset.height, turned, preset.pitch, *lens)


def _between_keys(preset: CameraPreset, frame: float, ground: Ground) -> CameraPose:
    """Through the keys by monotone cubics (Fritsch & Carlson 1980), always facing the target."""
    keys = preset.keys
    at = min(max(frame, keys[0].frame), keys[-1].frame)
    at_keys = _flight(keys, preset.fov_x_deg, preset.roll)
    x, y, height, px, py, pz, fov, roll = at_keys(at).tolist()
    base, far = (height_at(ground, *xy, preset.cell) for xy in ((x, y), (px, py)))
    east, north, up = px - x, py - y, far + pz - base - height
    heading = math.degrees(math.atan2(east, north))
    pitch = math.degrees(math.atan2(up, math.hypot(east, north)))
    f_stop = _pulled(keys, "f_stop", preset.f_stop, at) or preset.f_stop
    focus = _pulled(keys, "focus", preset.focus, at) or preset.focus or (px, py, pz)
    return CameraPose(x, y, height, heading, pitch, fov, roll, f_stop, focus)


def _pulled(keys: tuple[CameraKey, ...], name: str, camera: Any, at: float) -> float | None:
    """Read f-number or distance in focus between keys; None where no key has one of its own.

    They are pulled evenly in their logarithms, as the marks on a lens stand. A key that has none
    has the camera's.
    """
    own = [getattr(key, name) for key in keys]
    if not any(own):
        return None
    from scipy.interpolate import PchipInterpolator

    logarithms = np.log([each or camera for each in own])
    return math.exp(PchipInterpolator([key.frame for key in keys], logarithms)(at))


@lru_cache(maxsize=4)
def _flight(keys: tuple[CameraKey, ...], fov: float, roll: float) -> Callable[[float], Reals]:
    """Position, height, target, field of view and roll at any frame.

    ``fov`` and ``roll`` are those of keys that have none [degrees]. The same keys are asked for
    frame after frame.
    """
    from scipy.interpolate import PchipInterpolator  # expensive to import, and few presets fly

    columns = np.array([(*key.position, key.height, *key.target) for key in keys])
    lens = [[key.fov or fov, roll if key.roll is None else key.roll] for key in keys]
    curve: Callable[[float], Reals] = PchipInterpolator(
        [key.frame for key in keys], np.hstack((columns, lens))
    )
    return curve
