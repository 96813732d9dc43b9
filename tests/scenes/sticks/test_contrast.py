"""Classes of inherent contrast: by hand, for every model, and safe whatever stands behind."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lod.eye import CONTRAST_CLASSES, NEVER_LOST
from lod.shapes import StickTable
from scenes.models.catalogue import MODELS
from scenes.models.trees.weather import CALM_SUMMER
from scenes.sticks.contrast import (
    GROUND,
    GROUND_CONTRAST,
    HORIZONS,
    LIT,
    SHADED,
    greatest_contrast,
    part_contrast,
)


def test_a_dark_thing_stands_out_most_against_the_sky_and_a_white_one_against_shade():
    """By hand: (2 − 0.005)/(2 + 0.005), and (2.3 − 0.008)/(2·0.25) through air of 0.25."""
    found = greatest_contrast(np.array([0.05, 1.0]))
    assert found == pytest.approx([1.995 / 2.005, 2.292 / 0.5])


@given(
    albedo=st.floats(0.002, 1.0),
    light=st.floats(SHADED, LIT),
    ground=st.floats(SHADED * GROUND[0], LIT * GROUND[1]),
    horizon=st.floats(*HORIZONS),
    depth=st.floats(0.0, 8.0),
)
def test_no_modulation_left_is_above_what_the_class_promises(albedo, light, ground, horizon, depth):
    """The modulation of part and background through air, worked out directly (Koschmieder)."""
    through = np.exp(-depth)
    bound = greatest_contrast(np.array([albedo]))[0] * through
    seen = light * albedo * through + horizon * (1 - through)
    for behind in (ground, horizon):
        other = behind * through + horizon * (1 - through)
        assert abs(seen - other) / (seen + other) <= bound * (1 + 1e-9)


def test_a_whole_has_at_least_the_class_of_its_parts():
    """A black whole, a black part and on it a white one; beside them a grey one."""
    whole = np.array([-1, 0, 1, 0])
    table = StickTable(
        first=np.arange(5),
        start=np.zeros((4, 3)),
        end=np.ones((4, 3)),
        start_radius=np.ones(4),
        end_radius=np.ones(4),
        tint=np.array([0, 0, 1, 2]),
    )
    tints = np.array([[0.01] * 3, [0.9] * 3, [0.2] * 3])
    assert part_contrast(whole, table, tints).tolist() == [5, 5, 5, 3]


def test_the_mean_is_by_area_and_by_luminance():
    """A small white stick on a large black one changes nothing; pure blue is dark."""
    table = StickTable(
        first=np.array([0, 2, 3]),
        start=np.zeros((3, 3)),
        end=np.ones((3, 3)),
        start_radius=np.array([1.0, 0.01, 1.0]),
        end_radius=np.array([1.0, 0.01, 1.0]),
        tint=np.array([0, 1, 2]),
    )
    tints = np.array([[0.01] * 3, [1.0] * 3, [0.0, 0.0, 1.0]])
    assert part_contrast(np.array([-1, -1]), table, tints).tolist() == [3, 3]


@pytest.mark.parametrize("model", sorted(MODELS))
@pytest.mark.parametrize("weather", [CALM_SUMMER, replace(CALM_SUMMER, wind=5.0)])
def test_every_part_of_every_model_can_be_lost(model, weather):
    for prototype in MODELS[model](0, 1, weather):
        contrast = prototype.hierarchy.contrast
        assert len(contrast) == len(prototype.hierarchy)
        assert contrast.min() >= CONTRAST_CLASSES.index(0.5)
        assert contrast.max() < NEVER_LOST
        whole = prototype.hierarchy.parent[1:]
        assert (contrast[whole] >= contrast[1:]).all()


def test_the_ground_is_of_class_1():
    assert CONTRAST_CLASSES[GROUND_CONTRAST] == 1.0
