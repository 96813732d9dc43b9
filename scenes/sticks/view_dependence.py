"""Shapes that stand for hidden parts mind the height and the side from which they are seen.

A few smooth shapes cover and shine otherwise than what they stand for: the gaps between a conifer's
flat boughs open and close with the height of the eye, and the shade beneath them is seen from the
side and not from above. So what shapes cover, and how bright they are, is right on average over
heights alone. Where a species says how far they are off, height by height (measured:
``bench.calibrate.leaf_light``), they are thinned (``lod.pruning.area_scaling``) and darkened by as
much. Cover is the
same from below as from above; light from below is taken for that from the side. And who stands
between a tree and the sun sees less of the shade among its leaves than who looks toward the sun:
where a species says how much, by the angle between the two, they are darkened by that as well.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from jaxtyping import Float64
from numba import njit

from lod.arrays import Ints, Reals, freeze
from lod.pruning.area_scaling import radius_factor
from scenes.sticks.outline_area import directions, largest_area, parts_alone
from scenes.sticks.table import StickTable
from scenes.sticks.union_area import areas_of_parts

HEIGHTS_DEG = tuple(range(0, 91, 10))
"""Of the eye above the horizon, as a part sees it, at which a species tells its shapes' looks."""

TURNS_DEG = (0.0, 22.5, 45.0, 67.5, 90.0, 112.5, 135.0, 157.5, 180.0)
"""Between the eye and where the sun stands on the map, as a part sees them, at which a species
tells its shapes' tones: at 0° the sun stands behind the eye."""

STEP = 0.95
"""From each tone to the next darker one."""


@dataclass(frozen=True)
class FromHeights:
    """Looks of the shapes of one level of detail from HEIGHTS_DEG: what is left of their area, and
    of their colour, 0 to 1; of each the most is 1."""

    share: tuple[float, ...]
    tone: tuple[float, ...] = (1.0,) * len(HEIGHTS_DEG)

    def share_from(self, height: float) -> float:
        """What is left of their area from a height, sine of its angle."""
        found: float = between(np.array(self.share), place(height))
        return found


FROM_ALL = FromHeights((1.0,) * len(HEIGHTS_DEG))
"""The same from every height."""


@dataclass(frozen=True, eq=False)
class Minds:
    """Which sticks mind from where they are seen, and how; by default none does.

    of_stick (k,)  row of the tables below for each stick of a leaf appearance, −1 for none
    share (c, h)   of their area, at HEIGHTS_DEG; darker (c, h)  steps that their tone goes down
    aside (c, t)   steps that it goes down besides, at TURNS_DEG, and last for all sides alike
    """

    of_stick: np.ndarray = field(default_factory=lambda: np.zeros(0))
    share: np.ndarray = field(default_factory=lambda: np.zeros((0, len(HEIGHTS_DEG))))
    darker: np.ndarray = field(default_factory=lambda: np.zeros((0, len(HEIGHTS_DEG))))
    aside: np.ndarray = field(default_factory=lambda: np.zeros((0, len(TURNS_DEG) + 1)))

    def __post_init__(self) -> None:
        freeze(self, of_stick=np.int64, share=np.float64, darker=np.float64, aside=np.float64)

    @staticmethod
    def of(
        of_stick: Ints, looks: Sequence[FromHeights], sides: Sequence[Sequence[float]] = ()
    ) -> "Minds":
        """As a species tells it, level by level; ``of_stick`` gives each stick's level, or −1.

        sides: tones at TURNS_DEG over their mean, likewise; () for the same from all sides
        """
        share, tone = (np.array([getattr(each, k) for each in looks]) for k in ("share", "tone"))
        around = np.ones((len(share), len(TURNS_DEG) + 1))
        if sides:
            around[:, :-1] = sides
        around /= around.max(axis=1, keepdims=True)
        return Minds(of_stick, share, *(np.log(each) / math.log(STEP) for each in (tone, around)))

    def rows(self, sticks: int) -> Ints:
        """``of_stick`` of a table of so many sticks."""
        return self.of_stick if len(self.of_stick) else np.full(sticks, -1)


