"""Standing people: the stick figure of figs 1 and 2, down to the finger joints.

The origin of the person (and of its torso) is the pelvis; R of the person is the reach from there.
Every other part's origin is the joint at its near end. The person faces +x, both soles on z = 0.

Leaf appearances stand for what they hide (§2.4): their radii are fitted so that the mean area over
directions is that of everything hidden. The blob is an upright stick with round ends, as high as
the person. A part without a body of its own keeps, as an inner node, its leaf appearance thinned
(the person, a few such sticks of its own): a core hidden inside its parts, which shows only where
one of them is not displayed.
"""

from functools import lru_cache

import numpy as np

from lod.errors import InputError
from scenes.figure_looks import Person, person
from scenes.figure_skeleton import Frame, both_sides, parts, side_of, skeleton
from scenes.figure_sticks import (
    BUST,
    LONG_HAIR,
    PERSON_CORE,
    SIDE_BODY,
    SIDE_LEAF,
    TRUNK_BODY,
    TRUNK_LEAF,
)
from scenes.figure_tables import STANDING, Rod
from scenes.prototype import Prototype, assemble
from scenes.stick_area import mean_area, mean_outline_areas
from scenes.stick_table import StickTable

CORE = 0.75
"""Radius of the hidden core, as a share of the leaf appearance's."""

_STREAM = 0xF16


@lru_cache(maxsize=16)
def figure_prototypes(seed: int, count: int) -> tuple[Prototype, ...]:
    """``count`` standing people; the k-th depends on the seed and on k only."""
    if count < 1:
        raise InputError("species.figure.prototypes", count, "at least one prototype")
    return tuple(_figure(seed, k) for k in range(count))


def _figure(seed: int, k: int) -> Prototype:
    who = person(np.random.Generator(np.random.Philox(np.random.SeedSequence((seed, _STREAM, k)))))
    frames = skeleton(STANDING, {"shoulder": who.shoulders, "hip": who.hips})
    named = parts()
    names = list(named)
    row = {name: i for i, name in enumerate(names)} | {"": -1}
    whole = np.array([row[part.whole] for part in named.values()])
    body = _sticks(_bodies(who), row, frames, who)
    lift = -_lowest(body)
    body = _moved(body, lift)
    given = _moved(_sticks(both_sides(TRUNK_LEAF, SIDE_LEAF), row, frames, who), lift)
    core = _moved(_sticks({"person": PERSON_CORE}, row, frames, who), lift)
    full = _under(whole, body)
    leaf, tints = _leaves(given, body, full, who)
    origin = np.array([frames[part.joint].origin for part in named.values()]) * who.stature
    origin[:, 2] += lift
    return assemble(
        name=f"figure {k}",
        whole=whole,
        level=np.array([part.level for part in named.values()]),
        origin=origin,
        inner=_inner(whole, body, leaf, core),
        leaf=leaf,
        tints=tints,
    )


def _bodies(who: Person) -> dict[str, list[Rod]]:
    """What every part looks like by itself, bust and long hair where this person has them."""
    table = both_sides(TRUNK_BODY, SIDE_BODY)
    table["chest"] = table["chest"] + (BUST if who.bust else [])
    table["cranium"] = table["cranium"] + (LONG_HAIR if who.long_hair else [])
    return table


def _sticks(
    table: dict[str, list[Rod]], row: dict[str, int], frames: dict[str, Frame], who: Person
) -> StickTable:
    """The rods of a table as posed sticks [m]."""
    material = {name: i for i, name in enumerate(who.materials)}
    columns: list[tuple] = []
    for name, rods in table.items():
        side, _ = side_of(name)
        for rod in rods:
            for mirror in (side, -side) if rod.pair else (side,):
                ends = (_placed(frames[rod.joint], end, mirror) for end in (rod.start, rod.end))
                radii = rod.start_radius * who.girth, rod.end_radius * who.girth
                columns.append((row[name], *ends, *radii, material[rod.material]))
    owner, start, end, start_radius, end_radius, tint = zip(*columns, strict=True)
    return StickTable.of(
        len(row) - 1,
        np.array(owner),
        np.array(start) * who.stature,
        np.array(end) * who.stature,
        np.array(start_radius) * who.stature,
        np.array(end_radius) * who.stature,
        np.array(tint),
    )


def _placed(frame: Frame, point: tuple[float, float, float], mirror: float) -> np.ndarray:
    x, y, z = point
    return frame.origin + frame.turn @ np.array((x, mirror * y, z))


def _lowest(table: StickTable) -> float:
    start = table.start[:, 2] - table.start_radius
    return float(min(start.min(), (table.end[:, 2] - table.end_radius).min()))


