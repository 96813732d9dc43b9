"""What a preset may say: a frozen table per subject, keys with unit, range and default.

The tables of what stands in the scene are in ``scenes.presets.things``.
"""

import math
from itertools import pairwise
from typing import Annotated, Literal

from pydantic import Field, model_validator

from lod.errors import InputError
from scenes.presets.things import (
    ActingPreset,
    ActorPreset,
    PlacedPreset,
    PlumePreset,
    RepresentationPreset,
    ScriptLine,
    SpeciesName,
    SpeciesPreset,
    TroupePreset,
)
from scenes.presets.values import (
    LARGEST_SEED,
    Cell,
    Depth,
    Extent,
    Height,
    Metres,
    Moment,
    MostMemory,
    MostParts,
    PowerOfTwo,
    Size,
    Table,
    Visibility,
    key,
    parse_crop,
    refuse,
)

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


class ViewPreset(Table):
    """How detail is chosen."""

    metric: Annotated[
        str, key("which member of the metric family decides, see `lodbench list`")
    ] = "blake"
    detail: Annotated[float, key("detail threshold τ [px]", above=0, most=1e6)] = 1.0
    max_parts: MostParts = None
    max_memory: MostMemory = None
    offscreen_detail: Annotated[
        float, key("share of the detail that is kept out of view", above=0, most=1)
    ] = 0.25
    look_around: Annotated[bool, key("count every direction as in view")] = False
    haze_aware: Annotated[bool, key("leave out what the air hides at any size")] = True
    shutter: Annotated[
        float,
        key(
            "angle that is open, of the 360 that a frame lasts [degrees]; 0 = no blur",
            least=0,
            most=360,
        ),
    ] = 0.0
    smear: Annotated[
        Literal["shutter", "window", "off"],
        key("what hides detail of what moves: the shutter, that and the eye, or nothing"),
    ] = "shutter"
    update_threshold: Annotated[
        float,
        key("parts that moved by less are not redrawn [px]; 0 = all are", least=0, most=64),
    ] = 0.0
    fade: Annotated[
        float,
        key("share of its limit distance over which a part shrinks away", least=0, below=1),
    ] = 0.2


class AirPreset(Table):
    """Haze and mist. Koschmieder's 2 %: beta = 3.912/visibility (not the WMO's 5 %)."""

    visibility: Visibility = None
    mist: Visibility = None
    mist_base: Annotated[Height, key("below it mist is even; above the datum, as 20m or -5m")] = 0.0
    mist_scale: Annotated[Depth, key("above its base mist thins e-fold over this, as 50m")] = 50.0
    seeing: Annotated[
        float, key("full width of the blur by turbulence [seconds of arc]", least=0, most=3600)
    ] = 0.0


class DisplayPreset(Table):
    """The screen that the picture is looked at on, pixel for pixel; with this table, an eye."""

    pixels_per_degree: Annotated[
        float, key("pixels per degree of the viewer's sight", least=1, most=1000)
    ] = 67.0
    luminance: Annotated[float, key("mean of the picture [cd/m²]", least=1e-3, most=1e5)] = 100.0
    field_deg: Annotated[
        float, key("side of the square that the picture fills [degrees]", least=1, most=180)
    ] = 53.0


class EyePreset(Table):
    """Whose eye: Barten's standard observer, or another; with this table, in front of a display."""

    blur_arcmin: Annotated[
        float, key("spread of the eye's optics, pupil small [minutes of arc]", above=0, most=60)
    ] = 0.5
    aberration_arcmin: Annotated[
        float, key("growth of that with the pupil [minutes of arc per mm]", least=0, most=10)
    ] = 0.08
    signal_to_noise: Annotated[
        float, key("signal-to-noise ratio at which a pattern is seen", above=0, most=100)
    ] = 3.0
    integration_s: Annotated[float, key("time that light is gathered [s]", above=0, most=10)] = 0.1
    efficiency: Annotated[float, key("share of the photons that count", above=0, most=1)] = 0.03


class LightPreset(Table):
    """Sun and sky."""

    sun_azimuth: Annotated[
        float, key("direction of the sun, clockwise from north [degrees]", least=-360, most=360)
    ] = 230
    sun_elevation: Annotated[
        float, key("height of the sun above the horizon [degrees]", above=0, most=90)
    ] = 35.0
    turbidity: Annotated[float, key("turbidity of the sky", least=1, most=10)] = 3.0


class WorldPreset(Table):
    """How far the field goes, and the time of year."""

    extent: Extent = None
    season: Annotated[
        Literal["spring", "summer", "autumn", "winter"], key("what trees and shrubs look like")
    ] = "summer"


class WindPreset(Table):
    """The wind, which bends trees and carries smoke, flames and dust along."""

    speed: Annotated[
        float, key("speed of the wind at the height of crowns [m/s]; 0 = calm", least=0, most=20)
    ] = 0.0
    direction: Annotated[
        float, key("where it blows to, clockwise from north [degrees]", least=-360, most=360)
    ] = 60.0


class TerrainPreset(Table):
    """The ground: fractal relief about the datum; without this table it is flat."""

    amplitude: Annotated[float, key("RMS relief [m]; 0 = flat", least=0, most=1e4)] = 0.0
    wavelength: Annotated[
        PowerOfTwo, key("longest wavelength [m], a power of two", least=1, most=2**24)
    ] = 1024.0
    hurst: Annotated[float, key("Hurst exponent: 0 rough, 1 smooth", above=0, most=1)] = 0.8
    lacunarity: Annotated[
        float, key("how much shorter each octave's waves are", least=1.5, most=4)
    ] = 2.0
    reach: Annotated[
        float, key("how far from the eye the ground is built [m]", least=16, most=1e7)
    ] = 40_000.0
    finest: Annotated[
        PowerOfTwo, key("finest spacing of the mesh [m], a power of two", least=2**-5, most=1)
    ] = 0.25
    ridged: Annotated[bool, key("whether the relief has crests, as mountains do")] = False
    cover: Annotated[Literal["grassy", "bare", "snowy"], key("what lies on the ground")] = "grassy"


