"""What is shown to whom: conditions, levels, blocks, and rules of exclusion.

All that is fixed before anyone is asked stands here, and in no other file.
"""

import math
from collections import Counter
from collections.abc import Mapping, Sequence
from functools import cache
from itertools import permutations, product
from typing import Any, NamedTuple

import numpy as np

from bench.observers.psychometric import Staircase

LEVELS_PX = tuple(2.0 ** (k / 2) for k in range(-2, 9))
REFERENCE_PX, CATCH_PX = 0.25, 64.0
"""τ of pruned pictures: ½ to 16 px; of the reference, for a field without end cannot be displayed
whole; and of catch trials, where everyone sees that nearly all is missing."""

TRIALS, CATCHES, BLOCK = 24, 4, 6
"""Trials of the staircase, and catch trials, in each of an observer's conditions: 14 minutes."""

STAIRCASE = Staircase(
    levels=tuple(math.log10(px) for px in LEVELS_PX),
    thresholds=tuple(round(-0.6 + 0.075 * k, 3) for k in range(29)),
    slopes=(1.0, 2.0, 3.0, 4.0, 6.0),
    lapses=(0.01, 0.05),
)

FITTED_LEVELS = (*STAIRCASE.levels, math.log10(CATCH_PX))


def counts(level: np.ndarray, correct: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Count right answers and trials by level, (…, levels) each, of trials (…, trials)."""
    at = level[..., None] == np.arange(len(FITTED_LEVELS))
    return (at & correct[..., None]).sum(axis=-2), at.sum(axis=-2)


SUBJECTS = {"people": "crowd", "trees": "forest", "ground": "badlands", "grass": "meadow"}
"""The preset of every subject."""

PLACES: Mapping[str, Mapping[str, Any]] = {
    "near": {"camera.fov": 60.0, "camera.pitch": -12.0, "air.visibility": "clear"},
    "far": {"camera.fov": 30.0, "camera.pitch": 0.0, "air.visibility": "clear"},
    "hazy": {"camera.fov": 30.0, "camera.pitch": 0.0, "air.visibility": "700m"},
}

WAYS: Mapping[str, Mapping[str, Any]] = {
    "still": {"camera.speed": 0.0},
    "walking, crossfade": {"camera.speed": 1.4},
    "walking, switch": {"camera.speed": 1.4, "view.fade": 0.0},
}
"""Stills stand side by side, clips follow each other; both beside the reference."""

FPS = 24


class Condition(NamedTuple):
    """What is shown, from where, and how it moves and changes: keys of the three tables."""

    subject: str
    place: str
    way: str

    @property
    def name(self) -> str:
        """The name in records and result files: ``trees, far, still``."""
        return f"{self.subject}, {self.place}, {self.way}"

    @property
    def moving(self) -> bool:
        """Whether clips are shown, and not stills."""
        return self.way != "still"


CONDITIONS = tuple(Condition(*each) for each in product(SUBJECTS, PLACES, WAYS))  # all 36, in order

SMALL_SET = tuple(CONDITIONS[k] for k in (0, 1, 2, 12, 18, 33))
"""One block, with which the program is tried: people near in all ways, and other stills."""


@cache
def _balanced(replicate: int) -> tuple[tuple[int, ...], ...]:
    """Deal all conditions into six blocks: two of every place, two of every way, no subject thrice.

    A block leaves out one permutation of places and ways; which subjects it gets is drawn until no
    block has one thrice, with the replicate as the seed.
    """
    rng, cells = np.random.default_rng(replicate), list(product(PLACES, WAYS))
    left_out = [set(zip(PLACES, ways, strict=True)) for ways in permutations(WAYS)]
    while True:
        decks = {cell: list(rng.permutation(list(SUBJECTS))) for cell in cells}
        dealt = [[(decks[c].pop(), *c) for c in cells if c not in out] for out in left_out]
        if all(max(Counter(s for s, *_ in block).values()) <= 2 for block in dealt):
            return tuple(tuple(CONDITIONS.index(Condition(*c)) for c in b) for b in dealt)


def block_of(observer: int, conditions: Sequence[Condition]) -> tuple[int, ...]:
    """Return which of a set's conditions an observer sees, who is numbered from 1.

    Of all 36 conditions every six observers see each once; of a small set everyone sees all.
    """
    if len(conditions) <= BLOCK:
        return tuple(range(len(conditions)))
    return _balanced((observer - 1) // BLOCK)[(observer - 1) % BLOCK]


MOST_CATCHES_MISSED, SHORTEST_MEDIAN_MS = 3, 300
PIXELS_PER_DEGREE, MOST_OFF_DISTANCE = 60.0, 0.2
"""Where observers are asked to sit: so many pixels to a degree."""

EXCLUSIONS = (
    "the session was not finished",
    f"more than {MOST_CATCHES_MISSED} catch trials were missed",
    f"half of the answers came sooner than {SHORTEST_MEDIAN_MS} ms",
    f"the screen was more than {MOST_OFF_DISTANCE:.0%} off {PIXELS_PER_DEGREE:g} pixels a degree",
)
"""Why an observer's answers are not used, in the order in which it is asked. No other reason is."""
