"""What does a frame cost, stage by stage, and what share of it is the metric? (§4.2)

Every repeat is a fresh process, whose first frame compiles. Times are by the clock, on all cores.
"""

import json
import os
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from bench.experiments.cost.size_child import KINDS
from bench.experiments.cost.sizes import Size, measure_size, size_cases
from bench.records.points import Column, Point, columns
from bench.records.provenance import scene_digest
from bench.runner.experiment import Effort
from scenes.preset.load import load_preset
from scenes.render.mitsuba.variants import choose, trusting

SETTINGS = ("render.size=320x180", "render.spp=8", "species.sward.density=0")
_FRAMES = 4
_LONGEST_S = 600
_ROOT = Path(__file__).resolve().parents[3]


@dataclass(frozen=True)
class Process:
    """A fresh process; its number is added to the run's seed."""

    number: int
    variant: str


def cases(effort: Effort) -> list[Process | Size]:
    """Return as many processes as the effort says, and every size of world."""
    processes = [Process(number, choose()) for number in range(effort["processes"])]
    return [*processes, *size_cases(effort)]


def measure(case: Process | Size, seed: int) -> list[Point]:
    """Run a process, and return the points of its frames and of its start; or of both sides."""
    if isinstance(case, Size):
        return measure_size(case, seed)
    return process_points(_child(case.variant, seed + case.number))


def process_points(found: dict[str, Any]) -> list[Point]:
    """Make points of the times of a process's frames, and of what came before them."""
    rows = found["warm"]
    tests = Column("tests", [row["tests"] for row in rows])
    stages = [name for name in rows[0] if name != "tests"]
    times = (Column("us", [row[name] for row in rows], {"stage": name}) for name in stages)
    drawn = (Column("drawn", [n], {"what": what}) for what, n in found["statistics"].items())
    cold = columns({name: [value] for name, value in found["cold"].items()})
    return [
        Point({"what": "frames"}, samples=(*times, tests)),
        Point({"what": "processes"}, samples=(*cold, *drawn)),
    ]


def notes(effort: Effort, seed: int, points: tuple[Point, ...]) -> dict[str, Any]:
    """Return the sizes of the run, and the frames of each process."""
    return {**effort.sizes, "frames_of_each": _FRAMES}


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


def scene_hash(points: tuple[Point, ...]) -> str:
    """Return the SHA-256 of the presets and of the cases."""
    presets = [("meadow", SETTINGS), *KINDS.values()]
    loaded = [load_preset(*each).model_dump(mode="json") for each in presets]
    return scene_digest([loaded, [p.case for p in points]])