class RenderPreset(Table):
    """How the picture is made."""

    size: Size = (640, 360)
    crop: Annotated[
        str | None,
        key("part that is rendered: WxH+LEFT+TOP in pixels, or each in percent; absent = all"),
    ] = None
    spp: Annotated[int, key("samples per pixel", least=1, most=65536)] = 16
    subframes: Annotated[
        int,
        key("moments that are averaged while the shutter is open; at most spp", least=1, most=4096),
    ] = 16
    max_depth: Annotated[int, key("longest light path, in segments", least=1, most=64)] = 4
    variant: Annotated[str, Field(min_length=1), key("Mitsuba variant, or auto")] = "auto"
    haze: Annotated[
        Literal["analytic", "scattered", "medium"],
        key("airlight of the horizon's sky or as the air scatters it, or a medium (reference)"),
    ] = "analytic"
    spectral: Annotated[bool, key("light of 16 bands, not of three colours (reference)")] = False

    @property
    def window(self) -> tuple[int, ...]:
        """Left, top, right and bottom of what is rendered [px]."""
        return (0, 0, *self.size) if self.crop is None else parse_crop(self.crop, self.size)

    @model_validator(mode="after")
    def _inside(self) -> "RenderPreset":
        try:
            _ = self.window
        except InputError as error:
            raise refuse(error.rule, error.cure, "render.crop") from error
        return self


class OutputPreset(Table):
    """How frames are written, and what is in them beside the usual layers."""

    compression: Annotated[
        Literal["zip", "zips", "piz", "rle", "none"],
        key("how the file is packed, always without loss; only zip and zips notice a flipped bit"),
    ] = "zip"
    multipart: Annotated[bool, key("whether each group of layers is a part of the file")] = False
    colour: Annotated[Literal["half", "float"], key("pixels of colour layers")] = "float"
    motion: Annotated[bool, key("whether there are layers motion.X and motion.Y, in pixels")] = (
        False
    )
    denoise: Annotated[
        bool, key("whether there are layers denoised.R, denoised.G and denoised.B")
    ] = False
    cryptomatte: Annotated[
        bool, key("whether there are layers CryptoObject and CryptoSpecies, and their manifests")
    ] = False


class Preset(Table):
    """A whole scene with its camera and quality, as one TOML file says it."""

    about: Annotated[str, key("one line on what this preset shows")] = ""
    seed: Annotated[
        int, Field(ge=0, le=LARGEST_SEED), key(f"seed of every choice, 0 to {LARGEST_SEED}")
    ] = 0
    camera: CameraPreset = CameraPreset()
    view: ViewPreset = ViewPreset()
    air: AirPreset = AirPreset()
    display: DisplayPreset | None = None
    eye: EyePreset | None = None
    light: LightPreset = LightPreset()
    world: WorldPreset = WorldPreset()
    wind: WindPreset = WindPreset()
    terrain: TerrainPreset = TerrainPreset()
    species: dict[SpeciesName, SpeciesPreset] = Field(default_factory=dict)
    placed: dict[SpeciesName, PlacedPreset] = Field(default_factory=dict)
    plumes: dict[SpeciesName, PlumePreset] = Field(default_factory=dict)
    representations: dict[SpeciesName, RepresentationPreset] = Field(default_factory=dict)
    actors: dict[SpeciesName, ActorPreset] = Field(default_factory=dict)
    troupes: dict[SpeciesName, TroupePreset] = Field(default_factory=dict)
    acting: ActingPreset = ActingPreset()
    script: Annotated[
        tuple[ScriptLine, ...], Field(max_length=10_000), key("messages to the actors, in time")
    ] = ()
    render: RenderPreset = RenderPreset()
    output: OutputPreset = OutputPreset()

    @model_validator(mode="after")
    def _agree(self) -> "Preset":
        """Keys that must agree with each other."""
        from scenes.plugins import metric_by_name  # expensive to import, and mistakes come first

        try:
            metric = metric_by_name(self.view.metric)
        except InputError as error:
            raise refuse(error.rule, error.cure, "view.metric") from error
        if not metric.finite and self.world.extent is None:
            rule = "needs a finite world, and this one is endless"
            raise refuse(rule, "add -D world.extent=1000, or choose blake", "view.metric")
        for name, species in self.species.items():
            if species.dust and species.patrol == 0:
                rule = "only what walks throws up dust"
                raise refuse(rule, "give it a patrol, as patrol = 10.0", f"species.{name}.dust")
        if metric.along_axis and self.view.look_around:
            rule = "needs a view axis, not a full turn"
            raise refuse(rule, "set view.look_around = false", "view.metric")
        if self.camera.stereo and (self.output.multipart or self.output.cryptomatte):
            rule = "both eyes are views of one part, without mattes"
            raise refuse(rule, "leave --multipart and --cryptomatte out", "camera.stereo")
        if self.camera.projection == "panorama":
            if metric.along_axis:
                raise refuse("needs a view axis, not a panorama", "choose blake", "view.metric")
            if self.render.spectral or self.render.haze == "medium":
                rule = "a panorama is rendered in colours, with haze that is analytic or scattered"
                raise refuse(rule, "leave --spectral and --haze out", "camera.projection")
        return self
