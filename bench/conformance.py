"""Rules that every representation and every metric keeps, ours and those of other packages.

The pruner, the renderer and the law ask nothing of a representation but the protocol
(``lod.pruner.Representation``); whatever keeps these rules can be put in a scene. Those of a metric
are about its formula and the cuts that it makes; they follow from Blake 1987 §2.4. A rule is a
generator: it yields one line for each fault that it finds, and nothing where there is none.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, fields, replace
from functools import partial

import numpy as np

from lod.camera import Camera, Corner, camera_from_heading
from lod.errors import InputError
from lod.metric import METRICS, Metric
from lod.pruner import (
    BlendWeights,
    Moving,
    Parts,
    Representation,
    blend_weights,
    displayed,
    prune,
    prune_by_level,
)
from lod.shapes import Appearance, Sticks, Triangles, batches_of
from lod.view import View, in_view
from scenes.field.species_field import Species, SpeciesField
from scenes.ground.mesh import Terrain
from scenes.models.catalogue import model_prototypes
from scenes.plugins import make_representation, metric_by_name, plugin_by_name

_OF_POINTS = {"position", "centre", "start", "end", "tints", "vertices", "normals", "colours"}
_OF_POINTS |= {"faces", "glows"}


def report_rows(what: str, wrong: np.ndarray) -> Iterator[str]:
    """Yield one line where any row is wrong: what, how many of how many, and the first row."""
    rows = np.flatnonzero(wrong)
    if len(rows):
        yield f"{what}: {len(rows)} of {len(wrong)}, the first at {rows[0]}"


def full_weights(parts: Parts) -> BlendWeights:
    """Give weights that show both appearances of every part in full."""
    return BlendWeights(np.ones(len(parts)), np.ones(len(parts)))


def part_keys(parts: Parts) -> np.ndarray:
    """Give level, number and place of each part, sorted, (n, 5) int64, to compare traversals."""
    place = np.ascontiguousarray(parts.position + 0.0).view(np.int64)
    rows = np.column_stack((parts.level, parts.part, place))
    return rows[np.lexsort(rows.T)]


def shared_rows(one: Parts, other: Parts) -> tuple[np.ndarray, np.ndarray]:
    """Give the rows of the parts that two batches share, by object and number, in one order."""
    keys = [
        list(zip(*(getattr(each, k).tolist() for k in ("object", "level", "part")), strict=True))
        for each in (one, other)
    ]
    row = {key: i for i, key in enumerate(keys[1])}
    pairs = [(i, row[key]) for i, key in enumerate(keys[0]) if key in row]
    rows = np.array(pairs, np.int64).reshape(-1, 2)
    return rows[:, 0], rows[:, 1]


def frame_bytes(representation: Representation, view: View) -> dict[str, bytes]:
    """Give the bytes of every array of a frame: of its cut, and of the cut's appearance."""
    cut = prune(representation, view)
    shape = representation.appearance(cut.parts, blend_weights(cut, view))
    looks = [(type(each).__name__, each) for each in batches_of(shape)]
    both = (("parts", cut.parts), *looks)
    return {
        f"{where}.{field.name}": np.ascontiguousarray(getattr(each, field.name)).tobytes()
        for where, each in both
        for field in fields(each)
        if field.name != "state"
    }


def differing_columns(one: Appearance, other: Appearance) -> list[str]:
    """Name the columns in which two appearances differ by more than rounding."""
    if type(one) is not type(other):
        return ["their kind"]
    found = []
    for a, b in zip(batches_of(one), batches_of(other), strict=True):
        for name in (each.name for each in fields(a)):
            x, y = getattr(a, name), getattr(b, name)
            if x.shape != y.shape or not np.allclose(x, y, rtol=0, atol=1e-6):
                found.append(name)
    return found


def column_faults(batch: Parts | Appearance) -> Iterator[str]:
    """Yield columns that are not read-only arrays of finite numbers; limits may be infinite."""
    for each in (batch,) if isinstance(batch, Parts) else batches_of(batch):
        names = [field.name for field in fields(each) if field.name != "state"]
        names = [name for name in names if getattr(each, name) is not None]
        for name in names:
            column, where = getattr(each, name), f"{type(each).__name__}.{name}"
            if not isinstance(column, np.ndarray) or column.dtype == object:
                yield f"{where} is no array of numbers"
                continue
            if column.flags.writeable:
                yield f"{where} can be written to"
            if column.shape[1:] != ((3,) if name in _OF_POINTS else ()):
                yield f"{where} has shape {column.shape}"
            good = ~np.isnan(column) if name.startswith("limit") else np.isfinite(column)
            yield from report_rows(f"{where} is not finite", ~good)
        if isinstance(each, Parts) and {len(getattr(each, name)) for name in names} != {len(each)}:
            yield "columns of Parts have different lengths"


def appearance_faults(shape: Appearance, parts: int) -> Iterator[str]:
    """Yield rows that do not exist, radii or albedo out of range, and normals that are not unit."""
    for each in batches_of(shape):
        rows = {"owner": (each.owner, parts)}
        if isinstance(each, Sticks):
            for name in ("start_radius", "end_radius"):
                yield from report_rows(f"{name} not above 0", ~(getattr(each, name) > 0))
            rows["tint"], colours = (each.tint, len(each.tints)), each.tints
        else:
            length = np.linalg.norm(each.normals, axis=1)
            yield from report_rows("a normal that is not unit", abs(length - 1) > 1e-6)
            rows["faces"], colours = (each.faces, len(each.vertices)), each.colours
        yield from report_rows("albedo outside 0 to 1", np.max(abs(colours - 0.5), axis=1) > 0.5)
        for name, (row, count) in rows.items():
            yield from report_rows(f"{name} of no such row", (row < 0) | (row >= count))


