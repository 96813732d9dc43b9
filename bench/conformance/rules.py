"""Which rules must every representation keep, ours and those of other packages?

The pruner, the renderer and the law ask nothing of a representation but the protocol
(``lod.pruning.representation.Representation``); whatever keeps these rules can be put in a scene.
A rule is a generator: it yields one line for each fault that it finds, and nothing where there is
none.
"""

import gc
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np

from bench.conformance.rows import (
    appearance_faults,
    column_faults,
    differing_columns,
    frame_bytes,
    full_weights,
    owner_distances,
    part_keys,
    report_rows,
    shared_rows,
)
from lod.camera import Camera
from lod.errors import InputError
from lod.metric.family import METRICS
from lod.pruning.parts import Parts
from lod.pruning.pruner import displayed, prune, prune_by_level
from lod.pruning.representation import Moving, Representation
from lod.pruning.shapes import Triangles
from lod.pruning.view import View
from lod.pruning.view_geometry import in_view
from scenes.plugins.entry_points import metric_by_name

TIMES_S = (0.0, 0.37, 41.9)
"""Times at which poses are examined: what moves is somewhere else at each [s]."""

MOST_PARTS = 2_000_000
"""Largest number of parts, displayed or not, that a subject of the suite may have."""

_HUGE = 300_000
_ROUNDING = 1e-9
_ODD_OBJECTS = 2_000
"""Python objects that a frame may leave behind, whatever the number of its parts."""


@dataclass(frozen=True, eq=False)
class Subject:
    """A representation to be put through the suite.

    make    builds the representation from the same seed each time; its world is finite and small
    camera  has some objects in view and some not, so near that parts of parts are displayed
    detail  τ at which it displays some of its parts and not all [px]
    metrics names of those to be tried, the usual one first
    """

    make: Callable[[], Representation]
    camera: Camera
    detail: float = 1.0
    metrics: tuple[str, ...] = tuple(METRICS)

    def view(self, metric: str | None = None, time_s: float = 0.0) -> View:
        """Give the view of the camera, by the first of the metrics where none is named."""
        named = metric_by_name(metric or self.metrics[0])
        return View(self.camera, named, self.detail, time_s=time_s)


Rule = Callable[[Subject], Iterator[str]]


def broken_rules(subject: Subject) -> list[str]:
    """List the rules that the subject breaks, with what was found; empty where it conforms."""
    return [f"{name}: {found}" for name, rule in RULES.items() for found in rule(subject)]


def all_parts(representation: Representation, view: View) -> Parts:
    """Collect all parts of all objects, displayed or not; ``parent`` gives rows of this batch.

    Raises InputError where there are too many to be held.
    """
    batches, first, count = [representation.roots(view)], 0, 0
    while len(batches[-1]):
        count += len(batches[-1])
        if count > MOST_PARTS:
            raise InputError("subject", count, f"at most {MOST_PARTS} parts in all", "less of it")
        own = representation.parts_of(batches[-1], view)
        batches.append(replace(own, parent=own.parent + first))
        first += len(batches[-2])
    return Parts.concatenate(batches)


def inside_its_bound(subject: Subject) -> Iterator[str]:
    """Everything is inside B, in every pose: its looks, and the spheres of its parts."""
    representation = subject.make()
    for time_s in TIMES_S:
        view = subject.view(time_s=time_s)
        parts = all_parts(representation, view)
        rows = np.flatnonzero(parts.parent >= 0)
        whole = parts.parent[rows]
        away = np.linalg.norm(parts.centre[rows] - parts.centre[whole], axis=1)
        yield from report_rows(
            f"at {time_s} s a part reaches out of the sphere of its whole",
            away + parts.bound[rows] > parts.bound[whole] * (1 + _ROUNDING) + _ROUNDING,
        )
        cut = prune(representation, view).parts
        for asked in (cut, parts):
            shape = representation.appearance(asked, full_weights(asked))
            owner, reach = owner_distances(shape, asked.centre)
            yield from report_rows(
                f"at {time_s} s what a part looks like is outside of its sphere",
                reach > asked.bound[owner] * (1 + _ROUNDING) + _ROUNDING,
            )
            if isinstance(shape, Triangles):
                break  # one surface, of the finest parts alone


