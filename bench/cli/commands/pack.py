"""`lodbench pack`: a world as files for other programs, and parts that come back as a picture."""

from pathlib import Path
from typing import Any

import click

from bench.cli.flags import StrictCommand, memory_flag
from bench.cli.output import Output, progress_bar, tell_first_run
from scenes.files import make_folder


@click.group("pack")
def command() -> None:
    """Write a world for other programs, as USD, pbrt and part hierarchy: docs/packs.md."""


@command.command("make", cls=StrictCommand)
@click.argument("name", metavar="NAME")
@click.option("-o", "folder", required=True, metavar="DIR", help="Folder of the pack.")
@click.option("--walk", is_flag=True, help="Add references of the 24 frames of a walk.")
@click.option("--size", metavar="WxH", default="640x360", show_default=True, help="Of the still.")
@click.option("--spp", type=click.IntRange(1, 2**16), default=512, show_default=True, metavar="N")
@memory_flag
def make_command(
    name: str, folder: str, walk: bool, size: str, spp: int, max_memory: int | None, out: Output
) -> None:
    """Make a pack: NAME is WORLD-SIZE, as crowd-small, meadow-medium, forest-large, mountain-small.

    The same command again goes on where it was stopped; finished files are kept.
    """
    from bench.packs.content import settings_of
    from bench.packs.make import Recipe, make_pack
    from scenes.presets.load import load_preset
    from scenes.render.usd_export import check_usd

    preset, settings = settings_of(name)
    chosen = load_preset(preset, (*settings, f"render.size={size}")).render.size
    check_usd(Path(folder) / "scene.usda", True)
    place = make_folder(folder)
    tell_first_run()
    with progress_bar("file") as progress:
        found = make_pack(place, Recipe(name, chosen, spp), walk, max_memory, progress)
    still: dict[str, Any] = found["references"]["still"]
    out.record({"folder": str(place), **found})
    out.say(
        f"{place}: {found['instances']:,} copies, {found['sticks']:,} sticks, "
        f"{found['triangles']:,} triangles; noise of the reference: FLIP "
        f"{still['noise']['flip']:.4f}"
    )


@command.command("render", cls=StrictCommand)
@click.argument("folder", metavar="DIR")
@click.option("--kept", required=True, metavar="FILE", help="Parts that a method keeps.")
@click.option("-o", "path", required=True, metavar="OUT.exr", help="The picture: R, G, B and Z.")
@click.option("--frame", type=click.IntRange(1, 24), help="Of the walk; the still without it.")
@click.option("--spp", type=click.IntRange(1, 2**16), default=64, show_default=True, metavar="N")
@click.option("--seed", type=click.IntRange(0, 2**31), default=0, show_default=True, metavar="N")
@click.option("--overwrite", is_flag=True, help="Replace a file that is there.")
def render_command(
    folder: str,
    kept: str,
    path: str,
    frame: int | None,
    spp: int,
    seed: int,
    overwrite: bool,
    out: Output,
) -> None:
    """Render the parts of a pack that a method in another language kept."""
    from bench.packs.kept import render_kept
    from scenes.files import check_free, check_name, whole_file
    from scenes.render.exr.layer_file import write_channels

    check_name(path)
    check_free(path, overwrite)
    make_folder(Path(path).parent)
    tell_first_run()
    layers, counts = render_kept(Path(folder), Path(kept), frame or 0, spp, seed)
    channels = {name: layers.rgb[..., k] for k, name in enumerate("RGB")}
    with whole_file(path, overwrite) as temporary:
        write_channels(temporary, {**channels, "Z": layers.Z})
    out.record({"path": path, **counts, "seconds": layers.seconds})
    out.say(f"{path}: {counts['parts']:,} parts, {counts['sticks']:,} sticks")
