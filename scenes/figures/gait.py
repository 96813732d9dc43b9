"""How a gait given by tables becomes key poses: where feet go, how the body sways, hips and knees.

Lengths are shares of h, the height of the first leg's hip at rest. Speed and stride are those of
dynamically similar animals: speed² = Froude·g·h, and stride = 2.3·h·Froude^0.3 (Alexander,
"Estimates of speeds of dinosaurs", Nature 261:129, 1976; for people from four years on, the same
author, Am. J. Phys. Anthropol. 63:23, 1984).

A foot is prescribed relative to the ground: it lands on its heel, rolls flat, rises about its ball
and swings to its next print. It touches the ground with two round contacts, heel and ball (one and
the same for hooves and claws). While it stands, the centre of the one it rolls over stays where it
is; while it swings, the lower of both clears the ground. Angles of the foot to the ground follow
from a table of phases, joined by monotone cubics (Fritsch & Carlson, SIAM J. Numer. Anal. 17:238,
1980) so that flat stays flat. Hips follow from the body's own waves, and hip and knee from the two
of them by two-link inverse kinematics.
"""

import math
from dataclasses import dataclass, replace
from typing import Annotated, Literal, NamedTuple

import numpy as np
from jaxtyping import Float64
from pydantic import Field

from lod.arrays import Reals
from lod.errors import InputError
from scenes.figures.anatomy import side_of
from scenes.model_files import CLOSED
from scenes.rig.rig import (
    Feet,
    Motion,
    Quaternions,
    Rig,
    Vectors,
    from_euler,
    inverse,
    key_phases,
    multiply_quaternions,
    rotate_vectors,
    to_euler,
)
from scenes.rig.rigged_prototype import RiggedPrototype

Axis = Literal["x", "y", "z"]
AXES: tuple[Axis, ...] = ("x", "y", "z")

GRAVITY = 9.81  # acceleration of free fall [m/s²]


@dataclass(frozen=True)
class Leg:
    """A pair of legs: joints without their side, phases of the left one, lengths [shares of h].

    strike, apart  phase at which the foot lands; how much later the right one does
    pitch    (phase after landing, degrees) of the foot to the ground, toes up above 0
    ahead, spread  where the foot stands in mid-stance, ahead of the hip and aside of the middle;
        without spread, where it rests, and ahead of that
    bend     +1: a positive angle about y flexes the knee; −1 for elbows that point back
    toes     joints that stay flat on the ground while the foot rises; ``flat_toes``: at any
        pitch
    sticks_out  the hip turns about z towards the foot, not about x (insects)
    """

    __pydantic_config__ = CLOSED

    hip: str
    knee: str
    ankle: str
    pitch: tuple[tuple[float, float], ...] = ((0.0, 0.0), (0.5, 0.0))
    toes: tuple[str, ...] = ()
    strike: float = 0.0
    apart: float = 0.5
    ahead: float = 0.0
    spread: float | None = None
    turnout: float = 0.0
    bend: int = 1
    clearance: float = 0.03
    sticks_out: bool = False
    flat_toes: bool = False
    curl: float = 0.0


@dataclass(frozen=True)
class Wave:
    """One joint's swing about one axis: mean + amplitude·cos 2π(cycles·phase − peak) [degrees].

    Added to the angle at rest where ``mean`` is None. Of joints on both sides this is the left
    one; the right one is its mirror image, ``apart`` of a cycle later. Joint "" bobs and sways the
    whole [shares of h].
    """

    __pydantic_config__ = CLOSED

    joint: str
    axis: Axis
    amplitude: float
    peak: float = 0.0
    cycles: int = 1
    mean: float | None = None
    apart: float = 0.5


@dataclass(frozen=True)
class Spin:
    """A joint that goes round: whole rounds about an axis in one cycle."""

    __pydantic_config__ = CLOSED

    joint: str
    axis: Axis
    rounds: int


