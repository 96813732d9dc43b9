"""The camera: the eye in an endless plane, the angle of one pixel, and a lens."""

import math
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from lod.arrays import freeze, frozen
from lod.errors import InputError


@dataclass(frozen=True)
class ThinLens:
    """An ideal lens with a round opening.

    diameter_m  of the opening: focal length over f-number [m]
    focus_m     distance along the camera's axis at which things are sharp [m]; may be infinite

    A point at distance z along the axis covers a disc of the angle A·|1/z − 1/s|, A the diameter
    and s the focus (Potmesil & Chakravarty, "A lens and aperture camera model for synthetic image
    generation", SIGGRAPH 1981, with the angle taken at the lens and the field of view that of the
    picture in focus).
    """

    diameter_m: float
    focus_m: float

    def __post_init__(self) -> None:
        if not (math.isfinite(self.diameter_m) and self.diameter_m > 0):
            raise InputError("lens diameter", self.diameter_m, "finite and above 0 m")
        if not self.focus_m > 0:
            raise InputError("camera.focus", self.focus_m, "above 0 m", "focus before the camera")


GRID_M = 16.0
"""Side of the grid squares that carry the eye; a frame's geometry is relative to one corner."""

STEP_M = 2.0**-10
"""Sides of lattices are whole multiples of this, so that positions on them are exact integers."""

FULL_TURN = 2 * math.pi

_FARTHEST_CELL = 2**56
"""Bound on cell numbers that keeps every finer lattice (down to 2^-3 m) inside int64."""


@dataclass(frozen=True)
class Corner:
    """A corner of the endless grid: the origin of a frame's coordinates, exact at any distance.

    ``x`` and ``y`` count squares of GRID_M; x points east, y north, z up from the datum.
    """

    x: int
    y: int

    def __post_init__(self) -> None:
        if max(abs(self.x), abs(self.y)) > _FARTHEST_CELL:
            raise InputError("eye", (self.x, self.y), f"within {_FARTHEST_CELL * GRID_M:.1e} m")

    def lattice(self, side_m: float) -> tuple[int, int, float, float]:
        """Locate this corner in a lattice of squares whose side is a whole multiple of STEP_M.

        Returns (ix, iy, rx, ry): the square that the corner lies in, and how far into it [m]. The
        result is exact, because it is computed in integers.
        """
        side, grid = round(side_m / STEP_M), round(GRID_M / STEP_M)
        (ix, rx), (iy, ry) = (divmod(cell * grid, side) for cell in (self.x, self.y))
        return ix, iy, rx * STEP_M, ry * STEP_M


def split_position(
    x: float, y: float, cell_x: int = 0, cell_y: int = 0
) -> tuple[Corner, float, float]:
    """Split the point (x, y) metres from corner (cell_x, cell_y) into its own corner and an offset.

    The offset lies in [0, GRID_M) on both axes; it rounds to GRID_M itself where a coordinate is
    below a corner by less than float64 can tell.
    """
    if not (math.isfinite(x) and math.isfinite(y)):
        raise InputError("eye", (x, y), "a position is finite")
    step_x, step_y = math.floor(x / GRID_M), math.floor(y / GRID_M)
    corner = Corner(cell_x + step_x, cell_y + step_y)
    return corner, max(x - step_x * GRID_M, 0.0), max(y - step_y * GRID_M, 0.0)


