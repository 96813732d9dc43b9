"""Does pruning keep the tone of the land, from the nearest tree to the horizon? (§2.4)

Mean luminance in bands of distance is compared with that of everything there is: pruned to one
pixel and to twelve, with and without the far cover, which leaves on the land the colour of what
lies beyond the limit. Every field is another seed, and each picture's bands are by its own
distances. In the preset's air the land's own share of the light is summed as well: light in clear
air times the air's transmittance, ray by ray. Light along the rays that have the band in the whole
picture is noted and not judged: a tree that is pruned has its gaps elsewhere, so some of these rays
meet the sky (in ``forest`` it is 7 times as bright as trees), and rays of the sky that now meet the
tree are in no band.
"""

from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np

from bench.experiments.cover.claims import SAME_RAYS
from bench.experiments.cover.scene import (
    AIRS,
    LOOKS,
    Case,
    displayed,
    pictures,
    preset_of,
    whole,
    window_view,
)
from bench.old_experiment import Effort
from bench.records.provenance import scene_digest
from bench.records.records import Column, Point, columns
from bench.seeds import first_seed
from lod.air import CLEAR, Air, rgb_extinction
from scenes.frame.frame_input import DisplayedRepresentation, FrameInput
from scenes.frame.layers import Layers
from scenes.presets.schema import Preset
from scenes.render.render import build_frame, move_camera, trace
from scenes.render.variants import choose
from scenes.scene import frame_quality, preset_air
from scenes.sticks.prototype import LUMINANCE
from scenes.world.light import sun_and_sky
from scenes.world.world import World, build_world

_SPP = 1

Bands = tuple[Column, ...]
"""The columns of sums in each band, of each picture."""


@dataclass(frozen=True)
class Field:
    """A field of a look; ``unseen`` says whether it is for judging, or anybody may look at it."""

    look: str
    number: int
    unseen: bool

    def world_seed(self, seed: int) -> int:
        """Return the seed of its world in a run of a seed."""
        return first_seed(self.unseen, 2) + 20 * seed + self.number


def cases(effort: Effort) -> list[Field]:
    """Return as many fields of every look as the effort says."""
    counts = effort["fields"].items()
    return [Field(look, k, effort["unseen"]) for look, count in counts for k in range(count)]


def notes(effort: Effort, seed: int, points: tuple[Point, ...]) -> dict[str, Any]:
    """Return the number of fields of each look, and of rays of a pixel."""
    return {**effort.sizes, "rays_per_pixel": {name: e.fine**2 for name, e in LOOKS.items()}}


def measure(case: Field, seed: int) -> list[Point]:
    """Measure one field in all pictures of one look: a point for each picture."""
    mine = [each for each in pictures() if each.look == case.look]
    found = field(case.look, case.world_seed(seed), mine)
    return [Point(asdict(each), samples=bands) for each, bands in found.items()]


@dataclass(frozen=True, eq=False)
class Seen:
    """One picture: its layers, and the luminance of the land alone along each ray, (h, w)."""

    layers: Layers
    land: np.ndarray


def field(look: str, seed: int, wanted: Sequence[Case]) -> dict[Case, Bands]:
    """Measure one field in the ``wanted`` pictures of one look, band by band."""
    presets = {case.air: preset_of(look, case.air, seed) for case in wanted}
    first = next(iter(presets.values()))
    world = build_world(first)
    unpruned = _pictures(world, presets, whole(world, first, LOOKS[look]))
    made = {}
    for case in wanted:
        made[case] = in_bands(
            _pruned_picture(world, presets[case.air], case), unpruned[case.air], LOOKS[look].edges_m
        )
    return made


def _pruned_picture(world: World, preset: Preset, case: Case) -> Seen:
    visible = displayed(world, preset, LOOKS[case.look].fine * case.detail, case.cover)
    return _pictures(world, {case.air: preset}, visible)[case.air]


def _pictures(
    world: World, presets: dict[str, Preset], visible: list[DisplayedRepresentation]
) -> dict[str, Seen]:
    """Render what is displayed through every air, from one scene."""
    shot = _shot(world, next(iter(presets.values())), visible)
    stage = build_frame(shot)
    clear = trace(move_camera(stage, shot.camera, CLEAR), shot.quality)
    made = {}
    for name, preset in presets.items():
        air = preset_air(preset)
        layers = (
            clear if air == CLEAR else trace(move_camera(stage, shot.camera, air), shot.quality)
        )
        made[name] = Seen(layers, land_light(clear, air))
    return made


def land_light(clear: Layers, air: Air) -> np.ndarray:
    """Return the luminance that the land sends through air, by ray, from its light in clear air."""
    through = np.exp(-clear.Z.astype(np.float64)[..., None] * rgb_extinction(air))
    return np.asarray((clear.rgb * through) @ LUMINANCE)


def _shot(world: World, preset: Preset, visible: list[DisplayedRepresentation]) -> FrameInput:
    """Put together what the first frame displays, with one sample for each of its pixels."""
    camera, quality = window_view(world, preset).camera, frame_quality(preset, choose())
    light = preset_air(preset), sun_and_sky(preset)
    return FrameInput(camera, tuple(visible), *light, replace(quality, spp=_SPP))


def in_bands(tested: Seen, unpruned: Seen, edges_m: tuple[float, ...]) -> Bands:
    """Sum luminance [10⁻⁶] and rays in each band, of both pictures, each by its own distances.

    Of the tested picture there are also sums along the rays that have the band in the unpruned one.
    """
    both = {"pruned": tested, "whole": unpruned}
    found: list[Column] = []
    rows = {
        name: np.digitize(each.layers.Z.astype(np.float64), edges_m) - 1
        for name, each in both.items()
    }
    light = {k: each.layers.rgb.astype(np.float64) @ LUMINANCE for k, each in both.items()}
    for band in range(len(edges_m) - 1):
        for name, each in both.items():
            here = rows[name] == band
            sums = {
                "light": _micro(light[name][here]),
                "land": _micro(each.land[here]),
                "rays": int(here.sum()),
            }
            found += columns({k: [v] for k, v in sums.items()}, picture=name, band=band)
        same = _micro(light["pruned"][rows["whole"] == band])
        found += columns({"light": [same]}, picture=SAME_RAYS, band=band)
    return tuple(found)


def _micro(light: np.ndarray) -> int:
    return round(1e6 * float(light.sum()))


def scene_hash(points: tuple[Point, ...]) -> str:
    """Return the SHA-256 of every preset, picture and look."""
    presets = [preset_of(look, air, 0).model_dump(mode="json") for look in LOOKS for air in AIRS]
    looks = [asdict(each) for each in LOOKS.values()]
    return scene_digest([presets, [asdict(each) for each in pictures()], looks, _SPP])
