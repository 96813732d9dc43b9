"""The weighted distance W(d) ≥ d: how much farther air, eye and display make parts seem (§2.1).

**The definition.** A part whose limit distance in clear air is D_c has, at the metric's limit, a
size s = m·D_c. At distance d it is an angle s/d at the camera, on the display a half-period of
frequency f = 1/(2·angle), and the air has left it a contrast C₀·exp(−βd) (Koschmieder, 1924).
Pixel, seeing and motion leave of that the share M(f) (``gaussian_transfer``); the eye's own blur is
inside its sensitivity S(f), and would count twice in M. It is seen while C₀·exp(−βd)·M(f)·S(f) > 1.
Let E be the decreasing envelope of M·S, and f_s(d) the highest frequency f that still has
C₀·exp(−βd)·E(f) ≥ 1. Then the part is displayed while its angle exceeds m (the metric) *and* that
of f_s (what the viewer resolves):

    s/d > m·max(1, f_m/f_s(d)),    f_m the frequency of the angle m,    so    D_c > W(d),

    W(d) = d·max(1, f_m/f_s(d)),    and D = W⁻¹(D_c), because W increases.

It does: β ≥ 0 and E never rises, so f_s never rises and W/d never falls. Past the distance where
C₀·exp(−βd) = 1/max E no size is seen and W is infinite; parts too large to fail before that all
share this limit. With an ideal eye nothing fades from sight and W(d) = d.

**The table.** W is only ever asked on a table, which is therefore its definition here. Knot j
stands where the frequency f_j of the sensitivity table fades, at d_j = ln(C₀·E(f_j))/β, with

    W_j = d_j·max(1, f_m/f_{j−1}),    f_{j−1} the next higher frequency of the table,

and straight lines between. So W/d at a knot is one step of frequency late, and between knots lies
between theirs: the table is nowhere above the curve, so that nothing visible is dropped, and below
it by at most two steps of frequency, under 1 %.
"""

import math
from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np

from lod.arrays import Reals, freeze
from lod.errors import InputError
from lod.vision.blur_cascade import BlurWidths, gaussian_transfer
from lod.vision.eye import Display, Eye, envelope, sensitivity

MIN_EXTINCTION = 1e-15
"""β below which air counts as clear [1/m]."""


@dataclass(frozen=True, eq=False)
class WeightedDistance:
    """W as a table: straight lines between knots, one of slope ``beyond`` after the last.

    distance (k,) d of the knots [m], from 0, increasing
    weighted (k,) W there [m], from 0, increasing, W ≥ d
    beyond   slope after the last knot, at least 1; infinite where nothing is seen past it
    """

    distance: np.ndarray
    weighted: np.ndarray
    beyond: float

    def __post_init__(self) -> None:
        freeze(self, distance=np.float64, weighted=np.float64)
        d, w = self.distance, self.weighted
        if d.shape != w.shape or d.ndim != 1 or d[:1].tolist() + w[:1].tolist() != [0.0, 0.0]:
            raise InputError("W", (d.shape, w.shape), "two columns of knots that start at (0, 0)")
        if not ((np.diff(d) > 0).all() and (np.diff(w) > 0).all() and (w >= d).all()):
            raise InputError("W", "knots", "d and W increase from knot to knot, and W >= d")
        if not (np.isfinite(w).all() and self.beyond >= 1):
            raise InputError("W.beyond", self.beyond, "finite knots, and a slope of 1 or more")

    @cached_property
    def slope(self) -> np.ndarray:
        """Compute dW/dd from each knot on, (k,)."""
        return np.append(np.diff(self.weighted) / np.diff(self.distance), self.beyond)

    @property
    def vanishing_distance(self) -> float:
        """Return the distance past which nothing of this contrast is seen [m], or infinity."""
        return float(self.distance[-1]) if math.isinf(self.beyond) else math.inf

    def weight(self, distance: Reals) -> Reals:
        """Compute W of each distance, (n,) [m]; it is infinite past ``vanishing_distance``."""
        _refuse_negative("d", distance)
        row = np.searchsorted(self.distance, distance, side="right") - 1
        further = distance - self.distance[row]
        rise = np.where(further > 0, self.slope[row], 0.0) * np.where(further > 0, further, 1.0)
        weighted = self.weighted[row] + rise
        return np.maximum(distance, np.minimum(weighted, _next(self.weighted, row)))

    def inverse(self, weighted: Reals) -> Reals:
        """Compute the d of each W, (n,) [m], at most ``vanishing_distance``.

        The d of a limit distance in clear air is the limit distance through air and eye.
        """
        _refuse_negative("W", weighted)
        row = np.searchsorted(self.weighted, weighted, side="right") - 1
        slope = self.slope[row]
        further = np.where(np.isinf(slope), 0.0, weighted - self.weighted[row]) / slope
        distance = self.distance[row] + further
        return np.minimum(weighted, np.minimum(distance, _next(self.distance, row)))


