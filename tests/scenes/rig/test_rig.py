"""Posable prototypes: rotations, bounds over all poses, and the compiled walk over joints."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import minimize
from scipy.spatial.transform import Rotation

from lod.arrays import frozen
from scenes.figures.animal_file import (
    people_at_rest,
    walking_people,
)
from scenes.figures.gait import KEYS
from scenes.rig import foot_placement, pose
from scenes.rig.foot_placement import Placements, place_on_ground
from scenes.rig.pose import PoseTables, pose_points
from scenes.rig.rig import (
    Rig,
    from_euler,
    inverse,
    matrices,
    multiply_quaternions,
    rotate_vectors,
    to_euler,
)
from scenes.rig.rigged_prototype import reach_bound
from scenes.sticks.areas import largest_area
from tests.scenes.figures.motion_phase import motion_at

seeds = st.integers(0, 2**32 - 1)


def test_turns_are_those_of_scipy():
    rng = np.random.default_rng(1)
    degrees = rng.uniform(-89, 89, (50, 3))
    turns, v = from_euler(degrees), rng.normal(size=(50, 3))
    theirs = Rotation.from_euler("xyz", degrees, degrees=True)
    assert np.allclose(np.abs((turns * theirs.as_quat()).sum(axis=1)), 1, atol=1e-12)
    assert np.allclose(rotate_vectors(turns, v), theirs.apply(v), atol=1e-12)
    assert np.allclose(matrices(turns), theirs.as_matrix(), atol=1e-12)
    assert np.allclose(to_euler(turns), degrees, atol=1e-9)
    assert np.allclose(
        matrices(multiply_quaternions(turns, turns[::-1])), (theirs * theirs[::-1]).as_matrix()
    )
    assert np.allclose(multiply_quaternions(turns, inverse(turns)), (0, 0, 0, 1), atol=1e-12)


def chain(rng, joints):
    """A chain with random offsets and limits; joint 0 is held."""
    low = rng.uniform(-150, 60, (joints, 3))
    high = low + rng.uniform(0, 120, (joints, 3)) * (rng.random((joints, 3)) < 0.7)
    names = tuple(f"joint {k}" for k in range(joints))
    offset, none = rng.normal(0, 0.3, (joints, 3)), np.zeros(3)
    rest = from_euler(low + 0.5 * (high - low))
    return Rig(names, np.arange(joints) - 1, offset, rest, low, high, none, none)


@given(seeds, st.integers(2, 6))
@settings(max_examples=40)
def test_reach_is_never_exceeded(seed, joints):
    rng = np.random.default_rng(seed)
    rig, point = chain(rng, joints), rng.normal(0, 0.3, (1, 3))
    bound = reach_bound(rig, 0, np.array([joints - 1]), point, np.array([0.05]))
    origin, turn = rig.frames(rig.random_turns(rng, 500))
    at = origin[:, -1] + rotate_vectors(turn[:, -1], np.broadcast_to(point, (500, 3)))
    assert np.linalg.norm(at - origin[:, 0], axis=1).max() + 0.05 <= bound


@pytest.mark.parametrize("joints", [2, 3, 5])
def test_reach_is_reached_within_a_few_per_cent(joints):
    rng = np.random.default_rng(joints)
    rig, point = chain(rng, joints), rng.normal(0, 0.3, (1, 3))
    bound = reach_bound(rig, 0, np.array([joints - 1]), point, np.zeros(1))

    def away(angles):
        x = point[0]
        for offset, turn in zip(
            rig.offset[:0:-1], from_euler(angles.reshape(-1, 3))[:0:-1], strict=True
        ):
            x = offset + rotate_vectors(turn, x)
        return -np.linalg.norm(x)

    box = list(zip(rig.low.ravel(), rig.high.ravel(), strict=True))
    starts = rng.uniform(rig.low.ravel(), rig.high.ravel(), (8, 3 * joints))
    best = max(-minimize(away, start, bounds=box, method="L-BFGS-B").fun for start in starts)
    assert 0.97 * bound <= best <= bound


def people():
    return people_at_rest(5, 3, 0.5)


def reaches(who, poses):
    """Per part, farthest over poses: own sticks, direct parts' sticks, everything below, from
    whole.
    """
    rig, h = who.rig, who.hierarchy
    origin, turn = rig.frames(poses)
    n = len(h)
    own, R, B, separation = (np.zeros(n) for _ in range(4))
    for table in (who.inner, who.leaf):
        for joint, point, radius in (
            (table.start_joint, table.start, table.start_radius),
            (table.end_joint, table.end, table.end_radius),
        ):
            row = np.maximum(joint, 0)
            at = origin[:, row] + rotate_vectors(
                turn[:, row], np.broadcast_to(point, (len(poses), *point.shape))
            )
            at = np.where((joint < 0)[:, None], point, at)
            part, depth = table.owner, 0
            while len(part):
                centre = origin[:, who.joint[part]]
                far = (np.linalg.norm(at - centre, axis=-1) + radius).max(axis=0)
                if depth == 0:
                    np.maximum.at(own, part, far)
                if depth <= 1:
                    np.maximum.at(R, part, far)
                np.maximum.at(B, part, far)
                up = h.parent[part]
                keep, part, depth = up >= 0, up[up >= 0], depth + 1
                at, radius = at[:, keep], radius[keep]
    at = origin[:, who.joint]
    separation[1:] = np.linalg.norm(at[:, 1:] - at[:, h.parent[1:]], axis=-1).max(axis=0)
    return R, B, separation


@given(seeds)
@settings(max_examples=6)
def test_no_allowed_pose_exceeds_R_B_or_separation(seed):
    for who in people()[:2]:
        poses = who.rig.random_turns(np.random.default_rng(seed), 60)
        R, B, separation = reaches(who, poses)
        assert np.all(R <= who.hierarchy.R)
        assert np.all(B <= who.hierarchy.B)
        assert np.all(separation <= who.hierarchy.separation + 1e-12)


def test_P_is_not_exceeded_and_is_reached_in_allowed_poses():
    for who in people()[:2]:
        best = np.zeros(len(who.hierarchy))
        straight = from_euler(np.clip(0.0, who.rig.low, who.rig.high))
        for poses in (straight, *who.rig.random_turns(np.random.default_rng(2), 12)):
            best = np.maximum(best, largest_area(who.leaf.posed(*who.rig.frames(poses))))
        assert np.all(np.sqrt(best) <= 1.01 * who.hierarchy.P)
        assert np.all(np.sqrt(best) >= 0.99 * who.hierarchy.P)


def crowd(count, gradient=0.0, seed=0, on_keys=False):
    cast = walking_people(people(), 2)
    rng = np.random.default_rng(seed)
    heading = rng.uniform(0, 2 * np.pi, count)
    slope = rng.uniform(-gradient, gradient, 2)
    places = (rng.normal(0, 10, (count, 2)), np.cos(heading), np.sin(heading))
    variant, phase = rng.integers(0, len(cast), count), rng.uniform(-3, 3, count)
    drawn = variant, np.round(phase * KEYS) / KEYS if on_keys else phase, np.ones(count)
    return cast, place_on_ground(
        PoseTables.of(cast), lambda xy: xy @ slope, Placements(*places, *drawn)
    )


CORNERS = np.vstack((np.zeros(3), np.eye(3)))
"""A joint's origin and the ends of its axes tell all of its frame."""


