"""The prototypes of one species, laid end to end in one set of arrays."""

from dataclasses import dataclass

import numpy as np

from lod.arrays import freeze
from lod.hierarchy import Hierarchy
from lod.view import View
from scenes.prototype import Prototype, StickTable


@dataclass(frozen=True, eq=False)
class Atlas:
    """Rows are the parts of all prototypes, one prototype after the other.

    root (v,) row of each prototype's whole object; position, bound, level as in Hierarchy
    part_count, first_part, order: the parts of row i are order[first_part[i] :][: part_count[i]]
    sticks, first: both appearances; those of row i, inner then leaf, begin at first[2 i], first[2 i + 1]
    """

    hierarchies: tuple[Hierarchy, ...]
    root: np.ndarray
    position: np.ndarray
    bound: np.ndarray
    level: np.ndarray
    part_count: np.ndarray
    first_part: np.ndarray
    order: np.ndarray
    sticks: StickTable
    tints: np.ndarray

    def __post_init__(self) -> None:
        freeze(self, root=np.int64, position=np.float64, bound=np.float64, level=np.int64)
        freeze(self, part_count=np.int64, first_part=np.int64, order=np.int64, tints=np.float64)

    @staticmethod
    def of(prototypes: tuple[Prototype, ...]) -> "Atlas":
        """Lay the prototypes end to end."""
        trees = tuple(prototype.hierarchy for prototype in prototypes)
        root = np.cumsum([0] + [len(tree) for tree in trees])[:-1]
        order_start = np.cumsum([0] + [len(tree) - 1 for tree in trees])[:-1]
        sticks, tints = _appearances(prototypes)
        return Atlas(
            hierarchies=trees,
            root=root,
            position=np.concatenate([tree.position for tree in trees]),
            bound=np.concatenate([tree.B for tree in trees]),
            level=np.concatenate([tree.level for tree in trees]),
            part_count=np.concatenate([tree.part_count for tree in trees]),
            first_part=np.concatenate(
                [t.first_part + s for t, s in zip(trees, order_start, strict=True)]
            ),
            order=np.concatenate([tree.order + r for tree, r in zip(trees, root, strict=True)]),
            sticks=sticks,
            tints=tints,
        )

    def limits(self, view: View) -> tuple[np.ndarray, np.ndarray]:
        """Clamped limit distances of every row, in view and out of it [m]."""
        pairs = [view.limits(tree) for tree in self.hierarchies]
        return np.concatenate([p[0] for p in pairs]), np.concatenate([p[1] for p in pairs])

    def parts_of(self, rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """For each part owned by ``rows``: which of ``rows`` owns it, and its own row."""
        whole, offset = expand(self.part_count[rows])
        return whole, self.order[self.first_part[rows][whole] + offset]

    def sticks_of(
        self, rows: np.ndarray, is_leaf: np.ndarray
    ) -> tuple[StickTable, np.ndarray, np.ndarray]:
        """The table of sticks; which of ``rows`` owns each displayed stick; its row in the table."""
        block = 2 * rows + is_leaf
        first = self.sticks.first
        owner, offset = expand(first[block + 1] - first[block])
        return self.sticks, owner, first[block][owner] + offset


def expand(count: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """For counts (n,): the owner of each of count.sum() items, and its number under that owner."""
    owner = np.repeat(np.arange(len(count)), count)
    return owner, np.arange(len(owner)) - np.repeat(np.cumsum(count) - count, count)


def _appearances(prototypes: tuple[Prototype, ...]) -> tuple[StickTable, np.ndarray]:
    """Inner and leaf tables of all prototypes, interleaved part by part, on one palette."""
    tints, tint_row = np.unique(
        np.concatenate([p.tints for p in prototypes]), axis=0, return_inverse=True
    )
    tint_start = np.cumsum([0] + [len(p.tints) for p in prototypes])
    tables, counts = [], []
    for prototype, start in zip(prototypes, tint_start, strict=False):
        pair = (prototype.inner, prototype.leaf)
        count = np.stack([np.diff(table.first) for table in pair], axis=1)
        counts.append(count.ravel())
        for table in pair:
            tables.append((table, tint_row.ravel()[start:][table.tint]))
    count = np.concatenate(counts)
    order = _interleaved([np.diff(table.first) for table, _ in tables])

    def column(name: str) -> np.ndarray:
        return np.concatenate([getattr(table, name) for table, _ in tables])[order]

    return StickTable(
        first=np.concatenate(([0], np.cumsum(count))),
        start=column("start"),
        end=column("end"),
        start_radius=column("start_radius"),
        end_radius=column("end_radius"),
        tint=np.concatenate([tint for _, tint in tables])[order],
    ), tints


def _interleaved(counts: list[np.ndarray]) -> np.ndarray:
    """Order that takes tables (inner, leaf, inner, leaf, …) laid end to end to part-by-part blocks."""
    block, start = [], 0
    for number, count in enumerate(counts):
        part = start + np.arange(len(count))
        block.append(np.repeat(2 * part + number % 2, count))
        if number % 2:
            start += len(count)
    return np.argsort(np.concatenate(block), kind="stable")
