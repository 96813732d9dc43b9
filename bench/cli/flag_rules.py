"""Which flags exclude or need one another? One table, which every command is held against.

What is said twice of one key is refused, too, be it by a flag, by --density or by -D.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import click
from click.core import ParameterSource

from bench.cli.kernel_cache import use_scratch
from bench.cli.view_flags import FLAG_KEYS
from lod.errors import InputError


@dataclass(frozen=True)
class Rule:
    """Two flags, or keys of a preset, of which one excludes or needs the other, and why."""

    one: str
    other: str
    why: str


EXCLUDES = (
    Rule("resume", "overwrite", "one keeps what is done, the other replaces it"),
    Rule("view.detail", "view.max_parts", "a budget of parts chooses the detail"),
    Rule("view.detail", "fit", "a budget of memory chooses the detail"),
)
NEEDS = (
    Rule("tone", "preview", "frames are linear, and only previews have a tone"),
    Rule("view", "preview", "frames hold all layers, and only previews show one"),
    Rule("exposure", "preview", "frames are linear, and only previews are exposed"),
    Rule("fit", "max_memory", "it fills a budget"),
    Rule("cluster", "repair", "workers only repair; looking is done here"),
    Rule("threads", "repair", "threads only repair; looking is done by one"),
    Rule("max_memory", "repair", "only what is rendered again needs memory"),
)
"""A rule is for the commands that have both flags."""

EXAMPLES = {"max_memory": "--max-memory 4GB"}


class StrictCommand(click.Command):
    """A command that refuses what is said twice, and flags that the table sets against another."""

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        """Parse as click does, then hold what was given against the rules. Raises InputError."""
        words = list(args)
        rest = super().parse_args(ctx, args)
        if not ctx.resilient_parsing:
            *_, order = self.make_parser(ctx).parse_args(args=words)
            check_flags(ctx, order)
        return rest

    def invoke(self, ctx: click.Context) -> Any:
        """Run the command; without any other place, scratch is where its results go."""
        for name in ("pattern", "path", "folder"):
            if ctx.params.get(name) and self._writes(name):
                target = Path(ctx.params[name])
                use_scratch(target if name == "folder" else target.parent)
        return super().invoke(ctx)

    def _writes(self, name: str) -> bool:
        """Whether that parameter is the command's -o."""
        return any(each.name == name and "-o" in each.opts for each in self.params)


def check_flags(ctx: click.Context, order: Sequence[click.Parameter]) -> None:
    """Raise InputError where flags contradict; ``order`` has each as often as it was given."""
    said: dict[str, str] = {}
    for key, source in _said(ctx, order):
        if key in said:
            told = f"{said[key]} {source}" if said[key] != source else source
            raise InputError(told, "twice", "each key is said once", "leave one out")
        said[key] = source
    names = {FLAG_KEYS.get(each.name or "", each.name) for each in ctx.command.params}
    for rule in EXCLUDES:
        if rule.one in said and rule.other in said:
            where = f"{said[rule.one]} {said[rule.other]}"
            raise InputError(where, "both", rule.why, "leave one out")
    for rule in NEEDS:
        if rule.one in said and rule.other in names and rule.other not in said:
            flag = f"--{rule.other.replace('_', '-')}"
            cure = f"add {EXAMPLES.get(rule.other, flag)}, or leave it out"
            raise InputError(said[rule.one], "alone", rule.why, cure)


def _said(ctx: click.Context, order: Sequence[click.Parameter]) -> Iterator[tuple[str, str]]:
    """Yield the key, or the name of the flag, and the source of everything that was given."""
    for parameter in order:
        name = parameter.name or ""
        given = ctx.get_parameter_source(name) == ParameterSource.COMMANDLINE
        if given and not parameter.multiple and isinstance(parameter, click.Option):
            yield FLAG_KEYS.get(name, name), f"--{name.replace('_', '-')}"
    settings: Sequence[Any] = ctx.params.get("settings") or ()
    for text in settings:
        key = text.partition("=")[0].strip()
        yield key, f"-D {key}"
    for text in ctx.params.get("density") or ():
        name = text.partition("=")[0].strip()
        yield f"species.{name}.density", f"--density {name}"