def corners(cast, instances, rows, joints):
    """Those points of joints in the frame, (m, 4, 3)."""
    place, on = np.tile(CORNERS, (len(joints), 1)), np.repeat(joints, 4)
    four, points = np.repeat(rows, 4), np.arange(4 * len(joints))
    return pose_points(PoseTables.of(cast), instances, four, points, place, on).reshape(-1, 4, 3)


def test_the_walk_poses_as_the_rig_does():
    people, instances = crowd(6)
    rows, joints = np.divmod(np.arange(6 * 40), 40)
    seen = corners(people, instances, rows, joints)
    for o in range(6):
        who = people[instances.prototype[o]]
        at, facing = who.rig.frames(*motion_at(who.motion, float(instances.phase[o])))
        heading = Rotation.from_matrix(
            [
                [instances.cos[o], -instances.sin[o], 0],
                [instances.sin[o], instances.cos[o], 0],
                [0, 0, 1],
            ]
        )
        for k, corner in enumerate(CORNERS):
            theirs = at[:40] + rotate_vectors(facing[:40], np.broadcast_to(corner, (40, 3)))
            mine = seen[rows == o, k] - instances.origin[o]
            assert np.allclose(mine, heading.apply(theirs), atol=1e-12)


def test_a_kernel_is_compiled_once_whatever_kind_of_array_arrives():
    """Numba compiles anew for read-only arrays: kernels get no other kind."""
    cast, instances = crowd(3, 0.1)
    tables, place, on = PoseTables.of(cast), np.zeros((2, 3)), np.array([-1, 0])
    rows, points = np.array([0, 0, 2]), np.array([0, 1, 1])
    where = Placements(np.zeros((3, 2)), np.ones(3), np.zeros(3), rows, np.zeros(3), np.ones(3))
    kernels = pose._pose_points, foot_placement._place_bodies, foot_placement._contact_points
    compiled = []
    for kind in (np.array, lambda a: frozen(a, np.asarray(a).dtype)):
        pose_points(tables, instances, kind(rows), kind(points), kind(place), kind(on))
        place_on_ground(tables, lambda xy, kind=kind: kind(xy[:, 0]), Placements(*map(kind, where)))
        compiled.append([len(kernel.signatures) for kernel in kernels])
    assert compiled[0] == compiled[1]


@pytest.mark.parametrize(("on_keys", "most"), [(True, 1e-6), (False, 1e-3)])
def test_a_slope_changes_poses_little_by_little(on_keys, most):
    """Between keys a leg is posed by its own angles, not by a slerp of them."""
    people, instances = crowd(20, 1e-9, on_keys=on_keys)
    _, level = crowd(20, on_keys=on_keys)
    rows, joints = np.divmod(np.arange(20 * 50), 50)
    near, flat = (corners(people, b, rows, joints) for b in (instances, level))
    assert 0 < np.abs(near - flat).max() < most
