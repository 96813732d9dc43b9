"""What a frame's header says: the camera, the frame rate, the software, and every setting."""

import math
from collections.abc import Mapping
from fractions import Fraction
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from typing import Any

import numpy as np

from lod.camera import Camera
from lod.errors import InputError

PREFIX = "lod:"


def frame_header(camera: Camera, fps: float, settings: Mapping[str, Any]) -> dict[str, Any]:
    """Make the attributes for write_exr: only what determines the pixels, so that hashes repeat.

    worldToCamera (4, 4), for row vectors: camera x right, y up, looking along −z; the world's
    origin is the grid corner ``lod:corner``. Settings are text: integers would wrap at 32 bits.
    """
    if not (math.isfinite(fps) and 0 < fps <= 1e6):
        raise InputError("camera.fps", fps, "above 0 frames a second", "try 24")
    corner = f"{camera.corner.x},{camera.corner.y}"
    return {
        "worldToCamera": np.ascontiguousarray(camera_from_world(camera).T, np.float32),
        "framesPerSecond": Fraction(fps).limit_denominator(100_000),
        "software": software(),
        f"{PREFIX}corner": corner,
        f"{PREFIX}eye": ",".join(repr(float(x)) for x in camera.eye),
        f"{PREFIX}fov_x_deg": repr(math.degrees(camera.fov_x)),
        **{f"{PREFIX}{key}": str(value) for key, value in sorted(settings.items())},
    }


def camera_from_world(camera: Camera) -> np.ndarray:
    """Matrix (4, 4), for column vectors, from the frame's corner to the camera's axes."""
    axes = np.stack((camera.right, camera.up, -camera.forward))
    matrix = np.eye(4)
    matrix[:3, :3] = axes
    matrix[:3, 3] = -axes @ camera.eye
    return matrix


@cache
def software() -> str:
    """Name and versions of what makes the pixels."""
    return f"lodbench {_version('lodbench')} (Mitsuba {_version('mitsuba')})"


def _version(package: str) -> str:
    try:
        return version(package)
    except PackageNotFoundError:
        return "source"
