"""`lodbench ask`: ask an actor of a preset, or one of its parts, what a message asks."""

from typing import Any

import click

from bench.cli.flags import StrictCommand, memory_flag, preset_from_flags, view_flags
from bench.cli.output import Output
from scenes.files import LAST_FRAME


@click.command("ask", cls=StrictCommand)
@view_flags
@memory_flag
@click.argument("words", metavar='"WHO [PART] QUESTION"')
@click.option("--frame", type=click.IntRange(1, LAST_FRAME), default=1, show_default=True)
def command(
    preset: str, words: str, frame: int, max_memory: int | None, out: Output, **flags: Any
) -> None:
    """Ask an actor for its place, posture or course in a frame, as a message.

    `position` and `orientation` are relative to the part's whole; `where` is in the scene.
    """
    from scenes.render.memory import preflight
    from scenes.scene import Scene
    from scenes.world.cast import answer_at, plain

    chosen = preset_from_flags(preset, **flags)
    preflight(Scene(chosen), (), max_memory)
    found = plain(answer_at(chosen, words, frame))
    out.record({"asked": words, "frame": frame, "answer": found})
    out.say(str(found))
