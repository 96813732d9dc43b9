"""Which studies can `lodbench study` run? Programs of this folder, which judge no claim.

Experiments are in ``bench.experiments``: `lodbench run` measures their cases, records them
and judges their claims, and `lodbench report` shows them. A study has no record and no claims: it
is a command of its own that prints a table or makes pictures. It is a module NAME.py of this
folder, or a package NAME with a module ``study``; the first line of its docstring says what it
answers, and its click command is named ``command``.
"""

import ast
import importlib
from functools import cache
from pathlib import Path

import click

_FOLDER = Path(__file__).parent


@cache
def study_descriptions() -> dict[str, str]:
    """Return the first line of every study's docstring, by name, without importing a study."""
    packages = {path.parent.name: path for path in _FOLDER.glob("*/study.py")}
    modules = {p.stem: p for p in _FOLDER.glob("*.py") if p.stem not in ("__init__", "registry")}
    return {name: _first_line(path) for name, path in sorted((packages | modules).items())}


def load_study(name: str) -> click.Command:
    """Import the click command of a study that ``study_descriptions`` names."""
    module = f"bench.studies.{name}"
    if (_FOLDER / name).is_dir():
        module += ".study"
    command: click.Command = importlib.import_module(module).command
    return command


def _first_line(path: Path) -> str:
    text = ast.get_docstring(ast.parse(path.read_text(encoding="utf-8")))
    return (text or "").partition("\n")[0].rstrip(".")
