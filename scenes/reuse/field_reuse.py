"""A field's cut from that of the frame before: only what may have changed is examined again.

Every comparison holds until the eye has gone as far as its slack
(``lod.pruning.compiled_test.slack``). A cell
holds as long as its own comparison and those of its objects' homes; an object as long as the least
of all its parts', in steps of the eye added up, and of its own where it walks. What is left is
examined anew by the same walks, and woven into what held: the same cut as from scratch, to the last
bit.

A ``Hold`` is used up by the frame that goes on from it: its buffers become the next one's.
"""

from dataclasses import dataclass, replace

import numpy as np

from lod.pruning.parts import Parts
from lod.pruning.pruner import Cut
from lod.pruning.view import View
from scenes.field.poisson_cells import Draws
from scenes.field.posed_species import Objects
from scenes.field.species_field import SpeciesField
from scenes.field.traversal import Held, Rows, walk
from scenes.field.traversal_tables import limits_of
from scenes.reuse.cell_reuse import drawn_anew
from scenes.reuse.merge_cuts import picked, sources, stale_cells, woven
from scenes.rig.height_bound import height_bound, max_speed
from scenes.rig.pose_tables import Instances

FARTHEST_M, FARTHEST_WALKING_M = 32.0, 2.0
"""Nothing is said to hold for longer than so many metres; the ground rises under who walks."""

_ROUNDING_M, _USUAL_STEP_M = 1e-6, 0.05


@dataclass(eq=False)
class Hold:
    """What is known of a field from the frame before; cells row by row of those searched.

    view     of that frame; limits (2, m) of all parts, and the span of cells, that it holds for;
             table: limits as the walk reads them; lift: how far up or down walkers go meanwhile [m]
    moved    steps of the eye since this hold began [m]; gone: and of what walks
    step     the last of these; turned: of the axes
    until    (c, 2) ``moved`` until which a cell holds by distance, and by view, for each radian
             that the axes turn the last column [m]; far (c,) that: more than anything is away
    counts   (2, c) of each cell: objects in the window, objects kept
    lasting  (n, 3) of each kept object the same as ``until`` and ``far``, by ``gone``
    found    (n, 2) parts shown of it, parts examined
    order    (n,) its row in ``pool``: objects as they were drawn, and their bodies
    rows     displayed parts; level (p,) of each
    """

    view: View
    limits: np.ndarray
    spans: tuple[int, int, int, int]
    table: np.ndarray
    lift: float
    moved: float
    gone: float
    step: float
    turned: float
    until: np.ndarray
    far: np.ndarray
    counts: np.ndarray
    lasting: np.ndarray
    found: np.ndarray
    order: np.ndarray
    pool: list[Objects]
    rows: Rows
    level: np.ndarray


def cut_after(field: SpeciesField, view: View, before: Hold | None) -> tuple[Cut, Hold | None]:
    """What of a field is displayed, as ``prune`` finds it; and what the next frame may go on from.

    Where motion hides detail, or depth along the axis is what counts, every frame is pruned from
    scratch.
    """
    if view.exposure is not None or view.metric.along_axis:
        return field.walk(view), None
    limits = np.stack(field.troupe.atlas.limits(view))
    spans = field.search(view)[0]
    if before is not None and _fits(before, view, limits, spans):
        hold = _moved(field, view, before)
    else:
        hold = _begun(field, view, limits, spans)
    _examine(field, hold)
    return _cut(field, hold), hold


def _fits(before: Hold, view: View, limits: np.ndarray, spans: tuple[int, ...]) -> bool:
    was = before.view
    return (
        was.camera.corner == view.camera.corner
        and was.camera.tan_half == view.camera.tan_half
        and was.look_around == view.look_around
        and before.spans == spans
        and np.array_equal(before.limits, limits)
    )


def _begun(
    field: SpeciesField, view: View, limits: np.ndarray, spans: tuple[int, int, int, int]
) -> Hold:
    """A hold of which nothing holds yet."""
    troupe, cells = field.troupe, max(spans[1] - spans[0], 0) * max(spans[3] - spans[2], 0)
    none = np.zeros(0, np.int32)
    return Hold(
        view=view,
        limits=limits,
        spans=spans,
        table=limits_of(troupe.slots, troupe.atlas, view, 0.0),
        lift=height_bound(troupe.pose_tables, field.ground, FARTHEST_WALKING_M)
        if field.moves
        else 0.0,
        moved=0.0,
        gone=0.0,
        step=_USUAL_STEP_M,
        turned=0.0,
        until=np.full((cells, 2), -np.inf),
        far=np.zeros(cells),
        counts=np.zeros((2, cells), np.int32),
        lasting=np.zeros((0, 3)),
        found=np.zeros((0, 2), np.int32),
        order=none,
        pool=[],
        rows=Rows(none, none, none, 0),
        level=np.zeros(0, np.int16),
    )


def _moved(field: SpeciesField, view: View, before: Hold) -> Hold:
    """The hold of the frame before as this one has it."""
    a, b = before.view, view
    eye = float(np.linalg.norm(b.camera.eye - a.camera.eye)) + _ROUNDING_M
    walked = max_speed(field.troupe.rigged) if field.species.patrol_m else 0.0
    step = eye + walked * abs(b.time_s - a.time_s)
    axes = ("forward", "right", "up")
    turn = sum(float(np.linalg.norm(getattr(b.camera, k) - getattr(a.camera, k))) for k in axes)
    return replace(
        before,
        view=view,
        moved=before.moved + eye,
        gone=before.gone + step,
        step=step,
        turned=before.turned + turn,
    )


