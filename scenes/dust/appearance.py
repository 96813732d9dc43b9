"""What stands for parts of dust trails, and what those own: rows of puffs, wisps and grains."""

from typing import NamedTuple

import numpy as np

from lod.arrays import Ints
from lod.pruning.parts import Parts
from scenes.dust.footfalls import Footfalls, Legs, Walkers, footfalls, landing
from scenes.dust.growth import GRAINS, GRAINS_EACH, LIFE_S, SPARK, WISPS, WISPS_EACH
from scenes.dust.part_ids import decode, grain_name, name, named, wisp_name
from scenes.dust.puffs import Air, Puffs, grains_at, puffs_at, trails, wisps_at


class DustFrame(NamedTuple):
    """Air, walkers, their prototypes' legs, and the time [s]."""

    air: Air
    walks: Walkers
    legs: Legs
    time_s: float

    def puffs(self, falls: Footfalls) -> Puffs:
        """Those of footfalls."""
        return puffs_at(self.air, self.walks, self.legs, falls, self.time_s)


class Found(NamedTuple):
    """Parts that others own: row of the whole, name, place (n, 3) [m], share of the area."""

    whole: np.ndarray
    part: np.ndarray
    place: np.ndarray
    share: np.ndarray


class Drawn(NamedTuple):
    """Balls: row of the part, place (n, 3) [m], area in full grains, and where the foot struck,
    (n, 2) [m].
    """

    owner: np.ndarray
    place: np.ndarray
    area: np.ndarray
    struck: np.ndarray


def puffs_of(scene: DustFrame, parts: Parts, rows: Ints) -> Found:
    """The live puffs of trails."""
    whole, falls = _recent(scene, parts, rows)
    live = np.flatnonzero(_live(scene, falls))
    puffs, whole = scene.puffs(falls.take(live)), whole[live]
    area = puffs.mean_area
    total = np.bincount(whole, area, len(parts))
    return Found(whole, name(scene.legs, puffs.footfall), puffs.origin, area / total[whole])


def wisps_in(scene: DustFrame, parts: Parts, rows: Ints) -> Found:
    """The wisps of puffs."""
    puffs, row, _, _ = _distinct(scene, parts, rows)
    own, wisp = np.divmod(np.arange(len(rows) * WISPS), WISPS)
    place, area = wisps_at(scene.air, puffs, row[own], wisp)
    total = np.bincount(own, area, len(rows))
    return Found(rows[own], wisp_name(parts.part[rows[own]], wisp), place, area / total[own])


def grains_in(scene: DustFrame, parts: Parts, rows: Ints) -> Found:
    """The grains of wisps."""
    puffs, row, wisp, _ = _distinct(scene, parts, rows)
    own, grain = np.divmod(np.arange(len(rows) * GRAINS), GRAINS)
    place, _ = grains_at(scene.air, puffs, row[own], wisp[own], grain)
    part = grain_name(parts.part[rows[own]], grain)
    return Found(rows[own], part, place, np.full(len(part), 1 / GRAINS))


def drawn(scene: DustFrame, parts: Parts, shown: np.ndarray) -> Drawn:
    """What stands for the parts that are ``shown``, (n,) of them."""
    levels = (_of_trails, _of_puffs, _of_wisps, _of_grains)
    found = [
        each(scene, parts, np.flatnonzero(shown & (parts.level == level)))
        for level, each in enumerate(levels)
    ]
    columns = [np.concatenate(column) for column in zip(*found, strict=True)]
    order = np.argsort(columns[0], kind="stable")
    return Drawn(*(column[order] for column in columns))


def _of_trails(scene: DustFrame, parts: Parts, rows: Ints) -> Drawn:
    """One ball for each footfall that may still be seen: as many from frame to frame."""
    owner, falls = _recent(scene, parts, rows)
    puffs, live = scene.puffs(falls), _live(scene, falls)
    area = np.where(live, puffs.mean_area, SPARK)
    nowhere = trails(scene.air, scene.walks, falls.owner, scene.time_s)
    place = np.where(live[:, None], puffs.origin, nowhere)
    return Drawn(owner, place, WISPS * GRAINS * area, puffs.struck)


def _of_puffs(scene: DustFrame, parts: Parts, rows: Ints) -> Drawn:
    """One for WISPS_EACH wisps, where one of them is."""
    puffs, row, _, _ = _distinct(scene, parts, rows)
    own, wisp = np.divmod(np.arange(len(rows) * WISPS), WISPS)
    place, area = wisps_at(scene.air, puffs, row[own], wisp)
    each = GRAINS * area.reshape(-1, WISPS_EACH).sum(axis=1)
    own = own[::WISPS_EACH]
    return Drawn(rows[own], place[::WISPS_EACH], each, puffs.struck[row[own]])


def _of_wisps(scene: DustFrame, parts: Parts, rows: Ints) -> Drawn:
    """One for GRAINS_EACH grains, where one of them is."""
    puffs, row, wisp, _ = _distinct(scene, parts, rows)
    own, some = np.divmod(np.arange(len(rows) * (GRAINS // GRAINS_EACH)), GRAINS // GRAINS_EACH)
    place, area = grains_at(scene.air, puffs, row[own], wisp[own], GRAINS_EACH * some)
    return Drawn(rows[own], place, GRAINS_EACH * area, puffs.struck[row[own]])


def _of_grains(scene: DustFrame, parts: Parts, rows: Ints) -> Drawn:
    puffs, row, wisp, grain = _distinct(scene, parts, rows)
    place, area = grains_at(scene.air, puffs, row, wisp, grain)
    return Drawn(rows, place, area, puffs.struck[row])


def _recent(scene: DustFrame, parts: Parts, rows: Ints) -> tuple[np.ndarray, Footfalls]:
    """The last footfalls of the walkers of trails, and the row of the trail of each."""
    legs, slots = scene.legs, scene.legs.slots(LIFE_S)
    each = footfalls(scene.walks, legs, parts.object[rows], slots, scene.time_s)
    whole = np.repeat(rows, slots * legs.strike.shape[1])
    treads = legs.walks[scene.walks.prototype[each.owner], each.leg]
    return whole[treads], each.take(treads)


def _live(scene: DustFrame, falls: Footfalls) -> np.ndarray:
    """Whether the dust of these footfalls is in the air, (m,)."""
    since = scene.time_s - landing(scene.walks, scene.legs, falls).time_s
    return (since >= 0) & (since < LIFE_S)


def _distinct(scene: DustFrame, parts: Parts, rows: Ints) -> tuple[Puffs, Ints, Ints, Ints]:
    """The puffs that these parts are or are of, each once; the row of each part's puff, and the
    numbers of its wisp and its grain.
    """
    of = named(scene.legs, parts.part[rows])
    first = of.footfall.min(initial=0)
    span = of.footfall.max(initial=0) - first + 1
    both, row = np.unique(parts.object[rows] * span + of.footfall - first, return_inverse=True)
    owner, number = np.divmod(both, span)
    puffs = scene.puffs(decode(scene.legs, owner, number + first))
    return puffs, row, of.wisp, of.grain
