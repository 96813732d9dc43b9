"""What does the cover experiment look at? Presets in a window, pruned, and everything there is.

The eye stands at the window's southern edge, so that everything it sees as far as the last band is
inside; in ``aerial`` it is lower than in the preset, because the window that can be held unpruned
is smaller. Bands begin where all fields have ground in the picture: nearer there are crowns alone,
and no ground could carry their colour. In the whole picture every leaf in view is displayed. A
pixel is FINE × FINE rays, each with a distance of its own: of a pixel that is half tree and half
sky, half counts.
"""

from dataclasses import dataclass, replace

import numpy as np

from lod.pruning.pruner import prune
from lod.pruning.representation import Representation
from lod.pruning.view import View
from scenes.frame.displayed import DisplayedRepresentation, display
from scenes.preset.load import load_preset
from scenes.preset.tables import Preset
from scenes.world.view import view_at
from scenes.world.world import World

WIDTH_PX, HEIGHT_PX, FINE = 160, 90, 4
"""The size of a picture, and the rays along each side of a pixel: rendered pixels are rays."""

WHOLE_DETAIL, GROUND_DETAIL = 0.02, 0.5
"""Detail of species and of the ground in the whole picture [px]: every leaf is displayed."""

OFFSCREEN_PX = 0.5
"""Detail of what is out of view in the whole picture [px]."""


@dataclass(frozen=True)
class Outlook:
    """One preset as it is looked at.

    side_m    side of the window [m]
    eye_at    (x, y) of the eye from the middle of the window, as a share of its side
    edges_m   edges of the bands of distance [m]
    more      settings of the preset
    """

    preset: str
    side_m: float
    eye_at: tuple[float, float]
    edges_m: tuple[float, ...]
    more: tuple[str, ...] = ()

    def settings(self) -> tuple[str, ...]:
        """The outlook as settings of the preset."""
        x, y = (self.side_m * share for share in self.eye_at)
        return (
            f"world.extent={self.side_m}",
            f"camera.position=[{x}, {y}]",
            f"render.size={FINE * WIDTH_PX}x{FINE * HEIGHT_PX}",
            *self.more,
        )


def _edges(first: float, last: float, bands: int = 8) -> tuple[float, ...]:
    return tuple(round(float(each), 1) for each in np.geomspace(first, last, bands + 1))


LOOKS = {
    "aerial": Outlook(
        "aerial",
        400.0,
        (-0.27, -0.48),
        _edges(120.0, 350.0),
        ("camera.height=60", "camera.pitch=-22"),
    ),
    "forest": Outlook("forest", 280.0, (-0.2, -0.48), _edges(7.0, 120.0)),
}
AIRS = ("preset", "clear")
"""The air of the preset, and clear air."""

DETAILS = (1.0, 12.0)
"""Values of τ, in pixels of the picture."""


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
        for detail in DETAILS
        for cover in (True, False)
    ]


def preset_of(look: str, air: str, seed: int, more: tuple[str, ...] = ()) -> Preset:
    """Load a preset as it is looked at, with ``more`` settings; each seed has other objects."""
    clear = ("air.visibility=clear",) if air == "clear" else ()
    return load_preset(look, (*LOOKS[look].settings(), *clear, f"seed={seed}", *more))


def displayed(
    world: World, preset: Preset, detail: float, cover: bool
) -> list[DisplayedRepresentation]:
    """Return what is displayed in the pruned picture."""
    view = replace(view_at(world, preset, 1), detail=FINE * detail)
    ground = world.terrain if cover else replace(world.terrain, aggregate_cover=None)
    return [_visible(ground, view), *(_visible(each, view) for each in world.fields)]


def whole(world: World, preset: Preset) -> list[DisplayedRepresentation]:
    """Return everything in view of the window, with fine ground, and bare land beyond it."""
    plain = replace(view_at(world, preset, 1), fade=0.0, conditions=None)
    fine = replace(plain, detail=FINE * WHOLE_DETAIL, offscreen_detail=WHOLE_DETAIL / OFFSCREEN_PX)
    ground = replace(plain, detail=FINE * GROUND_DETAIL)
    bare = replace(world.terrain, aggregate_cover=None)
    return [_visible(bare, ground), *(_visible(each, fine) for each in world.fields)]


def _visible(each: Representation, view: View) -> DisplayedRepresentation:
    return display(each, prune(each, view), view)
