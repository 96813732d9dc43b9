"""Memory that frames need in a fresh process, against what the memory model predicts.

Each scene is rendered in a fresh process, whose most memory is measured; and 200 small frames in
one process show whether it grows. Bytes are facts of one system; the model was fitted to these.
"""

import json
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import click

from bench.cli.output import table
from scenes.files import check_free, whole_file
from scenes.presets.load import load_preset
from scenes.render.exr.header import Record, frame_settings
from scenes.render.memory import ExtraBuffers, predict_bytes
from scenes.render.worker import Worker
from scenes.scene import frame_quality


@dataclass(frozen=True)
class Scene:
    """A preset with settings over it, in one variant."""

    preset: str
    variant: str
    settings: tuple[str, ...]


_SMALL, _LARGE = 'render.size="320x180"', 'render.size="1280x720"'
_LLVM, _SCALAR, _SPECTRAL = "llvm_ad_rgb", "scalar_rgb", "llvm_ad_spectral"
_MIDDLE = 'render.size="640x360"'
SCENES = (
    Scene("meadow", _LLVM, ('render.size="64x36"', "render.spp=1", "species={}")),
    Scene("zoo", _LLVM, (_LARGE, "render.spp=16")),
    Scene("meadow", _LLVM, (_LARGE, "render.spp=1", "view.detail=2")),
    Scene("crowd", _LLVM, (_SMALL, "render.spp=16", "view.detail=0.4")),
    Scene("crowd", _LLVM, (_SMALL, "render.spp=4", "view.detail=2")),
    Scene("zoo", _LLVM, (_SMALL, "render.spp=4")),
    Scene("fly_in", _LLVM, ('render.size="1920x1080"', "render.spp=1")),
    Scene("meadow", _SCALAR, (_SMALL, "render.spp=1", "species={}", "view.detail=0.25")),
    Scene("meadow", _SCALAR, (_SMALL, "render.spp=1", "view.detail=0.5")),
    Scene("crowd", _SCALAR, ('render.size="640x360"', "render.spp=4", "view.detail=2")),
    Scene("meadow", _LLVM, (_MIDDLE, 'render.haze="medium"')),
    Scene("meadow", _LLVM, (_MIDDLE, 'render.haze="scattered"')),
    Scene("meadow", _SPECTRAL, (_MIDDLE, "render.spectral=true")),
    Scene("crowd", _LLVM, (_MIDDLE, "output.motion=true")),
    Scene("meadow", _LLVM, (_LARGE, "render.spp=2", "view.detail=4", "output.denoise=true")),
    Scene("crowd", _LLVM, (_MIDDLE, "view.shutter=180")),
)
"""Scenes that differ in everything that the model knows, and in what it need not know."""

GROWTH = Scene("meadow", _LLVM, ('render.size="16x9"', "render.spp=1", "view.detail=8"))
FRAMES = 200


def render_scene(scene: Scene, frames: int = 1) -> Iterator[Record]:
    """Render frames in one fresh process, and yield their records, with ``peak_rss_bytes``."""
    preset = load_preset(scene.preset, scene.settings)
    settings = frame_settings(preset, scene.variant)
    with tempfile.TemporaryDirectory() as folder, Worker() as worker:
        for frame in range(1, frames + 1):
            target = Path(folder) / f"{frame}.exr"
            yield worker(settings, frame, target)
            target.unlink()


def predicted_memory(scene: Scene, record: Record) -> int:
    """Predict the memory [bytes] of a frame from the sticks and triangles of its record."""
    preset = load_preset(scene.preset, scene.settings)
    counts = record["statistics"]["sticks"], record["statistics"]["triangles"]
    output, open_shutter = preset.output, preset.view.shutter > 0
    beside = ExtraBuffers(output.motion, output.denoise, open_shutter)
    quality = frame_quality(preset, scene.variant)
    return predict_bytes(*counts, preset.render.size, quality, beside)


def memory_growth(frames: int = FRAMES) -> tuple[int, int]:
    """Peak memory [bytes] after a tenth of the frames, when all is compiled, and after all."""
    peaks = [record["peak_rss_bytes"] for record in render_scene(GROWTH, frames)]
    return peaks[frames // 10], peaks[-1]


@click.command()
@click.option("-o", "path", metavar="FILE", help="Write the numbers there, as JSON.")
@click.option("--overwrite", is_flag=True, help="Replace a file that is there.")
def command(path: str | None, overwrite: bool) -> None:
    """Measure, print, and write where asked."""
    if path:
        check_free(path, overwrite)
    rows: list[tuple[object, ...]] = []
    for scene in SCENES:
        (record,) = render_scene(scene)
        said, was = predicted_memory(scene, record), record["peak_rss_bytes"]
        counts = record["statistics"]["sticks"], record["statistics"]["triangles"]
        name = " ".join((scene.preset, *scene.settings))
        rows.append((name, scene.variant, *counts, said / 1e6, was / 1e6, said / was))
        click.echo(table(rows[-1:]))
    before, after = memory_growth()
    heads = ("scene", "variant", "sticks", "triangles", "predicted MB", "measured MB", "ratio")
    click.echo(table([heads, *rows]))
    click.echo(f"{FRAMES} frames in one process: {before / 1e6:.0f} → {after / 1e6:.0f} MB")
    if path:
        body = {"scenes": [dict(zip(heads, row, strict=True)) for row in rows]}
        text = json.dumps({**body, "growth_bytes": [before, after]}, indent=1)
        with whole_file(path, overwrite) as temporary:
            temporary.write_text(text + "\n", encoding="utf-8")