def _examine(field: SpeciesField, hold: Hold) -> None:
    """Examine anew what no longer holds, and weave what is found into the rest."""
    stale = stale_cells(hold.until, hold.far, hold.moved, hold.turned)
    spread = float(field.troupe.slots.spread.max()) + 2 * FARTHEST_M + hold.lift
    draws, counts, room, far = drawn_anew(field, hold.view, stale, spread)
    kept = hold.counts[1]
    source, again = sources(stale, counts[1], kept, hold.lasting, hold.gone, hold.turned)
    hold.counts[:, stale], hold.far[stale] = counts, far
    hold.until[stale] = _until(room, far, hold.moved, hold.turned)
    if len(again):
        draws = _joined(draws, _draws_at(hold, hold.order[again]))
    objects = field.seen(draws, hold.view)
    far = np.concatenate((np.repeat(far, counts[1]), hold.lasting[again, 2]))
    _weave(field, hold, source, objects, far)


def _weave(
    field: SpeciesField, hold: Hold, source: np.ndarray, objects: Objects, far: np.ndarray
) -> None:
    """Walk down fresh objects, of which more than anything is ``far`` away, and weave them in."""
    first = sum(len(each) for each in hold.pool)
    held, rows = _walked(field, hold, objects)
    found, level = held[:, :2].astype(np.int32), field.troupe.atlas.level.astype(np.int16)
    columns = (*hold.rows[:3], hold.level), (*rows[:3], level[rows.part])
    object_, part, whole, hold.level = woven(source, hold.found, columns[0], found, columns[1])
    hold.rows = Rows(object_, part, whole, 0)
    lasting = np.column_stack((_until(held[:, 2:], far, hold.gone, hold.turned), far))
    hold.lasting = picked(source, hold.lasting, lasting)
    hold.found = picked(source, hold.found, found)
    numbers = np.arange(first, first + len(objects), dtype=np.int32)
    hold.order = picked(source, hold.order[:, None], numbers[:, None])[:, 0]
    hold.pool.append(objects)
    if first > 2 * len(hold.order) + 1000:
        hold.pool, hold.order = [_taken(hold)], np.arange(len(hold.order), dtype=np.int32)


def _until(room: np.ndarray, far: np.ndarray, gone: float, turned: float) -> np.ndarray:
    """How far gone a slack (n, 2), by distance and by view, lasts (n, 2) [m]."""
    until = gone + np.minimum(room, FARTHEST_M) - 100 * _ROUNDING_M
    until[:, 1] += turned * far
    return until


def _walked(field: SpeciesField, hold: Hold, objects: Objects) -> tuple[np.ndarray, Rows]:
    """Parts displayed of these objects, and ``held`` of each."""
    troupe, held, instances = field.troupe, np.zeros((len(objects), 4)), objects.instances
    asked = Held(held, not field.moves, hold.lift, hold.step)
    rows = walk(
        troupe.pose_tables, troupe.slots, hold.table, instances, objects.smear, hold.view, asked
    )
    if field.moves:
        held[:, 2:] = np.minimum(held[:, 2:], FARTHEST_WALKING_M)
    elif troupe.pose_tables.max_legs:
        room = troupe.heed_slack(hold.view, instances.origin[:, :2], instances.prototype)
        held[:, 2] = np.minimum(held[:, 2], room)
    return held, rows


_DRAWN = ("cell_x", "cell_y", "index", "u")
_STOOD = ("origin", "cos", "sin", "prototype", "phase", "foot_contacts")


def _joined(a: Draws, b: Draws) -> Draws:
    return Draws(*(np.concatenate((getattr(a, k), getattr(b, k))) for k in _DRAWN))


def _draws_at(hold: Hold, rows: np.ndarray) -> Draws:
    """Objects as they were drawn, by their rows in the pool."""
    draws = [each.draws for each in hold.pool]
    return Draws(*(_gathered([getattr(d, k) for d in draws], rows) for k in _DRAWN))


def _taken(hold: Hold) -> Objects:
    """The kept objects in their order, as they were when they were examined."""
    instances = [each.instances for each in hold.pool]
    stood = Instances(*(_gathered([getattr(b, k) for b in instances], hold.order) for k in _STOOD))
    return Objects(stood, _draws_at(hold, hold.order), np.zeros(len(hold.order)))


def _gathered(batches: list[np.ndarray], rows: np.ndarray) -> np.ndarray:
    """Rows of batches that lie end to end, which are never joined."""
    ends = np.cumsum([len(each) for each in batches])
    batch = np.searchsorted(ends, rows, side="right")
    taken = np.empty((len(rows), *batches[0].shape[1:]), batches[0].dtype)
    for number, each in enumerate(batches):
        mine = np.flatnonzero(batch == number)
        taken[mine] = each[rows[mine] - (ends[number] - len(each))]
    return taken


def _cut(field: SpeciesField, hold: Hold) -> Cut:
    """The cut of what is held; bodies that move are put in their places when somebody asks."""
    rows, view = hold.rows, hold.view
    frozen = replace(hold, pool=list(hold.pool))

    def tell() -> Parts:
        objects = _taken(frozen)
        if field.moves:
            objects = field.seen(objects.draws, view)
        return field.troupe.parts_shown(objects, rows, view)

    examined, parts = int(hold.counts[0].sum()), int(hold.found[:, 1].sum())
    counted = examined, examined - len(hold.order) + parts
    return Cut(rows.object, rows.part, hold.level, rows.whole, *counted, tell)
