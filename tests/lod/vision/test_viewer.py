"""Air, display and eye shorten limit distances: each by its contrast, before the clamp."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lod.camera import Corner, camera_from_heading
from lod.errors import InputError
from lod.metric.family import METRICS, limit_distances
from lod.metric.hierarchy import Hierarchy
from lod.pruning.view import View
from lod.vision.blur_cascade import BlurWidths, blur_widths
from lod.vision.contrast import CONTRAST_CLASSES, NEVER_LOST
from lod.vision.eye import Display, Eye, sensitivity
from lod.vision.viewer import ViewingConditions, perceptual_limits
from lod.vision.weighted_distance import UNWEIGHTED, weighted_distance

CAMERA = camera_from_heading(Corner(0, 0), np.array([0.0, 0.0, 2.0]), 0.0, 0.0, 60.0, (640, 360))
PIXEL = CAMERA.pixel_angle
BETA = 3.5 / 2000


def tree_of(*contrasts):
    """A chain of parts with these classes, each a third of the one before and 1 m from it."""
    n = len(contrasts)
    size = 9.0 / 3.0 ** np.arange(n)
    return Hierarchy(
        parent=np.arange(-1, n - 1),
        level=np.arange(n),
        position=np.zeros((n, 3)),
        P=size,
        R=size,
        B=size + np.arange(n, 0, -1),
        separation=np.minimum(np.arange(n), 1.0),
        contrast=np.array(contrasts),
    )


def test_without_an_eye_all_is_kept_as_fine_as_asked_up_to_where_contrast_is_gone():
    sight, row = (
        ViewingConditions(BlurWidths(PIXEL), BETA, acuity=False),
        CONTRAST_CLASSES.index(1.0),
    )
    clear = np.geomspace(1, 1e5, 200)
    seen = perceptual_limits(sight, clear, np.full(200, row), PIXEL)
    gone = math.log(sensitivity(Display(), Eye()).value.max()) / BETA
    assert (seen == np.minimum(clear, gone)).all()
    assert gone * BETA / 3.912 == pytest.approx(1.745, abs=0.01)  # of V, in air as thick as red is


def test_with_an_eye_it_is_the_weighted_distance():
    widths = blur_widths(PIXEL, Display(40.0), Eye())
    sight = ViewingConditions(widths, BETA, Display(40.0), Eye())
    clear, m = np.geomspace(1, 1e5, 50), sight.widths.effective
    for row, contrast in enumerate(CONTRAST_CLASSES):
        W = weighted_distance(contrast, BETA, m, widths, Display(40.0), Eye())
        assert (perceptual_limits(sight, clear, np.full(50, row), m) == W.inverse(clear)).all()


@pytest.mark.parametrize("acuity", [False, True])
def test_clear_air_and_what_is_never_lost_are_the_cut_of_today(acuity):
    tree = tree_of(NEVER_LOST, NEVER_LOST, NEVER_LOST)
    hazy = ViewingConditions(BlurWidths(PIXEL), BETA, acuity=acuity)
    assert hazy.weighted(math.inf, PIXEL) is UNWEIGHTED
    for metric in METRICS.values():
        alone = limit_distances(tree, metric, PIXEL)
        assert (limit_distances(tree, metric, PIXEL, hazy) == alone).all()
    assert (
        ViewingConditions(BlurWidths(PIXEL), 0.0, acuity=False).weighted(0.1, PIXEL) is UNWEIGHTED
    )


def test_every_part_has_the_limit_of_its_own_contrast():
    """V = 2 km: what is bolder lasts ln(C ratio)/β further."""
    sight = ViewingConditions(BlurWidths(PIXEL), BETA, acuity=False)
    gone = [sight.weighted(c, PIXEL).vanishing_distance for c in CONTRAST_CLASSES[:-1]]
    assert np.diff(gone) == pytest.approx(np.diff(np.log(CONTRAST_CLASSES[:-1])) / BETA)
    D = limit_distances(tree_of(3, 1, 0), METRICS["blake"], 1e-4, sight)
    assert D == pytest.approx([gone[3], gone[1], gone[0]])


def test_limits_are_weighted_before_they_are_clamped():
    """A faint whole takes its bold part with it, and the clamp is in metres of the scene."""
    sight = ViewingConditions(BlurWidths(PIXEL), BETA, acuity=False)
    faint = sight.weighted(CONTRAST_CLASSES[0], PIXEL).vanishing_distance
    D = limit_distances(tree_of(0, 3, 3), METRICS["blake"], 1e-4, sight)
    assert D == pytest.approx([faint, faint - 1.0, faint - 2.0])


@given(
    contrast=st.lists(st.integers(0, NEVER_LOST), min_size=4, max_size=4),
    beta=st.floats(0, 0.1),
    m=st.floats(1e-4, 1e-2),
    acuity=st.booleans(),
    metric=st.sampled_from(sorted(METRICS)),
)
def test_cuts_stay_connected_and_air_only_takes(contrast, beta, m, acuity, metric):
    tree, sight = tree_of(*contrast), ViewingConditions(BlurWidths(PIXEL), beta, acuity=acuity)
    clear = limit_distances(tree, METRICS[metric], m)
    D = limit_distances(tree, METRICS[metric], m, sight)
    assert (D <= clear).all()
    shown = D[1:] > 0
    assert (D[:-1][shown] >= D[1:][shown] + tree.separation[1:][shown]).all()


def test_metric_full_keeps_everything_in_any_air():
    sight = ViewingConditions(BlurWidths(PIXEL), 1.0)
    assert np.isinf(limit_distances(tree_of(0, 0), METRICS["full"], PIXEL, sight)).all()


def test_a_view_weighs_in_view_and_out_of_it_each_with_its_own_detail():
    display = Display(200.0)
    sight = ViewingConditions(blur_widths(PIXEL, display, Eye()), 20 * BETA, display)
    view, tree = View(CAMERA, METRICS["blake"], 1.0, conditions=sight), tree_of(2, 2, 1)
    inside, outside = view.limits(tree)
    assert view.m == pytest.approx(sight.widths.effective)
    assert view.m > 2 * PIXEL
    assert (inside == limit_distances(tree, METRICS["blake"], view.m, sight)).all()
    assert (outside == limit_distances(tree, METRICS["blake"], 4 * view.m, sight)).all()
    assert (outside < limit_distances(tree, METRICS["blake"], 4 * view.m)).any()
    assert sight.weighted(0.5, view.m) is not sight.weighted(0.5, view.m_offscreen)


def test_without_blur_m_is_that_of_the_pixel_to_the_last_bit():
    for tau in (1.0, 0.3, 7.7):
        with_air = View(
            CAMERA, METRICS["blake"], tau, conditions=ViewingConditions(BlurWidths(PIXEL), BETA)
        )
        assert with_air.m == View(CAMERA, METRICS["blake"], tau).m


def test_along_an_axis_the_depth_is_weighed():
    sight = ViewingConditions(BlurWidths(PIXEL), BETA, acuity=False)
    view, tree = View(CAMERA, METRICS["depth"], conditions=sight), tree_of(3, 3)
    assert (view.limits(tree)[0] == limit_distances(tree, METRICS["blake"], view.m, sight)).all()


def test_scaled_objects_keep_their_contrast():
    tree = tree_of(3, 1)
    assert (tree.scaled(2.0).contrast == tree.contrast).all()
    assert (replace(tree, contrast=np.zeros(0, np.int64)).contrast == NEVER_LOST).all()


def test_another_cameras_pixel_and_bad_air_are_refused():
    with pytest.raises(InputError, match="pixel"):
        View(CAMERA, METRICS["blake"], conditions=ViewingConditions(BlurWidths(2 * PIXEL)))
    for beta in (-1.0, math.nan, math.inf):
        with pytest.raises(InputError, match="extinction"):
            ViewingConditions(BlurWidths(PIXEL), beta)
    for contrast in ((-1, 0), (0, NEVER_LOST + 1)):
        with pytest.raises(InputError, match="contrast"):
            tree_of(*contrast)
