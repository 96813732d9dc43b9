"""Run experiments: cases here or on a cluster, each kept in a journal, and one record at the end.

In DIR/.journal lies one small file for each measured case and each finished record, named for all
that made it: sources, packages, experiment, seed and the case itself. Nothing that was made by
other sources can be taken for it, and the same command goes on where it was stopped, on any kind of
machine, as every case notes its own; a finished record is made again on another kind. The kind is
the processor's name and its cores, as ``compare`` has it.
"""

import contextlib
import hashlib
import importlib.util
import json
import math
import os
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, dataclass, is_dataclass, replace
from datetime import UTC, datetime
from functools import lru_cache
from pathlib import Path
from typing import Any

from pydantic import TypeAdapter

from bench.experiment import Case, Experiment, OwnPreset, Progress, silent
from bench.records.probe import CASES, NOTE, SOURCES, take_probe
from bench.records.provenance import Provenance, machine, provenance, scene_digest
from bench.records.records import (
    PRESET,
    PRESET_TEXT,
    Point,
    Record,
    merge_points,
    point_from_json,
    point_json,
    read_record,
    write_record,
)
from lod.errors import InputError
from scenes.files import write_text
from scenes.plugins import modules
from scenes.presets.load import preset_toml
from scenes.presets.schema import Preset
from scenes.processes.cache import PACKAGES, source_digest

CaseExecutor = Callable[[Callable[..., Any], Sequence[tuple[Any, ...]]], Iterator[Any]]
"""A function that calls another with each case's arguments, and gives the results in order."""

JOURNAL = ".journal"
_RETRIES = 2


def serial_executor(
    function: Callable[..., Any], cases: Sequence[tuple[Any, ...]]
) -> Iterator[Any]:
    """Measure the cases in this process, each when its result is asked for."""
    return (function(*case) for case in cases)


@contextlib.contextmanager
def dask_executor(where: str | None, say: Callable[[str], object]) -> Iterator[CaseExecutor]:
    """Give an executor over a Dask cluster, with one task for each case.

    ``where`` is what ``scenes.render.cluster`` takes; None gives ``serial_executor``.
    ``say`` is told of the cluster what someone who waits may want to know.
    """
    if where is None:
        yield serial_executor
        return
    from scenes.render.cluster import cluster

    with cluster(where, threads=1, say=say) as workers:

        def tasks(function: Callable[..., Any], cases: Sequence[tuple[Any, ...]]) -> Iterator[Any]:
            arguments = map(list, zip(*cases, strict=True))
            futures = workers.client.map(function, *arguments, pure=False, retries=_RETRIES)
            try:
                for future in futures:
                    yield future.result()
                    future.release()
            finally:
                workers.client.cancel(futures, force=True)

        yield tasks


@dataclass(frozen=True)
class RunRequest:
    """One experiment as it was asked for.

    metric names another to be tried beside its own; stems is the path of a map of stems,
    and the SHA-256 of that file; preset is tried in place of the experiment's own
    """

    name: str
    topics: tuple[str, ...]
    quick: bool = False
    seed: int = 0
    metric: str | None = None
    stems: tuple[str, str] | None = None
    preset: OwnPreset | None = None


def spent_since(start: Sequence[float] = (0.0, 0.0)) -> dict[str, float]:
    """Return seconds by the clock, and of all cores, here and in processes that were started.

    They are counted from the values that this gave at a start, in milliseconds' precision.
    """
    now = time.perf_counter(), math.fsum(os.times()[:4])
    passed = [round(one - other, 3) for one, other in zip(now, start, strict=True)]
    return dict(zip(("seconds", "processor_seconds"), passed, strict=True))


def measured_case(case: Case, seed: int) -> dict[str, Any]:
    """Measure a case: its points as plain data, and what made them, where and how long it took."""
    start = spent_since()
    found = case(seed)
    points = [found] if isinstance(found, Point) else found
    made = {"case": case_label(case), **machine(), **spent_since([*start.values()])}
    return {"points": [point_json(each) for each in points], "made": made}


