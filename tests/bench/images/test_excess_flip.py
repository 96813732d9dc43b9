"""Excess FLIP: nothing between equal pictures, what is planted between others, honest bounds."""

import numpy as np
import pytest

from bench.images.differences import FLOOR, flip_map, mean_flip, one_sided_excess
from lod.errors import InputError

HEIGHT, WIDTH = 24, 40


def scene(brighter=0.0):
    """A soft gradient with a bar that is brighter."""
    picture = np.linspace(0.2, 0.6, WIDTH)[None, :, None] * np.ones((HEIGHT, 1, 3))
    picture[8:16, 10:30] += brighter
    return picture


def noisy(rng, picture, noise):
    return np.clip(picture + rng.normal(0, noise, picture.shape), 0, 1).astype(np.float32)


def trios(seed, brighter, noise=0.001, pairs=8):
    rng = np.random.default_rng(seed)
    return [
        (
            noisy(rng, scene(brighter), noise),
            noisy(rng, scene(), noise),
            noisy(rng, scene(), noise),
        )
        for _ in range(pairs)
    ]


def excess_flip(trios):
    """The excess of the first picture of each trio over the third, and the mean noise floor."""
    columns = [[mean_flip(each, other) for each in pair] for *pair, other in trios]
    tested, noise = np.array(columns).T
    return one_sided_excess(tested, noise), noise.mean()


def test_flip_of_equal_pictures_is_nothing_and_of_black_and_white_is_almost_all():
    black, white = np.zeros((HEIGHT, WIDTH, 3)), np.ones((HEIGHT, WIDTH, 3))
    assert mean_flip(scene(), scene()) == 0
    assert mean_flip(white, black) > 0.9


def test_more_difference_is_more_flip_and_the_viewers_distance_counts():
    assert mean_flip(scene(0.1), scene()) > 1.5 * mean_flip(scene(0.05), scene()) > 0.05
    assert mean_flip(scene(0.05), scene(), 20.0) != mean_flip(scene(0.05), scene(), 200.0)


def test_the_map_is_bright_where_the_bar_is():
    found = flip_map(scene(0.2), scene())
    assert found.shape == scene().shape
    assert found[11, 20].sum() > 10 * found[0, 2].sum()
    assert found.min() >= 0 and found.max() <= 1


def test_the_same_scene_is_within_its_noise_and_a_planted_bar_is_beyond():
    (same, floor), (planted, above) = excess_flip(trios(1, 0.0)), excess_flip(trios(1, 0.1))
    assert floor <= FLOOR
    assert same.high <= floor
    assert planted.low > above
    assert planted.value == pytest.approx(mean_flip(scene(0.1), scene()), rel=0.25)


def test_one_bound_in_twenty_is_passed():
    """Excess 0.003 by construction: 93 to 97 of 100 bounds hold it, above and below alike."""
    rng = np.random.default_rng(2)
    found = [
        one_sided_excess(*(rng.normal(mean, 0.001, 8) for mean in (0.008, 0.005)))
        for _ in range(4000)
    ]
    for held in ([each.high >= 0.003 for each in found], [each.low <= 0.003 for each in found]):
        assert 0.93 < np.mean(held) < 0.97


@pytest.mark.parametrize("bad", [np.nan, -0.1, 1.1])
def test_what_is_no_displayed_picture_is_refused(bad):
    wrong = scene()
    wrong[0, 0, 0] = bad
    with pytest.raises(InputError, match="0 to 1"):
        mean_flip(wrong, scene())
    with pytest.raises(InputError, match="test"):
        mean_flip(scene()[1:], scene())
    with pytest.raises(InputError, match="8 pairs"):
        excess_flip(trios(1, 0.0, pairs=7))
