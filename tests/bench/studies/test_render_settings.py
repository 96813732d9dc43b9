"""Noise is what was put in, and every setting changes what is rendered with."""

import numpy as np
import pytest

from bench.studies.render_settings import DARK, SPP, noise, settings
from scenes.frame.frame_input import Quality
from scenes.render import variants
from scenes.render.light import load_plugin


def test_noise_is_the_variance_over_the_squared_light() -> None:
    rng, light = np.random.default_rng(0), np.full((200, 300, 3), 0.5)
    a, b = (light + 0.1 * rng.standard_normal(light.shape) for _ in range(2))
    assert noise(a, b, light) == pytest.approx(0.1**2 / (0.25 * (1 + DARK)), rel=0.02)


def test_every_setting_changes_the_quality_in_its_own_way() -> None:
    used = Quality(variants.SCALAR_VARIANT)
    first, *others = (each.of(used) for each in settings())
    assert first == used and used not in others
    assert len(set(others)) == len(others) == 15


def test_every_sampler_takes_as_many_samples_as_are_asked_for() -> None:
    """Orthogonal arrays round what they cannot, and say so only in a warning."""
    variants.use(variants.SCALAR_VARIANT)
    kinds = {each.of(Quality(variants.SCALAR_VARIANT)).sampler for each in settings()}
    assert len(kinds) == 4
    for kind in kinds:
        assert load_plugin({"type": kind, "sample_count": SPP}).sample_count() == SPP
