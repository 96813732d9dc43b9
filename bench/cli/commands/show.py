"""`lodbench show`: a preset with every key, as a TOML file to edit."""

from typing import Any

import click

from bench.cli.flags import StrictCommand, preset_from_flags, view_flags
from bench.cli.output import output


@click.command("show", cls=StrictCommand)
@view_flags
@click.option("--json", "as_json", is_flag=True, help="One JSON object on stdout.")
def command(preset: str, as_json: bool, **flags: Any) -> None:
    """A preset as TOML, with every key, its value and its meaning.

    Keep it with `lodbench show meadow > mine.toml`, edit it, and give its path as a preset.
    """
    chosen = preset_from_flags(preset, **flags)
    from scenes.presets.load import preset_toml

    with output(as_json) as out:
        out.record(chosen.model_dump(mode="json"))
        out.say(preset_toml(chosen))
