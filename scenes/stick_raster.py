"""Area that several sticks cover together, seen along a direction: rows sampled, lengths exact.

The outlines are cut by evenly spaced parallel rows; in each row the union of the intervals is measured
exactly, and the area is the sum over rows times their spacing (Cavalieri; midpoint rule). Rows are a
fraction of the sticks' own radius apart, less fine where many sticks average out, which keeps the error
of a composite well under 0.5 %.
"""

import math

import numpy as np
from numba import njit

from lod.arrays import Points
from scenes.stick_table import StickTable

ROWS_PER_RADIUS = 12.0
"""Rows per (area-weighted) mean radius for a single stick; falls with √count, to one row."""

MOST_ROWS = 4096


def areas_of_parts(table: StickTable, directions: Points) -> np.ndarray:
    """Area of the union of each part's sticks along each direction, (n, d) [m²]."""
    columns = (table.start, table.end, table.start_radius, table.end_radius)
    return _areas(table.first, *columns, np.ascontiguousarray(directions))


@njit(cache=True)
def _areas(first, start, end, r0, r1, directions):  # type: ignore[no-untyped-def]
    n = len(first) - 1
    areas = np.zeros((n, len(directions)))
    for j in range(len(directions)):
        across, up = _frame(directions[j])
        x0, y0 = _along(start, across), _along(start, up)
        x1, y1 = _along(end, across), _along(end, up)
        for i in range(n):
            a, b = first[i], first[i + 1]
            if b > a:
                areas[i, j] = _union_area(x0[a:b], y0[a:b], r0[a:b], x1[a:b], y1[a:b], r1[a:b])
    return areas


@njit(cache=True)
def _along(points, axis):  # type: ignore[no-untyped-def]
    out = np.empty(len(points))
    for i in range(len(points)):
        out[i] = points[i, 0] * axis[0] + points[i, 1] * axis[1] + points[i, 2] * axis[2]
    return out


@njit(cache=True)
def _union_area(x0, y0, r0, x1, y1, r1):  # type: ignore[no-untyped-def]
    """Area of a union of convex hulls of two discs each."""
    low, spacing, rows = _rows(x0, y0, r0, x1, y1, r1)
    begin = np.zeros(rows + 1, np.int64)
    for i in range(len(r0)):  # how many outlines cross each row
        a, b = _row_range(y0[i], r0[i], y1[i], r1[i], low, spacing, rows)
        for row in range(a, b):
            begin[row + 1] += 1
    for row in range(rows):
        begin[row + 1] += begin[row]
    left, right = np.empty(begin[-1]), np.empty(begin[-1])
    slot = begin[:-1].copy()
    for i in range(len(r0)):
        a, b = _row_range(y0[i], r0[i], y1[i], r1[i], low, spacing, rows)
        for row in range(a, b):
            y, k = low + (row + 0.5) * spacing, slot[row]
            left[k], right[k] = _interval(y, x0[i], y0[i], r0[i], x1[i], y1[i], r1[i])
            slot[row] = k + 1
    covered = 0.0
    for row in range(rows):
        covered += _union_length(left, right, begin[row], begin[row + 1])
    return covered * spacing


@njit(cache=True)
def _frame(direction):  # type: ignore[no-untyped-def]
    """Two unit vectors across a unit direction (Duff et al., JCGT 6(1), 2017)."""
    x, y, z = direction
    sign = math.copysign(1.0, z)
    a = -1.0 / (sign + z)
    b = x * y * a
    across = np.array((1.0 + sign * x * x * a, sign * b, -sign * x))
    up = np.array((b, sign + y * y * a, -y))
    return across, up


@njit(cache=True)
def _rows(x0, y0, r0, x1, y1, r1):  # type: ignore[no-untyped-def]
    """Lowest edge, spacing and number of the rows."""
    low, high, weight, radius = np.inf, -np.inf, 0.0, 0.0
    for i in range(len(r0)):
        low = min(low, y0[i] - r0[i], y1[i] - r1[i])
        high = max(high, y0[i] + r0[i], y1[i] + r1[i])
        r = 0.5 * (r0[i] + r1[i])
        area = r * (math.hypot(x1[i] - x0[i], y1[i] - y0[i]) + r)
        weight += area
        radius += area * r
    fineness = max(1.0, ROWS_PER_RADIUS / math.sqrt(len(r0)))
    rows = math.ceil((high - low) / (radius / weight) * fineness)
    rows = min(max(rows, 1), MOST_ROWS)
    return low, (high - low) / rows, rows


@njit(cache=True, inline="always")
def _row_range(y0, r0, y1, r1, low, spacing, rows):  # type: ignore[no-untyped-def]
    """First row whose middle lies inside the outline, and the one after the last."""
    bottom, top = min(y0 - r0, y1 - r1), max(y0 + r0, y1 + r1)
    first = max(0, math.ceil((bottom - low) / spacing - 0.5))
    last = min(rows, math.ceil((top - low) / spacing - 0.5))
    return first, max(first, last)


@njit(cache=True)
def _interval(y, x0, y0, r0, x1, y1, r1):  # type: ignore[no-untyped-def]
    """Where the row at height y crosses the convex hull of two discs."""
    left, right = np.inf, -np.inf
    for x, dy, r in ((x0, y - y0, r0), (x1, y - y1, r1)):
        if abs(dy) <= r:
            half = math.sqrt(r * r - dy * dy)
            left, right = min(left, x - half), max(right, x + half)
    ex, ey = x1 - x0, y1 - y0
    apart = math.hypot(ex, ey)
    if apart > abs(r0 - r1):
        ex, ey, sine = ex / apart, ey / apart, (r0 - r1) / apart
        cosine = math.sqrt(1.0 - sine * sine)
        for side in (-cosine, cosine):
            nx, ny = sine * ex - side * ey, sine * ey + side * ex
            ya, yb = y0 + r0 * ny, y1 + r1 * ny
            if (ya <= y) != (yb <= y):
                xa, xb = x0 + r0 * nx, x1 + r1 * nx
                x = xa + (y - ya) / (yb - ya) * (xb - xa)
                left, right = min(left, x), max(right, x)
    if left > right:  # the row only grazes the outline
        return x0, x0
    return left, right


@njit(cache=True)
def _union_length(left, right, a, b):  # type: ignore[no-untyped-def]
    """Length of the union of the intervals a to b; sorts both kinds of end in place."""
    if a == b:
        return 0.0
    _sort(left, a, b)
    _sort(right, a, b)
    # Sweep: the k-th end closes a piece of the union when only k intervals begin before it.
    length, begun = 0.0, left[a]
    for k in range(a, b - 1):
        if right[k] < left[k + 1]:
            length += right[k] - begun
            begun = left[k + 1]
    return length + right[b - 1] - begun


@njit(cache=True)
def _sort(values, a, b):  # type: ignore[no-untyped-def]
    """Sort values[a:b] in place (Shell 1959, gaps of Ciura 2001): few values, quick to compile."""
    for gap in (701, 301, 132, 57, 23, 10, 4, 1):
        for i in range(a + gap, b):
            value, k = values[i], i
            while k >= a + gap and values[k - gap] > value:
                values[k] = values[k - gap]
                k -= gap
            values[k] = value
