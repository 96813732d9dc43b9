"""What a frame's header says: the camera, the time, the software, and every setting.

Settings are what determines a frame's pixels, as plain data: they travel to other processes and
machines, stand in every header as attributes of OpenEXR, typed where it has the type, are read back
without loss, and make the same frame again.
"""

import json
import math
from collections.abc import Mapping
from fractions import Fraction
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from typing import Any

import numpy as np

from lod.camera import Camera
from lod.errors import InputError
from scenes.presets.load import MODEL_TABLES, preset_from
from scenes.presets.schema import Preset

_LEAST, _MOST = -(2**31), 2**31 - 1


def to_attribute(value: Any) -> Any:
    """Turn plain data into what OpenEXR writes, and from_attribute reads back the same.

    A whole number within 32 bits becomes an ``int``, a float a ``double``, two or three of either
    ``v2i``, ``v3i``, ``v2d`` or ``v3d``. Text stays text, unless it could be read as JSON. All else
    (true, null, longer lists and larger whole numbers) becomes text in JSON.
    """
    if isinstance(value, str):
        return value if _from_json(value) is _NOT_JSON else json.dumps(value)
    if type(value) is int and _LEAST <= value <= _MOST:
        return value
    if isinstance(value, float):
        return np.array([value])
    if isinstance(value, list | tuple) and len(value) in (2, 3):
        if all(type(each) is int and _LEAST <= each <= _MOST for each in value):
            return np.array(value, np.int32)
        if all(isinstance(each, float) for each in value):
            return np.array(value, np.float64)
    return json.dumps(value, sort_keys=True)


def from_attribute(value: Any) -> Any:
    """Turn what OpenEXR read back into plain data."""
    if isinstance(value, np.ndarray):
        return value.item() if value.size == 1 else value.tolist()
    found = _from_json(value) if isinstance(value, str) else value
    return value if found is _NOT_JSON else found


def flatten_attributes(table: Mapping[str, Any], prefix: str) -> dict[str, Any]:
    """Make attributes of nested tables, by dotted keys; an empty table is a key of its own."""
    found: dict[str, Any] = {}
    for key, value in table.items():
        if isinstance(value, Mapping) and value:
            found |= flatten_attributes(value, f"{prefix}{key}.")
        else:
            found[f"{prefix}{key}"] = to_attribute(value)
    return found


def nest_attributes(header: Mapping[str, Any], prefix: str) -> dict[str, Any]:
    """Make nested tables of the attributes whose names begin with a prefix."""
    tables: dict[str, Any] = {}
    for name in sorted(name for name in header if name.startswith(prefix)):
        *above, key = name.removeprefix(prefix).split(".")
        inner = tables
        for each in above:
            table = inner.get(each)  # no table where a name is damaged
            inner[each] = inner = table if isinstance(table, dict) else {}
        inner[key] = from_attribute(header[name])
    return tables


_NOT_JSON = object()


def _from_json(text: str) -> Any:
    try:
        return json.loads(text)
    except (ValueError, RecursionError):
        return _NOT_JSON


PREFIX = "lod:"
FRAME = f"{PREFIX}frame"
VIEWS = ["left", "right"]  # the eyes of a pair; a plain reader sees the first

_PRESET = f"{PREFIX}preset."
"""Before every key of a preset, which so shares no name with what the camera is in this frame."""


def frame_header(
    camera: Camera, fps: float, settings: Mapping[str, Any], frame: int
) -> dict[str, Any]:
    """Make the attributes for write_exr: only what determines the pixels, so that hashes repeat.

    worldToCamera and worldToNDC (4, 4) are for row vectors, as OpenEXR documents them: camera x
    right, y up, looking along +z; the picture from (0, 0), upper left, to (1, 1). The world's
    origin is the grid corner ``lod:corner``, and so is that of ``lod:eye`` [m]. Of a pair they are
    the left eye's, and the right one is ``lod:baseline_m`` to its right. settings: of
    ``frame_settings``, or any nested plain data; settings_in reads them back.
    """
    about: dict[str, Any] = {}
    attributes: dict[str, Any] = {}
    if camera.baseline_m:
        attributes["multiView"] = VIEWS
        about["baseline_m"] = camera.baseline_m
        camera = camera.pair[0]
    about |= {
        "corner": (camera.corner.x, camera.corner.y),
        "eye": tuple(camera.eye.tolist()),
        "fov_x_deg": math.degrees(camera.fov_x),
    }
    left_handed = np.diag((1.0, 1.0, -1.0, 1.0)) @ camera_from_world(camera)  # +z ahead
    attributes["worldToCamera"] = np.ascontiguousarray(left_handed.T, np.float32)
    if camera.panorama:  # an environment map in latitude and longitude
        attributes["envmap"] = "latlong"
    else:
        x, y = camera.tan_half  # what z becomes is of no meaning
        picture = [[0.5 / x, 0, 0.5, 0], [0, -0.5 / y, 0.5, 0], [0, 0, 0, 1], [0, 0, 1, 0]]
        from_world = np.array(picture) @ left_handed
        attributes["worldToNDC"] = np.ascontiguousarray(from_world.T, np.float32)
        attributes["screenWindowWidth"] = float(np.float32(2 * x))
    if camera.lens:
        attributes["focus"] = float(np.float32(camera.lens.focus_m))
        about["aperture_m"] = camera.lens.diameter_m
    return {
        **attributes,
        "framesPerSecond": Fraction(fps).limit_denominator(100_000),
        **_time_code(fps, frame),
        **flatten_attributes(about, PREFIX),
        **settings_attributes(settings, frame),
    }


