"""What a preset may say: a frozen table per subject, keys with unit, range and default."""

import math
import re
from itertools import pairwise
from typing import Annotated, Any, Literal

from pydantic import AfterValidator, Field, field_validator, model_validator
from pydantic_core import PydanticCustomError

from lod.errors import InputError
from scenes.model_files import is_model_file, model_names
from scenes.presets.values import (
    LARGEST_SEED,
    Cell,
    Extent,
    Metres,
    MostParts,
    PowerOfTwo,
    Size,
    SizeFactor,
    Table,
    Visibility,
    key,
    parse_crop,
    refuse,
)

SpeciesName = Annotated[str, Field(pattern=r"^[A-Za-z][A-Za-z0-9_-]*$", max_length=64)]


def _known_model(name: str, info: Any) -> str:
    known = model_names()
    if name not in known and not is_model_file(name) and not info.data.get("model_sha256"):
        expected = f"{', '.join(map(repr, known[:-1]))} or {known[-1]!r}"
        raise PydanticCustomError("literal_error", "one of {expected}", {"expected": expected})
    return name


def _sha256(text: str | None) -> str | None:
    if text is not None and not re.fullmatch(r"[0-9a-f]{64}", text):
        raise refuse("64 hexadecimal digits", "`lodbench model show` tells them")
    return text


Model = Annotated[
    str, AfterValidator(_known_model), key("what each object is: a model, or a file beside this")
]
"""The name of a model (``scenes.model_files``), or of a scene file."""


class ModelTable(Table):
    """What a table says that places objects: what they are."""

    model_sha256: Annotated[str | None, AfterValidator(_sha256)] = key(
        "hash that an imported model must have, as `model show` tells it", None
    )
    model: Model


class SpeciesPreset(ModelTable):
    """One Poisson field of objects."""

    density: float = key("objects per unit ground area [1/m²]", least=0, most=100)
    prototypes: int = key("different objects of this model", 1, least=1, most=256)
    sizes: Annotated[tuple[SizeFactor, ...], Field(min_length=1, max_length=64)] = key(
        "size factors, 1 to 64 of them, equally likely, each from 0.001 to 1000", (1.0,)
    )
    metric: Literal["blake", "bounded", "solid_angle"] | None = key(
        "metric that decides for this species; absent: view.metric, as with full and depth", None
    )
    patrol: float = key(
        "radius of the round that each one walks [m]; 0 = stays at home", 0.0, least=0, most=1000
    )
    dust: bool = key("whether feet throw up dust; only for what has a patrol", False)
    highest: float | None = key(
        "height above the datum where none grows [m]", None, least=-1e5, most=1e5
    )
    thinning: float = key(
        "how far below `highest` it begins to thin out [m]", 100.0, least=1, most=1e5
    )
    steepest: float | None = key(
        "tangent of the slope where none stands", None, least=0.01, most=100
    )


class StandingTable(ModelTable):
    """What a table says of one object: what it is, where it stands, and what it faces."""

    position: tuple[Metres, Metres] = key(
        "where it stands, or begins: (x, y) from the plane's origin [m]"
    )
    heading: float = key("what it faces, clockwise from north [degrees]", 0.0, least=-360, most=360)
    prototype: int = key("which of the model's objects, from 1", 1, least=1, most=256)
    size: SizeFactor = key("size factor", 1.0)


class PlacedPreset(StandingTable):
    """One object, put where the picture wants it."""

    walks: bool = key("whether it walks on the spot", False)


class PlumePreset(Table):
    """Smoke or flames rising from the ground."""

    kind: Literal["smoke", "flames"] = key("what rises")
    position: tuple[Metres, Metres] = key("where it stands: (x, y) from the plane's origin [m]")
    size: SizeFactor = key("size factor", 1.0)
    wind: float | None = key(
        "where it is blown to, clockwise from north [degrees]; absent: wind.direction",
        None,
        least=-360,
        most=360,
    )


class RepresentationPreset(Table):
    """What an installed package makes (scenes.plugins)."""

    kind: str = key("which of those that are installed, see `lodbench list`")
    options: dict[str, bool | int | float | str] = key("options that its package documents", {})


Options = Annotated[
    dict[str, bool | int | float | str], key("options that the behaviour documents")
]
BehaviourName = Annotated[
    str, key("what it does by itself, see `lodbench list`; absent = only what messages say")
]