@dataclass(frozen=True)
class Gait:
    """How one kind of object moves.

    duty    share of the cycle that a foot stands; froude: speed²/(g·h)
    stride  ground covered in a cycle [shares of h], and period [s]: instead of what ``froude``
        gives
    steepest  slope of the ground that its feet follow; tilts: as in Motion
    """

    __pydantic_config__ = CLOSED

    legs: tuple[Leg, ...] = ()
    waves: tuple[Wave, ...] = ()
    spins: tuple[Spin, ...] = ()
    duty: Annotated[float, Field(gt=0, le=1)] = 0.62
    froude: Annotated[float, Field(gt=0)] = 0.22
    stride: Annotated[float, Field(ge=0)] | None = None
    period: Annotated[float, Field(gt=0)] | None = None
    steepest: Annotated[float, Field(ge=0)] = 0.3
    tilts: bool = False

    def stride_m(self, height: float) -> float:
        """Return the ground covered in one cycle, by what stands ``height`` tall at the hip [m]."""
        relative = 2.3 * self.froude**0.3 if self.stride is None else self.stride
        return relative * height

    def period_s(self, height: float) -> float:
        """Return the duration of one cycle [s]."""
        if self.period is not None:
            return self.period
        return self.stride_m(height) / math.sqrt(self.froude * GRAVITY * height)


Points2 = Float64[np.ndarray, "3 2"]
Spheres = Float64[np.ndarray, "k 4"]

_NEAR = 1e-5


class Contacts(NamedTuple):
    """Heel and ball in the frame of the ankle: x, z of the centre and the radius, (3,) each [m]."""

    heel: np.ndarray
    ball: np.ndarray


def heel_and_ball(prototype: RiggedPrototype, ankle: int) -> Contacts:
    """Find the hindmost and foremost of the lowest spheres of the foot by itself, toes apart."""
    low = _lowest(prototype, ankle)
    heel, ball = low[np.argmin(low[:, 0])], low[np.argmax(low[:, 0])]
    return Contacts(heel[[0, 2, 3]], ball[[0, 2, 3]])


def sole_points(prototype: RiggedPrototype, ankle: int) -> Points2:
    """Find where a flat foot touches the ground, x and y from the ankle, (3, 2) [m].

    It does behind its heel, and on either side of its ball. Whose heel is its ball stands on its
    toes, laid flat.
    """
    low = _lowest(prototype, ankle)
    if np.ptp(low[:, 0]) < _NEAR:
        rig = prototype.rig
        toes = np.flatnonzero(rig.parent == ankle).tolist()
        flat = [_spheres(prototype, row) + np.append(rig.offset[row], 0.0) for row in toes]
        low = np.concatenate((low, *flat))
    heel, ball = low[np.argmin(low[:, 0])], low[:, 0].max()
    ahead = low[low[:, 0] >= (heel[0] + ball) / 2]
    right, left = (ahead[:, 1] - ahead[:, 3]).min(), (ahead[:, 1] + ahead[:, 3]).max()
    return np.array(((heel[0] - heel[3], heel[1]), (ball, right), (ball, left)))


def _lowest(prototype: RiggedPrototype, ankle: int) -> Spheres:
    spheres = _spheres(prototype, ankle)
    if not len(spheres):
        raise InputError("gait.leg", prototype.rig.name[ankle], "an ankle that carries a foot")
    bottom = spheres[:, 2] - spheres[:, 3]
    return spheres[bottom <= bottom.min() + 0.12 * abs(bottom.min())]


def _spheres(prototype: RiggedPrototype, joint: int) -> Spheres:
    """End spheres (k, 4) of all full-detail sticks on a joint: centre in its frame, radius [m]."""
    tables = prototype.full_detail_sticks()
    return np.concatenate([np.column_stack(t.spheres)[t.joints == joint] for t in tables])


