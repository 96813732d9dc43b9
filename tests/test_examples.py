"""What the pages tell a reader to type works: shell blocks marked ``sh``, and blocks of Python.

The commands of a page run in their order, in a folder of their own, made smaller by one rule:
pictures have 32x18 pixels and a sample, sequences their first two frames, clusters two workers,
experiments their quick sizes, `run all` is `run haze`, and an hour is six seconds. Shell blocks
marked ``bash`` are not run, each for a reason that is given here. Blocks of Python
are run, each page's by a test of its own, but for those whose first line says that they run in
another program or on other machines. tests/test_documents.py checks the syntax of all blocks,
those for other programs among them.
"""

import os
import re
import runpy
import shlex
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from scenes.frame.layers import SKY_Z, Layers
from scenes.render.exr.layer_file import write_exr

ROOT = Path(__file__).parents[1]
PAGES = ["README.md", *sorted(f"docs/{each.name}" for each in (ROOT / "docs").glob("*.md"))]
SMALL = {"--size": "32x18", "--spp": "1"}  # of pictures
LESS = {"--frames": "1-2", "--cluster": "2", "--minutes": "0.1"}  # where they are asked for
NOT_RUN = {
    "README.md": "make, which CI runs itself",
    "docs/first-steps.md": "make, which CI runs itself",
    "docs/extend.md": "copies into the package; tests of species and animals write their own",
    "docs/experiments.md": "R, which tests do not install; tests/bench/test_own_preset.py",
    "docs/submit.md": "takes hours, or a renderer; test_compare_runs.py, tests/bench/submissions",
    "docs/exr.md": "oiiotool, which a test of its own runs",
    "docs/observers.md": "renders for an hour; tests/bench/observers makes smaller experiments",
    "docs/packs.md": "a compiler of C; tests/bench/packs compiles the method and runs it",
}
PYTHON_RUN = {  # how many blocks of Python a page has that its test runs
    "docs/actors.md": 1,
    "docs/exr.md": 1,
    "docs/extend.md": 2,
    "docs/python.md": 4,  # as a notebook
}
ELSEWHERE = re.compile(r"# runs (in|on) (.+?)[:\n]")
PYTHON_NOT_RUN = {
    "docs/frames.md": {"SLURM", "Kubernetes"},  # the page says which of them was tried
    "docs/exr.md": {
        "Blender's Python",
        "NumPy",
    },  # in an environment of its own; the page says of 5.0
}

OAK = """#usda 1.0
def Xform "oak" {
    def Mesh "crown" {
        int[] faceVertexCounts = [3, 3, 3, 3]
        int[] faceVertexIndices = [0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3]
        point3f[] points = [(0, 0, 0), (200, 0, 0), (0, 0, 200), (0, 300, 0)]
        color3f[] primvars:displayColor = [(0.2, 0.35, 0.1)]
    }
    def Mesh "trunk" {
        int[] faceVertexCounts = [3, 3, 3, 3]
        int[] faceVertexIndices = [0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3]
        point3f[] points = [(0, 0, 0), (40, 0, 0), (0, 0, 40), (0, 200, 0)]
        color3f[] primvars:displayColor = [(0.3, 0.2, 0.1)]
    }
}
"""  # the model of a reader

pytestmark = pytest.mark.slow


def blocks(page: str, language: str) -> list[str]:
    text = (ROOT / page).read_text(encoding="utf-8")
    return re.findall(rf"```{language}\n(.*?)```", text, re.S)


def own_python(page: str) -> list[str]:
    """The blocks of Python that run where lodbench does."""
    return [block for block in blocks(page, "python") if not ELSEWHERE.match(block)]


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


def test_blocks_of_python_are_run_or_say_where_they_run() -> None:
    assert {page: len(own) for page in PAGES if (own := own_python(page))} == PYTHON_RUN
    named = {
        page: {found[2] for block in blocks(page, "python") if (found := ELSEWHERE.match(block))}
        for page in PAGES
    }
    assert {page: programs for page, programs in named.items() if programs} == PYTHON_NOT_RUN


@pytest.fixture
def frame(tmp_path: Path) -> Path:
    """The frame that the page of files names, half of it sky, in a folder of its own."""
    size = (18, 32)
    ground = np.broadcast_to(np.arange(18)[:, None] >= 9, size)
    colour = np.full((*size, 3), 0.5)
    layers = Layers(
        rgb=colour,
        Z=np.where(ground, 20.0, SKY_Z),
        N=colour,
        albedo=colour,
        object=np.where(ground, 7, 0),
        part=np.where(ground, 3, 0),
        level=np.where(ground, 1, 0),
    )
    write_exr(tmp_path / "a.0001.exr", layers, {})
    return tmp_path / "a.0001.exr"


