"""How a gait given by tables becomes key poses: where feet go, how the body sways, hips and knees.

A foot is prescribed relative to the ground: it lands on its heel, rolls flat, rises about its ball
and swings to its next print. Hips follow from the body's own waves, and hip and knee from the two
of them by two-link inverse kinematics. Everything on legs goes by the same rules; what differs
stands in its ``Gait`` (``scenes.gait.parameters``).
"""

import math
from dataclasses import dataclass, replace

import numpy as np

from lod.errors import InputError
from scenes.gait.foot_path import Contacts, foot_path, heel_and_ball, sole_points
from scenes.gait.parameters import AXES, Gait, Leg
from scenes.rig.anatomy import side_of
from scenes.rig.footprints import Feet
from scenes.rig.keyframes import Motion, key_phases
from scenes.rig.rig import Rig
from scenes.rig.rigged_prototype import RiggedPrototype
from scenes.rig.rotations import (
    Quaternions,
    Vectors,
    from_euler,
    inverse,
    multiply_quaternions,
    rotate_vectors,
    to_euler,
)

KEYS = 32

REACH = 0.996
"""How far a leg may be stretched, as a share of its length: knees are never locked."""


def with_gait(prototype: RiggedPrototype, gait: Gait, keys: int = KEYS) -> RiggedPrototype:
    """Give an object the motion of a gait. Raises InputError if a leg is too short for it."""
    return prototype.with_motion(make_motion(prototype, gait, keys))


def make_motion(prototype: RiggedPrototype, gait: Gait, keys: int = KEYS) -> Motion:
    """Make the key poses of one cycle; the first leg's left foot lands at its ``strike`` phase."""
    rig, phase = prototype.rig, key_phases(keys)
    height = _hip_height(rig, gait)
    stride = gait.stride_m(height)
    rotations, shift = _body_motion(rig, gait, phase, height)
    paths = [
        _leg_path(prototype, gait, leg, side, phase, stride, height)
        for leg in gait.legs
        for side in ("left ", "right ")
    ]
    shift[:, 2] += min(
        0.0, min((_rise_to_reach(rig, p, rotations, shift) for p in paths), default=0.0)
    )
    for p in paths:
        _solve_leg(rig, p, rotations, shift)
    feet = Feet(
        legs=np.array([p.rows for p in paths]).reshape(-1, 3),
        sticks_out=np.array([p.leg.sticks_out for p in paths], bool),
        bend=np.array([float(p.leg.bend) for p in paths]),
        strike=np.array([p.strike for p in paths]),
        duty=np.full(len(paths), gait.duty),
        home=np.array([p.home for p in paths]).reshape(-1, 2),
        steepest=np.full(len(paths), gait.steepest),
        sole=np.array([p.sole for p in paths]).reshape(-1, 3, 2),
    )
    return Motion(rotations, shift, stride, gait.period_s(height), feet, gait.tilts)


def _hip_height(rig: Rig, gait: Gait) -> float:
    if not gait.legs:
        return float(rig.frames()[0][:, 2].max())
    return float(rig.frames()[0][rig.row(f"left {gait.legs[0].hip}"), 2])