@dataclass(frozen=True)
class Camera:
    """A perspective camera with square pixels, or one that sees all round.

    corner   origin of the frame's coordinates, a function of the eye alone
    eye      (3,) position relative to the corner [m]
    forward, up   (3,) orthonormal unit vectors
    fov_x    full horizontal field of view [rad], below π; 2π of a panorama
    width, height [px]
    lens     with an opening, through which only one distance is sharp; None = a pinhole
    panorama whether the picture is equirectangular: the whole turn from left to right, ``forward``
             in its middle, and from ``up`` at the top to its opposite at the bottom
    baseline_m  distance of two eyes, half of it to either side of ``eye``; 0 = one eye
    """

    corner: Corner
    eye: np.ndarray
    forward: np.ndarray
    up: np.ndarray
    fov_x: float
    width: int
    height: int
    lens: ThinLens | None = None
    panorama: bool = False
    baseline_m: float = 0.0

    def __post_init__(self) -> None:
        freeze(self, eye=np.float64, forward=np.float64, up=np.float64)
        if self.panorama:
            if self.lens or self.fov_x != FULL_TURN:
                raise InputError("camera.projection", "panorama", "a whole turn, without a lens")
        elif not (math.isfinite(self.fov_x) and 0 < self.fov_x < math.pi):
            raise InputError("camera.fov", math.degrees(self.fov_x), "above 0° and below 180°")
        if not (math.isfinite(self.baseline_m) and self.baseline_m >= 0):
            raise InputError("camera.stereo", self.baseline_m, "finite and at least 0 m")
        if min(self.width, self.height) < 1:
            raise InputError("size", f"{self.width}x{self.height}", "at least 1x1", "try 640x360")
        if not np.isfinite(np.concatenate((self.eye, self.forward, self.up))).all():
            raise InputError("camera", "a number that is not finite", "every coordinate is finite")

    @property
    def pair(self) -> tuple["Camera", "Camera"]:
        """Return the cameras of the left eye and of the right one, which look the same way."""
        half = self.baseline_m / 2 * self.right
        left, right = (replace(self, eye=self.eye + s * half, baseline_m=0.0) for s in (-1, 1))
        return left, right

    @cached_property
    def right(self) -> np.ndarray:
        """Return the unit vector to the right of the picture, (3,)."""
        return frozen(np.cross(self.forward, self.up), np.float64)

    @property
    def tan_half(self) -> tuple[float, float]:
        """Return the tangents of half the field of view, horizontally and vertically.

        They are infinite in a panorama, which has no edges to be beyond of.
        """
        if self.panorama:
            return math.inf, math.inf
        tan_x = math.tan(self.fov_x / 2)
        return tan_x, tan_x * self.height / self.width

    @property
    def corner_secant(self) -> float:
        """Return 1/cos of the angle from the axis to the picture's corners."""
        return math.hypot(1.0, *self.tan_half)

    @property
    def pixel_angle(self) -> float:
        """θ = 2·tan(fov_x/2)/width [rad]: the angle of one pixel at the centre (§2.4).

        In a panorama it is the lesser of the angles that a pixel is wide and high on the horizon.
        """
        if self.panorama:
            return min(FULL_TURN / self.width, FULL_TURN / 2 / self.height)
        return 2 * self.tan_half[0] / self.width


def camera_from_heading(
    corner: Corner,
    eye: np.ndarray,
    heading_deg: float,
    pitch_deg: float,
    fov_x_deg: float,
    size: tuple[int, int],
    roll_deg: float = 0.0,
) -> Camera:
    """Return a camera by its heading, pitch and roll [degrees].

    The heading is clockwise from north (+y); the pitch is above the horizon, from -90° to 90°. A
    positive roll turns the camera clockwise about its axis, as seen from behind it. Raises
    InputError for other angles.
    """
    if not (math.isfinite(pitch_deg) and abs(pitch_deg) <= 90):
        raise InputError("camera.pitch", pitch_deg, "between -90° and 90°")
    for name, angle in (("heading", heading_deg), ("roll", roll_deg)):
        if not math.isfinite(angle):
            raise InputError(f"camera.{name}", angle, "finite")
    a, b = math.radians(heading_deg), math.radians(pitch_deg)
    forward = np.array((math.sin(a) * math.cos(b), math.cos(a) * math.cos(b), math.sin(b)))
    up = np.array((-math.sin(a) * math.sin(b), -math.cos(a) * math.sin(b), math.cos(b)))
    if roll_deg:
        c = math.radians(roll_deg)
        up = math.cos(c) * up + math.sin(c) * np.cross(forward, up)
    return Camera(corner, np.asarray(eye), forward, up, math.radians(fov_x_deg), *size)
