"""Presets in a window, pruned and unpruned: luminance and coverage by distance to 5 km (§2.4).

The eye stands at the window's southern edge, so that everything it sees as far as the last band is
inside; in ``aerial`` it is lower than in the preset, because the window that can be held unpruned
is smaller. Bands begin where all fields have ground in the picture: nearer there are crowns alone,
and no ground could carry their colour. The looks ``far_…`` see a window from 1 to 5 km away, where
at one pixel most of what stands there is far cover: small pieces of a picture as wide as the
others, from so high that what stands in the window hides little of it. In the whole picture every
leaf in view is displayed. A pixel is ``fine`` × ``fine`` rays, each with a distance of its own: of
a pixel that is half tree and half sky, half counts.

Coordinates are about the middle of the window, because the renderer begins a ray beside the surface
that it leaves, by a share of the distance from the origin: 0.4 m at 5 km. With the eye for an
origin the leaves there would hardly shade one another, and come out 15 % too bright.

Mean luminance in bands of distance is compared with that of the unpruned scene: pruned to one
pixel and to twelve, with and without the far cover, which leaves on the land the colour of what
lies beyond the limit. Every field is another seed, and each picture's bands are by its own
distances. In the preset's air the land's own share of the light is summed as well: light in clear
air times the air's transmittance, ray by ray. A tree that is pruned has its gaps elsewhere: along
the rays that have a band in the whole picture some would meet the sky.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from functools import partial

import numpy as np

from bench.experiment import Case
from bench.images.differences import coverage_ratio, luminance_ratio
from bench.records.records import Column, Point, columns
from bench.seeds import first_seed
from bench.statistics.estimates import Estimate
from lod.air import CLEAR, Air, rgb_extinction
from lod.camera import Corner
from lod.motion import eye_relative_to
from lod.pruner import Representation, prune
from lod.view import View
from scenes.frame.frame_input import DisplayedRepresentation, FrameInput, display
from scenes.frame.layers import Layers
from scenes.presets.load import load_preset
from scenes.presets.schema import Preset
from scenes.render.render import build_frame, move_camera, trace
from scenes.render.variants import choose
from scenes.scene import Scene, frame_quality
from scenes.sticks.prototype import LUMINANCE

WIDTH_PX, FOV_DEG = 160, 60.0
"""The width of a whole picture, in pixels and as an angle: pieces have pixels of the same angle."""

WHOLE_DETAIL, GROUND_DETAIL, LEAF_M = 0.02, 0.5, 250.0
"""Detail of species and of the ground in the whole picture [px]: every leaf is displayed.

