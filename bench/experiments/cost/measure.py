"""What does a frame cost, stage by stage, and what share of it is the metric? (§4.2)

Every repeat is a fresh process: its first frame compiles, the others do not. Wall-clock times on
all cores.
"""

import hashlib
import json
import os
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

from bench.experiments.cost.claims import judge
from bench.records.provenance import provenance
from bench.records.records import Point, Record
from bench.runner.experiment import Progress, silent
from bench.runner.run_cases import make_record
from scenes.preset.load import load_preset
from scenes.render.mitsuba.variants import choose, trusting

NAME, VERSION = "cost", 1

SETTINGS = ("render.size=320x180", "render.spp=8")
_PROCESSES, _QUICK_PROCESSES = 8, 2
_FRAMES = 4
_LONGEST_S = 600
_ROOT = Path(__file__).resolve().parents[3]


def run(quick: bool = False, progress: Progress = silent, seed: int = 0) -> Record:
    """Render meadow in fresh processes and judge the claims."""
    start, variant, found = time.perf_counter(), choose(), []
    processes = _QUICK_PROCESSES if quick else _PROCESSES
    for number in range(processes):
        progress(number, processes, f"process {number + 1}")
        found.append(_child(variant, seed + number))
    progress(processes, processes, "judged")
    points = (
        Point({"what": "frames"}, {}, _columns([row for each in found for row in each["warm"]])),
        Point({"what": "processes"}, {}, _columns([each["cold"] for each in found])),
    )
    return make_record(
        NAME,
        VERSION,
        quick=quick,
        provenance=provenance(_scene_hash(), seed, os.cpu_count() or 1, variant),
        points=points,
        claims=judge(points),
        notes={"processes": processes, "frames_of_each": _FRAMES, "drawn": found[-1]["statistics"]},
        start=start,
    )


def _child(variant: str, seed: int) -> dict[str, Any]:
    words = [variant, str(_FRAMES), *SETTINGS, f"seed={seed}"]
    paths = os.pathsep.join([str(_ROOT), *filter(None, [os.environ.get("PYTHONPATH")])])
    done = subprocess.run(
        [sys.executable, "-P", "-m", "bench.experiments.cost.child", *words],
        env={**trusting(variant), "PYTHONPATH": paths},
        stdout=subprocess.PIPE,
        timeout=_LONGEST_S,
        check=True,
        text=True,
    )
    found: dict[str, Any] = json.loads(done.stdout.splitlines()[-1])
    return found


def _columns(rows: list[dict[str, int]]) -> dict[str, list[int]]:
    return {name: [row[name] for row in rows] for name in rows[0]}


def _scene_hash() -> str:
    preset = load_preset("meadow", list(SETTINGS)).model_dump(mode="json")
    return hashlib.sha256(json.dumps(preset, sort_keys=True).encode()).hexdigest()