class ActorPreset(StandingTable):
    """One live actor."""

    behaviour: BehaviourName = ""
    options: Options = Field(default_factory=dict)


class TroupePreset(ModelTable):
    """Several live actors of a kind, NAME_1 to NAME_n, spread over a square without overlapping."""

    count: int = key("how many", least=1, most=100_000)
    centre: tuple[Metres, Metres] = key(
        "middle of the square: (x, y) from the plane's origin [m]", (0.0, 0.0)
    )
    side: float = key("side of the square [m]", 40.0, above=0, most=1e6)
    prototypes: int = key("different objects of this model", 1, least=1, most=256)
    behaviour: BehaviourName = ""
    options: Options = Field(default_factory=dict)


class ScriptLine(Table):
    """A message, sent at a time."""

    at: float = key("when it begins, frame 1 is at 0 [s]", 0.0, least=0, most=1e6)
    to: str = key("who, and the route to the part, as joe right leg/lower leg/foot")
    do: str = key("what is asked for, as orient y 40deg")
    over: float = key("how long it takes [s]; 0 = at once", 0.0, least=0, most=1e6)
    ease: Literal["linear", "smooth"] = key("how it goes on meanwhile", "smooth")


class ActingPreset(Table):
    """How long the actors act, and who may wait for an update."""

    frames: int = key("frames in which they act", 96, least=1, most=10**6)
    threshold: float = key(
        "an actor that is off by less may coast [px]; 0 = all are updated", 0.0, least=0, most=64
    )
    budget: Annotated[int, Field(ge=1, le=10**6)] | None = key(
        "updates in a frame at most, 1 to 1e6; absent = as many as are due", None
    )


_THERE = "absent: the camera's"
NEAREST_FOCUS_M, FARTHEST_FOCUS_M = 0.1, 1e7

FocusDistance = Annotated[float, Field(ge=NEAREST_FOCUS_M, le=FARTHEST_FOCUS_M)]
FStop = Annotated[float, Field(gt=0, le=1000)]


class CameraKey(Table):
    """Where the camera is in one frame of a flight, and what it faces."""

    frame: int = key("frame number", least=1, most=10**6)
    position: tuple[Metres, Metres] = key("where the eye is: (x, y) from the cell's corner [m]")
    height: float = key("height of the eye above the ground [m]", above=0, most=1e6)
    target: tuple[Metres, Metres, Metres] = key(
        "what it faces: (x, y) from the cell's corner, and height above the ground there [m]"
    )
    fov: Annotated[float, Field(gt=0, lt=180)] | None = key(
        f"full horizontal field of view there [degrees], above 0 and below 180; {_THERE}", None
    )
    roll: Annotated[float, Field(ge=-360, le=360)] | None = key(
        f"turn about the line of sight there [degrees], within ±360; {_THERE}", None
    )
    f_stop: FStop | None = key(f"f-number there, above 0, at most 1000; {_THERE}", None)
    focus: FocusDistance | None = key(
        f"distance in focus there [m], {NEAREST_FOCUS_M:g} to 1e7; "
        "absent: the camera's, else the target's",
        None,
    )


