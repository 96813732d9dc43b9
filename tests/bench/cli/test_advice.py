"""Every flag that a message names is one that the program has."""

import ast
import re
from collections.abc import Iterator
from pathlib import Path

import click
import pytest

from bench.cli.main import COMMANDS, program
from bench.studies.registry import load_study, study_descriptions

ROOT = Path(__file__).resolve().parents[3]
FLAG = re.compile(r"(?<![\w-])--[a-z][a-z-]*[a-z]\b")
ARGUMENT = re.compile(FLAG.pattern + r"(=\S+)?")
OF_OTHERS = {
    "--scheduler-file": "dask scheduler",
    "--flatten": "usdcat",
}
"""Flags of other programs, each with a word of the text that names it."""


def flags() -> set[str]:
    """Every flag of every command and study."""
    context = click.Context(program)
    groups = [program.get_command(context, name) for name in COMMANDS]
    commands = [program, *groups, *map(load_study, study_descriptions())]
    commands += [each for g in groups if isinstance(g, click.Group) for each in g.commands.values()]
    options = [each for command in commands if command for each in command.params]
    found = {flag for each in options for flag in (*each.opts, *each.secondary_opts)}
    return {*found, "--help", "--version"}


def messages() -> Iterator[tuple[str, str]]:
    """Every text in the rooms that names a flag, with its place; docstrings, too.

    A text that is a flag and nothing else is an argument. The programs of a folder that have flags
    of their own, for whoever starts them by hand, name them so, and may name them in messages.
    """
    for room in ("lod", "scenes", "bench"):
        for folder in sorted({path.parent for path in (ROOT / room).rglob("*.py")}):
            texts = [each for path in sorted(folder.glob("*.py")) for each in literals(path)]
            own = {text.split("=")[0] for _, text in texts if ARGUMENT.fullmatch(text)}
            for place, text in texts:
                rest = FLAG.sub(lambda found, own=own: "" if found[0] in own else found[0], text)
                if not ARGUMENT.fullmatch(text):
                    yield place, rest


def literals(path: Path) -> Iterator[tuple[str, str]]:
    """Every text of a file, with its place."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Constant) and isinstance(node.value, str):
            yield f"{path.relative_to(ROOT)}:{node.lineno}", node.value


def unknown(texts: Iterator[tuple[str, str]], known: set[str]) -> list[tuple[str, str]]:
    """Flags that no command has, each with its place."""
    return [
        (place, flag)
        for place, text in texts
        for flag in FLAG.findall(text)
        if flag not in known and OF_OTHERS.get(flag, "\0") not in text
    ]


def test_advice_names_flags_that_exist() -> None:
    assert unknown(messages(), flags()) == []


@pytest.mark.parametrize("text", ["add --nosuch", "--overwite", "(--repair-all)"])
def test_another_flag_would_be_noticed(text: str) -> None:
    assert unknown(iter([("here", text)]), flags()) == [("here", text.split()[-1].strip("()"))]
