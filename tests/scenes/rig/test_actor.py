"""The person of figures 1 and 2 as an actor, and the crowd that is posed from it: one figure."""

import numpy as np
import pytest

from lod.actors.message import Refusal, ask, change
from lod.actors.quaternion import Quaternion, rotation
from scenes.models.animals.catalogue import animal
from scenes.models.people.people import people_at_rest
from scenes.rig.actor import compile_rig, pose_from_actor, to_actor
from scenes.rig.foot_placement import Placements, place_on_ground
from scenes.rig.pose import pose_points
from scenes.rig.pose_tables import PoseTables

RIGHT_FOOT = "pelvis/right hip/right knee/right ankle"


def someone(name):
    return people_at_rest(0, 1, 0.0)[0] if name == "person" else animal(name)


def routes_of(rig):
    """The way to every joint."""
    routes = []
    for name, parent in zip(rig.name, rig.parent.tolist(), strict=True):
        routes.append((*(routes[parent] if parent >= 0 else ()), name))
    return routes


def posed_by_kernel(prototype):
    """Both ends and radii of every stick displayed when all detail is, by the crowd's walk."""
    cast, rows = PoseTables.of((prototype,)), []
    here = np.zeros((1, 2)), np.ones(1), np.zeros(1), np.zeros(1, np.int64), np.zeros(1)
    instances = place_on_ground(cast, lambda xy: np.zeros(len(xy)), Placements(*here, np.ones(1)))
    for table in prototype.full_detail_sticks():
        sticks = np.arange(len(table))
        columns = table.start, table.end, table.start_joint, table.end_joint
        start, end = (
            pose_points(cast, instances, 0 * sticks, sticks, at, on)
            for at, on in zip(columns[:2], columns[2:], strict=True)
        )
        rows.append(np.column_stack((start, end, table.start_radius, table.end_radius)))
    return np.concatenate(rows)


def posed_by_actor(actor):
    """The same by the actors' own recursive answers."""
    shown = actor.receive(ask("", "displayed_sticks")).value
    return np.array([(*s.start, *s.end, s.start_radius, s.end_radius) for _, s in shown])


def in_order(rows):
    return rows[np.lexsort(np.round(rows, 6).T)]


@pytest.mark.parametrize("name", ["person", "giraffe", "windmill"])
def test_messages_pose_the_crowds_sticks(name):
    who, rng = someone(name), np.random.default_rng(8)
    actor, routes = to_actor(who), routes_of(who.rig)
    for pose in (who.rig.rest, *who.rig.random_turns(rng, 4)):
        for route, turn in zip(routes, pose.tolist(), strict=True):
            actor.receive(change(route, "orient", Quaternion(*turn))).value  # noqa: B018
        mine, theirs = posed_by_kernel(pose_from_actor(who, actor)), posed_by_actor(actor)
        assert mine.shape == theirs.shape
        nearest = np.abs(mine[:, None] - theirs[None]).max(axis=2).min(axis=1)
        assert nearest.max() < 1e-9
        assert np.allclose(in_order(mine).sum(axis=0), in_order(theirs).sum(axis=0), atol=1e-6)


def test_the_actor_compiles_to_the_rig_it_came_from():
    who = someone("person")
    rig, again = who.rig, compile_rig(to_actor(who), who.rig)
    assert again.name == rig.name
    assert np.array_equal(again.parent, rig.parent)
    for key in ("offset", "rest", "low", "high"):
        assert np.allclose(getattr(again, key), getattr(rig, key), atol=1e-12), key


def test_figure_4_turns_the_foot_of_the_crowds_figure():
    """40° about y, as far as the ankle goes; 140° are refused, and change nothing."""
    who = someone("person")
    joe = to_actor(who)
    at_rest = posed_by_kernel(pose_from_actor(who, joe))
    before = joe.receive(ask(RIGHT_FOOT, "orientation")).value
    refused = joe.receive(change(RIGHT_FOOT, "orient", before * rotation((0, 1, 0), 140)))
    assert isinstance(refused, Refusal)
    assert np.array_equal(posed_by_kernel(pose_from_actor(who, joe)), at_rest)
    joe.receive(change(RIGHT_FOOT, "orient", before * rotation((0, 1, 0), 40))).value  # noqa: B018
    moved = np.abs(posed_by_kernel(pose_from_actor(who, joe)) - at_rest).max(axis=1) > 1e-6
    assert 5 < moved.sum() < 20  # the foot and its toes, and nothing else
