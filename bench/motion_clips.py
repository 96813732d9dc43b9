"""`python -m bench.motion_clips`: clips in which nothing should pop or stutter, and a table.

A fast pan, a walk past walkers, a turn that stops, and a flight over trees, each as it is pruned
(by motion too, and with parts kept for as long as they are off by less than half a pixel) beside
the same clip with everything drawn in every frame. The table has what motion does not explain from
frame to frame (``picture_lookup``) of both. In a window of 120 m, where everything can be drawn.
"""

from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path

import click
import numpy as np

from bench.output import table
from bench.picture_lookup import Shot, unexplained
from scenes.preset import Preset, load_preset
from scenes.render.contact_sheet import contact_sheet
from scenes.render.exr import write_exr
from scenes.render.frame import Layers
from scenes.render.header import frame_header
from scenes.render.movie import movie
from scenes.render.render import render_frame
from scenes.render.shutter import render_exposed
from scenes.render.variants import choose
from scenes.shot import shoot
from scenes.world import World, build_world, view_at

WORLD = (
    "render.max_depth=3",
    "render.subframes=8",
    "world.extent=120.0",
    "species.tree.density=0.002",
    "species.tree.prototypes=2",
    "species.tree.sizes=[0.6]",
    "species.figure.density=0.004",
    "species.figure.prototypes=2",
    "terrain.reach=300.0",
    "terrain.amplitude=1.0",
    "terrain.wavelength=256.0",
)
_TURN = (
    "camera.keys=[{frame=1, position=[0, -30], height=1.7, target=[-12, 0, 1.7]},"
    "{frame=6, position=[0, -30], height=1.7, target=[6, 0, 1.7]},"
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
    "walk": ("camera.speed=1.4", "species.figure.patrol=6", "view.update_threshold=0.5"),
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
QUANTILE = 0.999


def frames_of(preset: Preset, world: World, count: int, variant: str) -> Iterator[Shot]:
    """The frames of a clip. Samples are at the same places of every pixel in every frame."""
    for number in range(1, count + 1):
        made = shoot(world, preset, number, variant)
        lit = made.air, made.light, made.quality
        if made.instants:
            layers = render_exposed(made.instants, *lit)
        else:
            layers = render_frame(made.camera, made.visible, *lit)
        yield Shot(view_at(world, preset, number), layers)


def clip(name: str, settings: tuple[str, ...], count: int, folder: Path) -> list[list[str]]:
    """Both ways of a clip, side by side on disk, and their rows of the table."""
    variant, made = choose(), {}
    for way, pruned in WAYS.items():
        preset = load_preset("meadow", (*WORLD, *CLIPS[name], *pruned, *settings))
        made[way] = list(frames_of(preset, build_world(preset), count, variant))
    paths = []
    for number, (one, other) in enumerate(zip(*made.values(), strict=True), 1):
        path = folder / f"{name}.{number:04d}.exr"
        header = frame_header(one.view.camera, preset.camera.fps, {"clip": name, "frame": number})
        write_exr(path, _beside(one.layers, other.layers), header)
        paths.append(path)
    contact_sheet(paths, folder / f"{name}.png", columns=2, width=640)
    movie(paths, folder / f"{name}.mp4", preset.camera.fps)
    left = {way: _residuals(frames) for way, frames in made.items()}
    return [
        [name, str(number + 2), *(f"{left[way][number]:.4f}" for way in WAYS)]
        for number in range(count - 1)
    ]


def _residuals(frames: list[Shot]) -> list[float]:
    """Of every frame but the first, what motion does not explain of it, at the quantile."""
    return [float(np.quantile(unexplained(*pair), QUANTILE)) for pair in pairwise(frames)]


def _beside(one: Layers, two: Layers) -> Layers:
    """Two frames as one, side by side."""

    def joined(layer: str) -> np.ndarray:
        return np.concatenate((getattr(one, layer), getattr(two, layer)), axis=1)

    pictures = joined("rgb"), joined("Z"), joined("N"), joined("albedo")
    return Layers(*pictures, joined("object"), joined("part"), joined("level"))


@click.command()
@click.option("-o", "folder", default="out/motion_clips", type=click.Path(path_type=Path))
@click.option("--frames", "count", default=12, type=click.IntRange(2, 240), show_default=True)
@click.option("--size", default="160x90", show_default=True)
@click.option("--spp", default=32, show_default=True)
@click.option("--clip", "names", multiple=True, type=click.Choice(list(CLIPS)), help="Some alone.")
def main(folder: Path, count: int, size: str, spp: int, names: tuple[str, ...]) -> None:
    """Render the clips, pruned on the left, and print what motion does not explain."""
    folder.mkdir(parents=True, exist_ok=True)
    rows = [["clip", "frame", *WAYS]]
    for name in names or CLIPS:
        found = clip(name, (f"render.size={size}", f"render.spp={spp}"), count, folder)
        rows += found
        worst = max(float(row[2]) / max(float(row[3]), 1e-4) for row in found)
        click.echo(f"{name}: at most {worst:.2f} times what it is with everything drawn")
    click.echo(table([tuple(row) for row in rows]))


if __name__ == "__main__":
    main()
