"""`lodbench environments`: make the environments in which programs of others run.

They are no dependencies: each has pinned requirements of its own, and is made only here.
"""

import click

from bench.methods.environments import ENVIRONMENTS


@click.command("environments")
@click.argument("names", nargs=-1, type=click.Choice(sorted(ENVIRONMENTS)))
@click.option("--yes", is_flag=True, help="Do not ask before downloading.")
def command(names: tuple[str, ...], yes: bool) -> None:
    """Make environments for Cycles and ColorVideoVDP, or list those that there are."""
    for name in names:
        wanted = ENVIRONMENTS[name]
        click.echo(f"{name}: {wanted.about}; {wanted.asks}, in {wanted.folder}", err=True)
        if yes or click.confirm("Make it?", err=True):
            wanted.make()
    for each in ENVIRONMENTS.values():
        state = each.python() or f"not made ({each.asks})"
        click.echo(f"{each.name:8} {state}: {each.about}")
