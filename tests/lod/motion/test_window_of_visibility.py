"""The window of visibility: cut-off frequency times speed is the limit in time."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lod.motion.window_of_visibility import LIMIT_HZ, critical_hz, integration_time_s


@given(st.floats(0.1, 500), st.floats(0.01, 60), st.floats(5, 80))
def test_what_flickers_faster_than_the_limit_is_smaller_than_its_smear(speed, frequency, limit):
    """A grating is out of the window where speed × frequency exceeds ω_l."""
    half_period = 1 / (2 * frequency)
    smear = speed * integration_time_s(0.0, limit)
    if abs(speed * frequency - limit) > 1e-9 * limit:
        assert (half_period < smear) == (speed * frequency > limit)


def test_the_shutter_and_the_eye_add_as_variances_do():
    assert integration_time_s(1 / 48) ** 2 == pytest.approx((1 / 48) ** 2 + (1 / 60) ** 2)
    assert integration_time_s(1e3) == pytest.approx(1e3)


def test_the_rate_that_looks_smooth_is_the_published_one():
    """At rest the limit of flicker, and u_l more for each degree a second."""
    assert critical_hz(np.array((0.0, 2.0)), 10.0).tolist() == [LIMIT_HZ, LIMIT_HZ + 20]
