"""What does the cover experiment look at? Presets in a window, pruned, and everything there is.

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
"""

import math
from dataclasses import dataclass, replace

import numpy as np

from lod.camera import Corner
from lod.motion import eye_relative_to
from lod.pruner import Representation, prune
from lod.view import View
from scenes.frame.frame_input import DisplayedRepresentation, display
from scenes.presets.load import load_preset
from scenes.presets.schema import Preset
from scenes.scene import view_at
from scenes.world.world import World

WIDTH_PX, FOV_DEG = 160, 60.0
"""The width of a whole picture, in pixels and as an angle: pieces have pixels of the same angle."""

WHOLE_DETAIL, GROUND_DETAIL, LEAF_M = 0.02, 0.5, 250.0
"""Detail of species and of the ground in the whole picture [px]: every leaf is displayed.

That of species is finer by as much as the land is farther away than LEAF_M.
"""

OFFSCREEN_PX = 0.5
"""Detail of what is out of view in the whole picture [px]."""


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


def _edges(first: float, last: float, bands: int = 8) -> tuple[float, ...]:
    return tuple(round(float(each), 1) for each in np.geomspace(first, last, bands + 1))


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
AIRS = ("preset", "clear")
"""The air of the preset, and clear air."""


@dataclass(frozen=True)
class Case:
    """One way to prune one look; ``cover`` says whether the far cover is drawn."""

    look: str
    air: str
    detail: float
    cover: bool


def pictures() -> list[Case]:
    """Return every look through both airs, by every detail, with cover and without."""
    return [
        Case(look, air, detail, cover)
        for look in LOOKS
        for air in AIRS
        for detail in LOOKS[look].details
        for cover in (True, False)
    ]


def preset_of(look: str, air: str, seed: int, more: tuple[str, ...] = ()) -> Preset:
    """Load a preset as it is looked at, with ``more`` settings; each seed has other objects."""
    clear = ("air.visibility=clear",) if air == "clear" else ()
    return load_preset(LOOKS[look].preset, (*LOOKS[look].settings(), *clear, f"seed={seed}", *more))


def window_view(world: World, preset: Preset) -> View:
    """Return the view of the first frame, in coordinates about the middle of the window."""
    view, middle = view_at(world, preset, 1), Corner(0, 0)
    camera = replace(view.camera, corner=middle, eye=eye_relative_to(middle, view.camera))
    return replace(view, camera=camera)


def displayed(
    world: World, preset: Preset, detail: float, cover: bool
) -> list[DisplayedRepresentation]:
    """Return what is displayed in the pruned picture; ``detail`` is in rays."""
    view = replace(window_view(world, preset), detail=detail)
    ground = world.terrain if cover else replace(world.terrain, aggregate_cover=None)
    return [_visible(ground, view), *(_visible(each, view) for each in world.fields)]


def whole(world: World, preset: Preset, look: Outlook) -> list[DisplayedRepresentation]:
    """Return everything in view of the window, with fine ground, and bare land beyond it."""
    plain = replace(window_view(world, preset), fade=0.0, conditions=None)
    leaves = look.fine * WHOLE_DETAIL * min(1.0, LEAF_M / look.edges_m[0])
    fine = replace(plain, detail=leaves, offscreen_detail=WHOLE_DETAIL / OFFSCREEN_PX)
    ground = replace(plain, detail=look.fine * GROUND_DETAIL)
    bare = replace(world.terrain, aggregate_cover=None)
    return [_visible(bare, ground), *(_visible(each, fine) for each in world.fields)]


def _visible(each: Representation, view: View) -> DisplayedRepresentation:
    return display(each, prune(each, view), view)
