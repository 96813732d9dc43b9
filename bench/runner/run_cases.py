"""How every experiment is conducted: its cases measured one by one, a record made of the points."""

import time
from collections.abc import Callable, Iterable, Sequence
from datetime import UTC, datetime
from typing import Any

from bench.records.claims import Claim
from bench.records.provenance import Provenance
from bench.records.records import Point, Record
from bench.runner.dask_cases import CaseExecutor
from bench.runner.experiment import Progress

Measure = Callable[..., Point | list[Point]]
"""What one case gives. Over a cluster it is called there: a function of a module, not of another
function, whose arguments say all that it needs."""

Cases = Sequence[tuple[str, tuple[Any, ...]]]
"""Of every case: what progress calls it, and the arguments that it is measured with."""


def run_cases(
    progress: Progress, each: CaseExecutor, *batches: tuple[Measure, Cases]
) -> tuple[Point, ...]:
    """The points of all cases, in the cases' order, wherever ``each`` has them measured."""
    total = sum(len(cases) for _, cases in batches)
    points: list[Point] = []
    done = 0
    for measure, cases in batches:
        results = each(measure, [arguments for _, arguments in cases])
        for name, _ in cases:
            progress(done, total, name)
            found = next(results)
            points += [found] if isinstance(found, Point) else found
            done += 1
    progress(total, total, "judged")
    return tuple(points)


def merge_points(points: Iterable[Point]) -> tuple[Point, ...]:
    """Points of one case as one: samples one after the other, predictions those of the first."""
    made: dict[str, Point] = {}
    for point in points:
        first = made.setdefault(repr(point.case), Point(point.case, point.predicted, {}))
        for name, values in point.samples.items():
            first.samples.setdefault(name, []).extend(values)
    return tuple(made.values())


def make_record(
    name: str,
    version: int,
    *,
    quick: bool,
    provenance: Provenance,
    points: tuple[Point, ...],
    claims: tuple[Claim, ...],
    notes: dict[str, Any],
    start: float,
) -> Record:
    """The record, made now; ``start`` is when measuring began, by ``time.perf_counter()``."""
    return Record(
        experiment=name,
        version=version,
        quick=quick,
        made=datetime.now(UTC).strftime("%Y-%m-%dT%H:%M:%SZ"),
        provenance=provenance,
        points=points,
        claims=claims,
        notes={**notes, "seconds": round(time.perf_counter() - start, 1)},
    )