@dataclass(frozen=True)
class Journal:
    """What is done in a folder.

    maker    digest of the sources and the packages that measure
    machine  digest of the kind of machine, which a record is of; cases of one record may be of
             several, for each of them names its own
    """

    folder: Path
    maker: str
    machine: str = ""

    def record_of(self, asked: RunRequest) -> Path | None:
        """Return the path of the finished record; None without one that still verifies."""
        found = _read(self._record(asked))
        path = self.folder / Path(str(found)).name
        try:
            record = read_record(path) if found else None
        except InputError:
            return None
        same = record and (record.experiment, record.quick, record.provenance.seed)
        return path if same == (asked.name, asked.quick, asked.seed) else None

    def finished(self, asked: RunRequest, record: Path) -> None:
        """Note that a record is finished; its cases need not be kept any longer."""
        _write(self._record(asked), record.name)
        self._discard_cases(asked)

    def discard(self, asked: RunRequest) -> None:
        """Forget what was asked for and its cases; records stay."""
        self._record(asked).unlink(missing_ok=True)
        self._discard_cases(asked)

    def _discard_cases(self, asked: RunRequest) -> None:
        for path in self._cases(asked).glob("*.json"):
            path.unlink()

    def memoised(self, asked: RunRequest, each: CaseExecutor) -> CaseExecutor:
        """Return an executor like ``each`` that keeps results, and measures no case twice."""

        def kept(
            function: Callable[..., Any], cases: Sequence[tuple[Any, ...]]
        ) -> Iterator[dict[str, Any]]:
            folder = self._cases(asked)
            paths = [
                folder / f"{_sha256(case.func.__qualname__, case.args, case.keywords, seed)}.json"
                for case, seed in cases
            ]
            done = [_case(path) for path in paths]
            left = [case for case, data in zip(cases, done, strict=True) if data is None]
            measured = each(function, left)
            for path, data in zip(paths, done, strict=True):
                if data is None:
                    data = next(measured)
                    _write(path, data)
                yield data

        return kept

    def _record(self, asked: RunRequest) -> Path:
        return self._path("record", asked, self.machine).with_suffix(".json")

    def _cases(self, asked: RunRequest) -> Path:
        return self._path("cases", asked)

    def _path(self, what: str, asked: RunRequest, *of: str) -> Path:
        digest = _sha256(self.maker, asked, *of)[:16]
        return self.folder / JOURNAL / f"{what}-{asked.name}-{digest}"


def journal(folder: Path) -> Journal:
    """Return the journal of a folder, for the sources and the machine that are here."""
    here = asdict(provenance("", 0)) | {"commit": None, "platform": None}
    machine = _sha256(here.pop("cpu"), here.pop("cores"))
    return Journal(Path(folder), _sha256(here, sources()), machine)


@lru_cache(maxsize=1)
def sources() -> str:
    """Return the SHA-256 of every source that could change a number, plug-ins included."""
    return source_digest((*PACKAGES, *map(_source, modules())))


def run_experiment(
    experiment: Experiment,
    asked: RunRequest,
    executor: CaseExecutor = serial_executor,
    progress: Progress = silent,
) -> Record:
    """Measure all cases of the topics asked for, judge their points, and give the record."""
    start = spent_since()
    sizes, cases = {}, list[Case]()
    for name in asked.topics:
        topic = experiment.topics[name]
        sizes[name] = topic.sizes("quick" if asked.quick else "full")
        cases += topic.cases(**sizes[name], **{own: getattr(asked, own) for own in topic.accepts})
    points: list[Point] = []
    made: list[dict[str, Any]] = []
    results = executor(measured_case, [(case, asked.seed) for case in cases])
    for number, case in enumerate(cases):
        progress(number, len(cases), case_label(case))
        found = next(results)
        points += map(point_from_json, found["points"])
        made.append(found["made"])
    progress(len(cases), len(cases), "judged")
    merged = merge_points(points)
    notes: dict[str, Any] = {"sizes": sizes, CASES: made}
    if experiment.notes:
        notes |= experiment.notes(merged)
    if asked.preset:
        notes |= {PRESET: asked.preset[0], PRESET_TEXT: preset_toml(asked.preset[1])}
    return Record(
        experiment=experiment.name,
        version=experiment.version,
        quick=asked.quick,
        made=datetime.now(UTC).strftime("%Y-%m-%dT%H:%M:%SZ"),
        provenance=_origin(experiment, asked, merged),
        points=merged,
        claims=experiment.judged(merged),
        notes=notes | spent_since([*start.values()]),
    )


