"""What does motion not explain in clips of moving cameras, pruned and with everything drawn?

A fast pan, a walk past walkers, a turn that stops, and a flight over trees, each as it is pruned
(by motion too, and with parts kept for as long as they are off by less than half a pixel) beside
the same clip with everything drawn in every frame. In a window of 120 m, where that can be.

The table has of every frame what motion does not explain (``unexplained_change``), at a quantile
over its pixels that the frame before looked at, too: of both, and of a planted clip in which parts
pop, every other frame as coarse again, and stutter. It is looked for in sharp pictures of what is
displayed, as no open shutter would show it: with samples of its own in every frame, and with the
same samples, so that whatever switches is seen without noise. Where the planted clip leaves no more
than the one with everything drawn, nothing is proved, and that is said.
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import click
import numpy as np
from jaxtyping import Bool
from PIL import Image

from bench.cli.output import counted, table
from bench.experiments.popping.unexplained_change import Walk, walk
from lod.camera import Camera
from scenes.files import check_ours, make_folder
from scenes.frame.layers import Layers
from scenes.presets.load import load_preset
from scenes.presets.schema import Preset
from scenes.render.exr.header import frame_header
from scenes.render.exr.layers import write_exr
from scenes.render.pictures import save_picture, write_contact_sheet, write_movie
from scenes.render.render import render_frame
from scenes.render.variants import choose
from scenes.scene import assemble_frame, view_at
from scenes.world.world import World, build_world

WORLD = (
    "render.max_depth=3",
    "render.subframes=8",
    "world.extent=120.0",
    "species.tree.density=0.002",
    "species.sward.density=0",
    "species.tree.prototypes=2",
    "species.tree.sizes=[0.6]",
    "species.figure.density=0.004",
    "species.figure.prototypes=2",
    "terrain.reach=300.0",
    "terrain.amplitude=1.0",
    "terrain.wavelength=256.0",
)
_TURN = (
    "camera.keys=[{frame=1, position=[0, -30], height=1.7, target=[-32, -10, 1.7]},"
    "{frame=15, position=[0, -30], height=1.7, target=[3.5, -0.7, 1.7]},"
    "{frame=16, position=[0, -30], height=1.7, target=[6, 0, 1.7]},"
    "{frame=99, position=[0, -30], height=1.7, target=[6, 0, 1.7]}]"
)
CLIPS = {
    "pan": (
        "camera.turn=90",
        "camera.speed=0",
        "camera.position=[0, -30]",
        "camera.heading=-25",
        "view.shutter=180",
    ),
    "walk": (
        "camera.speed=1.4",
        "camera.position=[0, -30]",
        "camera.heading=-25",
        "species.figure.patrol=6",
        "view.update_threshold=0.5",
    ),
    "stop": ("view.shutter=180", _TURN),
    "fly-over": (
        "camera.speed=20",
        "camera.height=25",
        "camera.pitch=-25",
        "camera.position=[0, -70]",
        "camera.heading=0",
        "view.shutter=180",
    ),
}
WAYS = {
    "pruned": (),
    "everything": ("view.metric=full", "view.smear=off", "view.update_threshold=0"),
}
_CLIPPED = ("view.fade=0", "view.update_threshold=4")
PLANTED = (_CLIPPED, (*_CLIPPED, "view.detail=2"))
"""Parts of one to two pixels are there in every other frame alone, and others are kept until one
must see it: from where the camera turns in one place, nothing of a clip that is just coarse would
pop."""

MOST_RATIO = 1.1
"""Greatest ratio of what a clip leaves unexplained to what the unpruned clip leaves."""

QUANTILE = 0.999
MEASURED_SPP = 36

_EVERY, _STILL_PX = 4, 192
"""Frames from one still of a sheet to the next, and how wide they are."""


def frames_of(preset: Preset, world: World, count: int, variant: str) -> Iterator[Layers]:
    """Render the frames of a clip."""
    for number in range(1, count + 1):
        made = assemble_frame(world, preset, number, variant)
        yield render_frame(made, number)


def clip_files(name: str, count: int, folder: Path) -> list[Path]:
    """Name the files of a clip: its frames, then its sheet of stills and its film."""
    frames = [folder / f"{name}.{number:04d}.exr" for number in range(1, count + 1)]
    return [*frames, folder / f"{name}.png", folder / f"{name}.mp4"]


def write_film(name: str, settings: tuple[str, ...], count: int, folder: Path) -> None:
    """Write a clip, pruned beside everything drawn: frames, a sheet of stills, and a film."""
    variant = choose()
    *paths, sheet, film = clip_files(name, count, folder)
    presets = [
        load_preset("meadow", (*WORLD, *CLIPS[name], *way, *settings)) for way in WAYS.values()
    ]
    world = build_world(presets[0])
    both = [frames_of(preset, world, count, variant) for preset in presets]
    shown = counted(paths, "frame", lambda path: name)
    for number, (path, one, other) in enumerate(zip(shown, *both, strict=True), 1):
        view = view_at(world, presets[0], number)
        fps = presets[0].camera.fps
        header = frame_header(view.camera, fps, {"clip": name}, number)
        path.unlink(missing_ok=True)
        write_exr(path, _beside(one, other), header)
    write_contact_sheet(paths[::_EVERY], sheet, columns=2, width=2 * _STILL_PX)
    with Image.open(sheet) as picture:
        save_picture(picture.quantize(256), sheet, optimize=True)
    write_movie(paths, film, presets[0].camera.fps)


def measure_clip(name: str, settings: tuple[str, ...], numbers: Sequence[int]) -> dict[str, Walk]:
    """Measure what motion does not explain of every way of a clip, and of the planted one.

    It is 0 where the frame before did not look.
    """
    made = {}
    ways = {**{way: (pruned,) for way, pruned in WAYS.items()}, "planted": PLANTED}
    for way, turns in ways.items():
        presets = [load_preset("meadow", (*WORLD, *CLIPS[name], *t, *settings)) for t in turns]
        preset, world = presets[0], build_world(presets[0])
        seen = walk(world, presets, numbers, choose())
        cameras = (view_at(world, preset, number).camera for number in numbers)
        known = np.stack([pixels_seen_before(*both) for both in pairwise(cameras)])
        unexplained, switched = (
            np.where(known, each, 0) for each in (seen.unexplained, seen.switched)
        )
        made[way] = replace(seen, unexplained=unexplained, switched=switched)
    return made


def pixels_seen_before(before: Camera, now: Camera) -> Bool[np.ndarray, "h w"]:
    """Mark pixels of ``now`` whose direction the camera ``before`` has in its picture, too."""
    tan_x, tan_y = now.tan_half
    x = tan_x * (2 * (np.arange(now.width) + 0.5) / now.width - 1)
    y = tan_y * (1 - 2 * (np.arange(now.height) + 0.5) / now.height)
    ray = now.forward + x[None, :, None] * now.right + y[:, None, None] * now.up
    depth = ray @ before.forward
    tan_x, tan_y = before.tan_half
    across, up = abs(ray @ before.right), abs(ray @ before.up)
    return (across < tan_x * depth) & (up < tan_y * depth)


def table_rows(name: str, found: dict[str, Walk], first: int) -> list[tuple[object, ...]]:
    """Make a row for each frame after ``first``: quantiles with other and with the same samples."""
    columns = [
        np.quantile(each, QUANTILE, axis=(1, 2))
        for way in found.values()
        for each in (way.unexplained, way.switched)
    ]
    frames = enumerate(zip(*columns, strict=True), first + 1)
    return [(name, at, *(f"{value:.4f}" for value in row)) for at, row in frames]


def verdict_line(name: str, found: dict[str, Walk]) -> str:
    """Write what motion leaves unexplained of a clip, relative to everything drawn.

    Also says how many parts came or went at full size.
    """
    left = {way: float(np.quantile(each.unexplained, QUANTILE)) for way, each in found.items()}
    words = [f"{way} {left[way] / left['everything']:.2f}" for way in ("pruned", "planted")]
    most = MOST_RATIO * left["everything"]
    within = "within" if left["pruned"] <= most else "beyond"
    if left["planted"] <= most:
        within = "which proves nothing, as the planted one is within"
    popped = ", ".join(f"{way} {each.popped.sum()}" for way, each in found.items())
    told = f"{', '.join(words)} of what everything drawn has; {within} {MOST_RATIO}"
    return f"{name}: {told}; parts popped: {popped}"


def _beside(one: Layers, two: Layers) -> Layers:
    """Join two frames side by side into one."""

    def joined(layer: str) -> np.ndarray:
        return np.concatenate((getattr(one, layer), getattr(two, layer)), axis=1)

    pictures = joined("rgb"), joined("Z"), joined("N"), joined("albedo")
    return Layers(*pictures, joined("object"), joined("part"), joined("level"))


@click.command()
@click.option("-o", "folder", default="out/clips", type=click.Path(path_type=Path))
@click.option("--frames", "count", default=24, type=click.IntRange(2, 240), show_default=True)
@click.option("--size", default="320x180", show_default=True, help="Of each film.")
@click.option("--spp", default=16, show_default=True)
@click.option("--measure-size", default="160x90", show_default=True, help="Where it is measured.")
@click.option("--measure", "ends", type=(int, int), help="Its first and last frame; else all.")
@click.option("--clip", "names", multiple=True, type=click.Choice(list(CLIPS)), help="Some alone.")
@click.option("--table-only", is_flag=True, help="Measure, and render no film.")
@click.option("--overwrite", is_flag=True, help="Replace files that lodbench did not make.")
def command(
    folder: Path,
    count: int,
    measure_size: str,
    ends: tuple[int, int] | None,
    names: tuple[str, ...],
    table_only: bool,
    overwrite: bool,
    **film: Any,
) -> None:
    """Render clips, pruned beside everything drawn, and print what motion leaves unexplained."""
    if not table_only:
        make_folder(folder)
        for name in names or CLIPS:
            check_ours(clip_files(name, count, folder), overwrite)
    first, last = ends or (1, count)
    if not 1 <= first < last:
        raise click.UsageError(f"--measure {first} {last}: two frames or more, from 1; try 12 19")
    rows: list[tuple[object, ...]] = []
    for name in names or CLIPS:
        if not table_only:
            write_film(
                name, tuple(f"render.{key}={value}" for key, value in film.items()), count, folder
            )
        looks = f"render.size={measure_size}", f"render.spp={MEASURED_SPP}"
        found = measure_clip(name, looks, range(first, last + 1))
        click.echo(verdict_line(name, found))
        rows += table_rows(name, found, first)
    heads = [text for way in found for text in (way, f"{way}, same samples")]
    click.echo(table([("clip", "frame", *heads), *rows]))
