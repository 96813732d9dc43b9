"""`lodbench check`: the rules that metrics and representations of other packages must keep."""

from collections.abc import Iterable

import click

from bench.cli.flags import StrictCommand
from bench.cli.output import Output, output, table
from lod.errors import InputError


@click.command("check", cls=StrictCommand)
@click.argument("names", metavar="[NAME]...", nargs=-1)
@click.option("--json", "as_json", is_flag=True, help="One JSON object per name on stdout.")
def command(names: tuple[str, ...], as_json: bool) -> None:
    """Put metrics and representations through the rules that all others keep.

    Without NAME, everything that installed packages bring.
    """
    chosen = tuple(_chosen(names))
    if not chosen:
        cure = "try blake, or install a package that brings some (README: How to add yours)"
        raise InputError("NAME", names, "no other package brings a metric or representation", cure)
    with output(as_json) as out:
        failed = [name for kind, name in chosen if not _checked(out, kind, name)]
    if failed:
        raise click.ClickException(f"{', '.join(failed)}: not as the rules have it")


def _chosen(names: tuple[str, ...]) -> Iterable[tuple[str, str]]:
    """Give kind and name of everything that is to be checked."""
    from lod.metric import METRICS
    from scenes.plugins import METRIC, REPRESENTATION, installed

    known = {"metric": (*METRICS, *installed(METRIC)), "representation": installed(REPRESENTATION)}
    if not names:
        yield from (("metric", name) for name in installed(METRIC))
        yield from (("representation", name) for name in installed(REPRESENTATION))
    for name in names:
        found = [(kind, name) for kind, those in known.items() if name in those]
        if not found:
            rule = f"a metric or representation: {', '.join(n for k in known.values() for n in k)}"
            raise InputError("NAME", name, rule, "see `lodbench list`")
        yield from found


def _checked(out: Output, kind: str, name: str) -> bool:
    """Check one metric or representation, print the rules, and say whether it keeps all."""
    try:
        broken = _broken(kind, name)
    except InputError as error:
        broken = {"can be used": [str(error)]}
    out.record({"name": name, "kind": kind, "broken": {k: v for k, v in broken.items() if v}})
    rows = [
        (rule, "kept" if not found else line)
        for rule, found in broken.items()
        for line in found or [""]
    ]
    out.say(f"{name}, a {kind}\n{table(rows)}")
    return not any(broken.values())


def _broken(kind: str, name: str) -> dict[str, list[str]]:
    from bench.conformance import broken_metric_rules, broken_plugin_rules

    return broken_metric_rules(name) if kind == "metric" else broken_plugin_rules(name)
