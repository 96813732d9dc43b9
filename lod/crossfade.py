"""Cross-fading: parts shrink before their limit distance, and their wholes take over their area.

Within a band before its limit distance D a part shrinks from its full area to none (Rubin 1982,
the paper's ref. 8), and what hangs on it with it. Out of view D is less; what is displayed only
because it is in view grows while the sphere that holds it enters the pyramid of view. The area
that a part's own parts no longer cover is the share λ of its leaf appearance; what of the two lies
in one another is made up for where they are drawn (``leaf_area_share``). Counts are those of the
cut: fading changes no part of it.

Parts that thin out are not followed by a leaf appearance: those that are left become wider as the
others shrink, so that all together cover the same area (Cook et al. 2007, "Stochastic
simplification of aggregate detail", SIGGRAPH).
"""

import math

import numpy as np

from lod.arrays import Points, Reals
from lod.kernels import njit
from lod.pruner import BlendWeights, Cut
from lod.threads import map_chunks
from lod.view import View, compile_view, distance_to, entry_fraction, sphere_in_frustum

_INNER_GAIN = 4.0
"""Gain of the inner appearance, which thins only while less than a quarter of its parts is left:
it and the leaf appearance mostly overlap, and halves of both would not make a whole."""

_SHORTEST_RUN = 16384
"""Parts for which another thread is worth its start."""

_ROUNDING = 1e-9
"""Hidden shares below this are what sums of shares leave over."""


def blend_weights(cut: Cut, view: View) -> BlendWeights:
    """Compute the cross-fade weights of both appearances of every displayed part of a cut."""
    parts = cut.parts
    fades = view.fade > 0 or parts.kept is not None
    shown = fade_factors(cut, view) if fades else np.ones(len(parts))
    inner, leaf, hidden = cross_fade(parts.parent, parts.share, shown)
    return BlendWeights(inner, leaf, *view_angles(parts.position, view), hidden)


def view_angles(position: Points, view: View) -> tuple[Reals, Reals]:
    """Compute from which side the eye sees each point (n, 3): two columns of length n.

    The first is the sine of the eye's elevation above the point, the second the cosine of the angle
    between the line to the eye and the sun's azimuth (NaN in a view without a sun).
    """
    eye, sun = view.camera.eye, (math.nan, math.nan) if view.sun is None else view.sun
    rise, turn = np.empty((2, len(position)))

    def run(first: int, last: int) -> None:
        _view_angles(position[first:last], eye, sun, rise[first:last], turn[first:last])

    map_chunks(run, len(position), _SHORTEST_RUN)
    return rise, turn


def fade_factors(cut: Cut, view: View) -> Reals:
    """Compute which share of its area each part shows by itself: (D − d)/(fade·D), at most 1, (n,).

    In view times how far its sphere has entered it, but no less than it would show out of view.
    What thins out shows more than 1: its share over the share of all that is left.
    """
    parts = cut.parts
    columns = parts.position, parts.centre, parts.bound, parts.limit, parts.limit_offscreen
    vantage = compile_view(view)
    kept = np.broadcast_to(0.0, 0) if parts.kept is None else parts.kept  # both read-only

    shown = np.ones(len(parts))

    def run(first: int, last: int) -> None:
        rows = slice(first, last)
        own = [each[rows] for each in (*columns, kept)]
        _fade_factors(vantage, *own, view.fade, shown[rows])

    map_chunks(run, len(parts), _SHORTEST_RUN)
    return shown


@njit(cache=True, nogil=True)
def _fade_factors(vantage, position, centre, bound, limit, limit_offscreen, kept, fade, shown):  # type: ignore[no-untyped-def]
    for i in range(len(bound)):
        if len(kept) and kept[i] == 0.0:
            continue  # the whole of what thins out shows nothing
        d = distance_to(vantage, position[i, 0], position[i, 1], position[i, 2])
        # Where it is well within the coarser limit it is whole, in view or not.
        if d < limit_offscreen[i] * (1.0 - fade) and limit_offscreen[i] <= limit[i]:
            continue
        x, y, z = centre[i, 0], centre[i, 1], centre[i, 2]
        shown[i] = _band_factor(d, limit_offscreen[i], fade)
        if sphere_in_frustum(vantage, x, y, z, bound[i]):
            inside = _band_factor(d, limit[i], fade) * entry_fraction(vantage, x, y, z, bound[i])
            shown[i] = max(shown[i], inside)
        if len(kept):
            shown[i] /= kept[i]


@njit(cache=True, nogil=True)
def _view_angles(position, eye, sun, rise, turn):  # type: ignore[no-untyped-def]
    for i in range(len(position)):
        x, y, z = eye[0] - position[i, 0], eye[1] - position[i, 1], eye[2] - position[i, 2]
        d = math.sqrt(x * x + y * y + z * z)
        rise[i] = z / d if d > 0.0 else 0.0
        turn[i] = (x * sun[0] + y * sun[1]) / d if d > 0.0 else math.nan


@njit(cache=True)
def _band_factor(d, D, fade):  # type: ignore[no-untyped-def]
    if D == math.inf or fade == 0.0:
        return 1.0 if d < D else 0.0
    return min(max((D - d) / (fade * D), 0.0), 1.0) if D > 0.0 else 0.0


@njit(cache=True)
def cross_fade(parent, share, shown):  # type: ignore[no-untyped-def]
    """Compute weights (inner, leaf, hidden area) of every part from its fade factor, (n,) each.

    Rows: parents before children. The displayed parts of a part hang on its inner appearance,
    which stays while any of them does.
    """
    n = len(parent)
    shown = shown.copy()
    inner, leaf, hidden = np.zeros(n), np.zeros(n), np.ones(n)
    for i in range(n):
        if parent[i] >= 0:
            hidden[parent[i]] -= share[i] * shown[i]
            inner[parent[i]] = max(inner[parent[i]], shown[i])
    for i in range(n):
        if parent[i] >= 0:
            shown[i] *= shown[parent[i]]
        inner[i] = min(1.0, _INNER_GAIN * inner[i]) * shown[i]
        if hidden[i] <= _ROUNDING:
            hidden[i] = 0.0
        leaf[i] = hidden[i] * shown[i]
    return inner, leaf, hidden


@njit(cache=True)
def radius_factor(r0, r1, length, share):  # type: ignore[no-untyped-def]
    """Compute the factor on radii of a stick that leaves a share of its mean outline area.

    A stick of radii r₀, r₁ and length L has a quarter of its surface as mean outline (Cauchy):
    caps π(r₀² + r₁²)/2 and a flank π(r₀ + r₁)L/4, but for a term of (r₀ − r₁)². Radii times f
    make that f²·caps + f·flank: f is about the share for long sticks, its root for round blobs.
    """
    caps = (r0 * r0 + r1 * r1) / 2
    flank = (r0 + r1) * length / 4
    area = share * (caps + flank)
    return 2 * area / (flank + math.sqrt(flank * flank + 4 * caps * area))


@njit(cache=True)
def leaf_area_share(hidden, overlap):  # type: ignore[no-untyped-def]
    """Compute which share s of its area a leaf appearance shows while a share h of parts is hidden.

    The share s of the leaf appearance and the share 1 − h of the parts overlap by c·s·(1 − h), with
    c the overlap of the two at full size. Covering the same area as before asks for
    s + (1 − h) − c·s·(1 − h) = 1, so that s = h/(1 − c·(1 − h)), which is 0 for h = 0 and 1 for
    h = 1. The overlap c is below 1; it is below 0 where both together cover more than their sum.
    """
    return hidden / (1.0 - overlap * (1.0 - hidden))
