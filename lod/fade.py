"""Fading: parts shrink away before their limit, and their wholes take over what they hide.

Within a band before its limit distance D a part shrinks from its full area to none (Rubin 1982,
the paper's ref. 8), and what hangs on it with it. The area that a part's own parts no longer cover
is the share λ of its leaf appearance. Counts are those of the cut: fading changes no part of it.
"""

import numpy as np
from numba import njit

from lod.arrays import Reals
from lod.parts import Look
from lod.prune import Cut
from lod.view import View, distance, in_view

_FIRM = 4.0
"""An inner appearance thins only while less than a quarter of what hangs on it is left: it and the
leaf appearance mostly lie in one another, and halves of both would not make a whole."""

_ROUNDING = 1e-9
"""Hidden shares below this are what sums of shares leave over."""


def looks(cut: Cut, view: View) -> Look:
    """How much of its inner and of its leaf appearance each displayed part shows."""
    parts = cut.parts
    shown = shown_shares(cut, view) if view.fade else np.ones(len(parts))
    return Look(*_blended(parts.whole, parts.share, shown))


def shown_shares(cut: Cut, view: View) -> Reals:
    """Share of its area that each displayed part shows by itself: (D − d)/(fade·D), at most 1."""
    parts = cut.parts
    limit = np.where(in_view(view, parts.centre, parts.bound), parts.limit, parts.limit_offscreen)
    near = np.flatnonzero(np.isfinite(limit))
    shown = np.ones(len(parts))
    limit, d = limit[near], distance(view, parts.position[near])
    shown[near] = np.clip((limit - d) / (view.fade * limit), 0.0, 1.0)
    return shown


@njit(cache=True)
def _blended(whole, share, shown):  # type: ignore[no-untyped-def]
    """Shares of the two appearances; wholes stand before their parts.

    What is displayed of a part's own parts hangs on its inner appearance, which stays while any
    of them does.
    """
    n = len(whole)
    shown = shown.copy()
    inner, leaf = np.zeros(n), np.ones(n)
    for i in range(n):
        if whole[i] >= 0:
            leaf[whole[i]] -= share[i] * shown[i]
            inner[whole[i]] = max(inner[whole[i]], shown[i])
    for i in range(n):
        if whole[i] >= 0:
            shown[i] *= shown[whole[i]]
        inner[i] = min(1.0, _FIRM * inner[i]) * shown[i]
        leaf[i] = leaf[i] * shown[i] if leaf[i] > _ROUNDING else 0.0
    return inner, leaf
