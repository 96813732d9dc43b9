"""Is haze what it should be? Targets, the scattering medium, and light of sixteen bands (§2.1).

Targets: black and grey at 20 distances, in both frame drivers and the medium, tell β and V. Bands:
``meadow`` at V = 5 km by distance: the closed forms against the medium that scatters light, and
RGB against spectral haze by CIEDE2000. All samples are integers: radiance in 10⁻⁹, ΔE in 10⁻³.
"""

import hashlib
import json
import time
from dataclasses import replace
from functools import lru_cache

import numpy as np

from bench.experiments.air.claims import BAND_EDGES_M, SKY, judge
from bench.experiments.air.targets import look_at, order
from bench.records.provenance import provenance
from bench.records.records import Point, Record
from bench.runner.dask_cases import CaseExecutor, serial_executor
from bench.runner.experiment import Progress, silent
from bench.runner.run_cases import make_record, merge_points, run_cases
from scenes.frame.assemble import assemble_frame
from scenes.frame.frame_input import FrameInput
from scenes.frame.layers import SKY_Z, Layers
from scenes.frame.quality import Quality
from scenes.preset.load import load_preset
from scenes.render.mitsuba.variants import JIT_VARIANT, SCALAR_VARIANT, choose, works
from scenes.render.pictures.tone_map import auto_exposure
from scenes.render.pipeline.render import render_frame
from scenes.world.world import build_world

NAME, VERSION = "air", 1
VISIBILITIES_M = (1e3, 5e3, 20e3)
MEADOW = (
    *("air.visibility=5km", "render.size=96x54", "render.max_depth=16"),
    "render.haze=scattered",  # so that the light knows the canopy
)
_TARGET_SPP = {"scalar": 512, "jit": 512, "medium": 2048}
_QUICK_TARGET_SPP = {"scalar": 256, "jit": 256, "medium": 512}
_SPP = {"analytic": 32, "scattered": 32, "medium": 384, "spectral": 64}
_SEEDS, _QUICK_SEEDS = 8, 4
_LUMINANCE = np.array((0.2126, 0.7152, 0.0722))


def run(
    quick: bool = False,
    progress: Progress = silent,
    seed: int = 0,
    each: CaseExecutor = serial_executor,
) -> Record:
    """Render the targets and the meadow in every way there is here, and judge the claims."""
    start = time.perf_counter()
    spp = _QUICK_TARGET_SPP if quick else _TARGET_SPP
    ways = {"scalar": SCALAR_VARIANT, "jit": JIT_VARIANT, "medium": choose()}
    ways = {name: variant for name, variant in ways.items() if works(variant) is True}
    seeds = [seed + k for k in range(_QUICK_SEEDS if quick else _SEEDS)]
    aimed = [
        (f"targets, {way}, {visibility / 1000:g} km", (way, visibility, variant, spp[way], seed))
        for way, variant in ways.items()
        for visibility in VISIBILITIES_M
    ]
    looked = [(f"meadow, seed {number}", (number,)) for number in seeds]
    targets = run_cases(progress, each, (_targets, aimed))
    bands = merge_points(run_cases(progress, each, (_bands, looked)))
    points = targets + tuple(sorted(bands, key=lambda point: point.case["from"]))
    return make_record(
        NAME,
        VERSION,
        quick=quick,
        provenance=provenance(_scene_hash(), seed, variant=choose()),
        points=points,
        claims=judge(points),
        notes={"target_spp": spp, "meadow_spp": _SPP, "seeds": len(seeds)},
        start=start,
    )


def _targets(way: str, visibility: float, variant: str, spp: int, seed: int) -> Point:
    """Every target in haze, and what is seen beyond them."""
    haze = "medium" if way == "medium" else "analytic"
    quality = Quality(variant, spp, seed, 4, haze)
    target, beyond = look_at(visibility, quality)
    step, albedo = order(quality.seed)
    samples = {"step": step.tolist(), "grey": albedo.tolist()}
    for number, band in enumerate("rgb"):
        samples[f"target_{band}"] = _nano(target[:, number])
        samples[f"beyond_{band}"] = _nano(beyond[:, number])
    return Point({"what": "targets", "way": way, "visibility": visibility}, {}, samples)


def _bands(seed: int) -> list[Point]:
    """A point for each distance band of the meadow, rendered with a seed."""
    return [
        Point({"what": "bands", "from": low}, {}, {name: [value] for name, value in values.items()})
        for low, values in _compared(_meadow(), seed).items()
    ]


@lru_cache(maxsize=1)
def _meadow() -> FrameInput:
    preset = load_preset("meadow", list(MEADOW))
    return assemble_frame(build_world(preset), preset, 1, choose())


def _compared(shot: FrameInput, seed: int) -> dict[float, dict[str, int]]:
    """Mean luminance by every kind of haze, and median ΔE of RGB against spectral, by band."""
    seen = {kind: _rendered(shot, kind, seed) for kind in _SPP}
    distance, difference = seen["analytic"].Z, delta_e(seen["analytic"].rgb, seen["spectral"].rgb)
    edges, made = (*BAND_EDGES_M, float(SKY_Z)), {}
    for low, high in zip(edges, (*edges[1:], np.inf), strict=True):
        mine = (distance >= low) & (distance < high)
        if not mine.any():
            continue
        values = {k: float((frame.rgb[mine] @ _LUMINANCE).mean()) for k, frame in seen.items()}
        made[SKY if low == float(SKY_Z) else low] = {
            "pixels": int(mine.sum()),
            **{k: round(1e9 * value) for k, value in values.items()},
            "delta_e": round(1e3 * float(np.median(difference[mine]))),
        }
    return made


def _rendered(shot: FrameInput, kind: str, seed: int) -> Layers:
    spectral = kind == "spectral"
    haze = "analytic" if spectral else kind
    quality = replace(
        shot.quality,
        variant=choose("auto", spectral),
        haze=haze,
        spp=_SPP[kind],
        seed=seed,
    )
    return render_frame(replace(shot, quality=quality), 1)


def delta_e(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """CIEDE2000 of two pictures, each exposed for itself as displays do, (h, w)."""
    from colour import RGB_to_XYZ, XYZ_to_Lab, delta_E

    labs = []
    for rgb in (one, other):
        light = np.maximum(rgb.astype(np.float64), 0.0) * auto_exposure(rgb)
        labs.append(XYZ_to_Lab(RGB_to_XYZ(light, "ITU-R BT.709")))
    return np.asarray(delta_E(labs[0], labs[1], method="CIE 2000"))


def _nano(values: np.ndarray) -> list[int]:
    return [round(1e9 * float(value)) for value in values]


def _scene_hash() -> str:
    preset = load_preset("meadow", list(MEADOW)).model_dump(mode="json")
    words = json.dumps([preset, VISIBILITIES_M, BAND_EDGES_M], sort_keys=True)
    return hashlib.sha256(words.encode()).hexdigest()
