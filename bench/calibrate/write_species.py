"""Writing what is measured of a species of tree to its CSV file, some of its tables at a time."""

from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path
from typing import Any

from scenes.models.trees.appearance_tables import read_tables, table_text
from scenes.models.trees.species_files import species_folder, tree_species
from scenes.sticks.view_dependence import ElevationTable

DECIMALS = {"albedo_factor": 3, "elevation": 2, "azimuth_tone": 2, "overlap": 2}
"""Decimals to which each table is written: no more than other seeds would leave as they are."""


def update_tables(name: str, foliage: str, **tables: Iterable[Any]) -> None:
    """Put tables of a species, measured in leaf or bare, level by level, in the place of those in
    its file, and print the file's path."""
    path = Path(str(species_folder())) / f"{name}.csv"
    known = read_tables(path)
    rounded = {key: tuple(_round(each, DECIMALS[key]) for each in t) for key, t in tables.items()}
    known[foliage] = replace(known[foliage], **rounded)
    path.write_text(table_text(known), encoding="ascii")
    tree_species.cache_clear()
    print(f"{path}: {foliage}: {', '.join(tables)}", flush=True)


def _round(value: Any, decimals: int) -> Any:
    """A number, a row of numbers or an ElevationTable, rounded."""
    if isinstance(value, ElevationTable):
        columns = value.area_share, value.albedo_factor
        return ElevationTable(*(_round(each, decimals) for each in columns))
    if isinstance(value, Iterable):
        return tuple(_round(each, decimals) for each in value)
    return round(float(value), decimals) + 0.0  # no −0
