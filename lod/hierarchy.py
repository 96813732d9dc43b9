"""The part hierarchy of one object as arrays, parents before children (§2.3).

``lod`` explains the symbols P, R and B.
"""

from dataclasses import dataclass, field, fields, replace
from functools import cached_property

import numpy as np

from lod.arrays import ArrayData, FloatArray, IntArray, Ints, Reals, check_columns
from lod.errors import InputError
from lod.eye import NEVER_LOST


@dataclass(frozen=True, eq=False)
class Hierarchy(ArrayData):
    """The parts of one object. Row 0 is the whole object; each part stands after its owner.

    parent     (n,)   row of the part that owns this one; -1 for row 0
    level      (n,)   detail level; 0 is one blob; levels never decrease down the tree
    position   (n, 3) origin of the part in the object's own frame [m]
    P          (n,)   priority: √ of the largest cross-section of the leaf appearance (§2.4) [m]
    R          (n,)   range: reach of the part's extremes and its parts' ends from its origin [m]
    B          (n,)   bound: radius about the origin that holds everything in it, any pose [m]
    separation (n,)   greatest distance to the origin of the owner in any pose; 0 for row 0 [m]
    contrast   (n,)   class of inherent contrast, a row of lod.eye.CONTRAST_CLASSES; by
                      default the last one, which no air and no eye takes away
    contrast_to_whole (n,) contrast to the leaf appearance of its whole, which is shown in its
                      place, or that of one of its parts to its own if that is greater: above 0, at
                      most 1. By default 1, as where nothing is shown in its place
    overlap    (n,)   how much of the leaf appearance and of the parts' appearances lies in one
                      another where half of either shows, below 1; by default 0
                      (``lod.pruner.leaf_area_share``)
    stands_for (n,)   how many parts like itself each part has grown as wide as where it ends, at
                      least 1 and by default 1. P² counts them. Of a whole whose parts stand for
                      others it is the most of any of them, and it shows nothing of its own

    Raises InputError unless it is a tree of finite numbers with P > 0, R ≥ 0 and nested bounds:
    B of a whole is at least the separation of its part plus the part's B, so that the whole of a
    part in view is in view.
    """

    parent: IntArray
    level: IntArray
    position: FloatArray
    P: FloatArray
    R: FloatArray
    B: FloatArray
    separation: FloatArray
    contrast: IntArray = field(default_factory=lambda: np.zeros(0, np.int64))
    contrast_to_whole: FloatArray = field(default_factory=lambda: np.zeros(0))
    overlap: FloatArray = field(default_factory=lambda: np.zeros(0))
    stands_for: FloatArray = field(default_factory=lambda: np.zeros(0))

    def __post_init__(self) -> None:
        default = {"contrast_to_whole": 1.0, "overlap": 0.0, "stands_for": 1.0}
        for name, usual in {"contrast": NEVER_LOST, **default}.items():
            if len(getattr(self, name)) == 0:
                object.__setattr__(self, name, np.full(len(self.parent), usual))
        super().__post_init__()
        self._check()

    def __len__(self) -> int:
        return len(self.parent)

    @cached_property
    def depth(self) -> np.ndarray:
        """Number of steps from row 0 to each part, (n,)."""
        depth = np.zeros(len(self), np.int64)
        for row in range(1, len(self)):
            depth[row] = depth[self.parent[row]] + 1
        return depth

    @cached_property
    def order(self) -> np.ndarray:
        """Sort the rows without row 0 so that the parts of one whole stand together, (n - 1,)."""
        return np.argsort(self.parent[1:], kind="stable") + 1

    @cached_property
    def part_count(self) -> np.ndarray:
        """Number of parts that each part owns directly, (n,)."""
        return np.bincount(self.parent[1:], minlength=len(self))

    @cached_property
    def first_part(self) -> np.ndarray:
        """Return the index in ``order`` at which the parts of each part begin, (n,)."""
        return np.concatenate(([0], np.cumsum(self.part_count)[:-1]))

    @cached_property
    def share(self) -> np.ndarray:
        """Compute each part's own area over that of all parts of its owner, (n,), 1 for row 0."""
        area = self.P**2 / self.stands_for
        siblings = np.bincount(self.parent[1:], area[1:], len(self))
        share = np.ones(len(self))
        share[1:] = area[1:] / siblings[self.parent[1:]]
        share.setflags(write=False)
        return share

    @property
    def is_thinned(self) -> bool:
        """Tell whether its parts thin out with distance, and what is left stands for all."""
        return bool(self.stands_for[0] > 1)

    def scaled(self, factor: float) -> "Hierarchy":
        """Return the object with every length multiplied by ``factor``.

        Raises InputError unless the factor is finite and above 0.
        """
        if not (np.isfinite(factor) and factor > 0):
            raise InputError("scale", factor, "a size factor is finite and above 0", "try 1.0")
        lengths = {k: getattr(self, k) * factor for k in ("position", "P", "R", "B", "separation")}
        return replace(self, **lengths)

    def _check(self) -> None:
        n, parent, level = len(self.parent), self.parent, self.level
        if n == 0:
            raise InputError("hierarchy", 0, "an object has at least one part, itself")
        shapes = {each.name: (n,) for each in fields(self)} | {"position": (n, 3)}
        check_columns("hierarchy", self, **shapes)
        if parent[0] != -1:
            raise InputError(
                "hierarchy.parent[0]", int(parent[0]), "row 0 is the root, owned by -1"
            )
        rows = np.arange(1, n)
        for row in rows[(parent[1:] < 0) | (parent[1:] >= rows)].tolist():
            rule = "a part stands after the part that owns it"
            raise InputError(f"hierarchy.parent[{row}]", int(parent[row]), rule)
        above = np.where(parent < 0, 0, level[parent])
        for row in np.flatnonzero((level < above) | ((parent < 0) & (level != 0))).tolist():
            rule = "levels start at 0 and never decrease"
            raise InputError(f"hierarchy.level[{row}]", int(level[row]), rule)
        if self.contrast.min() < 0 or self.contrast.max() > NEVER_LOST:
            wrong = int(self.contrast.max() if self.contrast.min() >= 0 else self.contrast.min())
            raise InputError("hierarchy.contrast", wrong, f"a class of contrast, 0 to {NEVER_LOST}")
        seen = self.contrast_to_whole
        for value in seen[(seen <= 0) | (seen > 1)].tolist():
            raise InputError("hierarchy.contrast_to_whole", value, "above 0 and at most 1")
        if self.overlap.max() >= 1:
            raise InputError("hierarchy.overlap", float(self.overlap.max()), "below 1")
        if self.stands_for.min() < 1:
            raise InputError("hierarchy.stands_for", float(self.stands_for.min()), "at least 1")
        for name in ("P", "R", "B", "separation"):
            values = getattr(self, name)
            for row in np.flatnonzero(values <= 0 if name == "P" else values < 0).tolist():
                rule = "above 0 m" if name == "P" else "at least 0 m"
                raise InputError(f"hierarchy.{name}[{row}]", float(values[row]), rule)
        needed = self.separation[1:] + self.B[1:]
        for row in np.flatnonzero(self.B[parent[1:]] < needed * (1 - 1e-12) - 1e-12).tolist():
            rule = f"a whole's bound holds its part {row + 1}: at least {needed[row]:.6g} m"
            whole = int(parent[row + 1])
            raise InputError(f"hierarchy.B[{whole}]", float(self.B[whole]), rule)