def _body_motion(
    rig: Rig, gait: Gait, phase: np.ndarray, height: float
) -> tuple[Quaternions, Vectors]:
    """Rotations of every joint by the waves alone, (K, j, 4), and bob and sway, (K, 3) [m]."""
    rest = to_euler(rig.rest)
    angles = np.broadcast_to(rest, (len(phase), *rest.shape)).copy()
    shift, moved = np.zeros((len(phase), 3)), np.zeros(rest.shape, bool)
    for wave in gait.waves:
        axis = AXES.index(wave.axis)
        if not wave.joint:
            swing = np.cos(2 * np.pi * (wave.cycles * phase - wave.peak))
            shift[:, axis] += height * ((wave.mean or 0.0) + wave.amplitude * swing)
            continue
        named = [name for name in rig.name if side_of(name)[1] == wave.joint]
        if not named:
            raise InputError("gait.wave", wave.joint, "a joint of the rig")
        for name in named:
            row, right = rig.row(name), name.startswith("right ")
            late = wave.apart if right else 0.0
            value = wave.amplitude * np.cos(2 * np.pi * (wave.cycles * (phase - late) - wave.peak))
            sign = -1.0 if right and wave.axis != "y" else 1.0
            if wave.mean is not None and not moved[row, axis]:
                angles[:, row, axis] = sign * wave.mean
            angles[:, row, axis] += sign * value
            moved[row, axis] = True
    for spin in gait.spins:
        row, axis = rig.row(spin.joint), AXES.index(spin.axis)
        angles[:, row, axis] += 360.0 * spin.rounds * phase
        moved[row, axis] = True
    still = ~moved.any(axis=1)
    rotations = from_euler(angles)
    rotations[:, still] = rig.rest[still]
    return rotations, shift


@dataclass(frozen=True, eq=False)
class _LegPath:
    """One leg of one side through the cycle, K phases.

    rows: of hip, knee and ankle; toes: their rows; turnout: of the foot from ahead [rad]
    ankle (K, 3) where the ankle is [m], foot (K, 4) its rotation, curl (K,) of the toes [degrees]
    strike: phase at which the foot lands; home (2,): its print in mid-stance [m]; sole (3, 2) on it
    """

    leg: Leg
    rows: tuple[int, int, int]
    toes: tuple[int, ...]
    turnout: float
    ankle: np.ndarray
    foot: np.ndarray
    curl: np.ndarray
    strike: float
    home: np.ndarray
    sole: np.ndarray


def _leg_path(
    prototype: RiggedPrototype,
    gait: Gait,
    leg: Leg,
    side: str,
    phase: np.ndarray,
    stride: float,
    height: float,
) -> _LegPath:
    rig, sign = prototype.rig, 1.0 if side == "left " else -1.0
    rows = rig.row(side + leg.hip), rig.row(side + leg.knee), rig.row(side + leg.ankle)
    contacts: Contacts = heel_and_ball(prototype, rows[2])
    strike = (leg.strike + (0.0 if side == "left " else leg.apart)) % 1.0
    own = phase - strike
    path = foot_path(leg, contacts, own % 1.0, stride, gait.duty, leg.clearance * height)
    turnout = sign * math.radians(leg.turnout)
    rest = rig.frames()[0]
    hip, ankle = rest[rows[0]], rest[rows[2]]
    at = (ankle[0], ankle[1]) if leg.spread is None else (hip[0], sign * leg.spread * height)
    home = np.array((at[0] + leg.ahead * height, at[1], 0.0))
    ahead = np.stack((path.print_x, np.zeros(len(own)), path.z), axis=1)
    along = path.roll[:, None] * np.array((math.cos(turnout), math.sin(turnout), 0.0))
    degrees = np.stack((0 * own, path.pitch, np.full(len(own), math.degrees(turnout))), axis=1)
    return _LegPath(
        leg,
        rows,
        tuple(rig.row(side + toe) for toe in leg.toes),
        turnout,
        home + ahead + along,
        from_euler(degrees),
        path.curl,
        strike,
        home[:2],
        sole_points(prototype, rows[2]) @ _rotation_2d(turnout).T,
    )


def _rotation_2d(angle: float) -> np.ndarray:
    cos, sin = math.cos(angle), math.sin(angle)
    return np.array(((cos, -sin), (sin, cos)))


def rest_feet(prototype: RiggedPrototype) -> Feet:
    """Make the feet of a walker that stays at rest: each stands where it is, all of the time."""
    feet = prototype.motion.feet
    origin, turn = prototype.rig.frames()
    ankles = feet.legs[:, 2]
    ahead = rotate_vectors(turn[ankles], np.broadcast_to((1.0, 0.0, 0.0), (len(feet), 3)))
    yaw = np.arctan2(ahead[:, 1], ahead[:, 0])
    soles = [
        sole_points(prototype, int(row)) @ _rotation_2d(angle).T
        for row, angle in zip(ankles, yaw, strict=True)
    ]
    return replace(
        feet,
        duty=np.ones(len(feet)),
        home=origin[ankles, :2],
        sole=np.array(soles).reshape(-1, 3, 2),
    )


