"""Objects and displayed parts of two frames woven into one: what still holds, and what is fresh.

A ``source`` says of each object of the new frame which it is: its number in the frame before, or
−1 − its number among the fresh ones.
"""

import numpy as np
from numba import njit


@njit(cache=True)
def stale_cells(until, far, gone, turned):  # type: ignore[no-untyped-def]
    """Cells that no longer hold, in their order."""
    stale, n = np.empty(len(until), np.int64), 0
    for c in range(len(until)):
        if not _holds(until[c, 0], until[c, 1], far[c], gone, turned):
            stale[n] = c
            n += 1
    return stale[:n]


@njit(cache=True)
def _holds(by_distance, by_view, far, gone, turned):  # type: ignore[no-untyped-def]
    return gone < by_distance and gone + turned * far < by_view


@njit(cache=True)
def sources(stale, drawn, kept, until, gone, turned):  # type: ignore[no-untyped-def]
    """The ``source`` of every object, cell by cell; and which of the frame before are examined
    again.

    stale  cells that were drawn anew, ``drawn`` objects of each: the first of the fresh ones; those
           that are examined again follow them
    kept   (c,) objects of each cell in the frame before; until (n, 3) how long each of them holds
    """
    first, total = 0, len(until)
    for i in range(len(stale)):
        first += drawn[i]
        total += drawn[i] - kept[stale[i]]
    source, again = np.empty(total, np.int32), np.empty(len(until), np.int32)
    k, o, i, new, a = 0, 0, 0, 0, 0
    for c in range(len(kept)):
        last = o + kept[c]
        if i < len(stale) and stale[i] == c:
            for _ in range(drawn[i]):
                source[k] = -1 - new
                k, new = k + 1, new + 1
            i, o = i + 1, last
        while o < last:
            source[k] = o
            if not _holds(until[o, 0], until[o, 1], until[o, 2], gone, turned):
                source[k], again[a] = -1 - (first + a), o
                a += 1
            k, o = k + 1, o + 1
    return source, again[:a]


@njit(cache=True)
def woven(source, found, old, fresh_found, fresh):  # type: ignore[no-untyped-def]
    """Displayed parts of all objects, in the objects' order: object, row in the atlas, row of the
    whole, and level.

    found (n, 2) parts shown and examined of each object of the frame before, whose columns are
          ``old``; so too the fresh
    """
    old_at, new_at = _starts(found), _starts(fresh_found)
    total = 0
    for s in source:
        total += found[s, 0] if s >= 0 else fresh_found[-1 - s, 0]
    object_, part = np.empty(total, np.int32), np.empty(total, np.int32)
    whole, level = np.empty(total, np.int32), np.empty(total, np.int16)
    k, n = 0, 0
    while k < len(source):
        s, one, last = source[k], 1 if source[k] >= 0 else -1, k + 1
        while last < len(source) and source[last] == source[last - 1] + one:
            last += 1
        number = s if s >= 0 else -1 - s
        at, columns = (old_at, old) if s >= 0 else (new_at, fresh)
        a, b = at[number], at[number + last - k]
        m = n + b - a
        _moved(columns[0][a:b], object_[n:m], k - number)
        part[n:m] = columns[1][a:b]
        _moved(columns[2][a:b], whole[n:m], n - a)
        level[n:m] = columns[3][a:b]
        k, n = last, m
    return object_, part, whole, level


@njit(cache=True)
def picked(source, old, fresh):  # type: ignore[no-untyped-def]
    """Rows (n, k) of all objects in a table of the frame before, or in that of the fresh ones."""
    rows = np.empty((len(source), old.shape[1]), old.dtype)
    for i in range(len(source)):
        s = source[i]
        for k in range(old.shape[1]):
            rows[i, k] = old[s, k] if s >= 0 else fresh[-1 - s, k]
    return rows


@njit(cache=True)
def _starts(found):  # type: ignore[no-untyped-def]
    """Where the parts of each object begin, laid end to end; and the end."""
    at = np.zeros(len(found) + 1, np.int64)
    for i in range(len(found)):
        at[i + 1] = at[i] + found[i, 0]
    return at


@njit(cache=True)
def _moved(rows, out, by):  # type: ignore[no-untyped-def]
    """Numbers moved on; −1, which is none, stays."""
    step = np.int32(by)
    for i in range(len(rows)):
        out[i] = rows[i] + step if rows[i] >= 0 else rows[i]
