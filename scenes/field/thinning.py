"""Which share of parts that thin out is left at a distance; what is left is so much wider.

Parts of which each stands for others like it (``Hierarchy.stands_for``) end one by one, at limit
distances of their own. At the distance d the share k(d) of them is left, fading included, and what
is left is 1/k times as wide, so that all together cover the same. No part gets wider than
``stands_for`` says: beyond that the ground takes over (``scenes.field.far_cover``).
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from lod.arrays import ArrayData, FloatArray, IntArray, Ints, Reals
from lod.hierarchy import Hierarchy

_DISTANCES = np.geomspace(1e-4, 1.0, 384)
"""Distances at which shares are tabled, over the farthest limit distance."""

WHOLE, RIGID = -2, -1
"""Kinds of wholes whose parts thin out, and of what does not thin out."""


@dataclass(frozen=True, eq=False)
class Thinning(ArrayData):
    """Parts by kind: those of wholes whose parts are as large, which differ in their limits.

    kind (m,)   of every row of the part tables, or WHOLE or RIGID
    floor (k,)  share of each kind that is left before the last of it fades away
    area (k,)   share of the area of all kinds
    """

    kind: IntArray
    floor: FloatArray
    area: FloatArray

    @staticmethod
    def of(trees: tuple[Hierarchy, ...]) -> "Thinning | None":
        """Group the parts of hierarchies; None where none thin out."""
        thinned = [tree for tree in trees if tree.is_thinned]
        if not thinned:
            return None
        alone = np.array([(tree.P**2 / tree.stands_for).min() for tree in thinned])
        sizes, of_tree = np.unique(alone.round(12), return_inverse=True)
        most = np.zeros(len(sizes))
        np.maximum.at(most, of_tree, [tree.stands_for[0] for tree in thinned])
        kinds, numbers = [], iter(of_tree.tolist())
        for tree in trees:
            kind = next(numbers) if tree.is_thinned else RIGID
            kinds.append(np.where(tree.parent < 0, WHOLE if tree.is_thinned else RIGID, kind))
        area = sizes * np.bincount(of_tree)
        return Thinning(np.concatenate(kinds), 1 / most, area / area.sum())


@dataclass(frozen=True, eq=False)
class Left(ArrayData):
    """What is left in a view: shares (k, n) of each kind at distances (n,) [m]."""

    thinning: Thinning
    distances: FloatArray
    shares: FloatArray

    @staticmethod
    def of(thinning: Thinning, limits: Reals, fade: float) -> "Left":
        """Table what limits (m,) of all rows leave, where parts fade over a share of them."""
        farthest = float(limits[thinning.kind >= 0].max())
        shares = np.ones((len(thinning.floor), len(_DISTANCES)))
        if np.isfinite(farthest):
            for kind in range(len(shares)):
                limit = limits[thinning.kind == kind]
                past = limit - farthest * _DISTANCES[:, None]
                shares[kind] = np.clip(past / np.maximum(fade * limit, 1e-9), 0, 1).mean(axis=1)
        return Left(thinning, np.minimum(farthest, 1e30) * _DISTANCES, shares)

    def kept(self, rows: Ints, d: Reals) -> Reals:
        """Compute ``Parts.kept`` of parts in these rows at distances d [m], (n,)."""
        kinds = self.thinning.kind[rows]
        left = np.where(kinds == WHOLE, 0.0, 1.0)
        for kind, floor in enumerate(self.thinning.floor):
            own = np.flatnonzero(kinds == kind)
            left[own] = np.maximum(np.interp(d[own], self.distances, self.shares[kind]), floor)
        return left

    def missing(self, d: Reals) -> Reals:
        """Compute the share of the cover that what is left lacks at distances d [m], (n,)."""
        columns = zip(self.thinning.area, self.shares / self.thinning.floor[:, None], strict=True)
        covered = [a * np.interp(d, self.distances, np.minimum(s, 1.0)) for a, s in columns]
        return np.maximum(1.0 - np.sum(covered, axis=0), 0.0)


def at_motion(motion: Reals, at_step: Callable[[int, Ints], Reals]) -> Reals:
    """Interpolate what is known of rows at whole steps of motion to the step of each, (n,)."""
    low, found = motion.astype(np.int64), np.empty(len(motion))
    for step in np.unique(low).tolist():
        rows = np.flatnonzero(low == step)
        share = motion[rows] - step
        found[rows] = at_step(step, rows)
        if share.any():
            found[rows] += share * (at_step(step + 1, rows) - found[rows])
    return found
