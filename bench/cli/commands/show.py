"""`lodbench show`: a preset with every key, as a TOML file to edit."""

from typing import Any

import click

from bench.cli.flags import StrictCommand, preset_from_flags, view_flags
from bench.cli.output import Output


@click.command("show", cls=StrictCommand)
@view_flags
def command(preset: str, out: Output, **flags: Any) -> None:
    """Print a preset as TOML, with every key, its value and its meaning.

    Keep it with `lodbench show meadow > mine.toml`, edit it, and give its path as a preset.
    """
    chosen = preset_from_flags(preset, **flags)
    from scenes.presets.load import preset_toml

    out.record(chosen.model_dump(mode="json"))
    out.say(preset_toml(chosen))
