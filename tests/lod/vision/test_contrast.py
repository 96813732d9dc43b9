import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lod.errors import InputError
from lod.vision.contrast import CONTRAST_CLASSES, contrast_class, inherent_contrast

LUMINANCE = st.floats(0, 1e4)


def one(*values):
    return [np.array([float(v)]) for v in values]


@pytest.mark.parametrize(
    ("Y", "Y_b", "A", "contrast"),
    [(1, 3, math.inf, 0.5), (3, 1, math.inf, 0.5), (0, 5, 9, 1.0), (7, 7, 1, 0), (6, 2, 1, 2.0)],
)
def test_inherent_contrast_by_hand(Y, Y_b, A, contrast):
    assert inherent_contrast(*one(Y, Y_b, A)) == pytest.approx([contrast])


@given(Y=LUMINANCE, Y_b=LUMINANCE, A=st.floats(1e-3, 1e4), depth=st.floats(0, 20))
def test_no_air_leaves_more_than_the_inherent_contrast_says(Y, Y_b, A, depth):
    T = math.exp(-depth)
    part, ground = (x * T + A * (1 - T) for x in (Y, Y_b))
    total = part + ground
    modulation = abs(part - ground) / total if total else 0.0
    assert modulation <= inherent_contrast(*one(Y, Y_b, A))[0] * T * (1 + 1e-9) + 1e-12


@given(contrast=st.floats(0, 10))
def test_classes_round_up(contrast):
    row = int(contrast_class(np.array([contrast]))[0])
    assert contrast <= CONTRAST_CLASSES[row]
    assert row == 0 or contrast > CONTRAST_CLASSES[row - 1]


def test_what_matches_its_surroundings_keeps_the_least_class():
    nothing = inherent_contrast(np.zeros(1), np.zeros(1), np.zeros(1))
    assert contrast_class(nothing).tolist() == [0]
    assert contrast_class(inherent_contrast(*one(1, 0, 0))).tolist() == [len(CONTRAST_CLASSES) - 1]


@pytest.mark.parametrize("bad", [(-1, 1, 1), (1, math.nan, 1), (math.inf, 1, 1), (1, 1, -1)])
def test_bad_luminances_are_refused(bad):
    with pytest.raises(InputError, match="luminance"):
        inherent_contrast(*one(*bad))


@pytest.mark.parametrize(
    "classes", [(), (0.1, 1.0), (0.0, math.inf), (0.2, 0.1, math.inf), (0.1, 0.1, math.inf)]
)
def test_bad_classes_are_refused(classes):
    with pytest.raises(InputError, match="classes"):
        contrast_class(np.ones(1), classes)


@pytest.mark.parametrize("bad", [-0.1, math.nan])
def test_bad_contrasts_are_refused(bad):
    with pytest.raises(InputError, match="contrast"):
        contrast_class(np.array([bad]))
