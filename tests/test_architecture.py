"""The page on architecture is true: a frame takes the steps that it names, in that order."""

import json
import re
import sys
from pathlib import Path

import pytest

from bench.cli.main import main
from scenes.render import render_files, worker
from scenes.render.frame_session import FrameSession

ROOT = Path(__file__).resolve().parent.parent
PAGE = (ROOT / "docs" / "architecture.md").read_text(encoding="utf-8")
ROW = re.compile(r"^\| \d+ \| `(?P<file>[\w/.]+): (?P<name>[\w.]+)` \| (?P<words>.+) \|$", re.M)
STEPS = [(row["file"], row["name"]) for row in ROW.finditer(PAGE)]
WORDS = " ".join(row["words"] for row in ROW.finditer(PAGE))
SHAPES = set(re.findall(r"\*\*(\w+)\*\*", WORDS))
BESIDE = set(re.findall(r"`(\w+)`", WORDS))
"""Types that are handed over as fields of a shape, or beside one."""
PLAIN_DATA = {"Settings", "Description"}
"""Shapes that are dicts."""

MOST_STEPS, MOST_SHAPES = 10, 16


class InThisProcess(worker.Worker):
    """Stands in for the process that renders: settings come as JSON, as they do there."""

    def __init__(self, *arguments):
        pass

    def __enter__(self):
        return self

    def __exit__(self, *error):
        pass

    def __call__(self, settings, frame, target):
        return FrameSession(json.loads(json.dumps(settings))).render(frame, target)


class Trace:
    """What the project's functions were given and gave, as the interpreter reports it."""

    def __init__(self):
        self.returned = []
        self.handed_over = {}
        self.made = set()

    def __call__(self, frame, event, value):
        code = frame.f_code
        if event != "return" or not code.co_filename.startswith(f"{ROOT}/"):
            return
        step = (code.co_filename[len(f"{ROOT}/") :], code.co_qualname)
        if step[1].endswith(("__init__", "__post_init__")) and "self" in frame.f_locals:
            self.made.add(type(frame.f_locals["self"]).__name__)
        if isinstance(value, tuple) or hasattr(value, "__dataclass_fields__"):
            self.made.add(type(value).__name__)
        if step in STEPS:
            if step not in self.returned:
                self.returned.append(step)
            names = code.co_varnames[: code.co_argcount + code.co_kwonlyargcount]
            given = [frame.f_locals[name] for name in names if name != "self"]
            found = {type(each).__name__ for each in (*given, value) if is_ours(each)}
            self.handed_over.setdefault(step, set()).update(found)


def is_ours(value):
    return type(value).__module__.split(".")[0] in ("lod", "scenes", "bench")


@pytest.fixture(scope="module")
def trace(tmp_path_factory):
    seen, folder = Trace(), tmp_path_factory.mktemp("frame")
    arguments = ["render", "crowd", "-o", f"{folder}/a.####.exr", "--size", "32x18", "--spp", "1"]
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(render_files, "Worker", InThisProcess)
        before = sys.getprofile()
        sys.setprofile(seen)
        try:
            with pytest.raises(SystemExit) as end:
                main(arguments)
        finally:
            sys.setprofile(before)
    assert end.value.code == 0
    return seen


def test_a_frame_passes_through_every_step_in_the_order_of_the_page(trace):
    assert trace.returned == STEPS


def test_only_the_shapes_of_the_page_are_handed_over(trace):
    representations = {"SpeciesField", "Placed", "Terrain", "Plume", "Dust", "FarCover"}
    for step, shapes in trace.handed_over.items():
        assert shapes - SHAPES - BESIDE - representations == set(), step


def test_every_shape_of_the_page_is_made(trace):
    handed = set().union(*trace.handed_over.values())
    assert SHAPES - PLAIN_DATA - trace.made - handed == set()


def test_the_way_of_a_frame_is_short():
    assert 0 < len(STEPS) <= MOST_STEPS
    assert 0 < len(SHAPES) <= MOST_SHAPES
