"""A field's cut from that of the frame before: only what may have changed is examined again.

Every comparison holds until the eye has gone as far as its slack (``lod.comparison.slack``). A cell
holds as long as the least of its own, of its objects' and of all their parts', in steps of the eye
added up; where things walk, their own steps are added to the eye's. What is left is examined anew
by the same walks, and woven into what held: the same cut as from scratch, to the last bit.

A ``Hold`` is used up by the frame that goes on from it: its buffers become the next one's.
"""

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numba import njit

from lod.comparison import into_view, vantage_of
from lod.parts import Parts
from lod.prune import Cut
from lod.view import View
from scenes.cells import Draws, away_in_plan, near_enough
from scenes.field import SpeciesField
from scenes.rig_cast import Bodies
from scenes.rig_lift import lift, pace_most
from scenes.troupe import Objects
from scenes.walk import Held, Rows, limits_of, walk

FARTHEST_M, FARTHEST_WALKING_M = 32.0, 2.0
"""Nothing is said to hold for longer than so many metres; the ground rises under who walks."""

_ROUNDING_M, _USUAL_STEP_M = 1e-6, 0.05


@dataclass(eq=False)
class Hold:
    """What is known of a field from the frame before; cells row by row of those searched.

    view     of that frame; limits (2, m) of all parts, and the span of cells, that it holds for
    gone     steps of the eye, and of what walks, since this hold began [m]; step: the last one;
             turned: of its axes
    until    (c, 2) ``gone`` until which a cell holds by distance, and by view, for each radian that
             the axes turn the last column [m]; far (c,) that column: more than anything is away
    counts   (c, 4) of each cell: objects in the window, objects kept, parts shown, parts examined
    totals   of them (4,)
    order    (n,) row of each kept object in ``pool``: objects as they were drawn, and their bodies
    rows     displayed parts
    """

    view: View
    limits: np.ndarray
    spans: tuple[int, int, int, int]
    gone: float
    step: float
    turned: float
    until: np.ndarray
    far: np.ndarray
    counts: np.ndarray
    totals: np.ndarray
    order: np.ndarray
    pool: list[Objects]
    rows: Rows


def cut_after(field: SpeciesField, view: View, before: Hold | None) -> tuple[Cut, Hold | None]:
    """What of a field is displayed, as ``prune`` finds it; and what the next frame may go on from.

    Where motion hides detail, or depth along the axis is what counts, every frame is pruned from
    scratch.
    """
    if view.exposure is not None or view.metric.along_axis:
        return field.walk(view), None
    hold = _moved(field, view, before)
    stale = _stale(hold.until, hold.far, hold.gone, hold.turned)
    _examine(field, hold, stale)
    return _cut(field, hold), hold


def _moved(field: SpeciesField, view: View, before: Hold | None) -> Hold:
    """The hold of the frame before as this one has it; a new one where that is of no use."""
    limits = np.stack(field.troupe.atlas.limits(view))
    spans = field.search(view)[0]
    if before is None or not _fits(before, view, limits, spans):
        cells = max(spans[1] - spans[0], 0) * max(spans[3] - spans[2], 0)
        none = np.zeros(0, np.int32)
        never, none = np.full((cells, 2), -np.inf), np.zeros(0, np.int32)
        counts, rows = np.zeros((cells, 4), np.int32), Rows(none, none, none, 0)
        began = (view, limits, spans, 0.0, _USUAL_STEP_M, 0.0)
        return Hold(*began, never, np.zeros(cells), counts, counts.sum(axis=0), none, [], rows)
    a, b = before.view, view
    step = float(np.linalg.norm(b.camera.eye - a.camera.eye)) + _ROUNDING_M
    walked = pace_most(field.troupe.rigged) if field.species.patrol_m else 0.0
    step += walked * abs(b.time_s - a.time_s)
    axes = ("forward", "right", "up")
    turn = sum(float(np.linalg.norm(getattr(b.camera, k) - getattr(a.camera, k))) for k in axes)
    return replace(
        before, view=view, gone=before.gone + step, step=step, turned=before.turned + turn
    )


def _fits(before: Hold, view: View, limits: np.ndarray, spans: tuple[int, ...]) -> bool:
    was = before.view
    return (
        was.camera.corner == view.camera.corner
        and was.camera.tan_half == view.camera.tan_half
        and was.look_around == view.look_around
        and before.spans == spans
        and np.array_equal(before.limits, limits)
    )


@njit(cache=True)
def _stale(until, far, gone, turned):  # type: ignore[no-untyped-def]
    """Cells that no longer hold, in their order."""
    stale, n = np.empty(len(until), np.int64), 0
    for c in range(len(until)):
        if not (gone < until[c, 0] and gone + turned * far[c] < until[c, 1]):
            stale[n] = c
            n += 1
    return stale[:n]


