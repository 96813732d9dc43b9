import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lod.actors.actor import CompoundActor, SimpleActor
from lod.actors.appearance import ConeStick, StickBundle
from lod.actors.camera import CameraActor
from lod.actors.compile import compile_actor
from lod.actors.dispatch import query
from lod.actors.joint import JointLimits, RevoluteJoint
from lod.actors.message import Refused
from lod.actors.quaternion import UP, rotation
from lod.errors import InputError

RED, GREY = (0.8, 0.1, 0.1), (0.5, 0.5, 0.5)


def stick(length, albedo=GREY):
    return ConeStick((0, 0, 0), (length, 0, 0), 0.1, 0.05, albedo)


def chain_of_things(wholes, chance):
    """An actor whose i-th part belongs to part wholes[i] (-1: to the actor itself)."""

    def build(row):
        parts = {f"p{i}": build(i) for i, whole in enumerate(wholes) if whole == row}
        joint = RevoluteJoint(chance.normal(size=3), chance.normal(size=4))
        looks = (
            StickBundle(tuple(stick(row + k + 2, RED) for k in range(row % 3))),
            stick(row + 9),
        )
        return CompoundActor(parts, joint, *looks) if parts else SimpleActor(joint, looks[0])

    return build(-1)


families = st.lists(st.integers(0, 9), max_size=10).map(
    lambda draws: [draw % (i + 1) - 1 for i, draw in enumerate(draws)]
)


@given(families, st.integers(0, 2**32 - 1))
def test_wholes_stand_before_their_parts(wholes, seed):
    arrays = compile_actor(chain_of_things(wholes, np.random.default_rng(seed)))
    assert arrays.parent[0] == -1
    assert len(arrays) == len(wholes) + 1
    for row, route in enumerate(arrays.routes[1:], 1):
        assert arrays.parent[row] < row
        assert arrays.routes[arrays.parent[row]] == route[:-1]
        assert arrays.row(route) == row


@given(families, st.integers(0, 2**32 - 1), st.integers(0, 4))
def test_the_sticks_are_those_that_a_camera_renders(wholes, seed, deepest):
    actor = chain_of_things(wholes, np.random.default_rng(seed))
    arrays = compile_actor(actor)
    frames = dict(actor.frames())
    shown = np.array([len(route) for route in arrays.routes]) <= deepest
    is_leaf = np.bincount(arrays.parent[1:][shown[1:]], minlength=len(arrays)) == 0
    found = []
    for sticks, wanted in ((arrays.inner, shown & ~is_leaf), (arrays.leaf, shown & is_leaf)):
        own = sticks.owner[wanted[sticks.owner]]
        joints = [frames[arrays.routes[row]] for row in own]
        ends = map(RevoluteJoint.to_whole, joints, sticks.end[wanted[sticks.owner]])
        tints = arrays.tints[sticks.tint[wanted[sticks.owner]]]
        found += [(*end, *tint) for end, tint in zip(ends, tints, strict=True)]
    rendered = CameraActor().render([actor], lambda route, _: len(route) <= deepest)
    expected = np.hstack((rendered.end, rendered.tints[rendered.tint].reshape(-1, 3)))
    assert np.allclose(sorted(found), sorted(map(tuple, expected)), atol=1e-9)


def test_a_joints_limits_and_places():
    rest = rotation(UP, 90)
    elbow = RevoluteJoint((0, 0, 1), rest, JointLimits((0, 0, 0), (0, 140, 0), rest))
    arrays = compile_actor(CompoundActor({"arm": SimpleActor(elbow)}))
    assert arrays.position.tolist() == [[0, 0, 0], [0, 0, 1]]
    assert np.allclose(arrays.orientation[1], (0, 0, np.sqrt(0.5), np.sqrt(0.5)))
    assert arrays.rest[1].tolist() == arrays.orientation[1].tolist()
    assert arrays.low_deg.tolist() == [[-np.inf] * 3, [0, 0, 0]]
    assert arrays.high_deg.tolist() == [[np.inf] * 3, [0, 140, 0]]
    with pytest.raises(ValueError, match="read-only"):
        arrays.position[0] = 1


def test_an_unknown_route_names_the_nearest():
    arrays = compile_actor(CompoundActor({"arm": SimpleActor(), "leg": SimpleActor()}))
    with pytest.raises(InputError, match="did you mean 'leg'"):
        arrays.row("lge")


def test_a_whole_may_keep_its_parts_to_itself():
    class Closed(CompoundActor):
        @query
        def description(self):
            raise Refused(str(self), "private")

    box = CompoundActor({"lid": Closed({"hinge": SimpleActor()})}, name="box")
    with pytest.raises(Refused, match="box/lid refuses: private"):
        compile_actor(box)
