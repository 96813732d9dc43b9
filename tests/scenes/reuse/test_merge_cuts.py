"""Two frames woven into one, against the same done object by object with lists."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from scenes.reuse.merge_cuts import picked, sources, woven


def columns_of(parts, rng):
    """Rows of objects of so many parts each: object, part, row of the whole, level."""
    owner = np.repeat(np.arange(len(parts)), parts).astype(np.int32)
    first = np.repeat(np.cumsum(parts) - parts, parts)
    inside = np.arange(len(owner)) - first
    whole = np.where(inside == 0, -1, first + (inside * rng.random(len(owner))).astype(int))
    part, level = rng.integers(0, 1000, len(owner)), rng.integers(0, 9, len(owner))
    return owner, part.astype(np.int32), whole.astype(np.int32), level.astype(np.int16)


def told(columns, number):
    """One object's rows: parts, levels, and wholes from its own first row on."""
    owner, part, whole, level = columns
    rows = np.flatnonzero(owner == number)
    return [(part[r], level[r], whole[r] - rows[0] if whole[r] >= 0 else -1) for r in rows]


@given(seed=st.integers(0, 2**32 - 1), cells=st.integers(0, 9))
@settings(max_examples=60, deadline=None)
def test_weaving_is_what_lists_say(seed, cells):
    rng = np.random.default_rng(seed)
    kept = rng.integers(0, 4, cells).astype(np.int32)
    stale = np.flatnonzero(rng.random(cells) < 0.4)
    drawn = rng.integers(0, 4, len(stale)).astype(np.int32)
    n, gone, turned = int(kept.sum()), 1.0, 0.1
    until = rng.choice([0.5, 2.0, np.inf], (n, 3), p=[0.1, 0.5, 0.4])
    until[:, 2] = rng.choice([1.0, 50.0], n, p=[0.8, 0.2])
    source, again = sources(stale, drawn, kept, until, gone, turned)
    holds = (gone < until[:, 0]) & (gone + turned * until[:, 2] < until[:, 1])
    wanted, fresh, first = [], iter(range(int(drawn.sum()))), np.cumsum(kept) - kept
    for c in range(cells):
        if c in stale:
            wanted += [("fresh", next(fresh)) for _ in range(drawn[list(stale).index(c)])]
        else:
            wanted += [
                ("old" if holds[o] else "again", o) for o in range(first[c], first[c] + kept[c])
            ]
    late = {o: int(drawn.sum()) + k for k, o in enumerate(again.tolist())}
    assert [late[o] for kind, o in wanted if kind == "again"] == sorted(late.values())
    numbers = [
        o if kind == "old" else -1 - (late[o] if kind == "again" else o) for kind, o in wanted
    ]
    assert source.tolist() == numbers

    table, fresh_table = np.arange(2 * n).reshape(n, 2), -np.arange(2 * n + 98).reshape(-1, 2) - 1
    rows = [table[s] if s >= 0 else fresh_table[-1 - s] for s in numbers]
    assert np.array_equal(picked(source, table, fresh_table), np.reshape(rows, (-1, 2)))

    found, others = (
        np.stack((rng.integers(0, 5, k), np.zeros(k, int)), axis=1).astype(np.int32)
        for k in (n, int(drawn.sum()) + len(again))
    )
    old, new = columns_of(found[:, 0], rng), columns_of(others[:, 0], rng)
    joined = woven(source, found, old, others, new)
    assert np.all(np.diff(joined[0]) >= 0) and len(joined[0]) == len(joined[3])
    for k, s in enumerate(numbers):
        assert told(joined, k) == (told(old, s) if s >= 0 else told(new, -1 - s))
