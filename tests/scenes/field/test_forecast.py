"""What is estimated of a field is what pruning then displays, wherever the camera looks."""

import pytest

from lod.pruner import blend_weights, prune
from scenes.presets.load import load_preset
from scenes.render.memory import forecast_field
from scenes.scene import Scene

CASES = [
    ("zoo", "view.detail=6", "view.shutter=180"),
    ("zoo", "view.detail=8", "camera.pitch=-80"),
    ("zoo", "view.detail=3", "camera.pitch=60"),
    ("zoo", "view.detail=6", "view.look_around=true"),
    ("zoo", "view.detail=3", 'render.size="3000x1"'),
]


@pytest.mark.parametrize("case", CASES, ids=" ".join)
def test_parts_and_shapes_are_estimated_within_a_quarter(case):
    preset, *settings = case
    chosen = load_preset(preset, settings)
    scene = Scene(chosen)
    world = scene.world
    view = scene.view(1)
    told = [forecast_field(each, view) for each in world.fields]
    cuts = [prune(each, view) for each in world.fields]
    shapes = [
        len(each.appearance(cut.parts, blend_weights(cut, view)))
        for each, cut in zip(world.fields, cuts, strict=True)
    ]
    parts = sum(map(len, cuts))
    assert parts > 500
    assert sum(each.parts for each in told) == pytest.approx(parts, rel=0.25)
    assert sum(each.sticks + each.triangles for each in told) == pytest.approx(sum(shapes), rel=0.3)


def test_what_is_endless_costs_the_same_to_estimate():
    """Counts of a detail that no memory could hold come from as few objects as any other's."""
    chosen = load_preset("crowd", ["view.detail=1e-4", "air.visibility='clear'"])
    scene = Scene(chosen)
    world = scene.world
    view = scene.view(1)
    coarse = scene.with_preset(load_preset("crowd", ["air.visibility='clear'"])).view(1)
    fine, usual = (
        sum(forecast_field(each, v).parts for each in world.fields) for v in (view, coarse)
    )
    assert fine / usual == pytest.approx(1e8, rel=0.5)  # by the law, (1/1e-4)²
