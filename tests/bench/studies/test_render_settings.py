"""Noise is what was put in, and constants are as before afterwards."""

import numpy as np
import pytest

from bench.studies.render_settings import DARK, SPP, changed, noise, settings
from scenes.render.drivers import camera_rays
from scenes.render.mitsuba import variants
from scenes.render.mitsuba.plugin import load_plugin


def test_noise_is_the_variance_over_the_squared_light() -> None:
    rng, light = np.random.default_rng(0), np.full((200, 300, 3), 0.5)
    a, b = (light + 0.1 * rng.standard_normal(light.shape) for _ in range(2))
    assert noise(a, b, light) == pytest.approx(0.1**2 / (0.25 * (1 + DARK)), rel=0.02)


def test_constants_come_back_even_after_an_error() -> None:
    before = camera_rays.SAMPLER
    with pytest.raises(RuntimeError), changed(((camera_rays, "SAMPLER", "independent"),)):
        assert camera_rays.SAMPLER == "independent"
        raise RuntimeError
    assert before == camera_rays.SAMPLER


def test_every_setting_changes_a_constant_that_there_is() -> None:
    used, *others = settings()
    assert used == type(used)("as used")
    for each in others:
        names = [*each.scene, *each.trace]
        assert each.max_depth or all(getattr(place, name) != value for place, name, value in names)


def test_every_sampler_takes_as_many_samples_as_are_asked_for() -> None:
    """Orthogonal arrays round what they cannot, and say so only in a warning."""
    variants.use(variants.SCALAR_VARIANT)
    changes = [change for each in settings() for change in each.trace]
    kinds = {value for _, name, value in changes if name == "SAMPLER"} | {camera_rays.SAMPLER}
    assert len(kinds) == 4
    for kind in kinds:
        assert load_plugin({"type": kind, "sample_count": SPP}).sample_count() == SPP
