"""A budget of parts holds for every frame of a sequence, and the fullest one uses it."""

import math
from pathlib import Path

import numpy as np
import pytest

from lod.air import least_extinction
from lod.errors import InputError
from scenes.presets.load import load_preset
from scenes.render.budget import (
    COPIED_FROM,
    FINEST_PX,
    MIN_BUDGET_USE,
    parts_displayed,
    reference_preset,
    within_budget,
)
from scenes.scene import Scene

FRAMES = (1, 400, 3000)
TINY = Path(__file__).resolve().parents[2] / "bench" / "cli" / "tiny.toml"


def test_no_frame_is_over_the_budget_and_the_fullest_uses_it():
    most, people = 3000, ("species.tree.density=0", "render.size=320x180")
    asked = load_preset("crowd", [f"view.max_parts={most}", "camera.speed=20", *people])
    chosen = within_budget(asked, FRAMES)
    assert chosen.model_dump(exclude={"view"}) == asked.model_dump(exclude={"view"})
    assert chosen.view.max_parts == most
    scene = Scene(chosen)
    world = scene.world
    parts = [parts_displayed(world, scene.view(frame)) for frame in FRAMES]
    assert MIN_BUDGET_USE * most <= max(parts) <= most


def test_the_budget_is_used_up_where_the_preset_alone_would_show_less():
    asked = load_preset("crowd", ["view.max_parts=2000", "view.detail=50.0"])
    assert within_budget(asked, (1,)).view.detail < 50.0


def test_a_budget_that_nothing_fits_is_refused():
    asked = load_preset(str(TINY), ["world.extent=300", "view.max_parts=1", "view.metric=full"])
    with pytest.raises(InputError, match="--max-parts"):
        within_budget(asked, (1,))


SHORT = {
    "nothing grows": ("crowd", ["species.figure.density=0", "species.tree.density=0"], (1, 2)),
    "what is there lies behind the eye": ("crowd", ["world.extent=30", "camera.pitch=80"], (1,)),
    "one thing stands there alone": (str(TINY), [], (1, 2, 3)),
}
"""Budgets that cannot be filled: the preset, its settings, and the frames."""


@pytest.mark.parametrize("case", SHORT)
def test_a_budget_that_cannot_be_filled_shows_the_finest_there_is_and_says_so(case):
    name, settings, frames = SHORT[case]
    said: list[str] = []
    preset = load_preset(name, [*settings, "view.max_parts=3000000"])
    chosen = within_budget(preset, frames, note=said.append)
    scene = Scene(chosen)
    world = scene.world
    shown = max(parts_displayed(world, scene.view(frame)) for frame in frames)
    (line,) = said
    assert line.startswith(f"lodbench: --max-parts 3,000,000: {shown:,} parts at ")
    assert line.endswith(("that is all there is", "the ground can be no finer"))


def test_a_reference_leaves_nothing_out_and_is_as_fine_as_memory_allows():
    lavish = [
        "view.fade=0.3",
        "view.metric=depth",
        "view.detail=9",
        "air.seeing=5",
        'air.visibility="2km"',
        "world.extent=60",
    ]
    asked = load_preset(str(TINY), [*lavish, 'render.size="64x36"'])
    said: list[str] = []
    found = reference_preset(asked, (1, 3), 0, said.append)
    assert found.view.detail == pytest.approx(FINEST_PX)
    assert said[0].startswith("lodbench: --reference: 0.125 px, about 3")
    assert said[0].endswith("finer than 0.125 px is not tried")
    view = Scene(found).view(1)
    farthest = math.exp(-least_extinction(Scene(found).air) * found.view.reach)
    assert view.metric.limit(np.array([1e9]), np.zeros(1), 1e-3) == found.view.reach
    assert (farthest, found.view.copies) == (pytest.approx(1e-3), COPIED_FROM)
    assert (view.fade, view.metric.name, view.conditions) == (0.0, "blake", None)
    same = {"view", "air", "display", "eye"}
    assert found.model_dump(exclude=same) == asked.model_dump(exclude=same)
    with pytest.raises(InputError, match="one pixel needs more"):
        reference_preset(asked, (1,), 370_000_000)


@pytest.mark.slow
def test_more_memory_makes_a_finer_reference():
    few = ["world.extent=300", "species.figure.prototypes=2", "species.tree.density=0"]
    asked = load_preset("crowd", ['render.size="64x36"', *few])
    most = (440_000_000, 480_000_000, 900_000_000)
    details = [reference_preset(asked, (1,), each).view.detail for each in most]
    assert details[0] > details[1] > details[2]
