"""What a preset says of the camera: where it is, where it looks, its lens, and how it moves."""

import math
from itertools import pairwise
from typing import Annotated, Literal

from pydantic import Field, model_validator

from scenes.preset.values import Cell, Metres, Moment, Table, key, refuse

_THERE = "absent: the camera's"
NEAREST_FOCUS_M, FARTHEST_FOCUS_M = 0.1, 1e7

FocusDistance = Annotated[float, Field(ge=NEAREST_FOCUS_M, le=FARTHEST_FOCUS_M)]
FStop = Annotated[float, Field(gt=0, le=1000)]


class CameraKey(Table):
    """Where the camera is in one frame of a flight, and what it faces."""

    frame: Annotated[int, key("frame number", least=1, most=10**6)]
    position: Annotated[
        tuple[Metres, Metres], key("where the eye is: (x, y) from the cell's corner [m]")
    ]
    height: Annotated[float, key("height of the eye above the ground [m]", above=0, most=1e6)]
    target: Annotated[
        tuple[Metres, Metres, Metres],
        key("what it faces: (x, y) from the cell's corner, and height above the ground there [m]"),
    ]
    fov: Annotated[
        Annotated[float, Field(gt=0, lt=180)] | None,
        key(f"full horizontal field of view there [degrees], above 0 and below 180; {_THERE}"),
    ] = None
    roll: Annotated[
        Annotated[float, Field(ge=-360, le=360)] | None,
        key(f"turn about the line of sight there [degrees], within ±360; {_THERE}"),
    ] = None
    f_stop: Annotated[FStop | None, key(f"f-number there, above 0, at most 1000; {_THERE}")] = None
    focus: Annotated[
        FocusDistance | None,
        key(
            f"distance in focus there [m], {NEAREST_FOCUS_M:g} to 1e7; "
            "absent: the camera's, else the target's"
        ),
    ] = None


class CameraPreset(Table):
    """Where the eye is, where it looks, and how it moves from frame to frame."""

    position: Annotated[
        tuple[Metres, Metres],
        key("where the eye is in frame 1: (x, y) from the cell's corner [m], each within ±1e15"),
    ] = (0.0, 0.0)
    cell: Annotated[
        tuple[Cell, Cell], key("where the cell is: (x, y) in squares of 16 m, within ±2**55")
    ] = (
        0,
        0,
    )
    height: Annotated[float, key("height of the eye above the ground [m]", above=0, most=1e6)] = 1.7
    heading: Annotated[
        float, key("direction of view, clockwise from north [degrees]", least=-360, most=360)
    ] = 0.0
    pitch: Annotated[
        float, key("direction of view, above the horizon [degrees]", least=-90, most=90)
    ] = 0.0
    fov: Annotated[float, key("full horizontal field of view [degrees]", above=0, below=180)] = 60.0
    focal_length: Annotated[
        float | None,
        key("focal length of the lens [mm]; it decides instead of fov", above=0, most=1e5),
    ] = None
    sensor_width: Annotated[
        float, key("width of the picture on the sensor [mm]", above=0, most=1e4)
    ] = 36.0
    projection: Annotated[
        Literal["perspective", "panorama"],
        key("a plane picture, or all round: equirectangular, the heading in its middle"),
    ] = "perspective"
    roll: Annotated[
        float, key("turn about the line of sight, clockwise [degrees]", least=-360, most=360)
    ] = 0.0
    f_stop: Annotated[
        FStop | None,
        key("f-number of the lens, above 0, at most 1000; absent = everything is sharp"),
    ] = None
    focus: Annotated[
        FocusDistance | tuple[Metres, Metres, Metres] | None,
        key(
            f"distance in focus along the line of sight [m], {NEAREST_FOCUS_M:g} to 1e7, or a "
            "point (x, y, height above the ground there); absent: a flight's target, else far"
        ),
    ] = None
    stereo: Annotated[
        float | None,
        key("distance of two eyes [m], as 0.065; absent = one eye", above=0, most=1000),
    ] = None
    speed: Annotated[
        float, key("speed of the eye along the heading [m/s]; 0 = still", least=-1e6, most=1e6)
    ] = 0.0
    turn: Annotated[
        float, key("turn of the view, clockwise [degrees/s]; 0 = none", least=-1e5, most=1e5)
    ] = 0.0
    fps: Annotated[float, key("frames per second", above=0, most=1000)] = 24.0
    date: Moment = None
    behaviour: Annotated[
        str, key("what it does by itself, see `lodbench list`; absent = it keeps to its path")
    ] = ""
    options: Annotated[
        dict[str, bool | int | float | str], key("options that the behaviour documents")
    ] = Field(default_factory=dict)
    keys: Annotated[
        tuple[CameraKey, ...],
        Field(max_length=1000),
        key("a flight in place of the walk: 2 or more, in the order of their frames"),
    ] = ()

    @property
    def fov_x_deg(self) -> float:
        """Full horizontal field of view, of the lens where there is one [degrees]."""
        if self.focal_length is None:
            return self.fov
        return 2 * math.degrees(math.atan2(self.sensor_width, 2 * self.focal_length))

    def aperture_m(self, fov_x_deg: float, f_stop: float) -> float:
        """Diameter of the lens's opening at a field of view: its focal length over f_stop [m]."""
        focal_mm = self.sensor_width / (2 * math.tan(math.radians(fov_x_deg) / 2))
        return focal_mm / 1000 / f_stop

    @model_validator(mode="after")
    def _all_round(self) -> "CameraPreset":
        lenses = [self.f_stop, *(each.f_stop for each in self.keys)]
        if self.projection == "panorama" and any(lenses):
            raise refuse("a panorama has no lens", "leave f_stop out", "camera.projection")
        if self.projection == "panorama" and self.stereo:
            raise refuse("a panorama has one eye", "leave stereo out", "camera.projection")
        return self

    @model_validator(mode="after")
    def _in_focus(self) -> "CameraPreset":
        stopped = [each.f_stop is not None for each in self.keys]
        if self.f_stop is None and any(stopped) and not all(stopped):
            rule = "either every key has an f-number or the camera has one for all"
            raise refuse(rule, "add -D camera.f_stop=8", "camera.keys")
        focused = [each.focus is not None for each in self.keys]
        if any(focused) and not all(focused) and not isinstance(self.focus, float):
            rule = "either every key has a focus, or none, or the camera has a distance for all"
            raise refuse(rule, "give every key one", "camera.keys")
        return self

    @model_validator(mode="after")
    def _in_order(self) -> "CameraPreset":
        frames = [each.frame for each in self.keys]
        if len(frames) == 1:
            raise refuse("a flight has 2 keys or more", "add one, or leave it out", "camera.keys")
        for a, b in pairwise(frames):
            if a >= b:
                rule = f"keys stand in the order of their frames: {b} comes after {a}"
                raise refuse(rule, "give every key a frame after the last one's", "camera.keys")
        return self