def _foot_path(
    leg: Leg, contacts: Contacts, own: Reals, stride: float, duty: float, clearance: float
) -> tuple[Reals, Reals, Reals, Reals, Reals]:
    """A foot at phases ``own`` after landing, 0 to 1, (K,) each; lengths in m, angles in degrees.

    Gives where its print is, relative to mid-stance: it recedes as the body goes on, until the foot
    swings to the next; the ankle ahead of where it is over a flat print, along the foot; its
    height; its angle about y, toes down above 0; and that of the toes.
    """
    from scipy.interpolate import PchipInterpolator  # slow to import, and prototypes are kept

    phase, angle = (np.array(column) for column in zip(*leg.pitch, strict=True))
    around = np.concatenate([phase - 1, phase, phase + 1])
    toes_up = PchipInterpolator(around, np.tile(angle, 3))  # degrees, periodic

    def displacement(contact: np.ndarray, pitch: Reals) -> tuple[Reals, Reals]:
        """How far the ankle is ahead and above with a contact's centre kept, by the pitch."""
        c, s = np.cos(np.radians(pitch)), np.sin(np.radians(pitch))
        ahead = contact[0] - (contact[0] * c + contact[1] * s)
        return ahead, contact[2] - (contact[1] * c - contact[0] * s)

    def rolled(pitch: Reals) -> Reals:
        """How far ahead the ankle is over the contact below: the heel while toes are up."""
        heel, ball = (displacement(contact, pitch)[0] for contact in contacts)
        return np.where(pitch < 0, heel, ball)

    pitch = -toes_up(own)  # about y, toes down above 0
    u = np.clip((own - duty) / (1 - duty), 0, 1)  # share of the swing
    smooth = u * u * (3 - 2 * u)
    # While it swings, a cubic from roll and rate as it leaves the ground to those as it lands.
    phases = np.array((duty - _NEAR, duty, 0.0, _NEAR))
    before, leaves, lands, after = rolled(-toes_up(phases))
    rate = (1 - duty) / _NEAR
    start, end = float((leaves - before) * rate), float((after - lands) * rate)
    v = 1 - u
    swung = float(leaves) * (1 + 2 * u) * v * v + float(lands) * (1 + 2 * v) * u * u
    swung = swung + start * u * v * v - end * u * u * v
    hump = 45.5625 * u**2 * (1 - u) ** 4  # 1 at a third of the way, slow to come down
    # Toes turn up by as much as the foot is down, until they have left the ground.
    flat = pitch if leg.flat_toes else np.maximum(pitch, 0.0) * (1 - smooth)
    heel, ball = (displacement(contact, pitch)[1] for contact in contacts)
    roll = np.where(own < duty, rolled(pitch), swung)
    z = np.maximum(heel, ball) + clearance * hump
    return stride * (duty / 2 - own + smooth), roll, z, pitch, leg.curl * hump - flat


KEYS = 32

REACH = 0.996  # how far a leg may be stretched, as a share of its length: knees are never locked


def with_gait(prototype: RiggedPrototype, gait: Gait) -> RiggedPrototype:
    """Give an object the motion of a gait. Raises InputError if a leg is too short for it."""
    return replace(prototype, motion=make_motion(prototype, gait))


def make_motion(prototype: RiggedPrototype, gait: Gait, keys: int = KEYS) -> Motion:
    """Make the key poses of one cycle; the first leg's left foot lands at its ``strike`` phase.

    Raises InputError if a leg is too short.
    """
    rig, phase = prototype.rig, key_phases(keys)
    rest = rig.frames()[0][:, 2]
    height = float(rest[rig.row(f"left {gait.legs[0].hip}")] if gait.legs else rest.max())
    stride = gait.stride_m(height)
    rotations, shift = _body_motion(rig, gait, phase, height)
    paths = [
        _leg_path(prototype, gait, leg, side, phase, stride, height)
        for leg in gait.legs
        for side in ("left ", "right ")
    ]
    rises = [_rise_to_reach(rig, p, rotations, shift) for p in paths]
    shift[:, 2] += min(0.0, min(rises, default=0.0))
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
    lengths = stride, gait.duty, leg.clearance * height
    print_x, roll, z, pitch, curl = _foot_path(leg, contacts, own % 1.0, *lengths)
    turnout = sign * math.radians(leg.turnout)
    rest = rig.frames()[0]
    hip, ankle = rest[rows[0]], rest[rows[2]]
    at = (ankle[0], ankle[1]) if leg.spread is None else (hip[0], sign * leg.spread * height)
    home = np.array((at[0] + leg.ahead * height, at[1], 0.0))
    ahead = np.stack((print_x, np.zeros(len(own)), z), axis=1)
    along = roll[:, None] * np.array((math.cos(turnout), math.sin(turnout), 0.0))
    degrees = np.stack((0 * own, pitch, np.full(len(own), math.degrees(turnout))), axis=1)
    return _LegPath(
        leg,
        rows,
        tuple(rig.row(side + toe) for toe in leg.toes),
        turnout,
        home + ahead + along,
        from_euler(degrees),
        curl,
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
    hip, knee, ankle = p.rows
    origin, frame = rig.frames(rotations, shift)
    above = frame[:, rig.parent[hip]]
    if rig.parent[hip] < 0:
        above = from_euler(np.zeros((len(rotations), 3)))
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
