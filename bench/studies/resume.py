"""Are records of a run that was killed again and again those of an unbroken one?

``python -m bench.studies.resume [EXPERIMENT ...] [--seed N]``: the quick run of all experiments,
or of these, unbroken; then the same in another folder, killed (SIGKILL, with what it started) at
KILLS random moments and begun again. Prints one JSON object; exits 1 where cases, predictions,
samples or notes (settings and pictures) differ. Times aside: columns of microseconds, notes of
seconds, and all samples of experiments that are timed, whose cases name the scene by its hash.

Twice `lodbench run all --quick`, and what the kills cost: about half an hour of two cores.
"""

import argparse
import json
import os
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np

from bench.experiments.registry import EXPERIMENTS
from bench.records.records import Point, Record, read_records

KILLS = 5

_TIMES = {"seconds", "times"}
"""Words in the names of notes that tell of time."""


def killed_and_whole(names: list[str], seed: int) -> dict[str, Any]:
    """Both runs: how often the one was killed and when [s], and for each experiment whether it made
    the same record. Raises RuntimeError where a run does not end well.
    """
    with tempfile.TemporaryDirectory() as place:
        whole, broken = Path(place) / "whole", Path(place) / "broken"
        start = time.perf_counter()
        _end(names, whole)
        took = time.perf_counter() - start
        spans = spans_between(took, seed)
        killed = [round(each, 1) for each in spans if _killed_after(names, broken, each)]
        _end(names, broken)
        pairs = zip(read_records(whole), read_records(broken), strict=True)
        same = {one.experiment: aside(one) == aside(other) for one, other in pairs}
    return {"unbroken_s": round(took, 1), "killed_after_s": killed, "same": same}


def spans_between(took: float, seed: int) -> list[float]:
    """How long it works before every kill [s]: all fall in two thirds of what a run takes.

    The second time it may be faster: what was compiled is kept.
    """
    moments = np.sort(np.random.default_rng(seed).uniform(0, took * 2 / 3, KILLS))
    spans: list[float] = np.diff(moments, prepend=0.0).tolist()
    return spans


def aside(record: Record) -> dict[str, Any]:
    """What of a record may not depend on when it was made, nor on how long that took."""
    timed = EXPERIMENTS[record.experiment].timed
    points = [
        {"case": p.case, "predicted": p.predicted, "samples": _without_times(p, timed)}
        for p in record.points
    ]
    notes = {k: v for k, v in record.notes.items() if not _TIMES.intersection(k.split("_"))}
    named = {"experiment": record.experiment, "version": record.version, "quick": record.quick}
    return {**named, "points": points, "notes": notes}


def _without_times(point: Point, timed: bool) -> dict[str, list[int] | None]:
    timed = timed or point.case.get("what") == "time"
    return {
        name: None if timed or name.endswith("_us") else column
        for name, column in point.samples.items()
    }


def _started(names: list[str], folder: Path) -> subprocess.Popen[bytes]:
    words = (sys.executable, "-m", "bench.cli.main", "run", *names, "--quick", "-o", str(folder))
    return subprocess.Popen(
        words, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, start_new_session=True
    )


def _end(names: list[str], folder: Path) -> None:
    _ended_well(_started(names, folder), None)


def _ended_well(process: subprocess.Popen[bytes], within_s: float | None) -> None:
    """Raises TimeoutExpired for one still at work, RuntimeError for one that ends badly."""
    _, said = process.communicate(timeout=within_s)
    if process.returncode:
        raise RuntimeError(said.decode(errors="replace"))


def _killed_after(names: list[str], folder: Path, seconds: float) -> bool:
    """Whether it was still at work then."""
    process = _started(names, folder)
    try:
        _ended_well(process, seconds)
    except subprocess.TimeoutExpired:
        os.killpg(process.pid, signal.SIGKILL)
        process.communicate()
        return True
    return False


def main() -> int:
    """Measure and print; 1 where records differ."""
    parser = argparse.ArgumentParser(prog="python -m bench.studies.resume")
    parser.add_argument("experiments", nargs="*", default=["all"])
    parser.add_argument("--seed", type=int, default=0)
    asked = parser.parse_args()
    found = killed_and_whole(asked.experiments, asked.seed)
    print(json.dumps(found))
    return 0 if all(found["same"].values()) else 1


if __name__ == "__main__":
    sys.exit(main())
