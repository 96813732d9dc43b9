"""The house keeps its rules: imports run one way, between rooms and between their packages.

A question has one file, of at most 600 lines, and a name means one thing.
"""

import ast
import importlib.util
import re
import sys
import tomllib
from collections.abc import Iterator
from dataclasses import dataclass
from graphlib import CycleError, TopologicalSorter
from itertools import pairwise
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent

MAY_IMPORT = {"lod": {"lod"}, "scenes": {"scenes", "lod"}, "bench": {"bench", "scenes", "lod"}}
THEORY = {"numpy", "scipy", "numba", "colour", "drjit", "jaxtyping"}
# Where the two names differ; pydantic tells its users to take some names from its core.
DISTRIBUTION = {
    "colour": "colour-science",
    "distributed": "dask",
    "mitsuba_oidn": "mitsuba-oidn",
    "PIL": "pillow",
    "pxr": "usd-core",
    "pydantic_core": "pydantic",
}

# Programs that run in environments of their own, with pinned requirements beside them.
OUTSIDE = "bench/methods"
ELSEWHERE = {
    f"{OUTSIDE}/video_child.py": {"pycvvdp", "torch"},
}

FILES = {"fileinput", "glob", "io", "mmap", "os", "pathlib", "shutil", "sqlite3", "tempfile"}
CLOCK = {"datetime", "time", "timeit"}
OPENS = {
    *("fromfile", "genfromtxt", "load", "loadtxt", "memmap", "open", "save", "savetxt", "savez"),
    *("savez_compressed", "tofile", "read_bytes", "read_text", "write_bytes", "write_text"),
}

MOST_LINES = 600  # of a file
# Names that two files share, because they are of one subject.
SHARED_NAMES = {
    **dict.fromkeys(("air", "law", "viewing"), "a theory and the experiment on it"),
    **dict.fromkeys(("render", "usd", "verify", "environments"), "a command and what it calls"),
    "make": "what two commands of that name call",
    "acting": "how a scene acts, and what that costs",
}
# A reader has neither the plan nor the tracker that such a reference points to.
FLAG = re.compile(r"(?<![\w-])--[a-z][a-z-]+")
UNKNOWN_TO_READERS = re.compile(r"\bDESIGN(\.md)?\b|(?i:\bissues? #?\d+)")


@dataclass(frozen=True)
class Source:
    """One file of a room: where it is, what it imports and calls, how long it is."""

    path: str
    imports: frozenset[str]
    calls: frozenset[str]
    has_global: bool
    lines: int
    references: tuple[str, ...]
    flags: tuple[str, ...]

    @property
    def room(self) -> str:
        return self.path.split("/")[0]

    @property
    def tops(self) -> set[str]:
        return {name.split(".")[0] for name in self.imports}

    @property
    def package(self) -> str:
        """Its folder; a file that stands in a room, beside the folders, is one of its own."""
        folder = Path(self.path).parent
        return str(Path(self.path).with_suffix("") if str(folder) in MAY_IMPORT else folder)


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
            text = file.read_text(encoding="utf-8")
            nodes = list(ast.walk(ast.parse(text, str(path))))
            names = (name for node in nodes for name in imported(node, list(path.parts[:-1])))
            calls = (called(node.func) for node in nodes if isinstance(node, ast.Call))
            has_global = any(isinstance(node, ast.Global) for node in nodes)
            found.append(
                Source(
                    path.as_posix(),
                    frozenset(names),
                    frozenset(calls),
                    has_global,
                    text.count("\n"),
                    tuple(match[0] for match in UNKNOWN_TO_READERS.finditer(text)),
                    tuple(FLAG.findall(text)),
                )
            )
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
    known = MAY_IMPORT[source.room] | sys.stdlib_module_names
    for top in sorted(source.tops - known - ELSEWHERE.get(source.path, set())):
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
        yield from (f"lod names the flag {flag}" for flag in source.flags)
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


def too_long(files: list[Source]) -> Iterator[str]:
    """Files with more lines than a question needs."""
    for source in files:
        if source.lines > MOST_LINES:
            yield f"{source.path}: {source.lines} lines, at most {MOST_LINES}"


def namesakes(files: list[Source]) -> Iterator[str]:
    """Files of one name, unless stated above; a command's file is named as users type it."""
    by_name: dict[str, list[str]] = {}
    for source in (each for each in files if "cli/commands" not in each.path):
        by_name.setdefault(Path(source.path).stem, []).append(source.path)
    for name, paths in by_name.items():
        if len(paths) > 1 and name != "__init__" and name not in SHARED_NAMES:
            yield f"{len(paths)} files are named {name}: {', '.join(paths)}"