def _rise_to_reach(rig: Rig, p: _LegPath, rotations: Quaternions, shift: Vectors) -> float:
    """How far the body may rise for this leg to reach its foot at every phase [m].

    Below 0 the body must sink. Raises InputError where the stride is too long for the leg.
    """
    hip = rig.frames(rotations, shift)[0][:, p.rows[0]]
    length = REACH * sum(float(np.linalg.norm(rig.offset[row])) for row in p.rows[1:])
    aside = np.linalg.norm((p.ankle - hip)[:, :2], axis=1)
    if aside.max() >= length:
        raise InputError("gait.stride", float(aside.max()), f"within a leg's reach, {length:.3g} m")
    return float((np.sqrt(length**2 - aside**2) + p.ankle[:, 2] - hip[:, 2]).min())


def _solve_leg(rig: Rig, p: _LegPath, rotations: Quaternions, shift: Vectors) -> None:
    """Write the rotations of hip, knee, ankle and toes that put the ankle on its path."""
    hip, knee, ankle = p.rows
    origin, frame = rig.frames(rotations, shift)
    above = (
        frame[:, rig.parent[hip]]
        if rig.parent[hip] >= 0
        else from_euler(np.zeros((len(rotations), 3)))
    )
    reach = rotate_vectors(inverse(above), p.ankle - origin[:, hip])
    upper, lower = (float(np.linalg.norm(rig.offset[row])) for row in (knee, ankle))
    hip_degrees, knee_degrees = hip_and_knee_angles(reach, upper, lower, p.leg, p.turnout)
    rotations[:, hip], rotations[:, knee] = from_euler(hip_degrees), from_euler(knee_degrees)
    shank = multiply_quaternions(multiply_quaternions(above, rotations[:, hip]), rotations[:, knee])
    rotations[:, ankle] = multiply_quaternions(inverse(shank), p.foot)
    for toe in p.toes:
        rotations[:, toe] = from_euler(np.stack((0 * p.curl, p.curl, 0 * p.curl), axis=1))


def hip_and_knee_angles(
    reach: Vectors, upper: float, lower: float, leg: Leg, turnout: float
) -> tuple[Vectors, Vectors]:
    """Compute the angles about x, y, z of hip and knee that put the ankle at ``reach`` [degrees].

    ``reach`` is in the frame of the hip's parent [m]. Both bones hang straight down at angles 0.
    The knee turns about y alone, by the law of cosines; the hip about y into the direction of the
    ankle, and aside about x, or about z for legs that stick out.
    """
    distance = np.linalg.norm(reach, axis=1)
    cosine = (distance**2 - upper**2 - lower**2) / (2 * upper * lower)
    knee = leg.bend * np.arccos(np.clip(cosine, -1, 1))
    x, z = -lower * np.sin(knee), -(upper + lower * np.cos(knee))
    if leg.sticks_out:
        about_z = np.arctan2(reach[:, 1], reach[:, 0])
        about_x = np.zeros(len(reach))
        ahead = np.hypot(reach[:, 0], reach[:, 1])
    else:
        about_z = np.full(len(reach), turnout)
        ahead = reach[:, 0] * np.cos(turnout) + reach[:, 1] * np.sin(turnout)
        aside = reach[:, 1] * np.cos(turnout) - reach[:, 0] * np.sin(turnout)
        about_x = np.arcsin(np.clip(-aside / z, -1, 1))
        z = z * np.cos(about_x)
    about_y = np.arctan2(z * ahead - x * reach[:, 2], x * ahead + z * reach[:, 2])
    hip = np.degrees(np.stack((about_x, about_y, about_z), axis=1))
    return hip, np.degrees(np.stack((0 * knee, knee, 0 * knee), axis=1))