def run_request(
    experiment: Experiment,
    asked: RunRequest,
    journal: Journal,
    executor: CaseExecutor,
    progress: Progress,
) -> tuple[Path, Record]:
    """Run what was asked for, keep each case in the journal, and write the record.

    What is timed is measured here and in one go: neither a cluster nor a journal has part in it;
    but where times are compared within a case alone (``whole_cases``) cases are kept. The record
    notes its sources, and a probe that tells later whether others would make it otherwise.
    """
    each = serial_executor if experiment.timed else executor
    in_one_go = experiment.timed and not experiment.whole_cases
    kept = each if in_one_go else journal.memoised(asked, each)
    record = run_experiment(experiment, asked, kept, progress)
    spent = {
        name: round(math.fsum(case[name] for case in record.notes[CASES]), 1)
        for name in spent_since()
    }
    made_by = {NOTE: take_probe(experiment.probe), SOURCES: sources()}
    record = replace(record, notes=record.notes | spent | made_by)
    path = write_record(record, journal.folder)
    journal.finished(asked, path)
    return path, record


def case_label(case: Case) -> str:
    """Name a case for progress by its arguments: data by their label, and not without one."""
    values = [getattr(v, "label", v) for v in (*case.args, *case.keywords.values())]
    said = [" ".join(map(str, v)) if isinstance(v, tuple | list) else v for v in values]
    plain = (v for v in said if not isinstance(v, Preset) and not is_dataclass(v))
    words = (f"{v:g}" if isinstance(v, float) else str(v) for v in plain)
    return ", ".join(words)


def _origin(experiment: Experiment, asked: RunRequest, points: tuple[Point, ...]) -> Provenance:
    """Say what made a record; its scene is all that was looked at, and how it was asked for."""
    looked_at = [[point.case, point.scene] for point in points]
    own = [preset_toml(asked.preset[1])] if asked.preset else []
    scene = scene_digest([experiment.name, experiment.version, looked_at, *own])
    threads = (os.cpu_count() or 1) if experiment.all_cores else 1
    variant = None
    if experiment.rendered:
        from scenes.render.variants import choose

        variant = choose()
    return provenance(scene, asked.seed, threads, variant)


def _source(module: str) -> Path:
    """Find the folder of a package or the file of a module; without one, a path to nothing."""
    found = importlib.util.find_spec(module)
    origin = Path(found.origin if found and found.origin else module)
    return origin.parent if origin.name == "__init__.py" else origin


def _sha256(*words: object) -> str:
    return hashlib.sha256(repr(words).encode()).hexdigest()


def _read(path: Path) -> Any:
    """Return what a file of the journal holds; None where there is none, or a damaged one."""
    try:
        held = json.loads(path.read_text(encoding="utf-8"))
        return held["data"] if held["sha256"] == _sha256(held["data"]) else None
    except (OSError, ValueError, TypeError, KeyError, RecursionError):
        return None


def _case(path: Path) -> Any:
    """Return a measured case of the journal; None where its file has another shape."""
    data = _read(path)
    with contextlib.suppress(ValueError, TypeError, KeyError):
        tuple(map(point_from_json, data["points"]))
        TypeAdapter(list[Point]).validate_json(json.dumps(data["points"]), strict=True)
        if all(isinstance(data["made"][name], float | int) for name in spent_since()):
            return data
    return None


def _write(path: Path, data: Any) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    data = json.loads(json.dumps(data, allow_nan=False))
    write_text(path, json.dumps({"sha256": _sha256(data), "data": data}))