def package_imports(root: Path, files: list[Source]) -> dict[str, set[str]]:
    """Of each folder that holds modules: the other folders whose modules it imports."""
    graph: dict[str, set[str]] = {}
    for source in files:
        users = graph.setdefault(source.package, set())
        for name in source.imports:
            # A scene imports the renderer where it is asked for a picture, and nowhere else.
            drawn = source.path == "scenes/scene.py" and name.startswith("scenes.render")
            if name.split(".")[0] in MAY_IMPORT and not drawn:
                target = Path(*name.split("."))
                alone = target.parent.as_posix() in MAY_IMPORT
                folder = target if alone or (root / target).is_dir() else target.parent
                users.add(folder.as_posix())
        users.discard(source.package)
    return graph


def cycles(root: Path, files: list[Source]) -> Iterator[str]:
    """Packages that import one another, round about."""
    try:
        TopologicalSorter(package_imports(root, files)).prepare()
    except CycleError as error:
        # Each of the cycle's packages is imported by the one after it.
        steps = (f"{user} imports {used}" for used, user in pairwise(error.args[1]))
        yield f"packages in a circle: {', '.join(steps)}"


def unreadable(files: list[Source]) -> Iterator[str]:
    """References that a reader of the repository cannot look up."""
    for source in files:
        for reference in source.references:
            yield f"{source.path}: refers to {reference}, which no reader can open"


def violations(root: Path, distributions: set[str]) -> list[str]:
    """Every breach of the house's rules in the tree at `root`, one line each."""
    files = sources(root)
    distinct = [
        f"{source.path}: {breach}"
        for source in files
        for breach in (*misplaced(source, distributions), *impure(source))
    ]
    together = (shared(files), too_long(files), namesakes(files), unreadable(files))
    return [*distinct, *(breach for each in together for breach in each), *cycles(root, files)]


DECLARED = declared((ROOT / "pyproject.toml").read_text(encoding="utf-8"))


def test_the_house_keeps_its_rules():
    assert violations(ROOT, DECLARED) == []


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
        ("scenes__a", "from bench.plots import x", "scenes imports bench"),
        ("scenes__a", "import importlib\nimportlib.import_module('bench')", "scenes imports bench"),
        ("lod__a", "import mitsuba as mi", "lod imports mitsuba"),
        ("scenes__a", "import mitsuba", "mitsuba outside scenes/render/"),
        ("scenes__render__a", "import OpenEXR", "OpenEXR is imported by 2 files"),
        ("scenes__a", "import matplotlib", "matplotlib outside bench"),
        ("bench__a", "import matplotlib.figure", "matplotlib is imported by 2 files"),
        ("lod__a", "import time", "lod imports time"),
        ("lod__a", "import numpy as np\nnp.save('x', 1)", "calls save(…)"),
        ("lod__a", "n = 0\ndef f():\n    global n\n    n = 1", "a global that changes"),
        ("bench__statistics", "import pathlib", "statistics import pathlib"),
        ("bench__a", "import requests", "imports requests, which pyproject.toml does not declare"),
        ("scenes__a", "from tests import conftest", "imports tests, which"),
        ("scenes__a", "x = 1\n" * 601, "601 lines, at most 600"),
        ("scenes__rig__cut", "x = 1", "2 files are named cut"),
        ("lod__a", '"""As DESIGN §1 has it."""', "refers to DESIGN"),
        ("lod__a", "cure = 'leave --detail out'", "lod names the flag --detail"),
    ],
)
def test_a_planted_breach_is_found(tmp_path, file, text, says):
    plant(tmp_path, **{file: text})
    assert any(says in breach for breach in violations(tmp_path, DECLARED))


@pytest.mark.parametrize(
    ("file", "text"),
    [
        ("scenes__a", "x = 1\n" * 600),
        ("scenes__rig____init__", ""),
        ("bench__a", "design = 'a matrix, or what an image was made for'"),
    ],
)
def test_what_is_allowed_is_left_alone(tmp_path, file, text):
    plant(tmp_path, **{file: text})
    assert violations(tmp_path, DECLARED) == []


def test_packages_in_a_circle_are_found(tmp_path):
    circle = {
        "scenes__rig__a": "import scenes.figures.b",
        "scenes__figures__b": "import scenes.rig.a",
    }
    plant(tmp_path, **circle)
    found = violations(tmp_path, DECLARED)
    assert any("packages in a circle" in breach and "scenes/rig" in breach for breach in found)
