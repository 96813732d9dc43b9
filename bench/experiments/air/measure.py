"""Is haze as rendered what it should be? Targets, the scattering medium and spectral light (§2.1).

Black and grey targets at 20 distances, in both frame drivers and in the medium, give β and V. In
bands of distance of ``meadow`` at V = 5 km the closed forms are compared with the medium that
scatters light, and RGB with spectral haze by CIEDE2000. All samples are integers: radiance in 10⁻⁹,
ΔE in 10⁻³.
"""

from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any

import numpy as np

from bench.experiments.air.claims import BAND_EDGES_M, SKY
from bench.experiments.air.targets import look_at, order
from bench.old_experiment import Effort
from bench.records.provenance import scene_digest
from bench.records.records import Column, Point, columns
from scenes.frame.frame_input import FrameInput, Quality
from scenes.frame.layers import SKY_Z, Layers
from scenes.presets.load import load_preset
from scenes.render.pictures import auto_exposure
from scenes.render.render import render_frame
from scenes.render.variants import JIT_VARIANT, SCALAR_VARIANT, choose, works
from scenes.scene import assemble_frame
from scenes.sticks.prototype import LUMINANCE
from scenes.world.world import build_world

VISIBILITIES_M = (1e3, 5e3, 20e3)
MEADOW = (
    *("air.visibility=5km", "render.size=96x54", "render.max_depth=16"),
    "species.sward.density=0",
    "render.haze=scattered",  # so that the light knows the canopy
)
_SPP = {"analytic": 32, "scattered": 32, "medium": 384, "spectral": 64}


@dataclass(frozen=True)
class Targets:
    """Targets in haze of a visibility [m], rendered in one way: a frame driver, or the medium."""

    way: str
    visibility: float
    variant: str
    spp: int


@dataclass(frozen=True)
class Meadow:
    """A render of the meadow in every haze; its number is added to the run's seed."""

    number: int


def cases(effort: Effort) -> list[Targets | Meadow]:
    """Return the targets by every way that works here and every visibility, then the meadow."""
    ways = {"scalar": SCALAR_VARIANT, "jit": JIT_VARIANT, "medium": choose()}
    working = {name: variant for name, variant in ways.items() if works(variant) is True}
    return [
        *(
            Targets(way, visibility, variant, effort["target_spp"][way])
            for way, variant in working.items()
            for visibility in VISIBILITIES_M
        ),
        *(Meadow(number) for number in range(effort["seeds"])),
    ]


def measure(case: Targets | Meadow, seed: int) -> Point | list[Point]:
    """Measure the targets in one way, or the meadow: a point for each of its bands of distance."""
    if isinstance(case, Targets):
        return _targets(case, seed)
    return [
        Point({"what": "bands", "from": low}, samples=columns({k: [v] for k, v in values.items()}))
        for low, values in _compared(_meadow(), seed + case.number).items()
    ]


def notes(effort: Effort, seed: int, points: tuple[Point, ...]) -> dict[str, Any]:
    """Return the samples of a pixel, and the sizes of the run."""
    return {"meadow_spp": _SPP, **effort.sizes}


def _targets(case: Targets, seed: int) -> Point:
    """Measure the radiance of every target in haze, and of the endless path beside it."""
    haze = "medium" if case.way == "medium" else "analytic"
    target, beyond = look_at(case.visibility, Quality(case.variant, case.spp, seed, 4, haze))
    step, albedo = order(seed)
    seen = {"target": target, "beyond": beyond}
    radiance = (
        Column(name, _nano(rgb[:, number]), {"band": band})
        for number, band in enumerate("rgb")
        for name, rgb in seen.items()
    )
    named = {"what": "targets", "way": case.way, "visibility": case.visibility}
    return Point(
        named, samples=(*columns({"step": step.tolist(), "grey": albedo.tolist()}), *radiance)
    )


@lru_cache(maxsize=1)
def _meadow() -> FrameInput:
    preset = load_preset("meadow", list(MEADOW))
    return assemble_frame(build_world(preset), preset, 1, choose())


def _compared(shot: FrameInput, seed: int) -> dict[float, dict[str, int]]:
    """Return mean luminance by every kind of haze, and median ΔE of RGB and spectral, by band."""
    seen = {kind: _rendered(shot, kind, seed) for kind in _SPP}
    distance, difference = seen["analytic"].Z, delta_e(seen["analytic"].rgb, seen["spectral"].rgb)
    edges, made = (*BAND_EDGES_M, float(SKY_Z)), {}
    for low, high in zip(edges, (*edges[1:], np.inf), strict=True):
        mine = (distance >= low) & (distance < high)
        if not mine.any():
            continue
        values = {k: float((frame.rgb[mine] @ LUMINANCE).mean()) for k, frame in seen.items()}
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
    """Return CIEDE2000 of two pictures, each at the exposure that suits it, (h, w)."""
    from colour import RGB_to_XYZ, XYZ_to_Lab, delta_E

    labs = []
    for rgb in (one, other):
        light = np.maximum(rgb.astype(np.float64), 0.0) * auto_exposure(rgb)
        labs.append(XYZ_to_Lab(RGB_to_XYZ(light, "ITU-R BT.709")))
    return np.asarray(delta_E(labs[0], labs[1], method="CIE 2000"))


def _nano(values: np.ndarray) -> list[int]:
    return [round(1e9 * float(value)) for value in values]


def scene_hash(points: tuple[Point, ...]) -> str:
    """Return the SHA-256 of the preset, the visibilities and the bands."""
    preset = load_preset("meadow", list(MEADOW)).model_dump(mode="json")
    return scene_digest([preset, VISIBILITIES_M, BAND_EDGES_M])
