"""How does a gait move a foot over flat ground: print, roll, height and pitch at each phase?

A foot touches the ground with two round contacts, heel and ball (one and the same for hooves and
claws). While it stands, the centre of the one it rolls over stays where it is; while it swings,
the lower of both clears the ground. Angles of the foot to the ground follow from a table of phases,
joined by monotone cubics (Fritsch & Carlson, SIAM J. Numer. Anal. 17:238, 1980) so that flat
stays flat.
"""

from typing import NamedTuple

import numpy as np
from jaxtyping import Float64
from scipy.interpolate import PchipInterpolator

from lod.arrays import Reals
from lod.errors import InputError
from scenes.gait.parameters import Leg
from scenes.rig.rigged_prototype import RiggedPrototype

Points2 = Float64[np.ndarray, "3 2"]
Spheres = Float64[np.ndarray, "k 4"]

_NEAR = 1e-5


class Contacts(NamedTuple):
    """Heel and ball in the frame of the ankle: x, z of the centre, and the radius, (3,) each
    [m].
    """

    heel: np.ndarray
    ball: np.ndarray


class FootPath(NamedTuple):
    """A foot through the cycle, (K,) each.

    print_x  where its print is, relative to mid-stance: it recedes as the body goes on, until
        the foot
             swings to the next [m]
    roll, z  the ankle ahead of where it is over a flat print, along the foot; its height [m]
    pitch    angle about y, toes down above 0 [degrees]; curl: angle of the toes about y
        [degrees]
    """

    print_x: np.ndarray
    roll: np.ndarray
    z: np.ndarray
    pitch: np.ndarray
    curl: np.ndarray


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
        low = np.concatenate((low, *_toes(prototype, ankle)))
    heel, ball = low[np.argmin(low[:, 0])], low[:, 0].max()
    ahead = low[low[:, 0] >= (heel[0] + ball) / 2]
    right, left = (ahead[:, 1] - ahead[:, 3]).min(), (ahead[:, 1] + ahead[:, 3]).max()
    return np.array(((heel[0] - heel[3], heel[1]), (ball, right), (ball, left)))


def _toes(prototype: RiggedPrototype, ankle: int) -> list[Spheres]:
    """The spheres of the toes at the angles of the ankle, in its frame."""
    rig = prototype.rig
    rows = np.flatnonzero(rig.parent == ankle).tolist()
    return [_spheres(prototype, row) + np.append(rig.offset[row], 0.0) for row in rows]


def _lowest(prototype: RiggedPrototype, ankle: int) -> Spheres:
    """The lowest spheres of a foot in the frame of its ankle: centre and radius."""
    spheres = _spheres(prototype, ankle)
    if not len(spheres):
        raise InputError("gait.leg", prototype.rig.name[ankle], "an ankle that carries a foot")
    bottom = spheres[:, 2] - spheres[:, 3]
    return spheres[bottom <= bottom.min() + 0.12 * abs(bottom.min())]


def _spheres(prototype: RiggedPrototype, joint: int) -> Spheres:
    """End spheres (k, 4) of all full-detail sticks on a joint: centre in its frame, radius [m]."""
    return np.concatenate(
        [
            np.column_stack((point, radius))[on == joint]
            for table in prototype.full_detail_sticks()
            for on, point, radius in (
                (table.start_joint, table.start, table.start_radius),
                (table.end_joint, table.end, table.end_radius),
            )
        ]
    )


def foot_path(
    leg: Leg, contacts: Contacts, own: Reals, stride: float, duty: float, clearance: float
) -> FootPath:
    """Compute the path of a foot at phases ``own`` after landing, 0 to 1; lengths in m."""
    pitch = -_pitch(leg, own)  # about y, toes down above 0
    stands = own < duty
    swing = np.clip((own - duty) / (1 - duty), 0, 1)
    roll = _roll(contacts, pitch)
    start, end = _ends(leg, contacts, duty)
    hump = 45.5625 * swing**2 * (1 - swing) ** 4  # 1 at a third of the way, slow to come down
    return FootPath(
        print_x=stride * (duty / 2 - own + swing * swing * (3 - 2 * swing)),
        roll=np.where(stands, roll, _hermite(swing, start, end)),
        z=_height(contacts, pitch) + clearance * hump,
        pitch=pitch,
        curl=_curl(leg, pitch, swing, hump),
    )


def _pitch(leg: Leg, own: Reals) -> Reals:
    """Degrees of the foot to the ground, toes up above 0, periodic."""
    phase, angle = (np.array(column) for column in zip(*leg.pitch, strict=True))
    around = np.concatenate([phase - 1, phase, phase + 1])
    return PchipInterpolator(around, np.tile(angle, 3))(own)


def _turned(contact: np.ndarray, pitch: Reals) -> tuple[Reals, Reals]:
    """x and z of a contact's centre with the foot turned about y by ``pitch`` degrees."""
    c, s = np.cos(np.radians(pitch)), np.sin(np.radians(pitch))
    return contact[0] * c + contact[1] * s, contact[1] * c - contact[0] * s


def _roll(contacts: Contacts, pitch: Reals) -> Reals:
    """How far ahead the ankle is with the contact below it kept in place: the heel while toes
    are up.
    """
    heel, ball = (contact[0] - _turned(contact, pitch)[0] for contact in contacts)
    return np.where(pitch < 0, heel, ball)


def _height(contacts: Contacts, pitch: Reals) -> Reals:
    """Height of the ankle with the lower contact on the ground [m]."""
    heel, ball = (contact[2] - _turned(contact, pitch)[1] for contact in contacts)
    return np.maximum(heel, ball)


def _ends(leg: Leg, contacts: Contacts, duty: float):  # type: ignore[no-untyped-def]
    """Roll [m] and its rate per swing, as the foot leaves the ground and as it lands."""
    phases = np.array((duty - _NEAR, duty, 0.0, _NEAR))
    before, leaves, lands, after = _roll(contacts, -_pitch(leg, phases))
    rate = (1 - duty) / _NEAR
    return (float(leaves), float((leaves - before) * rate)), (
        float(lands),
        float((after - lands) * rate),
    )


def _hermite(u: Reals, start: tuple[float, float], end: tuple[float, float]) -> Reals:
    """Cubic from value and rate at u = 0 to value and rate at u = 1."""
    v = 1 - u
    values = start[0] * (1 + 2 * u) * v * v + end[0] * (1 + 2 * v) * u * u
    return values + start[1] * u * v * v - end[1] * u * u * v


def _curl(leg: Leg, pitch: Reals, swing: Reals, hump: Reals) -> Reals:
    """Angle of the toes about y: as much up as the foot is down, until they have left the
    ground.
    """
    if leg.flat_toes:
        return leg.curl * hump - pitch
    return leg.curl * hump - np.maximum(pitch, 0.0) * (1 - swing * swing * (3 - 2 * swing))
