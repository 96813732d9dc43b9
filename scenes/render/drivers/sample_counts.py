"""How samples are shared out: exact counts, in groups that keep their strata."""

import math
from functools import lru_cache


@lru_cache(maxsize=64)
def sample_groups(spp: int) -> tuple[int, ...]:
    """Split ``spp`` into counts that the multijitter sampler takes as they are: 7 → (6, 1).

    It lays samples out in isqrt(n) rows, and would round any other count up.
    """
    if spp == 0:
        return ()
    count = next(n for n in range(spp, 0, -1) if n % math.isqrt(n) == 0)
    return (count, *sample_groups(spp - count))


@lru_cache(maxsize=64)
def square_sides(spp: int) -> tuple[int, ...]:
    """Split ``spp`` into few squares and give their sides, largest first: 8 → (2, 2), 16 → (4,)."""
    if spp > 1024:
        side = math.isqrt(spp)
        return (side, *square_sides(spp - side**2))
    best: list[tuple[int, ...]] = [()]
    for n in range(1, spp + 1):
        options = ((*best[n - side**2], side) for side in range(1, math.isqrt(n) + 1))
        best.append(min(options, key=lambda sides: (len(sides), max(sides))))
    return tuple(sorted(best[spp], reverse=True))