def picture_windows(size: tuple[int, int], window: tuple[int, ...]) -> dict[str, Any]:
    """Make OpenEXR's display and data window: the whole picture, and what of it is in the file.

    ``window`` is left, top, right and bottom [px]. Of a whole picture there are none: the file's
    own size says it.
    """
    left, top, right, bottom = window
    if window == (0, 0, *size):
        return {}
    corners = {
        "displayWindow": ((0, 0), (size[0] - 1, size[1] - 1)),
        "dataWindow": ((left, top), (right - 1, bottom - 1)),
    }
    return {
        name: tuple(np.array(corner, np.int32) for corner in each) for name, each in corners.items()
    }


def _time_code(fps: float, frame: int) -> dict[str, Any]:
    """``timeCode`` as (hours, minutes, seconds, frames).

    It counts from frame 1 in whole frames a second (24 at 23.976) and wraps after 24 hours; there
    is none above 30 a second, or where the rate is no whole number or 1000/1001 of one.
    """
    rate, count = round(fps), frame - 1
    is_whole = min(abs(fps - rate), abs(fps * 1.001 - rate)) < 1e-3
    if not (is_whole and 1 <= rate <= 30 and count >= 0):
        return {}
    seconds = count // rate
    return {"timeCode": (seconds // 3600 % 24, seconds // 60 % 60, seconds % 60, count % rate)}


def settings_attributes(settings: Mapping[str, Any], frame: int) -> dict[str, Any]:
    """Make the attributes that say what a frame was made with, and which frame it is."""
    preset = {key: value for key, value in settings.items() if key != "software"}
    made_by = settings.get("software", software())
    return {FRAME: frame, "software": made_by, **flatten_attributes(preset, _PRESET)}


def settings_in(header: Mapping[str, Any]) -> dict[str, Any]:
    """Read the settings that settings_attributes was given: the same, and so is their hash."""
    return {**nest_attributes(header, _PRESET), "software": header.get("software")}


def camera_from_world(camera: Camera) -> np.ndarray:
    """Matrix (4, 4), for column vectors, from the frame's corner to the camera's axes: −z ahead."""
    axes = np.stack((camera.right, camera.up, -camera.forward))
    matrix = np.eye(4)
    matrix[:3, :3] = axes
    matrix[:3, 3] = -axes @ camera.eye
    return matrix


@cache
def software() -> str:
    """Name and versions of what makes the pixels."""
    found = []
    for package in ("lodbench", "mitsuba"):
        try:
            found.append(version(package))
        except PackageNotFoundError:
            found.append("source")
    return "lodbench {} (Mitsuba {})".format(*found)


Settings = Mapping[str, Any]
"""A preset as plain data, with the software that renders it (``frame_settings``)."""

_BESIDE = ("software", "track")  # what settings hold beside a preset

Record = dict[str, Any]
"""What is known of a rendered frame, as plain data (``FrameSession.render``)."""


def frame_settings(preset: Preset, variant: str, track: str | None = None) -> dict[str, Any]:
    """Collect everything that determines the pixels: preset, variant in place of auto, software.

    track  hash of the pose track by which its actors stand; None where nobody acts
    """
    settings = preset.model_dump(mode="json", exclude={"about"})
    settings["render"]["variant"] = variant
    for table in (each for kind in MODEL_TABLES for each in settings[kind].values()):
        if table["model_sha256"] is None:  # it is one of the program's own
            del table["model_sha256"]
    acts = {} if track is None else {"track": track}
    return {**settings, **acts, "software": software()}


def preset_from_settings(settings: Settings) -> Preset:
    """Check the preset that settings hold. Raises InputError for what no preset can be, which names
    the version that wrote it where that is another.
    """
    tables = {name: each for name, each in settings.items() if name not in _BESIDE}
    try:
        return preset_from(tables, source="settings")
    except InputError as error:
        if (made := settings.get("software")) == software():
            raise
        rule = f"settings of {software()} ({error.where}: {error.rule})"
        raise InputError("frame", made, rule, "render it again") from None
