"""What parts of a trail are called: each by one whole number, the trail by 0."""

import math
from typing import NamedTuple

import numpy as np

from lod.arrays import Ints
from scenes.dust.footfalls import Footfalls, Legs
from scenes.dust.growth import GRAINS, WISPS

_BEFORE_S = 1e4
"""Footfalls no longer before time 0 have numbers above 0."""

_PUFF, _WISP = 1 + WISPS * (1 + GRAINS), 1 + GRAINS


class PartIds(NamedTuple):
    """Footfalls by the number of ``footfall``, wisps and grains; −1 where it is none. (n,) each."""

    footfall: np.ndarray
    wisp: np.ndarray
    grain: np.ndarray


def footfall_number(legs: Legs, falls: Footfalls) -> Ints:
    """A number for each of a walker's footfalls, (n,)."""
    return falls.number * legs.strike.shape[1] + falls.leg


def decode(legs: Legs, owner: Ints, number: Ints) -> Footfalls:
    """The footfalls of these numbers."""
    cycle, leg = np.divmod(number, legs.strike.shape[1])
    return Footfalls(owner, leg, cycle)


def puff_id(legs: Legs, footfall: Ints) -> Ints:
    """What puffs are called."""
    return 1 + (footfall + _earliest(legs)) * _PUFF


def wisp_id(puff: Ints, wisp: Ints) -> Ints:
    """What wisps are called."""
    return puff + 1 + wisp * _WISP


def grain_id(wisp: Ints, grain: Ints) -> Ints:
    """What grains are called."""
    return wisp + 1 + grain


def decode_ids(legs: Legs, part: Ints) -> PartIds:
    """Whose these names of puffs, wisps and grains are."""
    footfall, rest = np.divmod(part - 1, _PUFF)
    wisp, grain = np.divmod(rest - 1, _WISP)
    return PartIds(footfall - _earliest(legs), np.where(rest == 0, -1, wisp), grain - 1)


def _earliest(legs: Legs) -> int:
    return math.ceil(_BEFORE_S / float(legs.period.min())) * legs.strike.shape[1]