def limits_never_grow(subject: Subject) -> Iterator[str]:
    """Down the tree neither limit grows, and what passes its test has a whole that passes."""
    representation = subject.make()
    for metric in subject.metrics:
        view = subject.view(metric)
        parts = all_parts(representation, view)
        rows = np.flatnonzero(parts.parent >= 0)
        whole, passed = parts.parent[rows], displayed(parts, view)
        for name in ("limit", "limit_offscreen"):
            limit = getattr(parts, name)
            yield from report_rows(f"{metric}: {name} below 0, or no number", ~(limit >= 0))
            yield from report_rows(
                f"{metric}: {name} grows down the tree", limit[rows] > limit[whole]
            )
        yield from report_rows(f"{metric}: coarser in view", parts.limit_offscreen > parts.limit)
        yield from report_rows(
            f"{metric}: displayed without its whole", passed[rows] & ~passed[whole]
        )
        yield from report_rows(f"{metric}: levels fall", parts.level[rows] < parts.level[whole])


def agrees_with_brute_force(subject: Subject) -> Iterator[str]:
    """The pruner's cut is what every part's own test gives, by whichever walk."""
    representation = subject.make()
    for metric in subject.metrics:
        view = subject.view(metric)
        parts = all_parts(representation, view)
        alone = part_keys(parts.take(displayed(parts, view)))
        for walk, cut in (("", prune(representation, view)), (
            " level by level", prune_by_level(representation, view)
        )):  # fmt: skip
            if not np.array_equal(part_keys(cut.parts), alone):
                yield f"{metric}: pruned{walk} {len(cut)} parts, {len(alone)} pass their own test"
            yield from report_rows(
                f"{metric}: a part stands before its whole", cut.parent >= np.arange(len(cut))
            )


def roots_leave_nothing_out(subject: Subject) -> Iterator[str]:
    """What is in view is the same while the eye looks all round, and no less in more detail.

    But for parts that something hides: those are told a lower limit than when looking all round.
    The latter is asked by name, not by place: in more detail a walker stands on the ground more
    closely, by less than can be seen in less.
    """
    representation, view = subject.make(), subject.view()
    here = prune(representation, view).parts
    seen = here.take(in_view(view, here.centre, here.bound))
    all_round = replace(view, look_around=True)
    everywhere = prune(representation, all_round).parts
    around = everywhere.take(in_view(view, everywhere.centre, everywhere.bound))
    asked = all_parts(representation, view)
    rows, same = shared_rows(around, asked)
    hidden = np.zeros(len(around), bool)
    hidden[rows] = asked.limit[same] < around.limit[rows]
    hidden[shared_rows(around, seen)[0]] = False
    around = around.take(~hidden)
    if not np.array_equal(part_keys(seen), part_keys(around)):
        yield f"{len(seen)} parts are in view, {len(around)} of the same when looking all round"
    finer = prune(representation, replace(all_round, detail=subject.detail / 2)).parts
    lost = len(everywhere) - len(shared_rows(everywhere, finer)[0])
    if lost:
        yield f"{lost} parts are lost in more detail"


def same_seed_same_bytes(subject: Subject) -> Iterator[str]:
    """Made again, asked again, or asked for something else in between: the same bytes."""
    first, again, view = subject.make(), subject.make(), subject.view(time_s=TIMES_S[1])
    reference = frame_bytes(first, view)
    prune(again, subject.view(time_s=TIMES_S[2]))
    for name, asked in (("made anew", again), ("asked again", first)):
        got = frame_bytes(asked, view)
        if changed := [key for key in reference if got.get(key) != reference[key]]:
            yield f"{name}, other bytes in {', '.join(changed)}"


