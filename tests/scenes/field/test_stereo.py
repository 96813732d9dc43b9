"""One cut for two eyes: it has what either eye alone displays, as many as the law says."""

from dataclasses import replace

import numpy as np
import pytest

from bench.counting import FLAT, prototypes_of
from lod.camera import Corner, camera_from_heading
from lod.errors import InputError
from lod.metric import METRICS
from lod.pruner import prune
from lod.view import View
from scenes.field.species_field import Species, SpeciesField
from scenes.presets.load import load_preset


def view_of(baseline_m, look_around=False, detail=20.0, eye=None):
    camera = camera_from_heading(
        Corner(0, 0), np.array((8.0, 8.0, 1.6)), 30.0, -4.0, 60.0, (640, 360)
    )
    camera = replace(camera, baseline_m=baseline_m)
    if eye is not None:
        camera = camera.pair[eye]
    return View(camera, METRICS["blake"], detail=detail, look_around=look_around)


def people(seed=1, density=0.02):
    return SpeciesField(Species("figure", prototypes_of("figure", 1.0), density), seed, FLAT)


def displayed(cut):
    """What is displayed, by place of the object and part of it: cuts number objects as they go."""
    parts = cut.parts
    whole = np.arange(len(parts))
    while (parts.parent[whole] >= 0).any():
        whole = np.where(parts.parent[whole] >= 0, parts.parent[whole], whole)
    place = np.round(parts.position[whole], 6).tolist()
    return set(zip(map(tuple, place), parts.part.tolist(), strict=True))


@pytest.mark.parametrize("baseline", [0.065, 3.0])
def test_what_either_eye_displays_both_do(baseline):
    field = people()
    both = displayed(prune(field, view_of(baseline)))
    each = [displayed(prune(field, view_of(baseline, eye=eye))) for eye in (0, 1)]
    assert len(both) > 150
    assert each[0] | each[1] <= both
    if baseline == 3.0:
        assert each[0] != each[1]
        assert each[0] | each[1] != displayed(prune(field, view_of(0.0)))


def test_one_eye_is_pruned_as_before_to_the_last_bit():
    one, pair = view_of(0.0), view_of(0.065)
    tree = prototypes_of("figure", 1.0)[0].hierarchy
    assert one.for_both_eyes(tree.P) is tree.P
    inside, _ = pair.limits(tree)
    alone, _ = one.limits(tree)
    np.testing.assert_allclose(inside[alone > 0], alone[alone > 0] + 0.0325)
    assert (inside[alone == 0] == 0).all()


@pytest.mark.parametrize(
    "settings",
    [
        ["camera.stereo=0"],
        ["camera.stereo=0.065", "camera.projection=panorama"],
        ["camera.stereo=0.065", "output.multipart=true"],
        ["camera.stereo=0.065", "output.cryptomatte=true"],
    ],
)
def test_what_a_pair_cannot_have_is_refused(settings):
    with pytest.raises(InputError, match="camera"):
        load_preset("meadow", settings)
