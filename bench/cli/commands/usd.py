"""`lodbench usd`: what is displayed in one frame, for other programs."""

from functools import partial
from pathlib import Path
from typing import Any

import click

from bench.cli.flags import StrictCommand, memory_flag, preset_from_flags, view_flags
from bench.cli.output import Output, progress_bar, tell_first_run
from lod.errors import InputError
from scenes.files import LAST_FRAME, make_folder


@click.command("usd", cls=StrictCommand)
@view_flags
@memory_flag
@click.option("-o", "path", required=True, metavar="OUT.usdc", help="A .usda, .usdc or .usd file.")
@click.option("--frame", type=click.IntRange(1, LAST_FRAME), default=1, show_default=True)
@click.option("--overwrite", is_flag=True, help="Replace a file that is there.")
def command(
    preset: str,
    path: str,
    frame: int,
    overwrite: bool,
    out: Output,
    max_memory: int | None,
    **flags: Any,
) -> None:
    """Write a frame's cut and camera as USD: sticks as curves, the ground as a mesh."""
    from scenes.render.budget import within_budget
    from scenes.render.memory import preflight
    from scenes.render.usd_export import check_usd, write_usd
    from scenes.render.variants import SCALAR_VARIANT
    from scenes.scene import Scene

    check_usd(path, overwrite)
    tell_first_run()
    chosen = preset_from_flags(preset, **flags)
    if chosen.camera.projection == "panorama" or chosen.camera.stereo:
        key = "stereo" if chosen.camera.stereo else "projection"
        rule, cure = "one camera in perspective", f"USD has no other here: leave {key} out"
        raise InputError(f"camera.{key}", getattr(chosen.camera, key), rule, cure)
    chosen = within_budget(chosen, (frame,), max_memory, partial(click.echo, err=True))
    make_folder(Path(path).parent)
    with progress_bar("step") as show:
        show(0, 3, "memory")
        scene = Scene(chosen)
        preflight(scene, (frame,), max_memory, SCALAR_VARIANT)
        show(1, 3, "cut")
        made = scene.input(frame, SCALAR_VARIANT)
        notes = {"lod:frame": str(frame), "lod:seed": str(chosen.seed)}
        notes["lod:air"] = chosen.air.model_dump_json()
        show(2, 3, "file")
        counts = write_usd(path, made, notes, overwrite)
    out.record({"frame": frame, "path": path, **counts})
    out.say(f"{path}  {counts['sticks']:,} sticks, {counts['triangles']:,} triangles")