That of species is finer by as much as the land is farther away than LEAF_M.
"""

OFFSCREEN_PX = 0.5  # detail of what is out of view in the whole picture [px]


@dataclass(frozen=True)
class Outlook:
    """One preset as it is looked at.

    side_m    side of the window [m]
    eye_at    (x, y) of the eye from the middle of the window, as a share of its side
    edges_m   edges of the bands of distance [m]
    more      settings of the preset
    details   values of τ, in pixels of the picture
    size_px   width and height of the picture
    fine      rays along each side of a pixel: rendered pixels are rays
    """

    preset: str
    side_m: float
    eye_at: tuple[float, float]
    edges_m: tuple[float, ...]
    more: tuple[str, ...] = ()
    details: tuple[float, ...] = (1.0, 12.0)
    size_px: tuple[int, int] = (WIDTH_PX, 90)
    fine: int = 4

    def settings(self) -> tuple[str, ...]:
        """The outlook as settings of the preset."""
        x, y = (self.side_m * share for share in self.eye_at)
        return (
            f"world.extent={self.side_m}",
            f"camera.position=[{x}, {y}]",
            f"render.size={self.fine * self.size_px[0]}x{self.fine * self.size_px[1]}",
            *self.more,
        )


def _edges(first: float, last: float) -> tuple[float, ...]:
    return tuple(round(float(each), 1) for each in np.geomspace(first, last, 9))


def _far(distance: float) -> Outlook:
    """Look at a window of ``aerial`` from so far away [m], down at 8° or from 200 m up."""
    side, deepest = 400.0, 130.0
    height = max(200.0, distance * math.tan(math.radians(8.0)))
    pixel = 2 * math.tan(math.radians(FOV_DEG / 2)) / WIDTH_PX
    width = max(4, round(240.0 / distance / pixel))
    tall = max(2, round(2 * deepest * height / distance**2 / pixel))
    fov = math.degrees(2 * math.atan(pixel * width / 2))
    slant = [math.hypot(distance + each, height) for each in (-deepest, 0.0, deepest)]
    down = math.degrees(math.atan2(height, distance))
    return Outlook(
        "aerial",
        side,
        (0.0, -distance / side),
        tuple(round(each, 1) for each in slant),
        (
            "camera.heading=0",
            f"camera.height={height:.1f}",
            f"camera.pitch={-down:.3f}",
            f"camera.fov={fov:.4f}",
            "terrain.amplitude=2",
        ),
        (1.0,),
        (width, tall),
        max(4, math.ceil(160 / width)),
    )


LOOKS = {
    "aerial": Outlook(
        "aerial",
        400.0,
        (-0.27, -0.48),
        _edges(120.0, 350.0),
        ("camera.height=60", "camera.pitch=-22"),
    ),
    "forest": Outlook(
        "forest", 280.0, (-0.2, -0.48), _edges(7.0, 120.0), ("species.sward.density=0",)
    ),
    **{f"far_{distance:g}_km": _far(1000 * distance) for distance in (1, 2.2, 5)},
}
AIRS = ("preset", "clear")  # the air of the preset, and clear air


@dataclass(frozen=True)
class Shot:
    """One way to prune one look; ``cover`` says whether the far cover is drawn."""

    look: str
    air: str
    detail: float
    cover: bool


def pictures() -> list[Shot]:
    """Return every look through both airs, by every detail, with cover and without."""
    return [
        Shot(look, air, detail, cover)
        for look in LOOKS
        for air in AIRS
        for detail in LOOKS[look].details
        for cover in (True, False)
    ]


def preset_of(look: str, air: str, seed: int, more: tuple[str, ...] = ()) -> Preset:
    """Load a preset as it is looked at, with ``more`` settings; each seed has other objects."""
    clear = ("air.visibility=clear",) if air == "clear" else ()
    return load_preset(LOOKS[look].preset, (*LOOKS[look].settings(), *clear, f"seed={seed}", *more))


def window_view(scene: Scene) -> View:
    """Return the view of the first frame, in coordinates about the middle of the window."""
    view, middle = scene.view(1), Corner(0, 0)
    camera = replace(view.camera, corner=middle, eye=eye_relative_to(middle, view.camera))
    return replace(view, camera=camera)


def displayed(scene: Scene, detail: float, cover: bool) -> list[DisplayedRepresentation]:
    """Return what is displayed in the pruned picture; ``detail`` is in rays."""
    view, world = replace(window_view(scene), detail=detail), scene.world
    ground = world.terrain if cover else replace(world.terrain, aggregate_cover=None)
    return [_visible(ground, view), *(_visible(each, view) for each in world.fields)]


def whole(scene: Scene, look: Outlook) -> list[DisplayedRepresentation]:
    """Return everything in view of the window, with fine ground, and bare land beyond it."""
    plain = replace(window_view(scene), fade=0.0, conditions=None)
    leaves = look.fine * WHOLE_DETAIL * min(1.0, LEAF_M / look.edges_m[0])
    fine = replace(plain, detail=leaves, offscreen_detail=WHOLE_DETAIL / OFFSCREEN_PX)
    ground = replace(plain, detail=look.fine * GROUND_DETAIL)
    bare = replace(scene.world.terrain, aggregate_cover=None)
    return [_visible(bare, ground), *(_visible(each, fine) for each in scene.world.fields)]


def _visible(each: Representation, view: View) -> DisplayedRepresentation:
    return display(each, prune(each, view), view)


PRUNED_AND_WHOLE = "pruned", "whole"  # the names of both pictures
Bands = tuple[Column, ...]  # the columns of sums in each band, of each picture


def cases(fields: Mapping[str, int], unseen: bool) -> list[Case]:
    """Return so many fields of every look, for judging or that anybody may look at."""
    return [
        partial(measure, look, number, unseen)
        for look, count in fields.items()
        for number in range(count)
    ]


def world_seed(number: int, unseen: bool, seed: int) -> int:
    """Return the seed of a field's world in a run of a seed."""
    return first_seed(unseen, 2) + 20 * seed + number


