"""What motion hides: the blur of an open shutter, and the detail that it leaves (§5.2, §2.1).

The paper leaves the metric of motion to the future; its own argument joins it to the spatial one
(``docs/method.md`` derives it): of what passes by an angle L while the shutter is open m grows by
the factor g of

    L²/θ² = 4g⁸/(g² + 1) − (g² + 1),          which is g = (L/2θ)^⅓ where L is long,

θ that of all other blurs. A part as large as its blurred area √(θ·√(θ² + L²)) is too much to leave
out: g = (L/θ)^½ makes an error that grows with L, because a part of that size has lost contrast and
not its area (the experiment ``motion`` has its planted cut about there). Even parts are meant: a
pole along the pan keeps more of its contrast, one across it less. The growth g of m is measured on
a scale with STEPS_PER_OCTAVE steps to each octave.

A camera can stop between two frames, and all that its motion hid would come at once. So what is
hidden eases: from one frame to the next the scale goes by EASE_PER_FRAME at most,

    step(f) = min over k of own(f + k) + EASE_PER_FRAME·|k|,

the largest such that is never more than the frame's own. The path of a camera is known ahead:
detail comes back before the motion ends, and goes after it has begun. At rest it is 0, and where
all frames are alike it is their own. Whatever moves is assumed to move on through the frames around
this one as it does in this one.

L is one for a whole object: the least that anything of it moves, so that all its parts have one m,
and by the clamp of ``limit_distances`` a connected cut. It is found as a lower bound from the eye
and the object at both ends of the shutter interval. With o → R·o + c the motion of a point o [m]
relative to the camera, |c| what the object shifts against the eye, φ = |R − I|, every point of it
within B of its origin and farther than n from the eye all the while, and s what it moves by itself,

    L ≥ |change of the origin's direction| − B·(φ + 2|c|/n)/n − s/n,    and
    L ≥ φ·sin(α − β) − |c|/n − s/n,

α the least angle between the origin's direction and the axis of R, sin β = B/d: the first because
the change is a Lipschitz function of the point, the second because a turn alone moves a direction
by φ times the sine of its angle to the axis, and the rest moves it by at most (|c| + s)/n.

**The window of visibility.** An eye that does not follow what moves has a shutter of its own. Of
everything on a display it sees what lies below a limit in time, ω_l, and one in space, u_l, and
little beyond either (Watson & Ahumada, "A look at motion in the frequency domain",
NASA TM 84352, 1983; Watson, Ahumada & Farrell, "The window of visibility", NASA TP 2211, 1983). A
grating of frequency u that passes at r has r·u periods a second: it is out of the window from
u = ω_l/r on. A feature of size a is half a period of u = 1/(2a), so what is smaller than
r/(2·ω_l) is gone along its path, as if a shutter had been open for 1/(2·ω_l).
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from lod.arrays import Points, Reals
from lod.camera import GRID_M, Camera, Corner
from lod.kernels import njit

STEPS_PER_OCTAVE = 8
"""Steps of the motion scale to each doubling of m."""

EASE_PER_FRAME = 0.5
"""Greatest difference between two frames in steps: 4 % of D, a fifth of a fade band."""

MAX_NEIGHBOURS = 48
"""Most frames before and after that count: farther ones matter only where L > 1100 θ."""


@dataclass(frozen=True, eq=False)
class ShutterInterval:
    """The interval in which the shutter is open: the camera at both ends, and their times [s].

    opening, closing  the camera as the shutter opens, and as it closes
    open_s, close_s   the times of both [s]
    neighbour         function from a number of frames to the interval that many frames later
                      (earlier where it is negative); None = motion hiding is not eased
    """

    opening: Camera
    closing: Camera
    open_s: float
    close_s: float
    neighbour: Callable[[int], "ShutterInterval"] | None = None

    @property
    def duration_s(self) -> float:
        """Compute how long the shutter is open [s]."""
        return self.close_s - self.open_s


def motion_coarsening(motion_step: float) -> float:
    """Compute the factor by which m grows at a place on the motion scale: 1 at place 0."""
    return float(2.0 ** (motion_step / STEPS_PER_OCTAVE))


def subframe_offsets(subframes: int) -> Reals:
    """Compute the middles of equal shares of a shutter interval, from its own middle, (n,)."""
    return (np.arange(subframes) + 0.5) / subframes - 0.5


def motion_steps(
    shutter: ShutterInterval,
    corner: Corner,
    theta: float,
    start: Points,
    end: Points,
    bound: Reals,
    own: Reals,
) -> Reals:
    """Compute the place of each object on the motion scale, (n,); 0 = motion hides nothing.

    theta       θ of all blurs but motion [rad]
    start, end  (n, 3) its origin as the shutter opens and closes, from ``corner`` [m]
    bound, own  (n,) radius that holds it, and farthest anything of it moves but for that shift [m]
    """
    motion_step, objects = np.empty(len(bound)), (theta, start, end, bound, own)
    _motion_steps(_camera_path(shutter, corner, 0), *objects, motion_step)
    most = float(motion_step.max(initial=0.0))
    if most and shutter.neighbour is not None:
        near = min(math.ceil(most / EASE_PER_FRAME), MAX_NEIGHBOURS)
        _motion_steps(_camera_path(shutter, corner, near), *objects, motion_step)
    return motion_step


class _CameraPath(NamedTuple):
    """A camera in a frame and those about it, (k, …).

    eyes (k, 2, 3) [m] and axes (k, 2, 3, 3) as the shutter opens and as it closes
    ease   least that is hidden by what is hidden then, beyond that: steps on the scale
    later  how much later than the frame itself, over the time that its shutter is open
    """

    eyes: np.ndarray
    axes: np.ndarray
    ease: np.ndarray
    later: np.ndarray


@lru_cache(maxsize=64)
def _camera_path(shutter: ShutterInterval, corner: Corner, near: int) -> _CameraPath:
    """Cameras of the frames within ±near, nearest first. Cached, as every species asks for them."""
    every = [shutter]
    if shutter.neighbour is not None:
        every += [shutter.neighbour(k) for far in range(1, near + 1) for k in (-far, far)]
    cameras = [camera for each in every for camera in (each.opening, each.closing)]
    eyes = np.stack([eye_relative_to(corner, camera) for camera in cameras])
    axes = np.stack([np.stack((c.right, c.forward, c.up)) for c in cameras])
    away = (np.arange(len(every)) + 1) // 2
    later = np.array([each.open_s - shutter.open_s for each in every]) / shutter.duration_s
    eyes, axes = eyes.reshape(-1, 2, 3), axes.reshape(-1, 2, 3, 3)
    return _CameraPath(eyes, axes, EASE_PER_FRAME * away, later)


def eye_relative_to(corner: Corner, camera: Camera) -> np.ndarray:
    """Return the eye of a camera in the coordinates of another frame's corner, (3,) [m]."""
    away = camera.corner.x - corner.x, camera.corner.y - corner.y, 0
    return camera.eye + GRID_M * np.array(away, np.float64)