def arrays_only(subject: Subject) -> Iterator[str]:
    """Parts and looks are arrays of one length, frozen, finite; no object per part."""
    representation, view = subject.make(), subject.view()
    parts = all_parts(representation, view)
    yield from column_faults(parts)
    yield from report_rows(
        "a share of area outside 0 to 1", ~((parts.share >= 0) & (parts.share <= 1))
    )
    rows = np.flatnonzero(parts.parent >= 0)
    total = np.bincount(parts.parent[rows], parts.share[rows], len(parts))
    owns = np.bincount(parts.parent[rows], minlength=len(parts)) > 0
    yield from report_rows(
        "shares of all parts of a whole are not 1", owns & (abs(total - 1) > 1e-6)
    )
    cut = prune(representation, view)
    shape = representation.appearance(cut.parts, full_weights(cut.parts))
    yield from column_faults(shape)
    yield from appearance_faults(shape, len(cut))
    gc.collect()
    before = len(gc.get_objects())
    cut = prune(representation, view)
    kept = cut, representation.appearance(cut.parts, full_weights(cut.parts))
    gc.collect()
    grown = len(gc.get_objects()) - before
    if grown > _ODD_OBJECTS:
        yield f"{grown} Python objects for {len(kept[0])} parts"


def any_request_is_answered(subject: Subject) -> Iterator[str]:
    """An empty request, a single part and a huge one get what each part gets among the others."""
    representation, view = subject.make(), subject.view()
    parts = all_parts(representation, view)
    nothing = parts.take(np.zeros(0, np.int64))
    if len(representation.parts_of(nothing, view)):
        yield "parts of nothing"
    if len(representation.appearance(nothing, full_weights(nothing))):
        yield "looks of nothing"
    if not len(parts):
        yield "nothing of it is near its camera: move that, and everything else is tested too"
        return
    for row in np.unique(np.linspace(0, len(parts) - 1, 5).astype(np.int64)).tolist():
        one, expected = parts.take(np.array([row])), parts.take(parts.parent == row)
        own = representation.parts_of(one, view)
        if not np.array_equal(part_keys(own), part_keys(expected)) or np.any(own.parent):
            yield f"part {row} alone owns other parts than among all"
        yield from appearance_faults(representation.appearance(one, full_weights(one)), 1)
    rows = np.arange(_HUGE) % len(parts)
    try:
        own = representation.parts_of(parts.take(rows), view)
    except InputError:
        return  # refused in one line, before memory is gone
    owns = np.bincount(parts.parent[parts.parent >= 0], minlength=len(parts)) > 0
    if not np.array_equal(np.unique(own.parent), np.flatnonzero(owns[rows])):
        yield "a huge request is answered for other parts than were asked"


def later_looks_alike(subject: Subject) -> Iterator[str]:
    """What moves looks later as it does when asked later, row by row."""
    representation, view = subject.make(), subject.view()
    if not isinstance(representation, Moving):
        return
    parts, then = (all_parts(representation, v) for v in (view, subject.view(time_s=TIMES_S[1])))
    here, there = shared_rows(parts, then)
    later = representation.later(parts, view, TIMES_S[1]).take(here)
    if not np.array_equal(part_keys(later), part_keys(parts.take(here))):
        yield "other parts or places later"
    then = then.take(there)
    looks = [representation.appearance(each, full_weights(each)) for each in (later, then)]
    if (changed := differing_columns(*looks)) != []:
        yield f"looks different when asked later, in {', '.join(changed)}"


RULES: dict[str, Rule] = {
    rule.__name__: rule
    for rule in (
        inside_its_bound,
        limits_never_grow,
        agrees_with_brute_force,
        roots_leave_nothing_out,
        same_seed_same_bytes,
        arrays_only,
        any_request_is_answered,
        later_looks_alike,
    )
}
