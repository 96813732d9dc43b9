"""Does pruning keep the tone of the land, from the nearest tree to the horizon? (§2.4)

Mean luminance in bands of distance is compared with that of everything there is: pruned to one
pixel and to twelve, with and without the far cover, which leaves on the land the colour of what
lies beyond the limit. Every field is another seed, and each picture's bands are by its own
distances. Light along the rays that have the band in the whole picture is noted and not judged: a
tree that is pruned has its gaps elsewhere, so some of these rays meet the sky (in ``forest`` it is
7 times as bright as trees), and rays of the sky that now meet the tree are in no band.
"""

from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np

from bench.experiments.cover.claims import SAME_RAYS
from bench.experiments.cover.scene import (
    AIRS,
    FINE,
    LOOKS,
    Case,
    displayed,
    pictures,
    preset_of,
    whole,
)
from bench.records.points import Column, Point
from bench.records.provenance import scene_digest
from bench.runner.experiment import Effort
from scenes.frame.assemble import frame_quality
from scenes.frame.displayed import DisplayedRepresentation
from scenes.frame.frame_input import FrameInput
from scenes.frame.layers import Layers
from scenes.preset.tables import Preset
from scenes.render.mitsuba.variants import choose
from scenes.render.pipeline.render import render_frame
from scenes.render.pipeline.stages import build_frame, move_camera, trace
from scenes.sticks.contrast import LUMINANCE
from scenes.world.light import sun_and_sky
from scenes.world.view import preset_air, view_at
from scenes.world.world import World, build_world

_SPP = 1

Bands = tuple[Column, ...]
"""The columns of sums in each band, of each picture."""


@dataclass(frozen=True)
class Field:
    """A field of a look; its number is added to the run's seed."""

    look: str
    number: int


def cases(effort: Effort) -> list[Field]:
    """Return as many fields of every look as the effort says."""
    return [Field(look, k) for look in LOOKS for k in range(effort["fields"][look])]


def notes(effort: Effort, seed: int, points: tuple[Point, ...]) -> dict[str, Any]:
    """Return the number of fields of each look, and of rays of a pixel."""
    return {**effort.sizes, "rays_per_pixel": _SPP * FINE**2}


def measure(case: Field, seed: int) -> list[Point]:
    """Measure one field in all pictures of one look: a point for each picture."""
    mine = [each for each in pictures() if each.look == case.look]
    found = field(case.look, seed + case.number, mine)
    return [Point(asdict(each), samples=bands) for each, bands in found.items()]


def field(look: str, seed: int, wanted: Sequence[Case]) -> dict[Case, Bands]:
    """Measure one field in the ``wanted`` pictures of one look, band by band."""
    presets = {case.air: preset_of(look, case.air, seed) for case in wanted}
    world = build_world(preset_of(look, AIRS[0], seed))
    unpruned = _whole_pictures(world, presets)
    made = {}
    for case in wanted:
        picture = _pruned_picture(world, presets[case.air], case)
        made[case] = in_bands(picture, unpruned[case.air], LOOKS[look].edges_m)
    return made


def pruned_alone(look: str, seed: int, case: Case) -> Bands:
    """Measure one field in one pruned picture alone, band by band."""
    preset = preset_of(look, case.air, seed)
    picture = _pruned_picture(build_world(preset), preset, case)
    return in_bands(picture, picture, LOOKS[look].edges_m)


def _whole_pictures(world: World, presets: dict[str, Preset]) -> dict[str, Layers]:
    """Render everything in the window through every air, from one scene."""
    first = next(iter(presets.values()))
    shot = _shot(world, first, whole(world, first))
    stage = build_frame(shot)
    return {
        air: trace(move_camera(stage, shot.camera, preset_air(preset)), shot.quality)
        for air, preset in presets.items()
    }


def _pruned_picture(world: World, preset: Preset, case: Case) -> Layers:
    return render_frame(_shot(world, preset, displayed(world, preset, case.detail, case.cover)))


def _shot(world: World, preset: Preset, visible: list[DisplayedRepresentation]) -> FrameInput:
    """Put together what the first frame displays, with one sample for each of its pixels."""
    camera, quality = view_at(world, preset, 1).camera, frame_quality(preset, choose())
    light = preset_air(preset), sun_and_sky(preset)
    return FrameInput(camera, tuple(visible), *light, replace(quality, spp=_SPP))


def in_bands(tested: Layers, unpruned: Layers, edges_m: tuple[float, ...]) -> Bands:
    """Sum luminance [10⁻⁶] and rays in each band, of both pictures, each by its own distances.

    Of the tested picture there are also sums along the rays that have the band in the unpruned one.
    """
    ours, theirs = (
        np.digitize(each.Z.astype(np.float64), edges_m) - 1 for each in (tested, unpruned)
    )
    light, of_all = (each.rgb.astype(np.float64) @ LUMINANCE for each in (tested, unpruned))
    bands = range(len(edges_m) - 1)
    sums = {
        ("light", "pruned"): [_micro(light[ours == k]) for k in bands],
        ("rays", "pruned"): [int((ours == k).sum()) for k in bands],
        ("light", "whole"): [_micro(of_all[theirs == k]) for k in bands],
        ("rays", "whole"): [int((theirs == k).sum()) for k in bands],
        ("light", SAME_RAYS): [_micro(light[theirs == k]) for k in bands],
    }
    return tuple(
        Column(quantity, [each], {"picture": picture, "band": k})
        for (quantity, picture), row in sums.items()
        for k, each in enumerate(row)
    )


def _micro(light: np.ndarray) -> int:
    return round(1e6 * float(light.sum()))


def scene_hash(points: tuple[Point, ...]) -> str:
    """Return the SHA-256 of every preset, picture and look."""
    presets = [preset_of(look, air, 0).model_dump(mode="json") for look in LOOKS for air in AIRS]
    looks = [asdict(each) for each in LOOKS.values()]
    return scene_digest([presets, [asdict(each) for each in pictures()], looks, _SPP])
