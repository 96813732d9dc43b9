"""Are records of a run that was killed again and again those of an unbroken one?

``python -m bench.resume_benchmark [EXPERIMENT ...] [--seed N]``: the quick run of all experiments,
or of these, unbroken; then the same in another folder, killed (SIGKILL) at KILLS random moments
and begun again. Prints one JSON object; exits 1 where cases, predictions or samples differ. Times
aside: columns of microseconds, and all samples of experiments that are timed.
"""

import argparse
import json
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np

from bench.experiments import EXPERIMENTS
from bench.records import Point, Record, read_records

KILLS = 5


def killed_and_whole(names: list[str], seed: int) -> dict[str, Any]:
    """Both runs: how often the one was killed and when [s], and for each experiment whether it made
    the same record. Raises RuntimeError where a run does not end well.
    """
    with tempfile.TemporaryDirectory() as place:
        whole, broken = Path(place) / "whole", Path(place) / "broken"
        start = time.perf_counter()
        _end(names, whole)
        took = time.perf_counter() - start
        moments = np.random.default_rng(seed).uniform(0, took / 3, KILLS)
        killed = [round(float(each), 1) for each in moments if _killed_after(names, broken, each)]
        _end(names, broken)
        pairs = zip(read_records(whole), read_records(broken), strict=True)
        same = {one.experiment: aside(one) == aside(other) for one, other in pairs}
    return {"unbroken_s": round(took, 1), "killed_after_s": killed, "same": same}


def aside(record: Record) -> dict[str, Any]:
    """What of a record may not depend on when it was made, nor on how long that took."""
    timed = EXPERIMENTS[record.experiment].timed
    points = [
        {"case": p.case, "predicted": p.predicted, "samples": _without_times(p, timed)}
        for p in record.points
    ]
    return {"experiment": record.experiment, "version": record.version, "points": points}


def _without_times(point: Point, timed: bool) -> dict[str, list[int] | None]:
    timed = timed or point.case.get("what") == "time"
    return {
        name: None if timed or name.endswith("_us") else column
        for name, column in point.samples.items()
    }


def _started(names: list[str], folder: Path) -> subprocess.Popen[bytes]:
    words = (sys.executable, "-m", "bench.cli", "run", *names, "--quick", "-o", str(folder))
    return subprocess.Popen(words, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)


def _end(names: list[str], folder: Path) -> None:
    process = _started(names, folder)
    _, said = process.communicate()
    if process.returncode:
        raise RuntimeError(said.decode(errors="replace"))


def _killed_after(names: list[str], folder: Path, seconds: float) -> bool:
    """Whether it was still at work then."""
    process = _started(names, folder)
    try:
        process.communicate(timeout=seconds)
    except subprocess.TimeoutExpired:
        process.kill()
        process.communicate()
        return True
    return False


def main() -> int:
    """Measure and print; 1 where records differ."""
    parser = argparse.ArgumentParser(prog="python -m bench.resume_benchmark")
    parser.add_argument("experiments", nargs="*", default=["all"])
    parser.add_argument("--seed", type=int, default=0)
    asked = parser.parse_args()
    found = killed_and_whole(asked.experiments, asked.seed)
    print(json.dumps(found))
    return 0 if all(found["same"].values()) else 1


if __name__ == "__main__":
    sys.exit(main())