def representative(parent: Ints, P: Reals) -> Ints:
    """Find the first of the parts that each part is tied to, (n,); for most it is the part itself.

    Which levels of the modelling hierarchy are one object of the display hierarchy (§4.2)? Where a
    whole has one part only, and that is no smaller, only rounding would separate their limit
    distances, although they should appear and disappear together. Measured from the same origin
    with the same P and R, they do, for every metric, eye and air. An only part that is smaller than
    its whole disappears before it, like any other.

    parent (n,) row of the part that owns each part, -1 for row 0; P (n,) priorities [m]. A part
    that is tied to its only part counts as large as that part when it is compared with its own
    whole.
    """
    only = np.bincount(parent[1:], minlength=len(parent)) == 1
    size, tied = P.copy(), np.zeros(len(P), bool)
    for row in range(len(P) - 1, 0, -1):
        if only[parent[row]] and size[row] >= size[parent[row]]:
            tied[row], size[parent[row]] = True, size[row]
    first = np.arange(len(P))
    for row in np.flatnonzero(tied).tolist():
        first[row] = first[parent[row]]
    return first


def max_over_tied(lengths: Reals, first: Ints) -> Reals:
    """Give each part the greatest length of all parts that are tied to it, (n,) [m]."""
    greatest = lengths.copy()
    np.maximum.at(greatest, first, lengths)
    return greatest[first]
