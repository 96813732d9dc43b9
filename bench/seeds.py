"""Which worlds are for building, and which for judging? A rule, so that nobody tunes on a test.

Worlds and prototypes of seeds up to BUILDING_SEEDS may be looked at, measured and tuned on at will;
quick runs look at some of those. Full runs judge worlds from JUDGED_SEED on, which no constant of
the program was fitted to: every experiment has a series of its own there.
"""

JUDGED_SEED = 4100  # the first seed of a world that is judged

BUILDING_SEEDS = 1000
"""The largest seed of a world that may be looked at while a scene or its pruning is built."""

QUICK_SEED = 900  # the first seed of a world that quick runs look at
_SERIES = 1000  # how far the series of two experiments are apart among judged seeds


def first_seed(unseen: bool, series: int = 0) -> int:
    """Return the first seed of a series of worlds: of those for judging, or for a trial."""
    return JUDGED_SEED + _SERIES * series if unseen else QUICK_SEED
