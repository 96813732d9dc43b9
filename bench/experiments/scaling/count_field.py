"""How many objects and parts has one field of a case, by the real field and the real pruner?"""

import numpy as np

from bench.fields.cases import Case
from bench.fields.scene import KEPT, field_seed, ground_of, prototypes_of, view_of
from bench.records.provenance import scene_digest
from bench.records.records import Point
from bench.statistics.samples import Row
from lod.pruner import Cut, prune
from scenes.field.species_field import Species, SpeciesField

COLUMNS = ("objects", "parts", "objects_examined", "parts_examined")
"""What is counted in a field, displayed and examined, in the order of a row."""

_GAMMA = np.uint64(0x9E3779B97F4A7C15)
_MIX = np.uint64(0xBF58476D1CE4E5B9), np.uint64(0x94D049BB133111EB)


def count_field(case: Case, seed: int) -> Row:
    """Count one field, in the order of COLUMNS."""
    cuts = [prune(each, view_of(case)) for each in fields_of(case, seed)]
    kept = [left(case, cut, seed) for cut in cuts]
    objects, parts = (sum(each) for each in zip(*kept, strict=True))
    examined = [(cut.examined_objects, cut.examined_parts) for cut in cuts]
    return objects, parts, *(sum(each) for each in zip(*examined, strict=True))


def fields_of(case: Case, seed: int) -> list[SpeciesField]:
    """Build a field for each species of a case; its density is shared evenly among them.

    Where objects are gathered unevenly the fields are denser, because ``left`` drops some objects.
    """
    names = case.species.split("+")
    K, ground = case.density / KEPT[case.gathered] / len(names), ground_of(case)
    return [
        SpeciesField(Species(name, prototypes_of(name, case.size), K), seed, ground, case.extent)
        for name in names
    ]


def left(case: Case, cut: Cut, seed: int) -> tuple[int, int]:
    """Count the objects and the parts of a cut that remain after thinning."""
    if case.gathered == "evenly":
        return cut.displayed_objects, cut.displayed_parts
    parts = cut.parts
    roots = np.flatnonzero(parts.parent < 0)
    keep = np.zeros(int(parts.object.max(initial=-1)) + 1, bool)
    keep[parts.object[roots]] = stands(case, parts.position[roots, :2], seed)
    return int(keep.sum()), int(keep[parts.object].sum())


def stands(case: Case, xy: np.ndarray, seed: int) -> np.ndarray:
    """Say which objects at these places [m] remain after thinning, (n,).

    The choice is independent for each object, or for each patch. A Poisson field may be thinned
    after pruning as well as before.
    """
    rng = np.random.Generator(np.random.Philox(seed))
    if case.gathered == "patches":
        cell = np.floor(xy / case.scale + rng.random(2)).astype(np.int64)
        return chance(seed, cell) < KEPT["patches"]
    if case.gathered == "slope":
        share = (1 + np.clip(xy[:, 0] / case.scale, -1, 1)) / 2
    else:
        share = np.minimum(np.hypot(xy[:, 0], xy[:, 1]) / case.scale, 1.0)
    return rng.random(len(xy)) < share


def chance(seed: int, cells: np.ndarray) -> np.ndarray:
    """Return a number in [0, 1) for each cell (n, 2), always the same for a seed and a cell.

    It is SplitMix64 (Steele, Lea & Flood, "Fast splittable pseudorandom number generators", OOPSLA
    2014).
    """
    word = np.full(len(cells), seed, np.uint64)
    with np.errstate(over="ignore"):
        for column in cells.T:
            word = (word ^ column.astype(np.uint64)) + _GAMMA
            word = (word ^ (word >> np.uint64(30))) * _MIX[0]
            word = (word ^ (word >> np.uint64(27))) * _MIX[1]
            word ^= word >> np.uint64(31)
    return np.asarray((word >> np.uint64(11)) * 2.0**-53)


def seed_of(case: Case, seed: int, index: int) -> int:
    """Return a field's own seed, in 63 bits, independent for every case, run seed and index."""
    return field_seed(case.as_json(), seed, index)


def scene_hash(points: tuple[Point, ...]) -> str:
    """Return the SHA-256 of every case and of every prototype's hierarchy."""
    cases = [Case(**point.case) for point in points]
    species = sorted({name for case in cases for name in case.species.split("+")})
    names = ("parent", "level", "position", "P", "R", "B", "separation")
    trees = [each.hierarchy for kind in species for each in prototypes_of(kind, 1.0)]
    arrays = (getattr(tree, name) for tree in trees for name in names)
    return scene_digest([case.as_json() for case in cases], arrays)