@njit(cache=True)
def _motion_steps(path, theta, start, end, bound, own, motion_step):  # type: ignore[no-untyped-def]
    eyes, axes, ease, later = path
    turn = axes[:, 1] - axes[:, 0]
    phi = np.array([math.sqrt((each * each).sum() / 2) for each in turn])
    opened, closed = np.empty(3), np.empty(3)
    for i in range(len(bound)):
        motion_step[i] = math.inf
        for k in range(len(ease)):
            if ease[k] >= motion_step[i]:
                break
            shift = 0.0
            for c in range(3):
                gone = later[k] * (end[i, c] - start[i, c])
                opened[c] = start[i, c] + gone - eyes[k, 0, c]
                closed[c] = end[i, c] + gone - eyes[k, 1, c]
                shift += (closed[c] - opened[c]) ** 2
            shift = math.sqrt(shift)
            length = _least_motion(
                axes[k], turn[k], phi[k], opened, closed, shift, bound[i], own[i]
            )
            if k == 0 or length / theta < _ratio_at_step(motion_step[i] - ease[k]):
                motion_step[i] = _step_at_ratio(length / theta) + ease[k]


@njit(cache=True)
def _ratio_at_step(steps):  # type: ignore[no-untyped-def]
    x = 2.0 ** (2.0 * steps / STEPS_PER_OCTAVE)
    return math.sqrt(max(4 * x**4 / (x + 1) - (x + 1), 0.0))


@njit(cache=True)
def _step_at_ratio(ratio):  # type: ignore[no-untyped-def]
    """Where L/θ is on the scale: x = g² of 4x⁴ = (x + 1)(x + 1 + (L/θ)²), by Newton from above."""
    squared = ratio * ratio
    x = 1.0 + np.cbrt(squared)
    while True:
        value = 4 * x**4 - (x + 1) * (x + 1 + squared)
        after = x - value / (16 * x**3 - 2 * (x + 1) - squared)
        if not after < x:
            return STEPS_PER_OCTAVE / 2 * math.log2(x)
        x = after


@njit(cache=True)
def _least_motion(axes, turn, phi, opened, closed, shift, bound, own):  # type: ignore[no-untyped-def]
    """The least L [rad] of anything within an object, from what its origin does."""
    far, farther = 0.0, 0.0
    for c in range(3):
        far += opened[c] ** 2
        farther += closed[c] ** 2
    far, farther = math.sqrt(far), math.sqrt(farther)
    near = min(far, farther) - bound - own
    if near <= 0:
        return 0.0
    moved, turned = 0.0, 0.0
    for row in range(3):
        before, after, by_turn = 0.0, 0.0, 0.0
        for c in range(3):
            before += axes[0, row, c] * opened[c] / far
            after += axes[1, row, c] * closed[c] / farther
            by_turn += turn[row, c] * opened[c] / far
        moved += (after - before) ** 2
        turned += by_turn**2
    least = math.sqrt(moved) - bound * (phi + 2 * shift / near) / near - own / near
    if phi > 0:
        sine, wide = min(math.sqrt(turned) / phi, 1.0), bound / far
        if sine > wide:
            inner = sine * math.sqrt(1 - wide * wide) - math.sqrt(1 - sine * sine) * wide
            least = max(least, phi * inner - (shift + own) / near)
    return max(least, 0.0)


LIMIT_HZ = 30.0
"""ω_l, the round figure of both papers."""


def integration_time_s(shutter_s: float, limit_hz: float = LIMIT_HZ) -> float:
    """Compute how long an eye behind a shutter integrates [s]: variances of both add (§2.1)."""
    return math.hypot(shutter_s, 1 / (2 * limit_hz))


def critical_hz(speed_deg_s: Reals, finest_cpd: float, limit_hz: float = LIMIT_HZ) -> Reals:
    """Compute the update rate ω_c = ω_l + r·u_l (1983) above which motion looks smooth, (n,) [Hz].

    The copies that sampling makes of its spectrum then lie outside the window; u_l in cycles per
    degree.
    """
    return limit_hz + speed_deg_s * finest_cpd
