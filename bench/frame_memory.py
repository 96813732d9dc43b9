"""Memory that frames need in fresh processes, against what the memory model estimates.

Each case renders in a fresh process, whose most memory is measured; and many small frames in one
process show whether it grows. Bytes are facts of one system; the model was fitted to these. It is
a topic of the experiment ``cost``.
"""

import tempfile
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from bench.children import run_in_child
from bench.records.claims import EXACT, Claim, at_most, claim, within
from bench.records.records import Point, columns
from bench.statistics.estimates import exactly
from scenes.presets.load import load_preset
from scenes.processes.memory_limit import peak_rss_bytes
from scenes.render.budget import ExtraBuffers, predict_bytes
from scenes.render.exr.layer_file import write_exr
from scenes.render.variants import JIT_VARIANT, SCALAR_VARIANT
from scenes.scene import Scene, frame_quality


@dataclass(frozen=True)
class Held:
    """Frames of a preset with settings over it, in a fresh process whose memory is measured."""

    preset: str
    variant: str
    settings: tuple[str, ...]
    frames: int = 1


_SMALL, _LARGE = "render.size=320x180", "render.size=1280x720"
_MIDDLE = "render.size=640x360"
_SPECTRAL = "llvm_ad_spectral"
HELD = (
    Held("meadow", JIT_VARIANT, ("render.size=64x36", "render.spp=1", "species={}")),
    Held("zoo", JIT_VARIANT, (_LARGE, "render.spp=16")),
    Held("meadow", JIT_VARIANT, (_LARGE, "render.spp=1", "view.detail=2")),
    Held("crowd", JIT_VARIANT, (_SMALL, "render.spp=16", "view.detail=0.4")),
    Held("crowd", JIT_VARIANT, (_SMALL, "render.spp=4", "view.detail=2")),
    Held("zoo", JIT_VARIANT, (_SMALL, "render.spp=4")),
    Held("fly_in", JIT_VARIANT, ("render.size=1920x1080", "render.spp=1")),
    Held("meadow", SCALAR_VARIANT, (_SMALL, "render.spp=1", "species={}", "view.detail=0.25")),
    Held("meadow", SCALAR_VARIANT, (_SMALL, "render.spp=1", "view.detail=0.5")),
    Held("crowd", SCALAR_VARIANT, (_MIDDLE, "render.spp=4", "view.detail=2")),
    Held("meadow", JIT_VARIANT, (_MIDDLE, "render.haze=medium")),
    Held("meadow", _SPECTRAL, (_MIDDLE, "render.spectral=true")),
    Held("crowd", JIT_VARIANT, (_MIDDLE, "output.motion=true")),
    Held("meadow", JIT_VARIANT, (_LARGE, "render.spp=2", "view.detail=4", "output.denoise=true")),
    Held("crowd", JIT_VARIANT, (_MIDDLE, "view.shutter=180")),
)
"""Frames that differ in everything that the memory model knows, and in what it need not know."""

GROWTH = Held("meadow", JIT_VARIANT, ("render.size=16x9", "render.spp=1", "view.detail=8"), 200)


def frame_memory(name: str, settings: tuple[str, ...], variant: str, frames: int) -> dict[str, Any]:
    """Render and write frames of a preset, and return the most memory held after each [bytes].

    ``statistics`` are the counts of the last frame.
    """
    scene, peaks = Scene(load_preset(name, settings)), []
    for frame in range(1, frames + 1):
        layers = scene.render(frame, variant)
        with tempfile.TemporaryDirectory() as folder:
            write_exr(Path(folder) / "frame.exr", layers, {})
        peaks.append(peak_rss_bytes())
    return {"peaks": peaks, "statistics": layers.statistics}


def measure_memory(case: Held, seed: int) -> Point:
    """Measure what frames hold in a fresh process, beside what the memory model estimates."""
    words = case.preset, case.settings, case.variant, case.frames
    found = run_in_child(frame_memory, *words, variant=case.variant).result
    preset = load_preset(case.preset, case.settings)
    sticks, triangles = (found["statistics"][name] for name in ("sticks", "triangles"))
    output, open_shutter = preset.output, preset.view.shutter > 0
    beside = ExtraBuffers(output.motion, output.denoise, open_shutter)
    quality = frame_quality(preset, case.variant)
    said = predict_bytes(sticks, triangles, preset.render.size, quality, beside)
    named = {"topic": "memory", "preset": case.preset, "variant": case.variant}
    counts = {"sticks": [sticks], "triangles": [triangles], "estimated_bytes": [said]}
    samples = columns({**counts, "peak_bytes": found["peaks"]})
    return Point({**named, "settings": " ".join(case.settings)}, samples=samples)


def memory_claims(points: Sequence[Point]) -> Iterator[Claim]:
    """Claim that the model is within a quarter, and that frame after frame takes no more."""
    for point in points:
        told = {name: point.case[name] for name in ("preset", "variant", "settings")}
        held = point.values("peak_bytes")
        found = exactly(point.column("estimated_bytes")[0] / held[0])
        estimand, bound = "memory of a frame, estimated ÷ measured", within(1, 0.25)
        if len(held) > 1:
            found = exactly(held[-1] / held[len(held) // 10], len(held))
            estimand = "memory held after all frames ÷ after a tenth of them"
            bound, told = at_most(1.05), told | {"frames": len(held)}
        yield claim(estimand, bound, told, found, unit=EXACT, source="derived")
