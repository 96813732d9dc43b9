"""How is an experiment run? Its cases are measured, its points judged, and a record is made."""

import os
from collections.abc import Callable, Iterator, Sequence
from dataclasses import is_dataclass, replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from bench.records.points import Point, merge_points
from bench.records.probe import NOTE, SOURCES, take_probe
from bench.records.provenance import provenance
from bench.records.records import Record, write_record
from bench.runner.dask_cases import CaseExecutor, serial_executor
from bench.runner.experiment import Effort, Experiment, Progress, silent
from bench.runner.journal import Elapsed, Journal, RunRequest, sources


def run_experiment(
    experiment: Experiment,
    effort: Effort,
    seed: int = 0,
    executor: CaseExecutor = serial_executor,
    progress: Progress = silent,
    metric: str | None = None,
) -> Record:
    """Measure all cases, merge their points, judge them, and give the record.

    ``metric`` is the name of an installed metric that is tried beside the experiment's own.
    """
    start = Elapsed.so_far()
    accepted = (metric,) if experiment.accepts_metric else ()
    cases = experiment.cases(effort, *accepted)
    points = merge_points(run_cases(experiment.measure, cases, seed, executor, progress))
    threads = (os.cpu_count() or 1) if experiment.all_cores else 1
    origin = provenance(experiment.scene_hash(points), seed, threads, _variant(experiment))
    notes = experiment.notes(effort, seed, points) if experiment.notes else dict(effort.sizes)
    claims = experiment.judge(points)
    return Record(
        experiment=experiment.name,
        version=experiment.version,
        quick=effort.name == "quick",
        made=datetime.now(UTC).strftime("%Y-%m-%dT%H:%M:%SZ"),
        provenance=origin,
        points=points,
        claims=claims,
        notes=notes | (Elapsed.so_far() - start).as_json(),
    )


def run_request(
    experiment: Experiment,
    request: RunRequest,
    journal: Journal,
    executor: CaseExecutor,
    progress: Progress,
) -> tuple[Path, Record]:
    """Run what was asked for, keep each case in the journal, and write the record.

    What is timed is measured here and in one go: neither a cluster nor a journal has part in it;
    but where times are compared within a case alone (``whole_cases``) cases are kept. Gives the
    record and its path; its seconds count what was kept from a run that was stopped. The record
    notes its sources, and a probe that tells later whether others would make it otherwise.
    """
    before = journal.elapsed(request)
    each = serial_executor if experiment.timed else executor
    in_one_go = experiment.timed and not experiment.whole_cases
    kept = each if in_one_go else journal.memoised(request, each)
    effort = experiment.effort("quick" if request.quick else "full")
    record = run_experiment(experiment, effort, request.seed, kept, progress, request.metric)
    spent = Elapsed(record.notes["seconds"], record.notes["processor_seconds"])
    notes = record.notes | (before + spent).as_json()
    made_by = {NOTE: take_probe(experiment.probe), SOURCES: sources()}
    record = replace(record, notes=notes | made_by)
    path = write_record(record, journal.folder)
    journal.finished(request, path)
    return path, record


def run_cases(
    measure: Callable[[Any, int], Point | list[Point]],
    cases: Sequence[Any],
    seed: int,
    executor: CaseExecutor,
    progress: Progress,
) -> Iterator[Point]:
    """Give the points of all cases, in the cases' order, wherever the executor measures them."""
    results = executor(measure, [(case, seed) for case in cases])
    for number, case in enumerate(cases):
        progress(number, len(cases), case_label(case))
        found = next(results)
        yield from [found] if isinstance(found, Point) else found
    progress(len(cases), len(cases), "judged")


def case_label(case: Any) -> str:
    """Name a case for progress: by its label where it has one, else by its values."""
    if hasattr(case, "label"):
        return str(case.label)
    values = list(vars(case).values()) if is_dataclass(case) else [case]
    return ", ".join(f"{v:g}" if isinstance(v, float) else str(v) for v in values)


def _variant(experiment: Experiment) -> str | None:
    if not experiment.rendered:
        return None
    from scenes.render.variants import choose

    return choose()