class CameraPreset(Table):
    """Where the eye is, where it looks, and how it moves from frame to frame."""

    position: tuple[Metres, Metres] = key(
        "where the eye is in frame 1: (x, y) from the cell's corner [m], each within ±1e15",
        (0.0, 0.0),
    )
    cell: tuple[Cell, Cell] = key(
        "where the cell is: (x, y) in squares of 16 m, within ±2**55",
        (0, 0),
    )
    height: float = key("height of the eye above the ground [m]", 1.7, above=0, most=1e6)
    heading: float = key(
        "direction of view, clockwise from north [degrees]", 0.0, least=-360, most=360
    )
    pitch: float = key("direction of view, above the horizon [degrees]", 0.0, least=-90, most=90)
    fov: float = key("full horizontal field of view [degrees]", 60.0, above=0, below=180)
    focal_length: float | None = key(
        "focal length of the lens [mm]; it decides instead of fov", None, above=0, most=1e5
    )
    sensor_width: float = key("width of the picture on the sensor [mm]", 36.0, above=0, most=1e4)
    projection: Literal["perspective", "panorama"] = key(
        "a plane picture, or all round: equirectangular, the heading in its middle", "perspective"
    )
    roll: float = key(
        "turn about the line of sight, clockwise [degrees]", 0.0, least=-360, most=360
    )
    f_stop: FStop | None = key(
        "f-number of the lens, above 0, at most 1000; absent = everything is sharp", None
    )
    focus: FocusDistance | tuple[Metres, Metres, Metres] | None = key(
        f"distance in focus along the line of sight [m], {NEAREST_FOCUS_M:g} to 1e7, or a "
        "point (x, y, height above the ground there); absent: a flight's target, else far",
        None,
    )
    stereo: float | None = key(
        "distance of two eyes [m], as 0.065; absent = one eye", None, above=0, most=1000
    )
    speed: float = key(
        "speed of the eye along the heading [m/s]; 0 = still", 0.0, least=-1e6, most=1e6
    )
    turn: float = key(
        "turn of the view, clockwise [degrees/s]; 0 = none", 0.0, least=-1e5, most=1e5
    )
    fps: float = key("frames per second", 24.0, above=0, most=1000)
    behaviour: str = key(
        "what it does by itself, see `lodbench list`; absent = it keeps to its path", ""
    )
    options: dict[str, bool | int | float | str] = key("options that the behaviour documents", {})
    keys: Annotated[tuple[CameraKey, ...], Field(max_length=1000)] = key(
        "a flight in place of the walk: 2 or more, in the order of their frames", ()
    )

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

    metric: str = key("which member of the metric family decides, see `lodbench list`", "blake")
    detail: float = key("detail threshold τ [px]", 1.0, above=0, most=1e6)
    max_parts: MostParts = None
    offscreen_detail: float = key(
        "share of the detail that is kept out of view", 0.25, above=0, most=1
    )
    look_around: bool = key("count every direction as in view", False)
    haze_aware: bool = key("leave out what the air hides at any size", True)
    shutter: float = key(
        "angle that is open, of the 360 that a frame lasts [degrees]; 0 = no blur",
        0.0,
        least=0,
        most=360,
    )
    smear: Literal["shutter", "window", "off"] = key(
        "what hides detail of what moves: the shutter, that and the eye, or nothing", "shutter"
    )
    update_threshold: float = key(
        "parts that moved by less are not redrawn [px]; 0 = all are", 0.0, least=0, most=64
    )
    fade: float = key(
        "share of its limit distance over which a part shrinks away", 0.2, least=0, below=1
    )
    reach: float | None = key(
        "how far from the eye things are displayed [m]; absent = as far as the metric says",
        None,
        above=0,
        most=1e7,
    )
    copies: float = key(
        "still things that subtend so many times the detail are copies of whole models; 0 = none",
        0.0,
        least=0,
        most=1e6,
    )


class AirPreset(Table):
    """Haze. Koschmieder's 2 %: beta = 3.912/visibility (not the WMO's 5 %)."""

    visibility: Visibility = None
    seeing: float = key(
        "full width of the blur by turbulence [seconds of arc]", 0.0, least=0, most=3600
    )


class DisplayPreset(Table):
    """The screen that the picture is looked at on, pixel for pixel; with this table, an eye."""

    pixels_per_degree: float = key(
        "pixels per degree of the viewer's sight", 67.0, least=1, most=1000
    )
    luminance: float = key("mean of the picture [cd/m²]", 100.0, least=1e-3, most=1e5)
    field_deg: float = key(
        "side of the square that the picture fills [degrees]", 53.0, least=1, most=180
    )


class EyePreset(Table):
    """Whose eye: Barten's standard observer, or another; with this table, in front of a display."""

    blur_arcmin: float = key(
        "spread of the eye's optics, pupil small [minutes of arc]", 0.5, above=0, most=60
    )
    aberration_arcmin: float = key(
        "growth of that with the pupil [minutes of arc per mm]", 0.08, least=0, most=10
    )
    signal_to_noise: float = key(
        "signal-to-noise ratio at which a pattern is seen", 3.0, above=0, most=100
    )
    integration_s: float = key("time that light is gathered [s]", 0.1, above=0, most=10)
    efficiency: float = key("share of the photons that count", 0.03, above=0, most=1)


class LightPreset(Table):
    """Sun and sky."""

    sun_azimuth: float = key(
        "direction of the sun, clockwise from north [degrees]", 230, least=-360, most=360
    )
    sun_elevation: float = key(
        "height of the sun above the horizon [degrees]", 35.0, above=0, most=90
    )
    turbidity: float = key("turbidity of the sky", 3.0, least=1, most=10)


