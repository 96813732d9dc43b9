"""What is measured of the leaf appearances of a species of tree, and the CSV file that holds it.

The file is written by ``bench.calibrate.leaf_light`` and ``bench.calibrate.leaf_overlap``, and read
here alone. It has one row for each value: whether the tree is in leaf or bare, the quantity, the
level of detail (0 for the tree as a whole, 1 for a limb, …), and the angle where the quantity
depends on one.
"""

import csv
from collections.abc import Mapping
from dataclasses import dataclass
from importlib.resources.abc import Traversable
from typing import NamedTuple

from lod.errors import InputError
from scenes.sticks.view_angles import AZIMUTHS_DEG, ELEVATIONS_DEG
from scenes.sticks.view_dependence import ElevationTable

FOLIAGE = ("leaf", "bare")
"""Whether a row is of a tree in leaf or without leaves."""

ANGLES_DEG: dict[str, tuple[float | None, ...]] = {
    "albedo_factor": (None,),
    "elevation_area_share": ELEVATIONS_DEG,
    "elevation_albedo_factor": ELEVATIONS_DEG,
    "azimuth_tone": AZIMUTHS_DEG,
    "overlap": (None,),
}
"""Quantities, and the angles at which each has a value, None for one value alone."""

HEADER = ("foliage", "quantity", "level", "angle_deg", "value")


class Row(NamedTuple):
    """One row of the file; ``angle_deg`` is None for a quantity without angles."""

    foliage: str
    quantity: str
    level: int
    angle_deg: float | None
    value: float


@dataclass(frozen=True)
class AppearanceTables:
    """What is measured of the leaf appearances of tree, limb, branch and so on; () for nothing.

    albedo_factor  share of its albedo that a leaf appearance has, so that it sends as much light as
                   what it hides, which shades itself; with ``elevation`` the share at the elevation
                   where it is brightest; by default 1
    elevation      correction by the elevation of the eye; by default none
    azimuth_tone   albedo at AZIMUTHS_DEG between eye and sun, over its mean; by default 1
    overlap        how much of a leaf appearance and of the parts that it stands for lies in one
                   another, half of each shown (``lod.pruning.area_scaling``); by default 0
    """

    albedo_factor: tuple[float, ...] = ()
    elevation: tuple[ElevationTable, ...] = ()
    azimuth_tone: tuple[tuple[float, ...], ...] = ()
    overlap: tuple[float, ...] = ()

    def check(self, file: str, levels: int) -> None:
        """Raise InputError unless every table that is there has one entry for each level."""
        for name in ("albedo_factor", "elevation", "azimuth_tone", "overlap"):
            arrived = len(getattr(self, name))
            if arrived not in (0, levels):
                rule = f"no level or each of the {levels} whose leaf appearances hide parts"
                raise InputError(f"{file}: {name}", f"{arrived} levels", rule, "measure it anew")

    def rows(self, foliage: str) -> list[Row]:
        """Make the rows of the file that hold these tables."""
        columns: dict[str, list[tuple[float, ...]]] = {
            "albedo_factor": [(each,) for each in self.albedo_factor],
            "elevation_area_share": [each.area_share for each in self.elevation],
            "elevation_albedo_factor": [each.albedo_factor for each in self.elevation],
            "azimuth_tone": list(self.azimuth_tone),
            "overlap": [(each,) for each in self.overlap],
        }
        return [
            Row(foliage, quantity, level, angle, value)
            for quantity, levels in columns.items()
            for level, values in enumerate(levels)
            for angle, value in zip(ANGLES_DEG[quantity], values, strict=True)
        ]


def read_tables(file: Traversable) -> dict[str, AppearanceTables]:
    """Read the tables of trees in leaf and of bare trees from a CSV file; empty ones without it.

    Raises InputError that names the file, the line, what arrived and the rule.
    """
    if not file.is_file():
        return {foliage: AppearanceTables() for foliage in FOLIAGE}
    lines = csv.reader(file.read_text("ascii").splitlines())
    if tuple(next(lines, ())) != HEADER:
        rule = f"its first line is {','.join(HEADER)}"
        raise InputError(file.name, "another first line", rule, _CURE)
    rows = [_row(file.name, number, cells) for number, cells in enumerate(lines, 2)]
    values = {(r.foliage, r.quantity, r.level, r.angle_deg): r.value for r in rows}
    return {foliage: _tables(file.name, foliage, values) for foliage in FOLIAGE}


def table_text(tables: Mapping[str, AppearanceTables]) -> str:
    """Write the CSV file of these tables of trees in leaf and of bare trees as text."""
    rows = [row for foliage in FOLIAGE for row in tables[foliage].rows(foliage)]
    lines = [",".join(HEADER), *(_line(row) for row in rows)]
    return "\n".join(lines) + "\n"


_CURE = "write it anew with python -m bench.calibrate.leaf_light and leaf_overlap"

_Values = Mapping[tuple[str, str, int, float | None], float]


def _line(row: Row) -> str:
    angle = "" if row.angle_deg is None else f"{row.angle_deg:g}"
    return f"{row.foliage},{row.quantity},{row.level},{angle},{row.value:g}"


def _row(file: str, number: int, cells: list[str]) -> Row:
    """Read one line of the file, and check it."""
    where = f"{file}: line {number}"
    try:
        foliage, quantity, level, angle, value = cells
        row = Row(foliage, quantity, int(level), float(angle) if angle else None, float(value))
    except ValueError:
        rule = f"{','.join(HEADER)}, the last three numbers"
        raise InputError(where, ",".join(cells), rule, _CURE) from None
    for arrived, known in ((foliage, FOLIAGE), (quantity, tuple(ANGLES_DEG))):
        if arrived not in known:
            raise InputError(where, arrived, f"one of {', '.join(known)}", _CURE)
    if row.angle_deg not in ANGLES_DEG[quantity]:
        angles = ", ".join("none" if a is None else f"{a:g}" for a in ANGLES_DEG[quantity])
        raise InputError(where, angle, f"an angle of {quantity}: {angles}", _CURE)
    return row


def _tables(file: str, foliage: str, values: _Values) -> AppearanceTables:
    """Collect the tables of trees in leaf or of bare trees."""
    columns = {q: _levels(file, foliage, q, values) for q in ANGLES_DEG}
    shares, factors = columns["elevation_area_share"], columns["elevation_albedo_factor"]
    if len(shares) != len(factors):
        rule = f"as many levels as elevation_area_share has, {len(shares)}"
        raise InputError(f"{file}: elevation_albedo_factor", len(factors), rule, _CURE)
    return AppearanceTables(
        tuple(value for (value,) in columns["albedo_factor"]),
        tuple(ElevationTable(*pair) for pair in zip(shares, factors, strict=True)),
        columns["azimuth_tone"],
        tuple(value for (value,) in columns["overlap"]),
    )


def _levels(
    file: str, foliage: str, quantity: str, values: _Values
) -> tuple[tuple[float, ...], ...]:
    """Collect the values of a quantity at its angles, level by level, none left out."""
    mine = {key[2:]: value for key, value in values.items() if key[:2] == (foliage, quantity)}
    levels = range(1 + max((level for level, _ in mine), default=-1))
    for level in levels:
        for angle in ANGLES_DEG[quantity]:
            if (level, angle) not in mine:
                at = "" if angle is None else f" at {angle:g} degrees"
                where = f"{file}: {foliage}, {quantity}, level {level}{at}"
                raise InputError(where, "missing", "a row for each level and angle", _CURE)
    return tuple(tuple(mine[level, angle] for angle in ANGLES_DEG[quantity]) for level in levels)
