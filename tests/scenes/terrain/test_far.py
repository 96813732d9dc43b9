"""Endless: at 10¹² m from the origin every object is where exact arithmetic puts it."""

from fractions import Fraction

import numpy as np
import pytest

from lod.camera import GRID_M
from lod.pruner import prune
from scenes.preset.load import load_preset
from scenes.world.view import view_at
from scenes.world.world import build_world


@pytest.mark.parametrize("cell", [(0, 0), (62_500_000_000, -62_500_000_000)])
def test_positions_are_exact_to_a_micrometre(cell):
    """Homes relative to the eye, against rational arithmetic on the plane's own coordinates."""
    preset = load_preset("meadow", [f"camera.cell={list(cell)}", "render.size=320x180"])
    world = build_world(preset)
    view = view_at(world, preset, 1)
    corner, eye = view.camera.corner, view.camera.eye
    assert abs(corner.x) * GRID_M >= (1e12 if cell[0] else 0)
    for field in world.fields:
        objects = prune(field, view).parts.state
        assert len(objects) > 100
        side, samples = Fraction(field.cells.side_m), objects.samples
        for k in range(0, len(objects), 7):
            for axis, (number, first) in enumerate(
                ((samples.cell_x[k], corner.x), (samples.cell_y[k], corner.y))
            ):
                there = (int(number) + Fraction(float(samples.u[k, axis]))) * side
                seen_from = int(first) * Fraction(GRID_M) + Fraction(float(eye[axis]))
                found = Fraction(float(objects.instances.origin[k, axis])) - Fraction(
                    float(eye[axis])
                )
                assert abs(found - (there - seen_from)) < Fraction(1, 10**6)


@pytest.mark.slow
def test_a_frame_does_not_know_how_far_the_world_goes():
    """The same cut, ids included, in worlds of 10⁶ to 10¹⁵ objects around the same eye."""
    cuts = []
    for side in (8e3, 1.8e8, None):
        extent = [] if side is None else [f"world.extent={side!r}"]
        preset = load_preset("crowd", ["render.size=160x90", *extent])
        world = build_world(preset)
        cuts.append(prune(world.fields[0], view_at(world, preset, 3)))
    for cut in cuts[1:]:
        for name in ("object", "part", "parent", "level"):
            assert np.array_equal(getattr(cut, name), getattr(cuts[0], name))
        assert np.array_equal(cut.parts.position, cuts[0].parts.position)
