"""Does pruning keep the tone of the land, from the nearest tree to the horizon? (§2.4)

Mean luminance in bands of distance, pruned to one pixel and to twelve, with and without what lies
beyond the limit left on the land, against everything there is. Every field is another seed; what
counts in a band is what each picture has at those distances. Along the rays that have the band in
the whole picture the light is noted as well, and not judged: a tree that is pruned has its gaps
elsewhere, so some of them meet the sky (in ``forest`` 7 times as bright as trees), and those of the
sky that now meet the tree are in no band.
"""

import hashlib
import json
import time
from collections.abc import Sequence
from dataclasses import asdict, replace

import numpy as np

from bench.experiments.cover.claims import judge
from bench.experiments.cover.scene import (
    AIRS,
    FINE,
    LOOKS,
    Case,
    cases,
    displayed,
    preset_of,
    whole,
)
from bench.records.provenance import provenance
from bench.records.records import Point, Record
from bench.runner.dask_cases import CaseExecutor, serial_executor
from bench.runner.experiment import Progress, silent
from bench.runner.run_cases import make_record, merge_points, run_cases
from scenes.frame.assemble import frame_quality
from scenes.frame.frame_input import FrameInput
from scenes.frame.layers import Layers
from scenes.frame.quality import Quality
from scenes.preset.tables import Preset
from scenes.render.mitsuba.variants import choose
from scenes.render.pipeline.render import render_frame
from scenes.render.pipeline.stages import build_frame, move_camera, trace
from scenes.world.light import sun_and_sky
from scenes.world.view import preset_air, view_at
from scenes.world.world import World, build_world

NAME, VERSION = "cover", 2
FIELDS, QUICK_FIELDS = {"aerial": 16, "forest": 40}, {"aerial": 2, "forest": 2}
_SPP = 1
_LUMINANCE = np.array((0.2126, 0.7152, 0.0722))

Bands = dict[str, list[int]]
"""What was summed, by name, band by band."""


def run(
    quick: bool = False,
    progress: Progress = silent,
    seed: int = 0,
    each: CaseExecutor = serial_executor,
) -> Record:
    """Render every field whole and pruned, and judge every band."""
    start, fields = time.perf_counter(), QUICK_FIELDS if quick else FIELDS
    steps = [(look, seed + k) for look in LOOKS for k in range(fields[look])]
    named = [(f"{look}, seed {own}", (look, own)) for look, own in steps]
    points = merge_points(run_cases(progress, each, (measure, named)))
    return make_record(
        NAME,
        VERSION,
        quick=quick,
        provenance=provenance(_scene_hash(), seed, variant=choose()),
        points=points,
        claims=judge(points),
        notes={"fields": fields, "rays_per_pixel": _SPP * FINE**2},
        start=start,
    )


def measure(look: str, seed: int) -> list[Point]:
    """One field in all pictures of one look: a point for each."""
    mine = [case for case in cases() if case.look == look]
    return [_point(case, found) for case, found in field(look, seed, mine).items()]


def field(look: str, seed: int, wanted: Sequence[Case]) -> dict[Case, Bands]:
    """One field in the ``wanted`` pictures of one look, band by band."""
    presets = {case.air: preset_of(look, case.air, seed) for case in wanted}
    world = build_world(preset_of(look, AIRS[0], seed))
    unpruned = _whole_pictures(world, presets)
    made = {}
    for case in wanted:
        picture = _pruned_picture(world, presets[case.air], case)
        made[case] = in_bands(picture, unpruned[case.air], LOOKS[look].edges_m)
    return made


def pruned_alone(look: str, seed: int, case: Case) -> Bands:
    """One field in one pruned picture, band by band, held against nothing but itself."""
    preset = preset_of(look, case.air, seed)
    picture = _pruned_picture(build_world(preset), preset, case)
    return in_bands(picture, picture, LOOKS[look].edges_m)


def _whole_pictures(world: World, presets: dict[str, Preset]) -> dict[str, Layers]:
    """Everything in the window through every air, from one scene."""
    first = next(iter(presets.values()))
    camera, quality = view_at(world, first, 1).camera, _quality(first)
    stage = build_frame(
        FrameInput(
            camera, tuple(whole(world, first)), preset_air(first), sun_and_sky(first), quality
        )
    )
    return {
        air: trace(move_camera(stage, camera, preset_air(preset)), quality)
        for air, preset in presets.items()
    }


def _pruned_picture(world: World, preset: Preset, case: Case) -> Layers:
    visible = displayed(world, preset, case.detail, case.cover)
    camera = view_at(world, preset, 1).camera
    quality = _quality(preset)
    return render_frame(
        FrameInput(camera, tuple(visible), preset_air(preset), sun_and_sky(preset), quality)
    )


def _quality(preset: Preset) -> Quality:
    return replace(frame_quality(preset, choose()), spp=_SPP)


def in_bands(tested: Layers, unpruned: Layers, edges_m: tuple[float, ...]) -> Bands:
    """Luminance summed in each band [10⁻⁶], and the rays there, of both pictures, each by its own
    distances; and of the tested one along the rays that have the band in the whole one."""
    ours, theirs = (
        np.digitize(each.Z.astype(np.float64), edges_m) - 1 for each in (tested, unpruned)
    )
    light, of_all = (each.rgb.astype(np.float64) @ _LUMINANCE for each in (tested, unpruned))
    bands = range(len(edges_m) - 1)
    return {
        "tested": [_micro(light[ours == k]) for k in bands],
        "tested rays": [int((ours == k).sum()) for k in bands],
        "whole": [_micro(of_all[theirs == k]) for k in bands],
        "whole rays": [int((theirs == k).sum()) for k in bands],
        "same rays": [_micro(light[theirs == k]) for k in bands],
    }


def _micro(light: np.ndarray) -> int:
    return round(1e6 * float(light.sum()))


def _point(case: Case, found: Bands) -> Point:
    samples = {f"{name} {k}": [each] for name, row in found.items() for k, each in enumerate(row)}
    return Point(asdict(case), {}, samples)


def _scene_hash() -> str:
    presets = [preset_of(look, air, 0).model_dump(mode="json") for look in LOOKS for air in AIRS]
    words = [presets, [asdict(case) for case in cases()], [asdict(e) for e in LOOKS.values()], _SPP]
    return hashlib.sha256(json.dumps(words, sort_keys=True).encode()).hexdigest()
