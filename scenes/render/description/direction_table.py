"""Radiance by direction in tables: rows by elevation, columns clockwise from north, evenly."""

import numpy as np


def interpolate(table: np.ndarray, row: np.ndarray, turn: np.ndarray) -> np.ndarray:
    """Interpolate between the four nearest entries of a table (rows, columns, bands), (…, bands).

    ``row`` (…) counts from 0 and stays within the table; ``turn`` (…) is in whole turns.
    drivers/jit.py does the same for Dr.Jit arrays.
    """
    rows, columns = table.shape[:2]
    row, column = np.clip(row, 0, rows - 1), turn % 1.0 * columns
    lower, left = np.floor(row).astype(np.int64), np.floor(column).astype(np.int64)
    up_share, right_share = (row - lower)[..., None], (column - left)[..., None]
    upper, left, right = np.minimum(lower + 1, rows - 1), left % columns, (left + 1) % columns
    below = table[lower, left] * (1 - right_share) + table[lower, right] * right_share
    above = table[upper, left] * (1 - right_share) + table[upper, right] * right_share
    return below * (1 - up_share) + above * up_share


def interpolate_planes(
    table: np.ndarray, plane: np.ndarray, row: np.ndarray, turn: np.ndarray
) -> np.ndarray:
    """Interpolate in a table (planes, rows, columns, bands); ``plane`` (…) counts from 0."""
    planes, rows = table.shape[:2]
    plane, row = np.clip(plane, 0, planes - 1), np.clip(row, 0, rows - 1)
    near_plane = np.floor(plane)
    share, far_plane = (plane - near_plane)[..., None], np.minimum(near_plane + 1, planes - 1)
    flat = table.reshape(planes * rows, *table.shape[2:])  # the last row has none after it
    near, far = (interpolate(flat, each * rows + row, turn) for each in (near_plane, far_plane))
    return near * (1 - share) + far * share


def azimuth(directions: np.ndarray) -> np.ndarray:
    """Azimuth in whole turns clockwise from north, (…, 3) → (…), 0 to 1."""
    return np.arctan2(directions[..., 0], directions[..., 1]) / (2 * np.pi) % 1.0


def row_sine(rows: int, up: np.ndarray) -> np.ndarray:
    """Row of a direction by its sine of elevation, of which rows are middles of even steps."""
    return (up + 1) / 2 * rows - 0.5


def row_sqrt_sine(rows: int, up: np.ndarray) -> np.ndarray:
    """Row of a direction by the root of its sine of elevation, from straight below to straight up.

    Rows are even in that root either way from the horizon: most of them lie where views change
    most.
    """
    return (np.sign(up) * np.sqrt(np.abs(up)) + 1) / 2 * (rows - 1)


def row_upper(rows: int, up: np.ndarray) -> np.ndarray:
    """Row of a direction by the root of its sine of elevation, from the horizon to straight up.

    Most rows lie where the sky changes most.
    """
    return np.sqrt(np.clip(up, 0.0, 1.0)) * (rows - 1)
