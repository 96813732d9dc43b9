"""Contrast against the endless path falls as exp(−βd) in each band, and tells the visibility."""

import numpy as np
import pytest

from bench.experiments.air import (
    DISTANCES,
    extinction_seen,
    look_at,
    order,
    visibility_seen,
)
from lod.air import Air, rgb_extinction
from scenes.frame.frame_input import Quality
from scenes.render import variants

SEED = 1


def found(visibility_m, quality):
    """β of each band from black and from grey as a share of what it is, and V, from both."""
    target, beyond = look_at(visibility_m, quality)
    step, albedo = order(quality.seed)
    distance = visibility_m * step / DISTANCES
    fit = extinction_seen(target, beyond, distance, albedo == 1)
    V = [visibility_seen(fit[k], fit[2 + k]).value / visibility_m for k in (0, 1)]
    return fit[:2] / rgb_extinction(Air(visibility_m)), V


@pytest.mark.parametrize("V", [1e3, 5e3, 20e3])
@pytest.mark.parametrize("variant", [variants.SCALAR_VARIANT, variants.JIT_VARIANT])
def test_both_drivers_within_one_per_cent(variant, V):
    if variants.works(variant) is not True:
        pytest.skip(f"{variant} does not work here")
    beta, seen = found(V, Quality(variant, 256, SEED, 3))
    assert np.allclose(beta[0], 1, atol=1e-3), "black"
    assert np.allclose(beta[1], 1, atol=0.03), "grey, whose colour is near to the air's in blue"
    assert np.allclose(seen, 1, atol=0.01)


@pytest.mark.slow
@pytest.mark.parametrize("V", [1e3, 5e3, 20e3])
def test_the_medium_within_three_per_cent(V):
    """A box 10 m above and 1 m below the targets, which are at most 13 m high."""
    variant = variants.choose()
    beta, seen = found(V, Quality(variant, 1024, SEED, 3, "medium"))
    assert np.allclose(beta, 1, atol=0.03)
    assert np.allclose(seen, 1, atol=0.03)


def test_a_wrong_extinction_is_noticed():
    """The fit itself, on made-up contrasts of air 3 % thicker."""
    step, albedo = order(SEED)
    beta, air = 1.03 * rgb_extinction(Air(5e3)), np.array((0.1, 0.2, 0.3))
    distance, grey = 5e3 * step / DISTANCES, albedo == 1
    own = np.where(grey, 0.5, 0.0)[:, None]
    through = np.exp(-beta * distance[:, None])
    seen = own * through + air * (1 - through)
    fit = extinction_seen(seen, np.tile(air, (len(seen), 1)), distance, grey)
    assert np.allclose(fit[:2], beta, rtol=1e-9)
    assert visibility_seen(fit[0], fit[2]).value == pytest.approx(5e3 / 1.03, rel=0.01)


def test_the_medium_repeats_to_the_last_bit():
    """Where a film was added to by many threads, five of six came out otherwise by 10⁻⁹."""
    quality = Quality(variants.choose(), 128, SEED, 8, "medium")
    one, *others = (look_at(20e3, quality) for _ in range(6))
    assert all(np.array_equal(one, other) for other in others)
