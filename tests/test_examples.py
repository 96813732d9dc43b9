"""What the pages tell a reader to type works: shell blocks marked ``sh``, and blocks of Python.

The commands of a page run in their order, in a folder of their own, made smaller by one rule:
pictures have 32x18 pixels and a sample, sequences their first two frames, clusters two workers,
experiments their quick sizes, `run all` is `run haze`, and an hour is six seconds. Shell blocks
marked ``bash`` are not run, each for a reason that is given here. tests/test_documents.py checks
the syntax of all blocks, those for other programs among them.
"""

import importlib
import os
import re
import runpy
import shlex
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
PAGES = ["README.md", *sorted(f"docs/{each.name}" for each in (ROOT / "docs").glob("*.md"))]
SMALL = {"--size": "32x18", "--spp": "1"}  # of pictures
LESS = {"--frames": "1-2", "--cluster": "2", "--minutes": "0.1"}  # where they are asked for
NOT_RUN = {
    "README.md": "make, which CI runs itself",
    "docs/first-steps.md": "make, which CI runs itself",
    "docs/add-a-tree-species.md": "copies into the package; test_species_files.py makes a willow",
    "docs/add-an-animal.md": "needs an animal of the reader's own; test_animal_file.py writes some",
    "docs/submit.md": "takes hours; test_compare_runs.py compares smaller runs",
}

OAK = """#usda 1.0
def Xform "oak" {
    def Mesh "crown" {
        int[] faceVertexCounts = [3, 3, 3, 3]
        int[] faceVertexIndices = [0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3]
        point3f[] points = [(0, 0, 0), (200, 0, 0), (0, 0, 200), (0, 300, 0)]
    }
    def Mesh "trunk" {
        int[] faceVertexCounts = [3, 3, 3, 3]
        int[] faceVertexIndices = [0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3]
        point3f[] points = [(0, 0, 0), (40, 0, 0), (0, 0, 40), (0, 200, 0)]
    }
}
"""  # the model of a reader

pytestmark = pytest.mark.slow


def blocks(page: str, language: str) -> list[str]:
    text = (ROOT / page).read_text(encoding="utf-8")
    return re.findall(rf"```{language}\n(.*?)```", text, re.S)


def smaller(line: str) -> tuple[list[str], str | None]:
    """The words of a command made smaller, and the file that its output goes to."""
    words = shlex.split(re.sub(r"\s#\s.*", "", line.removeprefix(".venv/bin/")))
    target = words[words.index(">") + 1] if ">" in words else None
    words = words[1 : words.index(">")] if target else words[1:]
    if words[0] == "render":
        words = with_values(words, {k: SMALL[k] for k in ("--size", "--spp")})
    elif words[0] == "run":
        words = ["haze" if word == "all" else word for word in words]
        words += [] if "--quick" in words else ["--quick"]
    return with_values(words, LESS, only_there=True), target


def with_values(words: list[str], values: dict[str, str], only_there: bool = False) -> list[str]:
    """Give flags these values, each in its place or at the end."""
    words = list(words)
    for flag, value in values.items():
        if flag in words:
            words[words.index(flag) + 1] = value
        elif not only_there:
            words += [flag, value]
    return words


@pytest.mark.parametrize("page", [page for page in PAGES if blocks(page, "sh")])
def test_the_commands_of_a_page_work(
    page: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "oak.usda").write_text(OAK, encoding="utf-8")
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path / "data"))
    lines = "".join(blocks(page, "sh")).splitlines()
    for words, target in map(smaller, filter(None, lines)):
        done = subprocess.run(
            [sys.executable, "-m", "lodbench", *words], cwd=tmp_path, capture_output=True, text=True
        )
        assert done.returncode == 0, f"{page}: {shlex.join(words)}: {done.stderr}"
        if target:
            (tmp_path / target).write_text(done.stdout, encoding="utf-8")


def test_blocks_that_are_not_run_have_a_reason() -> None:
    assert {page for page in PAGES if blocks(page, "bash")} == set(NOT_RUN)


RUN_CELLS = """
import json, sys
names = {"__name__": "__main__"}
for cell in json.load(open(sys.argv[1], encoding="utf-8"))["cells"]:
    if cell["cell_type"] == "code":
        exec("".join(cell["source"]), names)
"""


def test_the_cells_of_the_notebook_work(tmp_path: Path) -> None:
    """They are the blocks of docs/python.md, as a test of the documents sees to."""
    done = subprocess.run(
        [sys.executable, "-c", RUN_CELLS, str(ROOT / "docs/python.ipynb")],
        cwd=tmp_path,
        env={**os.environ, "MPLBACKEND": "agg"},
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stderr
    assert len(done.stdout.splitlines()) == 8


def test_the_experiment_of_the_page_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Its blocks are a package; `# measure.py` and the like say which file begins there."""
    from bench.runner.run_experiment import run_experiment

    first, others = blocks("docs/add-an-experiment.md", "python")
    package = tmp_path / "tiny_of_the_page"
    package.mkdir()
    (package / "__init__.py").write_text(first, encoding="utf-8")
    _, *files = re.split(r"^# (\w+\.py)\n", others, flags=re.M)
    for name, text in zip(files[::2], files[1::2], strict=True):
        (package / name).write_text(text, encoding="utf-8")
    monkeypatch.syspath_prepend(str(tmp_path))
    tiny = importlib.import_module("tiny_of_the_page").EXPERIMENT
    record = run_experiment(tiny, tiny.effort("quick"), 0)
    assert [claim.name for claim in record.claims] == ["half"] and len(record.points) == 3
    assert len(tiny.plots(record)) == 1 and len(tiny.point_table(record)[1]) == 3


def test_the_plug_ins_of_the_page_are_what_they_say() -> None:
    (block,) = blocks("docs/plugins.md", "python")
    whole = Path(__file__).parent / "plugin" / "lodbench_example.py"
    fence = runpy.run_path(str(whole))["FENCE"]
    names = {"make": fence.make, "camera": fence.camera, "detail": fence.detail}
    exec(block, names)
    assert names["HALFWAY"].limit(2.0, 1.0, 0.5) == 4.5 and names["FENCE"].make is names["make"]


def test_the_behaviour_of_the_page_goes_on_by_answers() -> None:
    from types import SimpleNamespace

    from lod.actors.message import ask, change

    names = {"ask": ask, "change": change}
    (block,) = blocks("docs/actors.md", "python")
    exec(block, names)
    greeting = names["greet"](SimpleNamespace(name="joe"))
    said = next(greeting), greeting.send(0.0), greeting.send(None)
    assert [str(each.action) for each in said] == ["heading()", "go(1.2, 30.0)", "near('joe', 4.0)"]
    assert greeting.send(("ann",)) is None


def test_a_command_is_made_smaller_by_the_rule() -> None:
    words, target = smaller(".venv/bin/lodbench render x -o ####.exr --frames 1-24  # a remark")
    assert words[4:] == ["--frames", "1-2", "--size", "32x18", "--spp", "1"] and target is None
    words, _ = smaller("lodbench run all -o out --cluster 4")
    assert words == ["run", "haze", "-o", "out", "--cluster", "2", "--quick"]
    assert smaller("lodbench show meadow > mine.toml") == (["show", "meadow"], "mine.toml")