UNWEIGHTED = WeightedDistance(np.zeros(1), np.zeros(1), 1.0)
"""W(d) = d, to the last bit, for an ideal eye or a contrast that no air can take away."""

_NEVER_SEEN = WeightedDistance(np.zeros(1), np.zeros(1), math.inf)


@lru_cache(maxsize=256)
def weighted_distance(
    contrast: float,
    extinction: float,
    m: float,
    widths: BlurWidths,
    display: Display,
    eye: Eye | None,
) -> WeightedDistance:
    """Tabulate W for parts of inherent contrast C₀ in air of extinction β, at detail angle m.

    ``extinction`` is β [1/m], ``m`` an angle at the camera [rad], ``widths`` the blurs there. The
    display shows a pixel under an angle of its own. An ``eye`` of None is ideal. Raises InputError
    for a contrast that is not above 0, β below 0 or m not above 0.
    """
    _check(contrast, extinction, m)
    if eye is None or math.isinf(contrast):
        return UNWEIGHTED
    table = sensitivity(display, eye)
    f_m = display_frequency(m, widths, display)
    # From the finest feature to the coarsest: the optical depth at which each fades.
    frequency = table.frequency[::-1]
    blur_deg = math.degrees(widths.before_eye * display.pixel_angle / widths.pixel)
    seen = envelope(table.value * gaussian_transfer(blur_deg, table.frequency))[::-1]
    with np.errstate(divide="ignore"):
        fades = np.log(contrast * seen)
    growth = np.maximum(1.0, f_m / np.concatenate(([math.inf], frequency[:-1])))
    visible = fades > 0
    if not visible.any():
        return _NEVER_SEEN
    if extinction < MIN_EXTINCTION:
        return WeightedDistance(np.zeros(1), np.zeros(1), float(growth[visible][0]))
    return _table(fades[visible] / extinction, growth[visible])


def display_frequency(m: float, widths: BlurWidths, display: Display) -> float:
    """Compute the frequency on the display of a feature of angle m at the camera [cycles/degree].

    The feature covers m/θ_pixel pixels there, and is half a period: f = 1/(2·angle).
    """
    angle_deg = math.degrees(m / widths.pixel * display.pixel_angle)
    return 1 / (2 * angle_deg)


def _table(distance: np.ndarray, growth: np.ndarray) -> WeightedDistance:
    new = np.diff(distance, prepend=0.0) > 0
    knots = np.concatenate(([0.0], distance[new]))
    return WeightedDistance(knots, knots * np.concatenate(([1.0], growth[new])), math.inf)


def _next(knots: np.ndarray, row: np.ndarray) -> np.ndarray:
    return np.append(knots, math.inf)[row + 1]


def _check(contrast: float, extinction: float, m: float) -> None:
    if not contrast > 0:
        raise InputError("contrast", contrast, "above 0", "use contrast_class")
    if not (math.isfinite(extinction) and extinction >= 0):
        raise InputError("extinction", extinction, "finite and at least 0 /m")
    if not (math.isfinite(m) and m > 0):
        raise InputError("m", m, "the detail angle is finite and above 0 rad", "check --detail")


def _refuse_negative(where: str, values: Reals) -> None:
    if not (values >= 0).all():
        raise InputError(where, "a negative number or NaN", "distances are at least 0 m")
