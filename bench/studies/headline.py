"""One hazy frame of a world of 10¹⁵ objects, and the next: ``python -m bench.studies.headline``.

Every frame is rendered as ``lodbench render`` does it: pruned, posed, described, built, traced and
written in a process of its own, whose most memory is measured. The first frame of a process
compiles; of the next, share of the time that is not the renderer's (everything but "trace" and the
file) says whether the picture, or getting ready for it, is what one waits for. Wall-clock seconds.
"""

import math
import os
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import click

from bench.cli.output import table
from scenes.preset.load import Preset, load_preset
from scenes.render.mitsuba.variants import choose
from scenes.render.sequence.detail_budget import parts_displayed
from scenes.render.sequence.one_frame import settings_of
from scenes.render.sequence.worker import Worker
from scenes.world.world import build_world, view_at

OBJECTS = 1e15
NOT_READYING = ("trace", "write", "world", "denoise")
"""Stages that are the renderer's, the file's, or of the first frame alone."""


def preset_with(name: str, size: str, spp: int, objects: float) -> Preset:
    """A preset at τ = 1, 60° and V = 20 km with its own densities, in a world of so many objects.

    Raises InputError where the world would be larger than there may be.
    """
    keys = [f'render.size="{size}"', f"render.spp={spp}", 'air.visibility="20km"']
    keys += ["view.detail=1.0", "camera.fov=60.0", "camera.speed=1.4"]
    density = sum(each.density for each in load_preset(name).species.values())
    return load_preset(name, [*keys, f"world.extent={math.sqrt(objects / density):.0f}"])


def frames_of(preset: Preset, frames: int) -> Iterator[dict[str, Any]]:
    """Records of frames that one fresh process renders; ``wall`` seconds of each, start and all."""
    settings = settings_of(preset, choose(preset.render.variant))
    with tempfile.TemporaryDirectory() as folder, Worker() as worker:
        for frame in range(1, frames + 1):
            start, target = time.perf_counter(), Path(folder) / f"{frame}.exr"
            record = worker(settings, frame, target)
            yield {**record, "wall": time.perf_counter() - start}


def readying(record: dict[str, Any]) -> float:
    """Seconds of everything but the render: prune, appearance, describe and build."""
    return sum(s for name, s in record["seconds"].items() if name not in NOT_READYING)


def row(name: str, parts: int, record: dict[str, Any]) -> tuple[object, ...]:
    """What is printed of a frame."""
    spent, drawn = record["seconds"], record["statistics"]
    stages = (spent[stage] for stage in ("prune", "appearance", "describe", "build", "trace"))
    share = readying(record) / (readying(record) + spent["trace"])
    return (
        f"{name}, frame {record['frame']}",
        f"{parts:,}",
        f"{drawn['sticks']:,}",
        f"{drawn['triangles']:,}",
        *(f"{seconds:.2f}" for seconds in stages),
        f"{record['wall']:.1f}",
        f"{readying(record):.2f}",
        f"{100 * share:.1f} %",
        f"{record['peak_rss_bytes'] / 1e6:.0f}",
    )


HEADS: tuple[str, ...] = (
    *("", "parts", "sticks", "triangles", "prune s", "appearance s", "describe s", "build s"),
    *("trace s", "wall s", "all but trace s", "its share", "most MB so far"),
)


@click.command()
@click.option("--presets", default="crowd,meadow", show_default=True, help="Names.")
@click.option("--size", default="1280x720", show_default=True, help="Of the picture.")
@click.option("--spp", default=64, show_default=True, help="Samples a pixel.")
@click.option("--frames", default=2, show_default=True, help="Of a camera at 1.4 m/s.")
@click.option("--objects", default=OBJECTS, show_default=True, help="In the world.")
def main(presets: str, size: str, spp: int, frames: int, objects: float) -> None:
    """Measure and print."""
    rows: list[tuple[object, ...]] = [HEADS]
    for name in presets.split(","):
        preset = preset_with(name, size, spp, objects)
        world = build_world(preset)
        for record in frames_of(preset, frames):
            parts = parts_displayed(world, view_at(world, preset, record["frame"]))
            rows.append(row(name, parts, record))
    click.echo(table(rows))
    load = os.getloadavg()[0]
    click.echo(f"{os.cpu_count()} cores, load {load:.1f}, {objects:.3g} objects in each world")


if __name__ == "__main__":
    main()
