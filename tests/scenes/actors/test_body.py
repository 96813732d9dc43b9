"""The person of figures 1 and 2 as an actor, and the crowd that is posed from it: one figure."""

import doctest
import importlib
from pathlib import Path

import numpy as np
import pytest

from lod.actors.actor import Quaternion, rotation
from lod.actors.object_with_parts import Refusal, ask, change
from scenes.actors.body import Body
from scenes.actors.limb import limb_routes, limb_tree, planted_phase, prints_ahead, step_at
from scenes.actors.performance import posed_prototype
from scenes.figures.animal_file import animal, people_at_rest, walking_people
from scenes.rig.foot_placement import Placements, place_on_ground
from scenes.rig.pose import PoseTables, pose_points

RIGHT_FOOT = "right leg/lower leg/foot"


def someone(name):
    return people_at_rest(0, 1, 0.0)[0] if name == "person" else animal(name)


def pose_of(who, actor):
    """The prototype as the pruner poses it, from what the actor answers."""
    posture = actor.receive(ask("", "posture")).value
    return posed_prototype(who, posture.eighths, posture.held)


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


def posed_by_actor(who, actor):
    """The same by the actors' own recursive answers."""
    rows = []
    rows_of = {(): -1, **limb_routes(limb_tree(who))}
    for route, frame in actor.receive(ask("", "frames")).value:
        for table in who.full_detail_sticks():
            for k in np.flatnonzero(table.start_joint == rows_of[route]).tolist():
                ends = frame.to_whole(table.start[k]), frame.to_whole(table.end[k])
                rows.append((*ends[0], *ends[1], table.start_radius[k], table.end_radius[k]))
    return np.array(rows)


def in_order(rows):
    return rows[np.lexsort(np.round(rows, 6).T)]


@pytest.mark.parametrize("name", ["person", "giraffe", "windmill"])
def test_messages_pose_the_crowds_sticks(name):
    who, rng = someone(name), np.random.default_rng(8)
    actor, routes = Body(name, who), limb_routes(limb_tree(who))
    assert tuple(routes) == actor.receive(ask("", "routes")).value
    for pose in (who.rig.rest, *who.rig.random_turns(rng, 4)):
        for route, row in routes.items():
            turn = Quaternion(*pose[row].tolist())
            actor.receive(change(route, "orient", turn)).value  # noqa: B018
        mine, theirs = posed_by_kernel(pose_of(who, actor)), posed_by_actor(who, actor)
        assert mine.shape == theirs.shape
        nearest = np.abs(mine[:, None] - theirs[None]).max(axis=2).min(axis=1)
        assert nearest.max() < 1e-9
        assert np.allclose(in_order(mine).sum(axis=0), in_order(theirs).sum(axis=0), atol=1e-6)


def test_figure_4_turns_the_foot_of_the_crowds_figure():
    """40° about y, as far as the ankle goes; 140° are refused, and change nothing."""
    who = someone("person")
    joe = Body("joe", who)
    at_rest = posed_by_kernel(pose_of(who, joe))
    before = joe.receive(ask(RIGHT_FOOT, "orientation")).value
    refused = joe.receive(change(RIGHT_FOOT, "orient", before * rotation((0, 1, 0), 140)))
    assert isinstance(refused, Refusal)
    assert np.array_equal(posed_by_kernel(pose_of(who, joe)), at_rest)
    joe.receive(change(RIGHT_FOOT, "orient", before * rotation((0, 1, 0), 40))).value  # noqa: B018
    moved = np.abs(posed_by_kernel(pose_of(who, joe)) - at_rest).max(axis=1) > 1e-6
    assert 5 < moved.sum() < 20  # the foot and its toes, and nothing else
    joe.receive(change("torso", "release")).value  # noqa: B018
    assert np.array_equal(posed_by_kernel(pose_of(who, joe)), at_rest)


@pytest.mark.parametrize("speed", [0.0, 0.2, 1.3])
def test_a_walkers_limbs_are_where_the_pruner_draws_them(speed):
    who = walking_people(people_at_rest(0, 1, 0.0), 0)[0]
    joe = Body("joe", who, (3.0, -2.0), heading_deg=30.0)
    joe.receive(change("", "go", speed, 20.0)).value  # noqa: B018
    for time_s in (0.1, 0.55, 3.0):
        joe.receive(change("", "advance", time_s)).value  # noqa: B018
        p = joe.receive(ask("", "posture")).value
        drawn = posed_prototype(who, p.eighths, p.held)
        here = np.array([[p.x, p.y]]), np.cos([p.yaw]), np.sin([p.yaw]), np.zeros(1, np.int64)
        level = Placements(*here, np.array([p.phase]), np.ones(1))
        tables = PoseTables.of((drawn,))
        instances = place_on_ground(tables, lambda xy: np.zeros(len(xy)), level)
        hand, row = ("right arm", "forearm", "hand"), np.array([who.rig.row("right wrist")])
        none = np.zeros(1, np.int64)
        by_pruner = pose_points(tables, instances, none, none, np.zeros((1, 3)), row)[0]
        assert np.allclose(joe.receive(ask("", "where", hand)).value, by_pruner, atol=1e-9)


