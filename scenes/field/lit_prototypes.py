"""Prototypes whose leaf appearances shine as what they hide does in a world's light.

Prototypes of one species that look the same but for their size are fitted once, and all of a
species together: one table of tones stands for them (``scenes.sticks.appearance.tone``).
"""

from dataclasses import replace
from functools import lru_cache

import numpy as np

from scenes.field.part_tables import PartTables
from scenes.processes.content_key import content_key
from scenes.rig.rigged_prototype import RiggedPrototype, rigged
from scenes.sticks.appearance.tone import Illumination, fit_tone
from scenes.sticks.prototype import Prototype


@lru_cache(maxsize=32)
def lit_part_tables(
    prototypes: tuple[Prototype | RiggedPrototype, ...], illumination: Illumination
) -> PartTables:
    """Lay prototypes end to end, with the tones of their leaf appearances in that light.

    Those without shapes that look otherwise from elsewhere stay as they are.
    """
    kinds = {_look(each): each for each in prototypes}
    objects = [each for each in kinds.values() if len(each.view_dependence.area_share)]
    if objects:
        at_rest = [each.posed() if isinstance(each, RiggedPrototype) else each for each in objects]
        tone = fit_tone(at_rest, illumination)
        prototypes = tuple(_toned(each, tone) for each in prototypes)
    return PartTables.of(tuple(map(rigged, prototypes)))


def _look(prototype: Prototype | RiggedPrototype) -> str:
    """Name what prototypes that differ by their size alone have in common."""
    views = prototype.view_dependence
    return content_key(views.table_row, views.area_share)


def _toned(prototype: Prototype | RiggedPrototype, tone: np.ndarray) -> Prototype | RiggedPrototype:
    levels = len(prototype.view_dependence.area_share)
    views = replace(prototype.view_dependence, tone=tone[:levels])
    return replace(prototype, view_dependence=views)
