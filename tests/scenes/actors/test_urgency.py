"""The bound of who coasts, against bodies that speed up, brake and turn as hard as they may."""

import numpy as np
import pytest

from scenes.actors.acting import MotionBounds, offset_bound_m
from scenes.actors.body import ACCELERATION, SPIN_ACCELERATION
from scenes.actors.limb import planted_phase, step_at
from scenes.actors.performance import posed_prototype
from scenes.field.prototypes import species_prototypes
from scenes.models.catalogue import model_prototypes
from scenes.rig.foot_placement import Placements, place_on_ground
from scenes.rig.pose import pose_points

PHASES = np.linspace(0, 1, 16, endpoint=False)


def stick_ends_of(who, eighths, x, y, yaw, phase, stride):
    """Both ends of every stick, at every phase after this one, as the pruner poses them."""
    posed, n = posed_prototype(who, eighths, ()), len(PHASES)
    tables, ones = species_prototypes((posed,)).pose_tables, np.ones(len(PHASES))
    facing = ones * np.cos(yaw), ones * np.sin(yaw), np.zeros(n, np.int64)
    there = Placements(np.full((n, 2), (x, y)), *facing, phase + PHASES, stride * ones)
    placed = place_on_ground(tables, lambda xy: np.zeros(len(xy)), there)
    ends = []
    for table in posed.full_detail_sticks():
        for at, on in ((table.start, table.start_joint), (table.end, table.end_joint)):
            own, item = np.repeat(np.arange(n), len(at)), np.tile(np.arange(len(at)), n)
            ends.append(pose_points(tables, placed, own, item, at, on).reshape(n, -1, 3))
    return np.concatenate(ends, axis=1)


def gone(who, speed, accelerating, turning, seconds, steps=100):
    """Where a body is after a time: shares of the greatest accelerations, step by step."""
    x = y = yaw = phase = spin = 0.0
    dt = seconds / steps
    for _ in range(steps):
        before, speed = speed, max(speed + accelerating * ACCELERATION * dt, 0.0)
        spin += turning * SPIN_ACCELERATION * dt
        yaw += spin * dt
        x, y = x + speed * dt * np.cos(yaw), y + speed * dt * np.sin(yaw)
        step = step_at(who.motion, speed)
        phase = planted_phase(who.motion, phase, step_at(who.motion, before), step)
        phase += dt * step.cadence
    return step.eighths, x, y, yaw, phase, step.stride_factor


@pytest.mark.parametrize("model", ["figure", "ostrich"])
@pytest.mark.parametrize("share", [0.0, 0.2, 0.8, 1.25, 1.5, 2.5])
def test_nothing_is_farther_off_than_the_bound(model, share):
    who = model_prototypes(model, 1, (1.0,), True)[0]
    speed, bodies = share * who.motion.speed, MotionBounds.of([who])
    for seconds in (1 / 24, 0.2):
        bound = float(offset_bound_m(bodies, np.array([speed]), np.array([seconds]))[0])
        coasted = stick_ends_of(who, *gone(who, speed, 0, 0, seconds))
        worst = 0.0
        for hard in ((1, 0), (-1, 0), (0, 1), (1, 1), (-1, 1)):
            other = stick_ends_of(who, *gone(who, speed, *hard, seconds))
            worst = max(worst, float(np.linalg.norm(other - coasted, axis=-1).max()))
        assert 0.02 * bound < worst <= bound
