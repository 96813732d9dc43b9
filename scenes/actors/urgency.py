"""By how much an actor that coasts may be off on the image: the temporal metric of actors (§2).

A body keeps its speed and its rate of turning until it is told to go otherwise, and both change by
no more than ``ACCELERATION`` and ``SPIN_ACCELERATION`` a second since it was told (``Body.go``).
So t seconds after that, against a body that was told anew all the time, with v its speed and r its
reach,

    its place is off by at most    a·t²/2 + v·α·t³/6,
    its parts, for its turning, by r·min(α·t²/2, 2),
    and for its walk by            w·a·t²/2, or for one that may slow down to a standstill by
                                   l·min(1, a·t/v_slow + 1/8),

where w is the speed of its fastest part against its own, and l how far a part is at most from where
it rests. Seen from a distance d, that is (the sum)/((d − r)·θ) pixels. What messages hold is not in
it: whose limbs were moved by the last update is updated in every frame.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from lod.arrays import ArrayData, FloatArray, Reals
from scenes.actors.body import ACCELERATION, SPIN_ACCELERATION
from scenes.actors.motions import EIGHTHS, SLOWEST
from scenes.actors.performance import Eye, X, Y
from scenes.actors.stage import Standings
from scenes.rig.rigged_prototype import RiggedPrototype
from scenes.rig.speed_bound import speed_bound


@dataclass(frozen=True, eq=False)
class Restlessness(ArrayData):
    """How much of n bodies may move: reach r [m], w, l [m] and v_slow [m/s], (n,) each."""

    reach: FloatArray
    walk: FloatArray
    travel: FloatArray
    slow: FloatArray

    @staticmethod
    def of(prototypes: Sequence[RiggedPrototype]) -> "Restlessness":
        """Collect them of the prototypes of bodies, one each."""
        rows = np.array([_of_one(each) for each in prototypes]).reshape(-1, 4)
        return Restlessness(*rows.T)


@dataclass(frozen=True)
class Lens:
    """What a camera resolves: θ of a pixel [rad], and half its widest angle of view [rad].

    offscreen  share of the detail that is kept out of view
    """

    theta: float
    half_angle: float
    offscreen: float


def offset_bound_m(bodies: Restlessness, speed: Reals, since_s: Reals) -> Reals:
    """Bound how far a part is from where coasting has it, (n,) [m]."""
    t, a, alpha = since_s, ACCELERATION, SPIN_ACCELERATION
    straight = a * t**2 / 2
    place = straight + speed * alpha * t**3 / 6
    turned = bodies.reach * np.minimum(alpha * t**2 / 2, 2.0)
    slow = np.maximum(bodies.slow, 1e-9)
    blend = bodies.travel * np.minimum(1.0, a * t / slow + 1.0 / EIGHTHS)
    walked = bodies.walk * straight + np.where(speed - a * t < slow, blend, 0.0)
    return np.where(t > 0, place + turned + np.where(bodies.slow > 0, walked, 0.0), 0.0)


def bound_px(
    bodies: Restlessness, stand: Standings, now_s: float, eye: Eye, lens: Lens
) -> tuple[Reals, Reals]:
    """Bound by how much a part of each body is off on the image [px], and how urgent that is, (n,).

    Urgency is the same bound in view; out of view, where there are shadows alone, less.
    """
    off = offset_bound_m(bodies, stand.speed, now_s - stand.went)
    away = stand.places[:, (X, Y)] - np.array(eye[:2])
    d = np.maximum(np.hypot(*away.T) - bodies.reach, 0.1)
    px = off / d / lens.theta
    a = np.radians(eye.heading)
    ahead = away @ np.array((np.sin(a), np.cos(a)))
    apart = np.arccos(np.clip(ahead / np.maximum(np.hypot(*away.T), 1e-9), -1, 1))
    margin = np.arcsin(np.clip((bodies.reach + off) / (d + bodies.reach), 0, 1))
    seen = apart < lens.half_angle + margin
    return px, np.where(seen, px, px * lens.offscreen)


@lru_cache(maxsize=256)
def _of_one(prototype: RiggedPrototype) -> tuple[float, float, float, float]:
    motion, rig = prototype.motion, prototype.rig
    reach = float(prototype.hierarchy.B[0])
    if motion.stride == 0:
        return reach, 0.0, 0.0, 0.0
    walking, _ = rig.frames(motion.rotations, motion.shift)
    resting, _ = rig.frames()
    # A stick beyond its joint moves by twice as much at most as its ends' joints do here.
    travel = 2 * float(np.linalg.norm(walking - resting, axis=-1).max())
    return reach, speed_bound(prototype) / motion.speed, travel, SLOWEST * motion.speed
