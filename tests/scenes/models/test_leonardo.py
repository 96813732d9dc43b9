"""Leonardo's order (§1.5): from an object that recedes the most minute parts are lost first, then
the greater ones, until what is left of the whole is rounded. Read from the cuts.
"""

from functools import lru_cache
from itertools import pairwise

import numpy as np
import pytest
from scipy.stats import spearmanr

from lod.camera import Corner, camera_from_heading
from lod.metric import METRICS
from lod.pruner import prune
from lod.view import View
from scenes.field.species_field import Placed
from scenes.model_files.names import animal_names
from scenes.models.animals.catalogue import animal, animal_tables
from scenes.models.catalogue import at_rest
from scenes.models.people.people import human_tables, people_at_rest
from scenes.sticks.outline_area import largest_area

PEOPLE = {"person": 0.0, "child": 1.0}
ALL = [*PEOPLE, *animal_names()]
GROWN_LIKE_US = ["person", "child", "rabbit", "giraffe", "ostrich"]
LIVING = [*GROWN_LIKE_US, "insect"]
DIRECTIONS = ((1.0, 0.0, 0.2), (-0.6, 0.7, 0.05), (0.3, -1.0, 0.8), (-0.2, -0.1, 1.0))
STEPS = 40
DETAIL = 0.5


class Plain:
    """Flat ground."""

    def height(self, corner, xy):
        return np.zeros(len(xy))

    def bounds(self):
        return 0.0, 0.0


@lru_cache(maxsize=8)
def one(name):
    """The object at rest, and the names of its parts."""
    if name in PEOPLE:
        return people_at_rest(0, 1, PEOPLE[name])[0], human_tables().anatomy.part_names
    return animal(name), animal_tables(name).anatomy.part_names


@lru_cache(maxsize=32)
def recession(name, way):
    """Distances from near to where nothing is left, and the parts displayed at each."""
    it, _ = one(name)
    what = Placed(name, at_rest(it), 0.0, 0.0, 30.0, Plain())
    h = it.hierarchy
    direction = np.array(DIRECTIONS[way]) / np.linalg.norm(DIRECTIONS[way])
    m = DETAIL * camera_from_heading(Corner(0, 0), np.zeros(3), 0, 0, 60.0, (100, 100)).pixel_angle
    # From where it could be touched to where the whole is lost.
    distances = np.geomspace(h.B[0], 1.1 * (h.P[0] + h.R[0]) / m, STEPS)
    shown = []
    for away in distances:
        eye = h.position[0] + away * direction
        camera = camera_from_heading(Corner(0, 0), eye, 0.0, 0.0, 60.0, (100, 100))
        view = View(camera, METRICS["blake"], DETAIL, look_around=True)
        shown.append(frozenset(prune(what, view).parts.part.tolist()))
    return distances, shown


def limits_seen(name, way):
    """Farthest distance at which each part was displayed, 0 for those that never were."""
    distances, shown = recession(name, way)
    count = len(one(name)[0].hierarchy)
    return np.array(
        [
            max((d for d, s in zip(distances, shown, strict=True) if i in s), default=0)
            for i in range(count)
        ]
    )


@pytest.mark.parametrize("name", ALL)
@pytest.mark.parametrize("way", range(len(DIRECTIONS)))
def test_what_is_displayed_only_shrinks_with_distance(name, way):
    _, shown = recession(name, way)
    assert len(shown[0]) > 0.5 * len(one(name)[0].hierarchy)
    assert all(far <= near for near, far in pairwise(shown))
    assert not shown[-1]


@pytest.mark.parametrize("name", ALL)
@pytest.mark.parametrize("way", range(len(DIRECTIONS)))
def test_the_first_parts_to_be_lost_are_among_the_most_minute(name, way):
    P, limit = one(name)[0].hierarchy.P, limits_seen(name, way)
    first = limit == limit.min()
    assert (P[first] <= np.quantile(P, 0.25)).all()


@pytest.mark.parametrize("name", ALL)
@pytest.mark.parametrize("way", range(len(DIRECTIONS)))
def test_the_whole_stays_to_the_last(name, way):
    _, shown = recession(name, way)
    assert [s for s in shown if s][-1] == {0}
    P, limit = one(name)[0].hierarchy.P, limits_seen(name, way)
    assert (limit[0] > limit[1:]).all()
    if name in LIVING:  # and before it the largest
        last = limit[1:] >= np.sort(limit[1:])[-2]
        assert (P[1:][last] >= np.quantile(P, 0.75)).all()


@pytest.mark.parametrize("name", ALL)
def test_what_is_left_at_the_end_is_rounded(name):
    """One stick with round ends, whose outline covers at least three quarters of the disc of its
    own width where it is as broad as long, and never tapers to a point.
    """
    it, _ = one(name)
    leaf = it.leaf
    rows = slice(leaf.first[0], leaf.first[1])
    radii = np.array([leaf.start_radius[rows], leaf.end_radius[rows]])
    assert radii.shape == (2, 1)
    assert radii.min() > 0.8 * radii.max()
    at = it.posed().leaf
    length = np.linalg.norm(at.end[0] - at.start[0])
    capsule = np.pi * radii.mean() ** 2 + 2 * radii.mean() * length
    one_stick = leaf.only(np.arange(len(it.joint)) == 0).posed(*it.rig.frames())
    assert largest_area(one_stick)[0] == pytest.approx(capsule, rel=0.02)


@pytest.mark.parametrize("name", LIVING)
@pytest.mark.parametrize("way", range(len(DIRECTIONS)))
def test_parts_are_lost_in_the_order_of_their_size(name, way):
    P, limit = one(name)[0].hierarchy.P, limits_seen(name, way)
    assert spearmanr(P, limit)[0] > (0.9 if name in GROWN_LIKE_US else 0.8)


def test_an_artifact_breaks_the_order():
    """The paper's doubt is right: the hub of a windmill is its smallest part, and stays as long as
    sails several times its size, which hang on it.
    """
    it, names = one("windmill")
    P, hub = it.hierarchy.P, names.index("hub")
    sails = [names.index(f"sail {k}") for k in (1, 2, 3, 4)]
    assert P[hub] == P.min()
    assert (P[sails] > 3 * P[hub]).all()
    for way in range(len(DIRECTIONS)):
        limit = limits_seen("windmill", way)
        assert (limit[hub] >= limit[sails]).all()
        assert limit[hub] >= np.median(limit)
        assert spearmanr(P, limit)[0] < 0.8