def _examine(field: SpeciesField, hold: Hold, stale: np.ndarray) -> None:
    """Examine stale cells anew, and weave what they hold now into the rest."""
    counts, room = np.zeros((len(stale), 4), np.int32), np.full((len(stale), 2), math.inf)
    near, of_objects, far = _search(field, hold, stale, room)
    objects = _drawn(field, hold.view, near, of_objects)
    most, rise = FARTHEST_M, 0.0
    if field.moves:
        most, rise = FARTHEST_WALKING_M, lift(field.troupe.cast, field.ground, FARTHEST_WALKING_M)
    of_parts, rows = _walked(field, hold, objects, rise)
    _by_cell(near[0], of_objects, of_parts, room, counts)
    first = sum(len(each) for each in hold.pool)
    woven = _woven(stale, counts, hold.counts, hold.order, hold.rows[:3], rows[:3], first)
    hold.order, shown, part, whole = woven
    hold.rows = Rows(shown, part, whole, 0)
    hold.totals = hold.totals + counts.sum(axis=0) - hold.counts[stale].sum(axis=0)
    hold.counts[stale], hold.far[stale] = counts, far + rise
    room = np.minimum(room, most) - 100 * _ROUNDING_M
    room[:, 1] += hold.turned * hold.far[stale]
    hold.until[stale] = hold.gone + room
    hold.pool.append(objects)
    if first > 2 * len(hold.order) + 1000:
        hold.pool, hold.order = [_taken(hold)], np.arange(len(hold.order), dtype=np.int32)


Near = tuple[np.ndarray, np.ndarray, np.ndarray]
"""Cells near enough: their rows among those that are stale, and their x and y."""


def _search(
    field: SpeciesField, hold: Hold, stale: np.ndarray, room: np.ndarray
) -> tuple[Near, np.ndarray, np.ndarray]:
    """Which stale cells are near enough, and ``held`` of their objects; more than anything of each
    stale cell is away. Slack of that into ``room``.
    """
    (x0, x1, y0, _), lattice, rules = field.search(hold.view)
    reach = field.near(hold.view)
    spread = float(field.troupe.slots.spread.max()) + 2 * FARTHEST_M + reach.high - reach.low
    x, y = x0 + stale % (x1 - x0), y0 + stale // (x1 - x0)
    is_near, far = _searched(x, y, vantage_of(hold.view), lattice, rules, spread, room)
    near = np.flatnonzero(is_near)
    return (near, x[near], y[near]), np.zeros((len(near), 4)), far


def _drawn(field: SpeciesField, view: View, near: Near, held: np.ndarray) -> Objects:
    """The objects of near cells that could be displayed, and ``held`` of each cell's."""
    corner, vantage, (_, x, y) = view.camera.corner, vantage_of(view), near
    draws, _ = field.cells.near(x, y, corner, vantage, field.near(view), held)
    grown = field.grown(corner, draws)
    cell = np.repeat(np.arange(len(held)), held[:, 1].astype(np.int64))[grown]
    held[:, 1] = np.bincount(cell, minlength=len(held))
    objects = field.seen(draws.take(grown), view)
    if not field.moves and field.troupe.cast.most_legs:
        bodies = objects.bodies
        room = field.troupe.heed_slack(view, bodies.origin[:, :2], bodies.variant)
        np.minimum.at(held[:, 2], cell, room)
    return objects


def _walked(
    field: SpeciesField, hold: Hold, objects: Objects, rise: float
) -> tuple[np.ndarray, Rows]:
    """Parts displayed of these objects, and ``held`` of each."""
    troupe, held = field.troupe, np.zeros((len(objects), 4))
    limits = limits_of(troupe.slots, troupe.atlas, hold.view, 0.0)
    asked = Held(held, not field.moves, rise, hold.step)
    bodies, smear = objects.bodies, objects.smear
    return held, walk(troupe.cast, troupe.slots, limits, bodies, smear, hold.view, asked)


@njit(cache=True)
def _searched(cell_x, cell_y, vantage, lattice, rules, spread, room):  # type: ignore[no-untyped-def]
    """Which of the cells are near enough; more than anything of them is away (n,); and into
    ``room`` (n, 2) the slack of that, by distance and by view.
    """
    ix, iy, rest_x, rest_y, side = lattice
    _, inside, outside, lean, above, middle, radius = rules
    is_near, away = np.empty(len(cell_x), np.bool_), np.empty(len(cell_x))
    for i in range(len(cell_x)):
        east, north = (cell_x[i] - ix + 0.5) * side - rest_x, (cell_y[i] - iy + 0.5) * side - rest_y
        is_near[i] = near_enough(vantage, east, north, side, rules)
        near = away_in_plan(vantage, east, north, side)
        far = math.hypot(max(near - lean, 0.0), above)
        away[i] = near + 2 * side + 2 * lean + above + spread
        room[i, 0], room[i, 1] = abs(inside - far), math.inf
        if above >= inside:
            room[i, 0] = 0.0
        elif not vantage.look_around and not far > inside:
            if not far > outside:
                room[i, 0] = outside - far
            else:
                within = into_view(vantage, east, north, middle)
                room[i, 1] = abs(within + radius)
                if not is_near[i]:
                    room[i, 0] = far - outside
    return is_near, away


