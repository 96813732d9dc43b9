"""The house keeps its rules: bench imports scenes, scenes imports lod, never the other way."""

import ast
import importlib.util
import re
import sys
import tomllib
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent

MAY_IMPORT = {"lod": {"lod"}, "scenes": {"scenes", "lod"}, "bench": {"bench", "scenes", "lod"}}
THEORY = {"numpy", "scipy", "numba", "colour", "drjit", "jaxtyping"}
# Where the two names differ; pydantic tells its users to take some names from its core.
DISTRIBUTION = {
    "skimage": "scikit-image",
    "colour": "colour-science",
    "distributed": "dask",
    "mitsuba_oidn": "mitsuba-oidn",
    "PIL": "pillow",
    "pxr": "usd-core",
    "pydantic_core": "pydantic",
}

FILES = {"fileinput", "glob", "io", "mmap", "os", "pathlib", "shutil", "sqlite3", "tempfile"}
CLOCK = {"datetime", "time", "timeit"}
OPENS = {
    *("fromfile", "genfromtxt", "load", "loadtxt", "memmap", "open", "save", "savetxt", "savez"),
    *("savez_compressed", "tofile", "read_bytes", "read_text", "write_bytes", "write_text"),
}


@dataclass(frozen=True)
class Source:
    """One file of a room: where it is, what it imports and calls."""

    path: str
    imports: frozenset[str]
    calls: frozenset[str]
    has_global: bool

    @property
    def room(self) -> str:
        return self.path.split("/")[0]

    @property
    def tops(self) -> set[str]:
        return {name.split(".")[0] for name in self.imports}


def imported(node: ast.AST, package: list[str]) -> Iterator[str]:
    """The modules that one statement imports, by their full names."""
    match node:
        case ast.Import(names=names):
            yield from (alias.name for alias in names)
        case ast.ImportFrom(module=module, level=level):
            above = package[: len(package) - level + 1] if level else []
            yield ".".join([*above, *([module] if module else [])])
        case ast.Call(func=func, args=[ast.Constant(value=str(name)), *_]):
            if called(func) in {"import_module", "__import__"}:
                yield name


def called(func: ast.AST) -> str:
    """The last name of what is called: `save` of `np.save(…)`."""
    return getattr(func, "attr", getattr(func, "id", ""))


def sources(root: Path) -> list[Source]:
    """Every Python file of the three rooms."""
    found = []
    for room in MAY_IMPORT:
        for file in sorted((root / room).rglob("*.py")):
            path = file.relative_to(root)
            nodes = list(ast.walk(ast.parse(file.read_text(encoding="utf-8"), str(path))))
            names = (name for node in nodes for name in imported(node, list(path.parts[:-1])))
            calls = (called(node.func) for node in nodes if isinstance(node, ast.Call))
            has_global = any(isinstance(node, ast.Global) for node in nodes)
            found.append(Source(path.as_posix(), frozenset(names), frozenset(calls), has_global))
    return found


def declared(pyproject: str) -> set[str]:
    """The distributions that a user's installation brings, without the tests' and developers'."""
    project = tomllib.loads(pyproject)["project"]
    extras = project.get("optional-dependencies", {})
    wanted = project["dependencies"] + [
        line for extra, lines in extras.items() if extra not in {"test", "dev"} for line in lines
    ]
    return {normalised(re.match(r"[\w.-]+", line)[0]) for line in wanted}


def normalised(name: str) -> str:
    return re.sub(r"[-_.]+", "-", name).lower()


def misplaced(source: Source, distributions: set[str]) -> Iterator[str]:
    """What one file imports and should not."""
    for top in sorted(source.tops - MAY_IMPORT[source.room] - sys.stdlib_module_names):
        if top in MAY_IMPORT:
            yield f"{source.room} imports {top}: imports run bench → scenes → lod"
        elif normalised(DISTRIBUTION.get(top, top)) not in distributions:
            yield f"imports {top}, which pyproject.toml does not declare"
        elif source.room == "lod" and top not in THEORY:
            yield f"lod imports {top}: the theory needs only {', '.join(sorted(THEORY))}"
        elif top == "mitsuba" and not source.path.startswith("scenes/render/"):
            yield "imports mitsuba outside scenes/render/"
        elif top == "OpenEXR" and not source.path.startswith("scenes/render/"):
            yield "imports OpenEXR outside scenes/render/"
        elif top == "matplotlib" and source.room != "bench":
            yield "imports matplotlib outside bench"


