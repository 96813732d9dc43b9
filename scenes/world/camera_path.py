"""Where the camera is in a frame: on a straight walk, or flying through keys."""

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from scipy.interpolate import PchipInterpolator

from lod.camera import Camera, camera_from_heading, split_position
from scenes.preset.camera_tables import CameraKey, CameraPreset
from scenes.terrain.ground import Ground


@dataclass(frozen=True)
class CameraPose:
    """A camera's place and direction in plan: metres from a cell's corner, degrees."""

    x: float
    y: float
    height: float
    heading: float
    pitch: float
    fov: float
    roll: float


def camera_at(preset: CameraPreset, size: tuple[int, int], frame: float, ground: Ground) -> Camera:
    """Place the camera of a frame, numbered from 1, above the ground it stands on.

    Between two frames it is where it is then: frame 1.5 is half a frame's time after frame 1.
    """
    if preset.keys:
        stand = _between_keys(preset, frame, ground)
    else:
        stand = _walked(preset, frame)
    corner, x, y = split_position(stand.x, stand.y, *preset.cell)
    eye = np.array((x, y, height_at(ground, stand.x, stand.y, preset.cell) + stand.height))
    return camera_from_heading(corner, eye, stand.heading, stand.pitch, stand.fov, size, stand.roll)


def height_at(ground: Ground, x: float, y: float, cell: tuple[int, int] = (0, 0)) -> float:
    """Compute the height of the ground at one point, metres from a cell's corner [m]."""
    corner, x, y = split_position(x, y, *cell)
    return float(ground.height(corner, np.array([[x, y]]))[0])


def _walked(preset: CameraPreset, frame: float) -> CameraPose:
    """Walk ahead along the first heading at an even speed, turning at an even rate."""
    walked = preset.speed * (frame - 1) / preset.fps
    turned = preset.heading + preset.turn * (frame - 1) / preset.fps
    heading = math.radians(preset.heading)
    x = preset.position[0] + walked * math.sin(heading)
    y = preset.position[1] + walked * math.cos(heading)
    fov = preset.fov_x_deg
    return CameraPose(x, y, preset.height, turned, preset.pitch, fov, preset.roll)


def _between_keys(preset: CameraPreset, frame: float, ground: Ground) -> CameraPose:
    """Through the keys by monotone cubics (Fritsch & Carlson 1980), always facing the target."""
    keys = preset.keys
    at = min(max(frame, keys[0].frame), keys[-1].frame)
    at_keys = _flight(keys, preset.fov_x_deg, preset.roll)
    x, y, height, *target, fov, roll = at_keys(at).tolist()
    base, far = (height_at(ground, px, py, preset.cell) for px, py in ((x, y), target[:2]))
    east, north, up = target[0] - x, target[1] - y, far + target[2] - base - height
    heading = math.degrees(math.atan2(east, north))
    pitch = math.degrees(math.atan2(up, math.hypot(east, north)))
    return CameraPose(x, y, height, heading, pitch, fov, roll)


@lru_cache(maxsize=4)
def _flight(keys: tuple[CameraKey, ...], fov: float, roll: float) -> PchipInterpolator:
    """Position, height, target, field of view and roll at any frame.

    ``fov`` and ``roll`` are those of keys that have none [degrees]. The same keys are asked for
    frame after frame.
    """
    columns = np.array([(*key.position, key.height, *key.target) for key in keys])
    lens = [[key.fov or fov, roll if key.roll is None else key.roll] for key in keys]
    return PchipInterpolator([key.frame for key in keys], np.hstack((columns, lens)))
