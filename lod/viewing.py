"""What stands between a scene and whoever looks at its picture: blur, air, lens and eye (§2.1).

A view carries its viewing conditions. They give the weighted distance W(d) ≥ d of each class of
inherent contrast, which says how much farther they make parts seem, and so the limit distances
D = W⁻¹(D in clear air with an ideal eye).

**Blur adds in quadrature.** The variance of a convolution is the sum of the variances (Bracewell,
"The Fourier Transform and Its Applications", ch. 8), so θ_eff² = θ_pixel² + θ_eye² +
θ_atmosphere² + θ_motion² where each θ is a full width √12·σ: that of the box with the same
variance, so a box pixel has its own width. As a transfer function each blur is taken for the
Gaussian of its variance.

**The weighted distance** is derived in ``docs/method.md`` ("Air and eye"): the eye's own blur is
inside its sensitivity S(f), and would count twice in M. With E the decreasing envelope of M·S, f_m
the frequency of the angle m, and f_s(d) the highest frequency with C₀·exp(−βd)·E(f) ≥ 1,

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

**Defocus** is one more blur, which depends on the distance. A thin lens spreads a point at distance
z along its axis over a disc of the angle A·|1/z − 1/s|. A uniform disc of diameter a has the
standard deviation a/4 on each axis (Bracewell, ch. 8), so its full width √12·σ is
DISC_WIDTH·a = (√3/2)·a, and

    θ_eff(d)² = θ² + θ_defocus(d)²,    θ all other blurs together,

is to the metric a weighted distance: P + R > τ·θ_eff(d)·d while D_c > W(d) = d·θ_eff(d)/θ. The lens
is focused on a plane, and the metric measures d along the ray: what is seen at distance d is
between z = d·cos φ and z = d, φ the angle from the axis to the picture's corner. Nothing visible
may be dropped, so that θ_defocus(d) is the least over these:

    (√3/2)·A·max(1/d − 1/s, 1/s − k/d, 0),    k = 1/cos φ.

Near the eye W does not increase: what is nearer than the focus is blurred more the nearer it is.
With q = (√3/2)·A/θ and p = 1/s, W² = d² + q²(1 − p·d)² is least at d* = q²p/(1 + q²p²) < s. A limit
distance needs an increasing W, and the largest one below it is W(d*) for all d < d*: parts for
which D_c > W(d*) are displayed all the way to the eye as if they were at d*, and all others never.
From d* on the limit D = W⁻¹(D_c) is the larger root of a quadratic equation.
"""

import math
from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np

from lod.arrays import ArrayData, FloatArray, Ints, Reals
from lod.camera import ThinLens
from lod.errors import InputError
from lod.eye import CONTRAST_CLASSES, Display, Eye, envelope, optical_sigma, sensitivity


@dataclass(frozen=True)
class BlurWidths:
    """Full widths √12·σ of the blurs between scene and viewer, as angles at the camera [rad].

    pixel       angle of one pixel: a box of that width, σ = θ/√12
    eye         the viewer's optics, carried to the camera by the display (``blur_widths``)
    atmosphere  seeing: the blur by turbulence of the air, in a long exposure
    motion      what passes by while the shutter is open: a box of angular speed × open time
    """

    pixel: float
    eye: float = 0.0
    atmosphere: float = 0.0
    motion: float = 0.0

    @property
    def effective(self) -> float:
        """θ_eff [rad] is the root of the sum of the squares; m = τ·θ_eff."""
        return math.hypot(self.pixel, self.eye, self.atmosphere, self.motion)


def blur_widths(
    pixel_angle: float,
    display: Display,
    eye: Eye | None,
    atmosphere: float = 0.0,
    motion: float = 0.0,
) -> BlurWidths:
    """Give the blurs of a camera whose picture is looked at on a display, at the camera [rad].

    The display shows a camera's pixel under an angle of its own. So the eye's width, an angle at
    the viewer, covers (eye width)/(display pixel) pixels, each of which is ``pixel_angle`` at the
    camera. An ideal eye (None) has no width.
    """
    seen = 0.0 if eye is None else eye_width(display, eye) * pixel_angle / display.pixel_angle
    return BlurWidths(pixel_angle, seen, atmosphere, motion)


def eye_width(display: Display, eye: Eye) -> float:
    """Compute the full width √12·σ_opt of the eye's optics, an angle at the viewer [rad].

    Barten's optical transfer function is exp(−2π²σ²f²), a Gaussian (1999, ch. 3).
    """
    return math.sqrt(12.0) * math.radians(optical_sigma(display, eye))


