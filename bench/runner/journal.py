"""What of a run is done already? The same command goes on where it was stopped.

In DIR/.journal, one small file for each measured case and each finished record, named for all that
made it: sources, packages, machine, experiment, seed and the case itself. Nothing that was made by
other sources or another machine can be taken for it.
"""

import hashlib
import importlib.util
import json
import math
import os
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, dataclass, fields
from functools import lru_cache
from pathlib import Path
from typing import Any

from bench.records.points import Point, point_from_json, point_json
from bench.records.provenance import provenance
from bench.records.records import read_record
from bench.runner.dask_cases import CaseExecutor
from lod.errors import InputError
from scenes.plugins.entry_points import modules
from scenes.processes.cache import PACKAGES, source_digest

JOURNAL = ".journal"


@dataclass(frozen=True)
class RunRequest:
    """One experiment as it was asked for; ``metric`` names another to be tried beside its own."""

    name: str
    quick: bool
    seed: int
    metric: str | None = None


@dataclass(frozen=True)
class Elapsed:
    """Seconds by the clock, and of all cores, in this process and in those that it started."""

    seconds: float
    processor_seconds: float

    @classmethod
    def so_far(cls) -> "Elapsed":
        """Return the time up to now, from a start that means nothing by itself."""
        return cls(time.perf_counter(), math.fsum(os.times()[:4]))

    def __sub__(self, other: "Elapsed") -> "Elapsed":
        return Elapsed(
            self.seconds - other.seconds, self.processor_seconds - other.processor_seconds
        )

    def __add__(self, other: "Elapsed") -> "Elapsed":
        return Elapsed(
            self.seconds + other.seconds, self.processor_seconds + other.processor_seconds
        )

    def as_json(self) -> dict[str, float]:
        """Return plain data as a record notes it, in tenths of a second."""
        return {name: round(value, 1) for name, value in asdict(self).items()}


@dataclass(frozen=True)
class Journal:
    """What is done in a folder; ``maker`` is a digest of the sources and of the machine."""

    folder: Path
    maker: str

    def record_of(self, asked: RunRequest) -> Path | None:
        """Return the path of the finished record; None without one that still verifies."""
        found = _read(self._path("record", asked))
        if found is None:
            return None
        path = self.folder / str(found)
        try:
            read_record(path)
        except InputError:
            return None
        return path

    def finished(self, asked: RunRequest, record: Path) -> None:
        """Note that a record is finished; its cases need not be kept any longer."""
        _write(self._path("record", asked), record.name)
        for path in self._cases(asked).glob("*.json"):
            path.unlink()

    def discard(self, asked: RunRequest) -> None:
        """Forget what was asked for and its cases; records stay."""
        self._path("record", asked).unlink(missing_ok=True)
        for path in self._cases(asked).glob("*.json"):
            path.unlink()

    def elapsed(self, asked: RunRequest) -> "Elapsed":
        """Return the time that the kept cases took when they were measured."""
        found = [_read(path) for path in self._cases(asked).glob("*.json")]
        return Elapsed(
            *(math.fsum(each[k.name] for each in found if each) for k in fields(Elapsed))
        )

    def memoised(self, asked: RunRequest, each: CaseExecutor) -> CaseExecutor:
        """Return an executor like ``each`` that keeps results, and measures no case twice."""

        def kept(
            function: Callable[..., Any], cases: Sequence[tuple[Any, ...]]
        ) -> Iterator[Point | list[Point]]:
            folder = self._cases(asked)
            paths = [folder / f"{_sha256(_function_name(function), case)}.json" for case in cases]
            done = [_read(path) for path in paths]
            left = [case for case, data in zip(cases, done, strict=True) if data is None]
            measured = each(function, left)
            for path, data in zip(paths, done, strict=True):
                if data is None:
                    start = Elapsed.so_far()
                    result = next(measured)
                    took = asdict(Elapsed.so_far() - start)
                    _write(path, {"result": _as_json(result), **took})
                    yield result
                else:
                    yield _from_json(data["result"])

        return kept

    def _path(self, what: str, asked: RunRequest) -> Path:
        return self.folder / JOURNAL / f"{what}-{asked.name}-{_sha256(self.maker, asked)[:16]}.json"

    def _cases(self, asked: RunRequest) -> Path:
        return self._path("cases", asked).with_suffix("")


def journal(folder: Path) -> Journal:
    """Return the journal of a folder, for the sources and the machine that are here."""
    here = asdict(provenance("", 0)) | {"commit": None}
    return Journal(Path(folder), _sha256(here, sources()))


@lru_cache(maxsize=1)
def sources() -> str:
    """Return the SHA-256 of every source that could change a number, plug-ins included."""
    return source_digest((*PACKAGES, *map(_source, modules())))


def _source(module: str) -> Path:
    """Find the folder of a package or the file of a module; without one, a path to nothing."""
    found = importlib.util.find_spec(module)
    origin = Path(found.origin if found and found.origin else module)
    return origin.parent if origin.name == "__init__.py" else origin


def _sha256(*words: object) -> str:
    return hashlib.sha256(repr(words).encode()).hexdigest()


def _function_name(function: Callable[..., Any]) -> str:
    """Return a name of the function that is the same in every process."""
    return getattr(function, "__qualname__", None) or repr(function)


def _as_json(result: Point | list[Point]) -> Any:
    if isinstance(result, Point):
        return point_json(result)
    return [point_json(point) for point in result]


def _from_json(data: Any) -> Point | list[Point]:
    return point_from_json(data) if isinstance(data, dict) else [*map(point_from_json, data)]


def _read(path: Path) -> Any:
    """Return what a JSON file holds; None where there is none, or half of one."""
    try:
        return json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return None


def _write(path: Path, data: Any) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    temporary = path.with_suffix(f".{os.getpid()}.part")
    temporary.write_text(json.dumps(data, allow_nan=False), encoding="utf-8")
    os.replace(temporary, path)