def impure(source: Source) -> Iterator[str]:
    """Files, clocks and globals where calculation should be pure."""
    if source.room == "lod":
        yield from (f"lod imports {top}" for top in sorted(source.tops & (FILES | CLOCK)))
        if source.has_global:
            yield "lod has a global that changes"
    elif source.path.startswith("bench/statistics"):
        yield from (f"statistics import {top}" for top in sorted(source.tops & FILES))
    else:
        return
    yield from (f"calls {name}(…), which opens a file" for name in sorted(source.calls & OPENS))


def shared(files: list[Source]) -> Iterator[str]:
    """Libraries that one file alone may know."""
    for library in ("OpenEXR", "matplotlib"):
        users = [source.path for source in files if library in source.tops]
        if len(users) > 1:
            yield f"{library} is imported by {len(users)} files, not one: {', '.join(users)}"


def violations(root: Path, distributions: set[str]) -> list[str]:
    """Every breach of the house's rules in the tree at `root`, one line each."""
    files = sources(root)
    return [
        f"{source.path}: {breach}"
        for source in files
        for breach in (*misplaced(source, distributions), *impure(source))
    ] + list(shared(files))


DECLARED = declared((ROOT / "pyproject.toml").read_text(encoding="utf-8"))


def test_the_house_keeps_its_rules():
    assert violations(ROOT, DECLARED) == []


@pytest.mark.parametrize("room", MAY_IMPORT)
def test_no_room_is_empty(room):
    # Without files to read, the test above could not fail.
    assert any(source.room == room for source in sources(ROOT))


@pytest.mark.parametrize("room", MAY_IMPORT)
def test_annotations_are_checked_under_test(room):
    assert type(importlib.util.find_spec(room).loader).__name__ == "_JaxtypingLoader"


def plant(root: Path, **texts: str) -> None:
    """Write a small sound house, with `texts` (a/b.py spelt a__b) planted in it."""
    sound = {
        "lod__cut": "import numpy as np",
        "scenes__field": "from lod.cut import np\nfrom . import render",
        "scenes__render__exr": "import mitsuba\nimport OpenEXR",
        "bench__plots": "import os, time\nimport matplotlib.pyplot\nfrom scenes import field",
        "bench__statistics": "import statsmodels.api\nimport numpy",
    }
    for name, text in (sound | texts).items():
        file = root / f"{name.replace('__', '/')}.py"
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text, encoding="utf-8")


def test_a_sound_house_is_left_alone(tmp_path):
    plant(tmp_path)
    assert violations(tmp_path, DECLARED) == []


@pytest.mark.parametrize(
    ("file", "text", "says"),
    [
        ("lod__a", "import scenes.field.species_field", "lod imports scenes"),
        ("lod__a", "def f():\n    from bench import plots", "lod imports bench"),
        ("scenes__a", "from bench.plots import x", "scenes imports bench"),
        ("scenes__a", "import importlib\nimportlib.import_module('bench')", "scenes imports bench"),
        ("lod__a", "import mitsuba as mi", "lod imports mitsuba"),
        ("lod__a", "import pydantic", "lod imports pydantic"),
        ("scenes__a", "import mitsuba", "mitsuba outside scenes/render/"),
        ("bench__a", "from mitsuba import load_dict", "mitsuba outside scenes/render/"),
        ("bench__a", "import OpenEXR", "OpenEXR outside scenes/render/"),
        ("scenes__render__a", "import OpenEXR", "OpenEXR is imported by 2 files"),
        ("scenes__a", "import matplotlib", "matplotlib outside bench"),
        ("bench__a", "import matplotlib.figure", "matplotlib is imported by 2 files"),
        ("lod__a", "import time", "lod imports time"),
        ("lod__a", "from pathlib import Path", "lod imports pathlib"),
        ("lod__a", "x = open('x')", "calls open(…)"),
        ("lod__a", "import numpy as np\nnp.save('x', 1)", "calls save(…)"),
        ("lod__a", "n = 0\ndef f():\n    global n\n    n = 1", "a global that changes"),
        ("bench__statistics", "import pathlib", "statistics import pathlib"),
        ("bench__statistics", "def f(p):\n    return p.read_text()", "calls read_text(…)"),
        ("bench__a", "import requests", "imports requests, which pyproject.toml does not declare"),
        ("scenes__a", "import pytest", "imports pytest, which pyproject.toml does not declare"),
        ("scenes__a", "from tests import conftest", "imports tests, which"),
    ],
)
def test_a_planted_breach_is_found(tmp_path, file, text, says):
    plant(tmp_path, **{file: text})
    assert any(says in breach for breach in violations(tmp_path, DECLARED))