@njit(cache=True)
def _by_cell(near, of_objects, of_parts, room, counts):  # type: ignore[no-untyped-def]
    """What objects and their parts say, cell by cell: the least of their slacks, and counts."""
    first = 0
    for i in range(len(near)):
        c = near[i]
        counts[c, 0], counts[c, 1] = of_objects[i, 0], of_objects[i, 1]
        room[c, 0] = min(room[c, 0], of_objects[i, 2])
        room[c, 1] = min(room[c, 1], of_objects[i, 3])
        for o in range(first, first + counts[c, 1]):
            counts[c, 2] += of_parts[o, 0]
            counts[c, 3] += of_parts[o, 1]
            room[c, 0] = min(room[c, 0], of_parts[o, 2])
            room[c, 1] = min(room[c, 1], of_parts[o, 3])
        first += counts[c, 1]


@njit(cache=True)
def _woven(stale, fresh, counts, order, old, new, first):  # type: ignore[no-untyped-def]
    """Objects and displayed parts of all cells in their order: fresh ones of stale cells, and old.

    first: row in the pool of the first fresh object.
    """
    kept, shown = len(order), len(old[0])
    for i in range(len(stale)):
        kept += fresh[i, 1] - counts[stale[i], 1]
        shown += fresh[i, 2] - counts[stale[i], 2]
    names = np.empty(kept, np.int32)
    object_, part, whole = (
        np.empty(shown, np.int32),
        np.empty(shown, np.int32),
        np.empty(shown, np.int32),
    )
    at, row, i = np.zeros(2, np.int64), np.zeros(2, np.int64), 0
    o, n = 0, 0
    for c in range(len(counts)):
        which = 0
        if i < len(stale) and stale[i] == c:
            which = 1
            at[0] += counts[c, 1]
            row[0] += counts[c, 2]
            objects, parts = fresh[i, 1], fresh[i, 2]
            i += 1
        else:
            objects, parts = counts[c, 1], counts[c, 2]
        if objects == 0:
            continue
        a, r = at[which], row[which]
        for k in range(objects):
            names[o + k] = first + a + k if which == 1 else order[a + k]
        source = new if which == 1 else old
        _copy(source[0], source[1], source[2], r, parts, o - a, n - r, object_, part, whole)
        at[which], row[which] = a + objects, r + parts
        o, n = o + objects, n + parts
    return names, object_, part, whole


@njit(cache=True)
def _copy(objects, parts, wholes, first, count, later, down, object_, part, whole):  # type: ignore[no-untyped-def]
    """Rows of one cell, of objects so many later, so many rows further down."""
    for k in range(first, first + count):
        object_[k + down], part[k + down] = objects[k] + later, parts[k]
        whole[k + down] = wholes[k] + down if wholes[k] >= 0 else wholes[k]


def _taken(hold: Hold) -> Objects:
    """The kept objects in their order, as they were when they were examined."""
    draws = [each.draws for each in hold.pool]
    names = ("cell_x", "cell_y", "index", "u")
    drawn = Draws(*(np.concatenate([getattr(d, k) for d in draws])[hold.order] for k in names))
    bodies = [each.bodies for each in hold.pool]
    parts = ("origin", "cos", "sin", "variant", "phase", "feet")
    stood = Bodies(*(np.concatenate([getattr(b, k) for b in bodies])[hold.order] for k in parts))
    return Objects(stood, drawn, np.zeros(len(drawn)))


def _cut(field: SpeciesField, hold: Hold) -> Cut:
    """The cut of what is held; bodies that move are put in their places when somebody asks."""
    rows, view, order, pool = hold.rows, hold.view, hold.order, tuple(hold.pool)
    frozen = replace(hold, order=order, pool=list(pool))

    def tell() -> Parts:
        objects: Any = _taken(frozen)
        if field.moves:
            objects = field.seen(objects.draws, view)
        return field.troupe.parts_shown(objects, rows, view)

    examined, kept, _, parts = hold.totals.tolist()
    level = field.troupe.atlas.level.astype(np.int16)[rows.part]
    counted = examined, examined - kept + parts
    return Cut(rows.object, rows.part, level, rows.whole, *counted, tell)