def test_readers_of_the_page_open_a_frame(frame: Path) -> None:
    """Each expression of the block gives pixels; in a process of its own, which OpenCV needs."""
    (block,) = own_python("docs/exr.md")
    first = "import OpenEXR, mitsuba, OpenImageIO, cv2, imageio.v3, ast\n"
    first += "mitsuba.set_variant('scalar_rgb')\n"
    each = "for each in ast.parse(TEXT).body: print(eval(ast.unparse(each)) is not None)"
    done = subprocess.run(
        [sys.executable, "-c", f"{first}TEXT = {block!r}\n{each}"],
        cwd=frame.parent,
        env={**os.environ, "OPENCV_IO_ENABLE_OPENEXR": "1"},
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout.split() == ["True"] * 5


def test_oiiotool_makes_the_pictures_of_the_page(frame: Path) -> None:
    import OpenImageIO as oiio

    _, block = blocks("docs/exr.md", "bash")
    for line in block.splitlines():
        _, *words = shlex.split(line)
        tool = Path(sys.executable).with_name("oiiotool")
        subprocess.run([tool, *words], cwd=frame.parent, check=True)
    colour, distance = (
        oiio.ImageBuf(str(frame.with_name(name))) for name in ("colour.png", "distance.png")
    )
    assert colour.spec().nchannels == 3 and colour.get_pixels(oiio.FLOAT).mean() > 0.05
    assert distance.get_pixels(oiio.FLOAT).max() == 1.0  # the sky
    assert distance.get_pixels(oiio.FLOAT).min() == pytest.approx(20 / 500, abs=1e-4)
    ids = oiio.ImageBuf(str(frame))
    place = ids.spec().channelindex("id.object")
    assert ids.get_pixels(oiio.UINT)[..., place].max() == 7
    assert ids.get_pixels(oiio.FLOAT)[..., place].max() == pytest.approx(7 / 2**32)  # a share


def test_other_programs_make_the_preview_of_the_page(tmp_path: Path) -> None:
    """Within one step of 255, from light of many strengths."""
    import OpenImageIO as oiio

    from scenes.render.pictures import to_srgb_8bit

    light = np.geomspace(1e-3, 20, 18 * 32 * 3).reshape(18, 32, 3)
    layers = Layers(
        rgb=light,
        Z=np.full((18, 32), 20.0),
        N=light,
        albedo=light,
        **{name: np.zeros((18, 32), np.int64) for name in ("object", "part", "level")},
    )
    write_exr(tmp_path / "a.0001.exr", layers, {})
    wanted = to_srgb_8bit(light, 2.0).astype(int)
    names = {"np": np, "rgb": light, "E": 2.0}
    (numpy,) = (b for b in blocks("docs/exr.md", "python") if "runs in NumPy" in b)
    exec(numpy, names)
    assert np.abs(names["picture"] * 255 - wanted).max() <= 1
    _, *words = shlex.split(blocks("docs/exr.md", "bash")[0])
    subprocess.run([Path(sys.executable).with_name("oiiotool"), *words], cwd=tmp_path, check=True)
    made = oiio.ImageBuf(str(tmp_path / "preview.png")).get_pixels(oiio.UINT8).astype(int)
    assert np.abs(made - wanted).max() <= 1


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
    assert len(done.stdout.splitlines()) == 7


def test_the_experiment_of_the_page_runs() -> None:
    from bench.runs import RunRequest, run_experiment

    _, block = own_python("docs/extend.md")
    names: dict[str, object] = {}
    exec(block, names)
    tiny = names["EXPERIMENT"]
    record = run_experiment(tiny, RunRequest("tiny", ("tiny",), True, 0))
    assert [claim.name for claim in record.claims] == ["parts_displayed/person/80_m_over_20_m"]
    assert len(record.points) == 3 and len(tiny.topics["tiny"].plots(record)) == 1


def test_the_plug_ins_of_the_page_are_what_they_say() -> None:
    block, _ = own_python("docs/extend.md")
    whole = ROOT / "examples" / "plugin" / "lodbench_example.py"
    fence = runpy.run_path(str(whole))["FENCE"]
    names = {"make": fence.make, "camera": fence.camera, "detail": fence.detail}
    exec(block, names)
    assert names["HALFWAY"].limit(2.0, 1.0, 0.5) == 4.5 and names["FENCE"].make is names["make"]


def test_the_behaviour_of_the_page_goes_on_by_answers() -> None:
    from types import SimpleNamespace

    from lod.actors.object_with_parts import ask, change

    names = {"ask": ask, "change": change}
    (block,) = own_python("docs/actors.md")
    exec(block, names)
    greeting = names["greet"](SimpleNamespace(name="joe"))
    said = next(greeting), greeting.send(0.0), greeting.send(None)
    assert [str(each.action) for each in said] == ["heading()", "go(1.2, 30.0)", "near('joe', 4.0)"]
    assert greeting.send(("ann",)) is None