def test_a_body_coasts_on_an_arc_however_it_is_asked():
    """One second at once or in 7 steps: the same place; a quarter turn at 1 m/s has radius 2/π."""
    who = someone("person")
    once, often = Body("a", who, heading_deg=90.0), Body("b", who, heading_deg=90.0)
    for body, times in ((once, (1.0,)), (often, np.linspace(0, 1, 8).tolist())):
        body.receive(change("", "go", 1.0, 90.0)).value  # noqa: B018
        for time_s in times:
            body.receive(change("", "advance", time_s)).value  # noqa: B018
    a, b = (np.array(each.receive(ask("", "course")).value) for each in (once, often))
    assert np.allclose(a, b, atol=1e-12)
    assert np.allclose(a[:2], 2 / np.pi, atol=1e-12)


def test_a_foot_that_stands_keeps_its_print_while_the_pace_changes():
    """From rest a body sets off beside its print; later the print stays where it is, in metres."""
    motion = walking_people(people_at_rest(0, 1, 0.0), 0)[0].motion
    pace = [step_at(motion, speed) for speed in (0.0, 1.3, 1.1)]
    set_off = planted_phase(motion, 0.3, *pace[:2])
    assert abs(prints_ahead(motion, set_off)) < 1e-9
    for phase in np.linspace(0, 1, 13):
        shifted = planted_phase(motion, phase, *pace[1:])
        if len(standing(motion, phase)) == 1 and standing(motion, phase) == standing(
            motion, shifted
        ):
            ahead = prints_ahead(motion, phase) * pace[1].stride_factor
            assert np.isclose(prints_ahead(motion, shifted) * pace[2].stride_factor, ahead)
            assert abs(shifted - phase) > 1e-3 * abs(ahead)
    assert planted_phase(motion, 0.3, pace[1], pace[0]) == 0.3


def standing(motion, phase):
    """Legs that stand at a phase."""
    own = (phase - motion.feet.strike) % 1.0
    return np.flatnonzero(own <= motion.feet.duty).tolist()


def test_a_guard_may_watch_modify_and_reject():
    joe, seen = Body("joe", someone("person")), []

    def guard(message):
        seen.append(message.action.name)
        if message.action.name == "turn":
            return "it does not like to be turned"
        if message.action.changes:
            return change(message.route, "bend", (0, -5, 0))
        return message

    joe.receive(change("", "guard", guard)).value  # noqa: B018
    joe.receive(change("head", "bend", (0, 10, 0))).value  # noqa: B018
    bent = joe.receive(ask("head", "orientation")).value
    assert bent.y < 0
    assert joe.receive(change("head", "turn", (0, 0, 1), 5)) == Refusal(
        "joe", "it does not like to be turned"
    )
    assert seen == ["bend", "orientation", "turn"]


@pytest.mark.parametrize("first", ["", "torso/right leg/lower leg", "torso/abdomen/chest/head"])
def test_a_limb_that_is_asked_alone_is_where_all_limbs_say_it_is(first):
    """Only limbs on the way to who is asked follow the walk; it shows in no answer."""
    who = walking_people(people_at_rest(0, 1, 0.0), 0)[0]
    one, all_of_them = (Body("joe", who) for _ in range(2))
    for time_s in (0.0, 0.3, 0.7):
        for body in (one, all_of_them):
            body.receive(change("", "go", 1.3)).value  # noqa: B018
            body.receive(change("", "advance", time_s)).value  # noqa: B018
            if time_s == 0.3:
                body.receive(change("right arm", "bend", (-90.0, 0.0, 0.0))).value  # noqa: B018
                if first:
                    body.receive(change(first, "turn", (1, 0, 0), 0.0)).value  # noqa: B018
            if time_s == 0.7 and first:
                body.receive(change(first, "release")).value  # noqa: B018
        all_of_them.receive(ask("torso", "frames")).value  # noqa: B018
        for route in limb_routes(limb_tree(who)):
            asked = [
                body.receive(ask(route, name)).value.turn
                if name == "joint"
                else body.receive(ask("", name, route)).value
                for body in (one, all_of_them)
                for name in ("where", "joint")
            ]
            assert asked[:2] == asked[2:]
        posed = [each.receive(ask("", "posture")).value.held for each in (one, all_of_them)]
        assert posed[0] == posed[1]
        below = all_of_them.receive(ask("torso", "held")).value
        assert sorted(turn for _, turn in posed[0]) == sorted(turn for _, turn in below)


@pytest.mark.parametrize("module", ["actors.acting", "world.cast"])
def test_the_examples_in_the_docstrings_run(module):
    outcome = doctest.testmod(importlib.import_module(f"scenes.{module}"))
    assert outcome.attempted > 0
    assert outcome.failed == 0


def test_figures_3_and_4_are_on_the_page_of_actors():
    page = Path(__file__).parents[3] / "docs/actors.md"
    outcome = doctest.testfile(str(page), module_relative=False)
    assert outcome.attempted > 8
    assert outcome.failed == 0