def together(minds: Sequence[Minds], sticks: Sequence[int]) -> Minds:
    """Those of several tables of so many sticks each, laid end to end."""
    first = np.cumsum([0] + [len(each.share) for each in minds])[:-1]
    rows = [each.rows(count) for each, count in zip(minds, sticks, strict=True)]
    moved = [np.where(row >= 0, row + start, -1) for row, start in zip(rows, first, strict=True)]
    names = ("share", "darker", "aside")
    tables = (np.concatenate([getattr(each, k) for each in minds]) for k in names)
    return Minds(np.concatenate(moved), *tables)


def toned(tint: Ints, tints: np.ndarray, minds: Minds) -> tuple[Ints, Float64[np.ndarray, "t 3"]]:
    """Tints (k,) of sticks in a longer palette, where all tones of a stick that minds from where it
    is seen follow its own."""
    darkest = [each.max(axis=1, initial=0.0) for each in (minds.darker, minds.aside)]
    steps = np.ceil(darkest[0] + darkest[1]).astype(np.int64)
    mindful = minds.of_stick >= 0
    pairs, pair = np.unique(
        np.stack((minds.of_stick[mindful], tint[mindful])), axis=1, return_inverse=True
    )
    blocks = [tints[colour] * STEP ** np.arange(steps[row] + 1)[:, None] for row, colour in pairs.T]
    first = len(tints) + np.cumsum([0] + [len(block) for block in blocks])[:-1]
    found = tint.copy()
    found[mindful] = first[pair.reshape(-1)]
    return found, np.concatenate((tints, *blocks))


@njit(cache=True)
def place(height):  # type: ignore[no-untyped-def]
    """Where a height, sine of its angle, 0 to 1, is among HEIGHTS_DEG."""
    return math.asin(min(height, 1.0)) / math.radians(HEIGHTS_DEG[1])


@njit(cache=True)
def place_around(turn):  # type: ignore[no-untyped-def]
    """Where a turn, cosine of its angle, is among TURNS_DEG; −1 where it is NaN, for all sides."""
    if math.isnan(turn):
        return -1.0
    return math.acos(min(max(turn, -1.0), 1.0)) / math.radians(TURNS_DEG[1])


@njit(cache=True)
def tone_aside(table, at):  # type: ignore[no-untyped-def]
    """An entry of a row of ``Minds.aside`` at a ``place_around``."""
    sides = len(table) - 1
    return between(table[:sides], at) if at >= 0.0 else table[sides]


@njit(cache=True)
def between(table, at):  # type: ignore[no-untyped-def]
    """An entry of a table (h,) at a ``place``: linear in the angle."""
    low = min(int(at), len(table) - 2)
    return table[low] + (at - low) * (table[low + 1] - table[low])


def thinned(table: StickTable, share: Reals | float) -> StickTable:
    """Sticks that cover their share (k,) of what they did, or all the same."""
    share = np.broadcast_to(share, len(table)).astype(np.float64)
    length = np.sqrt(((table.end - table.start) ** 2).sum(axis=1))
    factor = _factors(table.start_radius, table.end_radius, length, share)
    return replace(
        table, start_radius=table.start_radius * factor, end_radius=table.end_radius * factor
    )


def largest_seen(table: StickTable, minds: Minds) -> Reals:
    """The largest area that the sticks of each part cover from any side, as they look there, (n,)
    [m²]."""
    mindful, thins = np.zeros(len(table.count), np.bool_), (minds.share != 1).any(axis=1)
    mindful[table.owner[np.append(thins, False)[minds.rows(len(table))]]] = True
    if not mindful.any():
        return largest_area(table)
    largest = np.empty(len(mindful))
    largest[~mindful] = largest_area(parts_alone(table, ~mindful))
    some = parts_alone(table, mindful)
    rows = minds.rows(len(table))[mindful[table.owner]]
    views = directions()
    areas = [
        areas_of_parts(thinned(some, shares_from(minds, rows, view[2])), view[None])[:, 0]
        for view in views
    ]
    largest[mindful] = np.max(areas, axis=0)
    return largest


def shares_from(minds: Minds, rows: Ints, height: float) -> Reals:
    """Share of their area that sticks show from a height, sine of its angle; ``rows`` as
    ``of_stick``."""
    shares = np.append([between(row, place(height)) for row in minds.share], 1.0)
    found: Reals = shares[rows]
    return found


@njit(cache=True)
def _factors(r0, r1, length, share):  # type: ignore[no-untyped-def]
    found = np.empty(len(r0))
    for k in range(len(r0)):
        found[k] = radius_factor(r0[k], r1[k], length[k], share[k])
    return found
