"""What do cuts that know of a lens leave out, and what does that cost the picture?

A preset is seen through a lens of 50 mm. Its cut is compared with the cut of the same detail that
does not know of the lens: by parts at each distance, and by pictures of both, taken through the
lens in a window of the world, against the unpruned one. Whole fields on flat ground, seen all
round, are counted against the law.
"""

import math
from dataclasses import replace

import numpy as np

from bench.images.differences import Looks, flips, look
from bench.part_sizes import (
    COARSE_M,
    camera,
    count_sizes,
    density_of,
    predicted_sizes,
    prototypes_with,
    seed_of,
    view_through,
)
from bench.records.records import Column, Point, Prediction, columns
from lod.camera import ThinLens
from lod.metric import METRICS
from lod.pruner import prune
from lod.view import View, distance
from lod.viewing import BlurWidths, Defocus, ViewingConditions
from scenes.frame.frame_input import FrameInput, display
from scenes.presets.load import load_preset
from scenes.scene import Scene, frame_quality

F_STOP, FOCUS_M = 2.0, 12.0
LENS = (f"camera.f_stop={F_STOP}", f"camera.focus={FOCUS_M}", "camera.focal_length=50")
BANDS_M = (0.0, 6.0, 12.0, 24.0, 48.0, 100.0, 150.0, 400.0, math.inf)
"""Where bands of distance begin and end [m]."""

LENS_CUTS = ("aware", "unaware")


def lens_views(view: View) -> dict[str, View]:
    """Return the view whose cut knows of the lens, and the one whose cut does not."""
    assert view.conditions is not None
    return {
        "aware": view,
        "unaware": replace(view, conditions=replace(view.conditions, defocus=None)),
    }


def measure_lens_fields(fields: int, seed: int) -> Point:
    """Count the parts of whole fields on flat ground, seen all round, and predict them."""
    eye = camera(640)
    defocus = Defocus(ThinLens(0.05 / F_STOP, FOCUS_M), eye.corner_secant)
    sight = ViewingConditions(BlurWidths(eye.pixel_angle), acuity=False, defocus=defocus)
    view = view_through(sight, 640)
    things = prototypes_with("figure", None), 4 * density_of("figure", COARSE_M)
    seeds = [seed_of("defocus", seed, index) for index in range(fields)]
    counts = [sum(count_sizes(*things, view, each)[0]) for each in seeds]
    expected = float(predicted_sizes(*things, view).sum())
    named = {"topic": "defocus", "what": "fields"}
    return Point(named, (Prediction("parts", expected),), columns({"parts": counts}))


def measure_lens_parts(size: str, seed: int) -> list[Point]:
    """Count the parts of one frame of `crowd` in each band of distance, by every cut."""
    scene = Scene(load_preset("crowd", [*LENS, f"render.size={size}"]))
    made = []
    for cut, view in lens_views(scene.view(1)).items():
        counts = np.zeros(len(BANDS_M) - 1, np.int64)
        for each in scene.world.fields:
            away = distance(view, prune(each, view).parts.position)
            counts += np.histogram(away, BANDS_M)[0]
        found = (
            Column("parts", [int(n)], {"from": low})
            for low, n in zip(BANDS_M, counts, strict=False)
        )
        named = {"topic": "defocus", "what": "parts", "cut": cut}
        made.append(Point(named, samples=tuple(found)))
    return made


def measure_lens_pictures(
    pair: int, size: str, spp: tuple[int, ...], variant: str, seed: int
) -> list[Point]:
    """Measure FLIP to the unpruned picture of every cut, and of another unpruned picture.

    They are of one pair of seeds and of a window; ``spp`` are the samples of a pixel of each.
    """
    settings = *LENS, f"render.size={size}", "world.extent=150"
    scene = Scene(load_preset("crowd", settings))
    view = scene.view(1)
    unpruned = replace(
        view, metric=METRICS["full"], fade=0.0, conditions=None, offscreen_detail=1.0
    )

    def pictures(of: View, own: int) -> tuple[np.ndarray, ...]:
        shown = tuple(display(each, prune(each, of), of) for each in scene.world.representations)
        quality = replace(frame_quality(scene.preset, variant), seed=own)
        frame = FrameInput(of.camera, shown, scene.air, scene.light, quality)
        return look(frame, Looks(spp, 0), np.array((0.0, np.inf)), 0).pictures[0]

    one, two = (seed + 2 * pair + k for k in (0, 1))
    reference, made = pictures(unpruned, two), []
    for cut, of in {**lens_views(view), "unpruned": unpruned}.items():
        found = flips(pictures(of, one), reference)
        ppm = (
            Column("flip_ppm", [round(1e6 * error)], {"samples": samples})
            for samples, error in zip(spp, found, strict=True)
        )
        named = {"topic": "defocus", "what": "picture", "cut": cut}
        made.append(Point(named, samples=tuple(ppm)))
    return made
