"""Numbers of the parts of a trail of dust: one whole number for each, 0 for the trail."""

import math
from typing import NamedTuple

import numpy as np

from lod.arrays import Ints
from scenes.dust.footfalls import Footfalls, Legs
from scenes.dust.growth import GRAINS, WISPS

_BEFORE_S = 1e4
"""Time before 0 from which on footfalls have numbers above 0 [s]."""

_PUFF, _WISP = 1 + WISPS * (1 + GRAINS), 1 + GRAINS


class PartIds(NamedTuple):
    """Footfall, wisp and grain of each part, (n,) each; −1 where it is none."""

    footfall: np.ndarray
    wisp: np.ndarray
    grain: np.ndarray


def footfall_number(legs: Legs, falls: Footfalls) -> Ints:
    """Number of each footfall among those of its walker, (n,)."""
    return falls.number * legs.strike.shape[1] + falls.leg


def decode(legs: Legs, owner: Ints, number: Ints) -> Footfalls:
    """Decode footfalls of walkers by their numbers; the inverse of ``footfall_number``."""
    cycle, leg = np.divmod(number, legs.strike.shape[1])
    return Footfalls(owner, leg, cycle)


def puff_id(legs: Legs, footfall: Ints) -> Ints:
    """Compute the part numbers of the puffs of footfalls, (n,)."""
    return 1 + (footfall + _earliest(legs)) * _PUFF


def wisp_id(puff: Ints, wisp: Ints) -> Ints:
    """Compute the part numbers of wisps of puffs, (n,)."""
    return puff + 1 + wisp * _WISP


def grain_id(wisp: Ints, grain: Ints) -> Ints:
    """Compute the part numbers of grains of wisps, (n,)."""
    return wisp + 1 + grain


def decode_ids(legs: Legs, part: Ints) -> PartIds:
    """Decode footfall, wisp and grain of parts by their numbers."""
    footfall, rest = np.divmod(part - 1, _PUFF)
    wisp, grain = np.divmod(rest - 1, _WISP)
    return PartIds(footfall - _earliest(legs), np.where(rest == 0, -1, wisp), grain - 1)


def _earliest(legs: Legs) -> int:
    return math.ceil(_BEFORE_S / float(legs.period.min())) * legs.strike.shape[1]