class WorldPreset(Table):
    """How far the field goes, and the time of year."""

    extent: Extent = None
    season: Literal["spring", "summer", "autumn", "winter"] = key(
        "what trees and shrubs look like", "summer"
    )


class WindPreset(Table):
    """The wind, which bends trees and carries smoke, flames and dust along."""

    speed: float = key(
        "speed of the wind at the height of crowns [m/s]; 0 = calm", 0.0, least=0, most=20
    )
    direction: float = key(
        "where it blows to, clockwise from north [degrees]", 60.0, least=-360, most=360
    )


class TerrainPreset(Table):
    """The ground: fractal relief about the datum; without this table it is flat."""

    amplitude: float = key("RMS relief [m]; 0 = flat", 0.0, least=0, most=1e4)
    wavelength: Annotated[
        PowerOfTwo, key("longest wavelength [m], a power of two", least=1, most=2**24)
    ] = 1024.0
    hurst: float = key("Hurst exponent: 0 rough, 1 smooth", 0.8, above=0, most=1)
    reach: float = key("how far from the eye the ground is built [m]", 40_000.0, least=16, most=1e7)
    finest: Annotated[
        PowerOfTwo, key("finest spacing of the mesh [m], a power of two", least=2**-5, most=1)
    ] = 0.25
    detail: float = key("τ of the ground in view, as a share of view.detail", 1.0, above=0, most=1)
    ridged: bool = key("whether the relief has crests, as mountains do", False)
    cover: Literal["grassy", "trodden", "bare", "snowy"] = key("what lies on the ground", "grassy")


class RenderPreset(Table):
    """How the picture is made."""

    size: Size = (640, 360)
    crop: str | None = key(
        "part that is rendered: WxH+LEFT+TOP in pixels, or each in percent; absent = all", None
    )
    spp: int = key("samples per pixel", 16, least=1, most=65536)
    subframes: int = key(
        "moments that are averaged while the shutter is open; at most spp", 16, least=1, most=4096
    )
    max_depth: int = key("longest light path, in segments", 4, least=1, most=64)
    variant: Annotated[str, Field(min_length=1)] = key("Mitsuba variant, or auto", "auto")
    haze: Literal["analytic", "medium"] = key(
        "airlight of the horizon's sky, or a medium that scatters light (reference)", "analytic"
    )
    spectral: bool = key("light of 16 bands, not of three colours (reference)", False)

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

    compression: Literal["zip", "zips", "piz", "rle", "none"] = key(
        "how the file is packed, always without loss; only zip and zips notice a flipped bit", "zip"
    )
    multipart: bool = key("whether each group of layers is a part of the file", False)
    colour: Literal["half", "float"] = key("pixels of colour layers", "float")
    motion: bool = key("whether there are layers motion.X and motion.Y, in pixels", False)
    denoise: bool = key("whether there are layers denoised.R, denoised.G and denoised.B", False)
    cryptomatte: bool = key(
        "whether there are layers CryptoObject and CryptoSpecies, and their manifests", False
    )


class Preset(Table):
    """A whole scene with its camera and quality, as one TOML file says it.

    What has names that the user chose is in the order of these: species get their ids in that
    order, and it is no part of a settings hash, for which there must be one frame.
    """

    about: str = key("one line on what this preset shows", "")
    seed: Annotated[int, Field(ge=0, le=LARGEST_SEED)] = key(
        f"seed of every choice, 0 to {LARGEST_SEED}", 0
    )
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
    script: Annotated[tuple[ScriptLine, ...], Field(max_length=10_000)] = key(
        "messages to the actors, in time", ()
    )
    render: RenderPreset = RenderPreset()
    output: OutputPreset = OutputPreset()

    @field_validator("species", "placed", "plumes", "representations", "actors", "troupes")
    @classmethod
    def _by_name(cls, tables: dict[str, Any]) -> dict[str, Any]:
        return dict(sorted(tables.items()))

    @model_validator(mode="after")
    def _agree(self) -> "Preset":
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
                rule = "a panorama is rendered in colours, with analytic haze"
                raise refuse(rule, "leave --spectral and --haze out", "camera.projection")
        return self
