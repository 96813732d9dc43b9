"""Parts of dust trails and their leaf appearances: rows of puffs, wisps and grains."""

from typing import NamedTuple

import numpy as np

from lod.arrays import Ints
from lod.pruner import Parts
from scenes.dust.footfalls import Footfalls, Legs, Walkers, footfalls, landing
from scenes.dust.growth import GRAINS, GRAINS_EACH, LEAST_AREA, LIFE_S, WISPS, WISPS_EACH
from scenes.dust.part_ids import decode, decode_ids, grain_id, puff_id, wisp_id
from scenes.dust.puffs import Air, Puffs, grains_at, puffs_at, trail_centres, wisps_at


class DustFrame(NamedTuple):
    """Dust at one time: air, walkers, their prototypes' legs, and the time [s]."""

    air: Air
    walkers: Walkers
    legs: Legs
    time_s: float

    def puffs(self, falls: Footfalls) -> Puffs:
        """Return the puffs that footfalls have thrown up."""
        return puffs_at(self.air, self.walkers, self.legs, falls, self.time_s)


class ChildParts(NamedTuple):
    """Parts of wholes: row of the whole, part number, place (n, 3) [m], share of the area."""

    parent: np.ndarray
    part: np.ndarray
    place: np.ndarray
    share: np.ndarray


class DustBalls(NamedTuple):
    """Balls that are drawn for parts.

    owner (n,), place (n, 3)  row of the part, and middle of the ball [m]
    area (n,)                 area over that of a full grain
    struck (n, 2)             place where the foot struck [m]
    """

    owner: np.ndarray
    place: np.ndarray
    area: np.ndarray
    struck: np.ndarray


def live_puffs(frame: DustFrame, parts: Parts, rows: Ints) -> ChildParts:
    """Return the puffs of trails that are in the air."""
    parent, falls = _recent_footfalls(frame, parts, rows)
    live = np.flatnonzero(_is_in_air(frame, falls))
    puffs, parent = frame.puffs(falls.take(live)), parent[live]
    area = puffs.mean_area
    total = np.bincount(parent, area, len(parts))
    return ChildParts(
        parent, puff_id(frame.legs, puffs.footfall), puffs.origin, area / total[parent]
    )


def wisps_of_puffs(frame: DustFrame, parts: Parts, rows: Ints) -> ChildParts:
    """Return the wisps of puffs."""
    puffs, row, _, _ = _distinct(frame, parts, rows)
    own, wisp = np.divmod(np.arange(len(rows) * WISPS), WISPS)
    place, area = wisps_at(frame.air, puffs, row[own], wisp)
    total = np.bincount(own, area, len(rows))
    return ChildParts(rows[own], wisp_id(parts.part[rows[own]], wisp), place, area / total[own])


def grains_of_wisps(frame: DustFrame, parts: Parts, rows: Ints) -> ChildParts:
    """Return the grains of wisps."""
    puffs, row, wisp, _ = _distinct(frame, parts, rows)
    own, grain = np.divmod(np.arange(len(rows) * GRAINS), GRAINS)
    place, _ = grains_at(frame.air, puffs, row[own], wisp[own], grain)
    part = grain_id(parts.part[rows[own]], grain)
    return ChildParts(rows[own], part, place, np.full(len(part), 1 / GRAINS))


def leaf_balls(frame: DustFrame, parts: Parts, shown: np.ndarray) -> DustBalls:
    """Return the balls of the leaf appearances of the parts that are ``shown`` (n,)."""
    levels = (_trail_balls, _puff_balls, _wisp_balls, _grain_balls)
    found = [
        each(frame, parts, np.flatnonzero(shown & (parts.level == level)))
        for level, each in enumerate(levels)
    ]
    columns = [np.concatenate(column) for column in zip(*found, strict=True)]
    order = np.argsort(columns[0], kind="stable")
    return DustBalls(*(column[order] for column in columns))


def _trail_balls(frame: DustFrame, parts: Parts, rows: Ints) -> DustBalls:
    """One ball for each recent footfall, as many in every frame."""
    owner, falls = _recent_footfalls(frame, parts, rows)
    puffs, live = frame.puffs(falls), _is_in_air(frame, falls)
    area = np.where(live, puffs.mean_area, LEAST_AREA)
    nowhere = trail_centres(frame.air, frame.walkers, falls.owner, frame.time_s)
    place = np.where(live[:, None], puffs.origin, nowhere)
    return DustBalls(owner, place, WISPS * GRAINS * area, puffs.struck)


def _puff_balls(frame: DustFrame, parts: Parts, rows: Ints) -> DustBalls:
    """One ball for WISPS_EACH wisps, in the place of one of them."""
    puffs, row, _, _ = _distinct(frame, parts, rows)
    own, wisp = np.divmod(np.arange(len(rows) * WISPS), WISPS)
    place, area = wisps_at(frame.air, puffs, row[own], wisp)
    each = GRAINS * area.reshape(-1, WISPS_EACH).sum(axis=1)
    own = own[::WISPS_EACH]
    return DustBalls(rows[own], place[::WISPS_EACH], each, puffs.struck[row[own]])


def _wisp_balls(frame: DustFrame, parts: Parts, rows: Ints) -> DustBalls:
    """One ball for GRAINS_EACH grains, in the place of one of them."""
    puffs, row, wisp, _ = _distinct(frame, parts, rows)
    own, some = np.divmod(np.arange(len(rows) * (GRAINS // GRAINS_EACH)), GRAINS // GRAINS_EACH)
    place, area = grains_at(frame.air, puffs, row[own], wisp[own], GRAINS_EACH * some)
    return DustBalls(rows[own], place, GRAINS_EACH * area, puffs.struck[row[own]])


def _grain_balls(frame: DustFrame, parts: Parts, rows: Ints) -> DustBalls:
    puffs, row, wisp, grain = _distinct(frame, parts, rows)
    place, area = grains_at(frame.air, puffs, row, wisp, grain)
    return DustBalls(rows, place, area, puffs.struck[row])


def _recent_footfalls(frame: DustFrame, parts: Parts, rows: Ints) -> tuple[np.ndarray, Footfalls]:
    """The last footfalls of the walkers of trail_centres, and the row of the trail of each."""
    legs, slots = frame.legs, frame.legs.slots(LIFE_S)
    each = footfalls(frame.walkers, legs, parts.object[rows], slots, frame.time_s)
    parent = np.repeat(rows, slots * legs.strike.shape[1])
    treads = legs.walks[frame.walkers.prototype[each.owner], each.leg]
    return parent[treads], each.take(treads)


def _is_in_air(frame: DustFrame, falls: Footfalls) -> np.ndarray:
    """Whether the dust of these footfalls is in the air, (m,)."""
    since = frame.time_s - landing(frame.walkers, frame.legs, falls).time_s
    return (since >= 0) & (since < LIFE_S)


def _distinct(frame: DustFrame, parts: Parts, rows: Ints) -> tuple[Puffs, Ints, Ints, Ints]:
    """Puffs of these parts, each once; row of each part's puff, and its wisp and its grain."""
    of = decode_ids(frame.legs, parts.part[rows])
    first = of.footfall.min(initial=0)
    span = of.footfall.max(initial=0) - first + 1
    both, row = np.unique(parts.object[rows] * span + of.footfall - first, return_inverse=True)
    owner, number = np.divmod(both, span)
    puffs = frame.puffs(decode(frame.legs, owner, number + first))
    return puffs, row, of.wisp, of.grain
