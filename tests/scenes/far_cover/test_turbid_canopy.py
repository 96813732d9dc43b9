"""What stands as a turbid medium: outlines by height, and their colour."""

import numpy as np
import pytest

from lod.canopy import BARE
from lod.shapes import StickTable
from scenes.far_cover.stand_appearance import full_detail_sticks
from scenes.far_cover.turbid_canopy import outlines_between, turbid_canopy
from scenes.field.species_field import Species
from scenes.models.catalogue import model_prototypes
from scenes.trees.species import Weather


def post(low, high, radius, x=0.0):
    """One upright stick, as columns: start, end, two radii, tint."""
    return (x, 0.0, low), (x, 0.0, high), radius, radius, 0


def table(*posts):
    start, end, r0, r1, tint = (np.array(each) for each in zip(*posts, strict=True))
    return StickTable(np.array((0, len(posts))), start, end, r0, r1, tint)


def test_outlines_of_layers_add_up_and_hide_each_other():
    """Two posts, of which one hides the other along x and none along y, and a third above."""
    posts = table(post(0, 2, 0.1), post(0, 2, 0.1, x=5.0), post(4, 5, 0.3))
    one, other = 2 * 2 * 0.1 + np.pi * 0.1**2, 2 * 0.3 + np.pi * 0.3**2
    found = outlines_between(posts, np.array((0.0, 3.0, 6.0)))
    assert found == pytest.approx((1.5 * one, other), rel=0.05)
    assert outlines_between(posts, np.array((0.0, 6.0))).sum() == pytest.approx(found.sum())


def test_the_canopy_of_species_is_what_they_cover_together():
    people = Species("figure", model_prototypes("figure", 2, (1.0,), False, Weather()), 0.02)
    double = Species("figure", people.prototypes, 0.04)
    once, twice = turbid_canopy((people,)), turbid_canopy((double,))
    assert np.allclose(twice.depth, 2 * once.depth) and (once.depth >= 0).all()
    tables = [full_detail_sticks(each)[0] for each in people.prototypes]
    whole = np.mean([outlines_between(each, np.array((0.0, 9.0))).sum() for each in tables])
    assert once.depth.sum() == pytest.approx(0.02 * whole, rel=0.01)
    assert 0.2 < whole < 0.6  # of a person from the side [m²]
    assert 1.6 < once.top_m < 2.0
    tints = full_detail_sticks(people.prototypes[0])[1]
    assert (once.albedo > tints.min(axis=0)).all() and (once.albedo < tints.max(axis=0)).all()
    assert turbid_canopy(()) is BARE and BARE.top_m == 0.0


def test_outlines_of_mirrored_limbs_are_finite():
    """Rows meet both ears of a rabbit at once, and at one size only just."""
    rabbits = model_prototypes("rabbit", 1, (1.0, 1.2), True, Weather())
    height = np.linspace(0, 1, 7) ** 2
    small, large = (
        outlines_between(full_detail_sticks(each)[0], top * height)
        for each, top in zip(rabbits, (0.3572, 0.42864), strict=True)
    )
    assert np.allclose(large, 1.44 * small, rtol=0.2, atol=2e-3)
