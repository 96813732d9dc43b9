"""`lodbench study NAME`: programs that answer one question each, beside the experiments."""

import click

from bench.cli.flags import memory_flag_of_all
from bench.studies.registry import load_study, study_descriptions
from lod.errors import InputError
from scenes.presets.keys import nearest_name


class Studies(click.Group):
    """Group of the studies, each imported only when it is run."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        """Name the studies in alphabetical order."""
        return list(study_descriptions())

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command:
        """Import the study of that name. Raises InputError for an unknown one."""
        if cmd_name not in study_descriptions():
            cure = nearest_name(cmd_name, tuple(study_descriptions()))
            raise InputError("NAME", cmd_name, "no study of that name", cure)
        return load_study(cmd_name)

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write a line for each study, from its docstring alone."""
        with formatter.section("Studies"):
            formatter.write_dl(list(study_descriptions().items()))


@click.group(
    "study",
    cls=Studies,
    subcommand_metavar="NAME [ARGUMENTS]...",
    invoke_without_command=True,
)
@memory_flag_of_all
@click.pass_context
def command(ctx: click.Context) -> None:
    """Run a study: a program of its own that prints what it measures, and judges no claim."""
    if ctx.invoked_subcommand is None:
        click.echo(ctx.get_help())
