"""`lodbench ids`: species, place and key of the objects of a frame."""

from collections.abc import Iterable
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING

import click

from bench.cli.flags import StrictCommand, memory_flag, memory_limit_bytes
from bench.cli.output import Progress, output, progress_bar, table, tell_first_run
from lod.errors import InputError

if TYPE_CHECKING:
    from scenes.render.object_keys import Identity


@click.command("ids", cls=StrictCommand)
@click.argument("path", metavar="OUT/NAME.0001.exr")
@click.option("--object", "objects", type=int, multiple=True, help="Only these ids of objects.")
@memory_flag
@click.option("--json", "as_json", is_flag=True, help="A JSON object for each on stdout.")
def command(path: str, objects: tuple[int, ...], max_memory: str | None, as_json: bool) -> None:
    """Species, cell, number and 128-bit key of a frame's objects, worked out from its header."""
    most_bytes = memory_limit_bytes(max_memory)
    with progress_bar("step") as show:
        found = list(_identities(Path(path), most_bytes, show))
    if strangers := sorted(set(objects) - {each.object for each in found}):
        rule = f"an id.object that {path} displays"
        raise InputError("--object", strangers[0], rule, "leave it out to list them")
    chosen = [each for each in found if not objects or each.object in objects]
    with output(as_json) as out:
        for each in chosen:
            out.record(asdict(each))
        rows = [(e.object, e.of, _cell(e), e.index, e.key or "–") for e in chosen]
        out.say(table([("object", "of", "cell", "index", "key"), *rows]))


def _cell(each: "Identity") -> str:
    return "–" if each.cell is None else f"{each.cell[0]},{each.cell[1]}"


def _identities(path: Path, most_bytes: int | None, show: Progress) -> Iterable["Identity"]:
    from scenes.render.exr.header import preset_from_settings
    from scenes.render.exr.sequence import read_whole
    from scenes.render.memory import preflight
    from scenes.render.object_keys import identities
    from scenes.scene import Scene

    whole = read_whole(path)
    preset = preset_from_settings(whole.settings)
    tell_first_run()
    show(0, 2, "memory")
    scene, frame = Scene(preset), whole.frame
    preflight(scene, (frame,), most_bytes)
    show(1, 2, "objects")
    return identities(scene, frame)
