import numpy as np
import pytest

from lod.errors import InputError
from scenes.model_files import animal_names, built_in_names
from scenes.models.catalogue import MODELS, at_rest, model_prototypes
from scenes.presets.load import load_preset
from scenes.rig.rigged_prototype import RiggedPrototype

RIGGED = ["figure", *animal_names()]
LEGGED = [name for name in RIGGED if name != "windmill"]


def test_the_presets_know_every_model():
    assert set(built_in_names()) == set(MODELS)
    for model in MODELS:
        assert load_preset("zoo", [f"species.tree.model={model}"]).species["tree"].model == model


@pytest.mark.parametrize("model", LEGGED)
def test_standing_keeps_legs_and_nothing_of_the_walk(model):
    (walker,) = model_prototypes(model, 1, (1.0,), walks=True)
    rest = at_rest(walker)
    assert walker.motion.stride > 0
    assert rest.motion.stride == 0
    assert len(rest.motion.rotations) == 1
    assert np.array_equal(rest.motion.rotations[0], walker.rig.rest)
    assert not rest.motion.shift.any()
    assert len(rest.motion.feet) >= 2
    assert np.array_equal(rest.motion.feet.legs, walker.motion.feet.legs)
    assert np.array_equal(rest.motion.feet.bend, walker.motion.feet.bend)
    ankles = rest.rig.frames()[0][rest.motion.feet.legs[:, 2], :2]
    assert np.array_equal(rest.motion.feet.home, ankles)
    assert np.all(rest.motion.feet.duty == 1)
    assert rest.hierarchy is walker.hierarchy
    tables = (walker.posed().inner, walker.posed().leaf)
    lows = [
        np.minimum(t.start[:, 2] - t.start_radius, t.end[:, 2] - t.end_radius).min() for t in tables
    ]
    assert min(lows) == pytest.approx(0.0, abs=0.02 * walker.hierarchy.B[0])


@pytest.mark.parametrize("model", animal_names())
def test_animals_come_in_one_build(model):
    with pytest.raises(InputError, match=f"{model}: prototypes: 2.*one build"):
        model_prototypes(model, 2, (1.0,), walks=True)


@pytest.mark.parametrize("model", MODELS)
@pytest.mark.parametrize("walks", [True, False])
def test_sizes_scale_every_length(model, walks):
    them = model_prototypes(model, 1, (1.0, 2.5), walks)  # of grass, several rankings of each
    one, large = them[0], them[len(them) // 2]
    shadows = (
        () if model == "sward" else ("B",)
    )  # that of grass has room for shadows, of one length
    for name in ("P", "R", *shadows, "separation", "position"):
        ours, theirs = getattr(one.hierarchy, name), getattr(large.hierarchy, name)
        assert theirs == pytest.approx(2.5 * ours, rel=1e-12)
    for name in ("start", "end", "start_radius", "end_radius"):
        assert getattr(large.leaf, name) == pytest.approx(2.5 * getattr(one.leaf, name), rel=1e-12)
    if isinstance(one, RiggedPrototype):
        assert large.motion.stride == pytest.approx(2.5 * one.motion.stride)
        speeds = large.motion.speed, one.motion.speed * np.sqrt(2.5)  # equal Froude numbers
        assert speeds[0] == pytest.approx(speeds[1])
