"""`lodbench frames`: a sequence as one command a frame, for farms that run commands."""

import shlex
from collections.abc import Iterable, Iterator
from functools import partial

import click

from bench.cli.flags import FLAG_KEYS, StrictCommand, frame_numbers, preset_from_flags
from lod.errors import InputError
from scenes.files import check_pattern

_NOT_FOR_ONE = ("cluster", "preview")


@click.command(
    "frames", cls=StrictCommand, json="", context_settings={"ignore_unknown_options": True}
)
@click.option("--print-commands", is_flag=True, required=True, help="One line for each frame.")
@click.argument("words", metavar="PRESET -o OUT/NAME.####.exr …", nargs=-1, type=click.UNPROCESSED)
def command(print_commands: bool, words: tuple[str, ...]) -> None:
    """Print the render commands of single frames: every flag of `render`, the variant settled.

    They may run at once and anywhere: processes of the same settings share a folder.
    """
    from bench.cli.commands.render import command as render
    from scenes.render.budget import within_budget
    from scenes.render.variants import choose

    names = click.get_current_context().help_option_names  # a command keeps those it first gets
    flags = render.make_context("lodbench render", list(words), help_option_names=names).params
    for name in _NOT_FOR_ONE:
        if flags.pop(name):
            raise InputError(f"--{name}", "given", "not for single frames", "leave it out")
    check_pattern(flags["pattern"])
    numbers = frame_numbers(flags["frames"])
    told = {name: value for name, value in flags.items() if name in FLAG_KEYS}
    chosen = preset_from_flags(
        flags["preset"], flags["settings"], flags["density"], flags["say"], **told
    )
    variant = choose(chosen.render.variant, chosen.render.spectral)
    kept = [*drop_flag(drop_flag(words, "--frames"), "--variant"), "--variant", variant]
    if flags["max_parts"] is not None:
        # One detail for all: a frame by itself would choose its own.
        note = partial(click.echo, err=True)
        detail = within_budget(chosen, numbers, flags["max_memory"], note).view.detail
        for flag in ("--max-parts", "--detail"):
            kept = list(drop_flag(kept, flag))
        kept += ["--detail", repr(detail)]
    if broken := next((word for word in kept if len(f"{word} ".splitlines()) > 1), None):
        raise InputError("words", broken, "words of one line", "choose names without line breaks")
    for number in numbers:
        click.echo(shlex.join(["lodbench", "render", *kept, "--frames", str(number)]))


def drop_flag(words: Iterable[str], flag: str) -> Iterator[str]:
    """Yield the words of a command line without a flag and its value."""
    skip = False
    for word in words:
        if not skip and word != flag and not word.startswith(f"{flag}="):
            yield word
        skip = not skip and word == flag