def gaussian_transfer(width: float, frequency: Reals) -> Reals:
    """Compute the share of a sinusoid's contrast that a blur leaves, (n,).

    It is exp(−2π²σ²f²) with σ = width/√12, the Fourier transform of a Gaussian. ``width`` and
    1/``frequency`` are in the same unit.
    """
    return np.exp(-((math.pi * width * frequency) ** 2) / 6)


MIN_EXTINCTION = 1e-15
"""β below which air counts as clear [1/m]."""


@dataclass(frozen=True, eq=False)
class WeightedDistance(ArrayData):
    """W as a table: straight lines between knots, one of slope ``beyond`` after the last.

    distance (k,) d of the knots [m], from 0, increasing
    weighted (k,) W there [m], from 0, increasing, W ≥ d
    beyond   slope after the last knot, at least 1; infinite where nothing is seen past it
    """

    distance: FloatArray
    weighted: FloatArray
    beyond: float

    def __post_init__(self) -> None:
        super().__post_init__()
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
        row, after = self._interval(distance, self.distance, self.weighted)
        further = distance - self.distance[row]
        rise = np.where(further > 0, self.slope[row], 0.0) * np.where(further > 0, further, 1.0)
        return np.maximum(distance, np.minimum(self.weighted[row] + rise, after))

    def inverse(self, weighted: Reals) -> Reals:
        """Compute the d of each W, (n,) [m], at most ``vanishing_distance``.

        The d of a limit distance in clear air is the limit distance through air and eye.
        """
        row, after = self._interval(weighted, self.weighted, self.distance)
        slope = self.slope[row]
        further = np.where(np.isinf(slope), 0.0, weighted - self.weighted[row]) / slope
        return np.minimum(weighted, np.minimum(self.distance[row] + further, after))

    @staticmethod
    def _interval(
        values: Reals, knots: np.ndarray, others: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Knots that the values follow, and what the other column has at the next one."""
        if not (values >= 0).all():
            raise InputError("W", "a negative number or NaN", "distances are at least 0 m")
        row = np.searchsorted(knots, values, side="right") - 1
        return row, np.append(others, math.inf)[row + 1]


UNWEIGHTED = WeightedDistance(np.zeros(1), np.zeros(1), 1.0)
"""W(d) = d, to the last bit, for an ideal eye or a contrast that no air can take away."""


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
    if not contrast > 0:
        raise InputError("contrast", contrast, "above 0", "use contrast_class")
    if not (math.isfinite(extinction) and extinction >= 0):
        raise InputError("extinction", extinction, "finite and at least 0 /m")
    if not (math.isfinite(m) and m > 0):
        raise InputError("m", m, "the detail angle is finite and above 0 rad", "check the detail")
    if eye is None or math.isinf(contrast):
        return UNWEIGHTED
    table = sensitivity(display, eye)
    # The feature covers m/θ_pixel pixels there, and is half a period: f = 1/(2·angle).
    f_m = 1 / (2 * math.degrees(m / widths.pixel * display.pixel_angle))
    # From the finest feature to the coarsest: the optical depth at which each fades.
    frequency = table.frequency[::-1]
    before_eye = math.hypot(widths.pixel, widths.atmosphere, widths.motion)
    blur_deg = math.degrees(before_eye * display.pixel_angle / widths.pixel)
    seen = envelope(table.value * gaussian_transfer(blur_deg, table.frequency))[::-1]
    with np.errstate(divide="ignore"):
        fades = np.log(contrast * seen)
    growth = np.maximum(1.0, f_m / np.concatenate(([math.inf], frequency[:-1])))
    visible = fades > 0
    if not visible.any():
        return WeightedDistance(np.zeros(1), np.zeros(1), math.inf)
    growth = growth[visible]
    if extinction < MIN_EXTINCTION:
        return WeightedDistance(np.zeros(1), np.zeros(1), float(growth[0]))
    distance = fades[visible] / extinction
    new = np.diff(distance, prepend=0.0) > 0
    knots = np.concatenate(([0.0], distance[new]))
    return WeightedDistance(knots, knots * np.concatenate(([1.0], growth[new])), math.inf)


DISC_WIDTH = math.sqrt(3.0) / 2
"""Full width √12·σ of a uniform disc over its diameter."""


@dataclass(frozen=True)
class Defocus:
    """A lens, and how much farther along the ray than along the axis things are at most.

    corner  1/cos of the angle from the axis to the corners of the picture, at least 1
    """

    lens: ThinLens
    corner: float = 1.0

    @property
    def vergence(self) -> float:
        """Return p = 1/s [1/m]; 0 where the focus is at infinity."""
        return 1 / self.lens.focus_m

    def ratio(self, theta: float) -> float:
        """Return q = (√3/2)·A/θ [m], θ all other blurs together [rad]."""
        return DISC_WIDTH * self.lens.diameter_m / theta

    def sharpest_m(self, theta: float) -> float:
        """Compute d*, the distance at which W is least [m]."""
        q, p = self.ratio(theta), self.vergence
        return q * q * p / (1 + q * q * p * p)


def defocus_width(defocus: Defocus, distance: Reals) -> Reals:
    """Compute the least full width √12·σ of the blur at distances d > 0 in the picture, (n,)."""
    p, nearness = defocus.vergence, 1 / distance
    beside = np.maximum(nearness - p, p - defocus.corner * nearness)
    return DISC_WIDTH * defocus.lens.diameter_m * np.maximum(beside, 0.0)


def defocus_limits(defocus: Defocus, theta: float, clear: Reals) -> Reals:
    """Compute D = W⁻¹(D_c), (n,) [m]: 0 for what is nowhere sharp enough to be displayed.

    ``clear`` (n,) holds limit distances D_c without this lens [m], theta all other blurs [rad].
    """
    q, p, k = defocus.ratio(theta), defocus.vergence, defocus.corner
    slope = 1 + (q * p) ** 2
    least = q / math.sqrt(slope)

    def root(corner: float) -> Reals:
        inside = np.maximum(clear**2 * slope - (q * corner) ** 2, 0.0)
        return (q * q * p * corner + np.sqrt(inside)) / slope

    with np.errstate(invalid="ignore"):
        near, far = root(1.0), root(k)
    focus = defocus.lens.focus_m
    seen = np.where(clear <= focus, near, np.where(clear <= k * focus, clear, far))
    return np.where(clear > least, np.minimum(seen, clear), 0.0)


STANDARD_DISPLAY, STANDARD_EYE = Display(), Eye()


@dataclass(frozen=True)
class ViewingConditions:
    """Air, display and eye of one view. A picture has two kinds of viewer, so two readings.

    widths      the blurs at the camera; m = τ·(their effective width)
    extinction  β along the path, the least where it varies [1/m]; 0 = clear
    display, eye  where the picture is looked at, and by whom
    acuity      An eye looks at the picture on the stated display. Its blur counts in θ_eff, and
                what is too fine for the contrast it has left is gone (``weighted_distance``).
                Without, nobody knows who will look, or how closely. Every detail stays as fine as
                asked; only what the air has left too little contrast to be seen *at any size* is
                gone: past the d where C₀·exp(−βd)·max S = 1, S the standard observer's sensitivity
                on the display.
    defocus     the lens that the picture is taken through; None = everything is sharp
    """

    widths: BlurWidths
    extinction: float = 0.0
    display: Display = STANDARD_DISPLAY
    eye: Eye = STANDARD_EYE
    acuity: bool = True
    defocus: Defocus | None = None

    def weighted(self, contrast: float, m: float) -> WeightedDistance:
        """Give W for parts of inherent contrast C₀ at detail angle m [rad]."""
        beta, display, eye = self.extinction, self.display, self.eye
        if self.acuity:
            return weighted_distance(contrast, beta, m, self.widths, display, eye)
        if math.isinf(contrast) or beta < MIN_EXTINCTION:
            return UNWEIGHTED
        # W(d) = d up to ln(C₀·max S)/β, where C₀ is gone at any size; infinite beyond.
        gone = math.log(contrast * float(sensitivity(display, eye).value.max())) / beta
        knots = np.array([0.0, gone] if gone > 0 else [0.0])
        return WeightedDistance(knots, knots, math.inf)


def perceptual_limits(
    conditions: ViewingConditions, clear: Reals, contrast: Ints, m: float
) -> Reals:
    """Compute D = W⁻¹(D in clear air) of parts in these classes of contrast, (n,) [m].

    ``clear`` (n,) holds their limit distances in clear air [m], ``contrast`` rows of
    CONTRAST_CLASSES. A part must pass both of air and eye and of the lens, so that the lesser of
    their limits decides.
    """
    seen = clear.copy()
    for row in np.unique(contrast):
        of_class = contrast == row
        seen[of_class] = conditions.weighted(CONTRAST_CLASSES[row], m).inverse(clear[of_class])
    if conditions.defocus is None:
        return seen
    return np.minimum(seen, defocus_limits(conditions.defocus, conditions.widths.effective, clear))