TIMES_S = (0.0, 0.37, 41.9)
"""Times at which poses are examined: what moves is somewhere else at each [s]."""

MOST_PARTS = 2_000_000
"""Largest number of parts, displayed or not, that a subject of the suite may have."""

_ROUNDING = 1e-9


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
            for each in batches_of(shape):
                if isinstance(each, Sticks):
                    owner = np.concatenate((each.owner, each.owner))
                    point = np.concatenate((each.start, each.end))
                    radius = np.concatenate((each.start_radius, each.end_radius))
                else:
                    owner, point = np.repeat(each.owner, 3), each.vertices[each.faces.ravel()]
                    radius = np.zeros(len(owner))
                reach = np.linalg.norm(point - asked.centre[owner], axis=1) + radius
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
    for name, asked in (("rebuilt", again), ("asked again", first)):
        got = frame_bytes(asked, view)
        if changed := [key for key in reference if got.get(key) != reference[key]]:
            yield f"{name}, other bytes in {', '.join(changed)}"


def arrays_only(subject: Subject) -> Iterator[str]:
    """Parts and looks are arrays of one length, frozen, finite."""
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


def any_request_is_answered(subject: Subject) -> Iterator[str]:
    """An empty request and a single part get what each part gets among the others."""
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

_GROUND = Terrain(seed=4, amplitude=0.4, wavelength=16.0, hurst=0.8, reach=100.0, finest=1.0)
_EXTENT_M, _DENSITY = 6.0, 0.1
_ANGLES = (1e-5, 1e-3, 0.1)
_PARTS = 400


def broken_metric_rules(name: str) -> dict[str, list[str]]:
    """List what a metric breaks, rule by rule; an empty list for each rule that it keeps."""
    metric = metric_by_name(name)
    formula = {rule.__name__: list(rule(metric)) for rule in FORMULA}
    subject = rabbits(name)
    return formula | {rule.__name__: list(rule(subject)) for rule in CUTS}


def answers_with_distances(metric: Metric) -> Iterator[str]:
    """Every part has a limit that is not below 0, and finite where the metric says so."""
    P, R = _parts()
    for m in _ANGLES:
        D = np.asarray(metric.limit(P, R, m))
        if D.shape != P.shape or D.dtype.kind != "f":
            yield f"m = {m:g}: {D.dtype} of shape {D.shape} for parts of shape {P.shape}"
            continue
        yield from report_rows(f"m = {m:g}: a limit below 0, or no number", ~(D >= 0))
        if metric.finite:
            yield from report_rows(f"m = {m:g}: an infinite limit of a finite metric", np.isinf(D))


def knows_one_part_at_a_time(metric: Metric) -> Iterator[str]:
    """A part's limit does not depend on what else is asked, nor on when."""
    P, R = _parts()
    for m in _ANGLES:
        D, again = metric.limit(P, R, m), metric.limit(P, R, m)
        alone = np.concatenate([metric.limit(P[k : k + 1], R[k : k + 1], m) for k in range(_PARTS)])
        yield from report_rows(f"m = {m:g}: another limit when asked again", D != again)
        yield from report_rows(f"m = {m:g}: another limit when asked alone", D != alone)


def finer_detail_takes_nothing_away(metric: Metric) -> Iterator[str]:
    """A smaller m never lowers a limit, and neither does a larger P or R."""
    P, R = _parts()
    for m in _ANGLES:
        D = metric.limit(P, R, m)
        yield from report_rows(
            f"m = {m:g}: less far in finer detail", metric.limit(P, R, m / 2) < D
        )
        yield from report_rows(f"m = {m:g}: less far for a larger P", metric.limit(2 * P, R, m) < D)
        yield from report_rows(f"m = {m:g}: less far for a larger R", metric.limit(P, 2 * R, m) < D)


FORMULA = (answers_with_distances, knows_one_part_at_a_time, finer_detail_takes_nothing_away)
CUTS: tuple[Rule, ...] = (limits_never_grow, agrees_with_brute_force, same_seed_same_bytes)


def _parts() -> tuple[np.ndarray, np.ndarray]:
    """Draw P and R of parts from 0.1 mm to 100 m, some with R = 0; both arrays are read-only."""
    rng = np.random.default_rng(4)
    P, R = 10.0 ** rng.uniform(-4, 2, (2, _PARTS))
    R[::5] = 0.0
    for column in (P, R):
        column.setflags(write=False)
    return P, R


def rabbits(metric: str) -> Subject:
    """Put a few rabbits in a small window of rolling ground, to be pruned by one metric."""
    kind = Species("rabbit", model_prototypes("rabbit", 1, (0.8, 1.0), False), _DENSITY)
    make = partial(SpeciesField, kind, 1, _GROUND, _EXTENT_M)
    eye = np.array((0.0, -1.2 * _EXTENT_M, 0.5))
    camera = camera_from_heading(Corner(0, 0), eye, -8.0, -4.0, 65.0, (90, 50))
    return Subject(make, camera, 0.3, (metric,))


def broken_plugin_rules(kind: str) -> dict[str, list[str]]:
    """List what a plug-in's representation breaks, rule by rule, with its default options."""
    offer = plugin_by_name(kind)
    make = partial(make_representation, kind, kind, 5, _GROUND, {})
    subject = Subject(make, offer.camera, offer.detail)
    return {name: list(rule(subject)) for name, rule in RULES.items()}