def _moved(table: StickTable, up: float) -> StickTable:
    shift = np.array((0.0, 0.0, up))
    return StickTable(
        table.first,
        table.start + shift,
        table.end + shift,
        table.start_radius,
        table.end_radius,
        table.tint,
    )


def _under(whole: np.ndarray, body: StickTable) -> StickTable:
    """For every part, the bodies of itself and of everything below it."""
    owner, stick = body.owner, np.arange(len(body))
    owners, sticks = [owner], [stick]
    while True:
        above = whole[owner]
        owner, stick = above[above >= 0], stick[above >= 0]
        if not len(owner):
            break
        owners.append(owner)
        sticks.append(stick)
    return _chosen(body, np.concatenate(sticks), np.concatenate(owners), len(whole))


def _chosen(table: StickTable, stick: np.ndarray, owner: np.ndarray, n: int) -> StickTable:
    names = ("start", "end", "start_radius", "end_radius", "tint")
    return StickTable.of(n, owner, *(getattr(table, name)[stick] for name in names))


def _leaves(
    given: StickTable, body: StickTable, full: StickTable, who: Person
) -> tuple[StickTable, np.ndarray]:
    """Leaf appearances: the blob; those given, fitted to what they hide; the rest as they are."""
    n = len(full.first) - 1
    has = given.count > 0
    fitted = _fitted(given, mean_area(full), has)
    plain = np.flatnonzero(~has[body.owner] & (body.owner > 0))
    blob, blob_tint = _blob(full, np.array(list(who.materials.values())))
    tints = np.concatenate((np.array(list(who.materials.values())), blob_tint[None]))
    pieces = ((fitted, np.arange(len(fitted))), (body, plain))
    columns = [
        np.concatenate([blob_value[None], *(getattr(table, name)[rows] for table, rows in pieces)])
        for name, blob_value in blob.items()
    ]
    owner = np.concatenate(([0], *(table.owner[rows] for table, rows in pieces)))
    return StickTable.of(n, owner, *columns), tints


def _fitted(given: StickTable, target: np.ndarray, has: np.ndarray, rounds: int = 4) -> StickTable:
    """The same sticks, each part's radii scaled alike so that its mean area is the target [m²]."""
    rows = np.flatnonzero(has)
    factor = np.ones(len(has))
    for _ in range(rounds):
        table = _thickened(given, factor)
        # Area grows almost in proportion to the radius of a slender stick: a fixed-point step
        # converges.
        factor[rows] *= target[rows] / mean_area(table)[rows]
    return _thickened(given, factor)


def _thickened(table: StickTable, factor: np.ndarray) -> StickTable:
    scale = factor[table.owner]
    radii = table.start_radius * scale, table.end_radius * scale
    return StickTable(table.first, table.start, table.end, *radii, table.tint)


def _blob(full: StickTable, materials: np.ndarray) -> tuple[dict[str, np.ndarray], np.ndarray]:
    """The person as one upright stick, and its tint: the mean of the body's, by outline area.

    A stick of even radius r and height h over all has mean area S/4 = π·r·h/2.
    """
    own = slice(full.first[0], full.first[1])
    start, end = full.start[own], full.end[own]
    height = max(
        (start[:, 2] + full.start_radius[own]).max(), (end[:, 2] + full.end_radius[own]).max()
    )
    radius = 2 * mean_area(full)[0] / (np.pi * height)
    weight = mean_outline_areas(full)[own]
    tint = (weight[:, None] * materials[full.tint[own]]).sum(axis=0) / weight.sum()
    blob = {
        "start": np.array((0.0, 0.0, radius)),
        "end": np.array((0.0, 0.0, height - radius)),
        "start_radius": np.array(radius),
        "end_radius": np.array(radius),
        "tint": np.array(len(materials)),
    }
    return blob, tint


def _inner(whole: np.ndarray, body: StickTable, leaf: StickTable, person: StickTable) -> StickTable:
    """Bodies of the parts that own parts; a thinned core where there is no body."""
    n = len(whole)
    owns = np.zeros(n, bool)
    owns[whole[whole >= 0]] = True
    kept = np.flatnonzero(owns[body.owner])
    cores = owns & (body.count == 0)
    cores[0] = False
    core = np.flatnonzero(cores[leaf.owner])
    pieces = ((person, np.arange(len(person)), 1.0), (body, kept, 1.0), (leaf, core, CORE))
    columns = [
        np.concatenate(
            [
                getattr(t, name)[rows] * (share if "radius" in name else 1)
                for t, rows, share in pieces
            ]
        )
        for name in ("start", "end", "start_radius", "end_radius", "tint")
    ]
    owner = np.concatenate([t.owner[rows] for t, rows, _ in pieces])
    columns[-1] = columns[-1].astype(np.int64)
    return StickTable.of(n, owner, *columns)