def measure(look: str, number: int, unseen: bool, seed: int) -> list[Point]:
    """Measure one field in all pictures of one look: a point for each picture."""
    mine = [each for each in pictures() if each.look == look]
    found = field(look, world_seed(number, unseen, seed), mine)
    return [
        Point({"topic": "cover", **asdict(each)}, samples=bands) for each, bands in found.items()
    ]


@dataclass(frozen=True, eq=False)
class Seen:
    """One picture: its layers, and the luminance of the land alone along each ray, (h, w)."""

    layers: Layers
    land: np.ndarray


def field(look: str, seed: int, wanted: Sequence[Shot]) -> dict[Shot, Bands]:
    """Measure one field in the ``wanted`` pictures of one look, band by band."""
    presets = {case.air: preset_of(look, case.air, seed) for case in wanted}
    outlook, scene = LOOKS[look], Scene(next(iter(presets.values())))
    scenes = {air: scene.with_preset(preset) for air, preset in presets.items()}
    unpruned = _pictures(scenes, whole(scene, outlook))
    made = {}
    for case in wanted:
        mine = scenes[case.air]
        visible = displayed(mine, outlook.fine * case.detail, case.cover)
        pruned = _pictures({case.air: mine}, visible)[case.air]
        made[case] = in_bands(pruned, unpruned[case.air], outlook.edges_m)
    return made


def _pictures(
    scenes: Mapping[str, Scene], visible: list[DisplayedRepresentation]
) -> dict[str, Seen]:
    """Render what is displayed through every air, from one scene, by one ray a pixel."""
    first = next(iter(scenes.values()))
    quality = replace(frame_quality(first.preset, choose()), spp=1)
    light = first.air, first.light
    shot = FrameInput(window_view(first).camera, tuple(visible), *light, quality)
    stage = build_frame(shot)
    clear = trace(move_camera(stage, shot.camera, CLEAR), quality)
    made = {}
    for name, scene in scenes.items():
        air, layers = scene.air, clear
        if air != CLEAR:
            layers = trace(move_camera(stage, shot.camera, air), quality)
        made[name] = Seen(layers, land_light(clear, air))
    return made


def land_light(clear: Layers, air: Air) -> np.ndarray:
    """Return the luminance that the land sends through air, by ray, from its light in clear air."""
    through = np.exp(-clear.Z.astype(np.float64)[..., None] * rgb_extinction(air))
    return np.asarray((clear.rgb * through) @ LUMINANCE)


def in_bands(tested: Seen, unpruned: Seen, edges_m: tuple[float, ...]) -> Bands:
    """Sum luminance [10⁻⁶] and rays in each band, of both pictures, each by its own distances."""
    found: list[Column] = []
    for name, each in zip(PRUNED_AND_WHOLE, (tested, unpruned), strict=True):
        row = np.digitize(each.layers.Z.astype(np.float64), edges_m) - 1
        lit = {"light": each.layers.rgb.astype(np.float64) @ LUMINANCE, "land": each.land}
        for band in range(len(edges_m) - 1):
            here = row == band
            sums = {k: [round(1e6 * float(v[here].sum()))] for k, v in lit.items()}
            found += columns(sums | {"rays": [int(here.sum())]}, picture=name, band=band)
    return tuple(found)


def tone(point: Point, band: int, light: str = "light") -> Estimate:
    """Estimate mean luminance of a band, pruned ÷ unpruned, over fields: each by its own distances.

    ``light`` is ``light`` for all of it, or ``land`` for that of the land without the airlight.
    """
    return luminance_ratio(point, band, light, PRUNED_AND_WHOLE)


def coverage(point: Point, band: int) -> Estimate:
    """Estimate how much of the picture a band fills, pruned ÷ unpruned, over fields."""
    return coverage_ratio(point, band, PRUNED_AND_WHOLE)
