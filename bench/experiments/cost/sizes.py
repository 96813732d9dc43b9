"""What do ever larger worlds cost, pruned and whole, stage by stage, and is the picture as good?

Each side of each world has a fresh process (``size_child``); the error is FLIP of what the two saw.
"""

import json
import os
import subprocess
import sys
import tempfile
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from bench.experiments.fidelity.shipped.pictures import flips
from bench.fields.judged_seeds import first_seed
from bench.records.points import Column, Key, Point, columns
from bench.runner.experiment import Effort
from scenes.render.mitsuba.variants import choose, trusting

SIDES = "whole", "pruned"
_LONGEST_S = 1800
_ROOT = Path(__file__).resolve().parents[3]


@dataclass(frozen=True)
class Size:
    """One field of one size of world; ``samples`` are those of the pictures that are compared."""

    kind: str
    objects: float
    field: int
    unseen: bool
    size: str
    spp: int
    frames: int
    samples: tuple[int, ...]
    variant: str

    @property
    def label(self) -> str:
        """The name of the case, in short."""
        return f"{self.kind}, {self.objects:g} objects, field {self.field + 1}"


def size_cases(effort: Effort) -> list[Size]:
    """Return every field of every size of every kind of world."""
    rest = effort["size"], effort["spp"], effort["frames"], tuple(effort["samples"]), choose()
    return [
        Size(kind, objects, field, effort["unseen"], *rest)
        for kind, sizes in effort["worlds"].items()
        for objects in sizes
        for field in range(effort["fields"])
    ]


def measure_size(case: Size, seed: int) -> list[Point]:
    """Measure one world on both sides: a point for each."""
    made = []
    with tempfile.TemporaryDirectory() as folder:
        seen: dict[str, list[np.ndarray]] = {}
        for side in SIDES:
            path = Path(folder) / f"{side}.npz"
            world_seed = first_seed(case.unseen, 4) + 12 * seed + case.field
            words = asdict(case) | {"side": side, "seed": world_seed, "pictures": str(path)}
            found = _child(words, case.variant)
            with np.load(path) as pictures:
                seen[side] = [pictures[name].astype(np.float64) for name in pictures.files]
            errors = flips(seen[side], seen["whole"]) if side == "pruned" else []
            made.append(_point(case, side, found, errors))
    return made


def _point(case: Size, side: str, found: dict[str, Any], errors: list[float]) -> Point:
    rows = found["rows"]
    named = {"what": "size", "kind": case.kind, "objects": case.objects, "side": side}
    counts = {"field": case.field, "peak_bytes": found["peak_bytes"], **found["statistics"]}
    flip: list[Column] = []
    for number, (samples, error) in enumerate(zip(case.samples, errors, strict=False)):
        keys: dict[str, Key] = {"samples": samples, "number": number}
        flip.append(Column("flip_ppm", [round(1e6 * error)], keys))
    return Point(
        named,
        samples=(
            *(Column("us", [row[stage] for row in rows], {"stage": stage}) for stage in rows[0]),
            *columns({name: [value] for name, value in counts.items()}),
            *flip,
        ),
    )


def _child(words: dict[str, Any], variant: str) -> dict[str, Any]:
    paths = os.pathsep.join([str(_ROOT), *filter(None, [os.environ.get("PYTHONPATH")])])
    done = subprocess.run(
        [sys.executable, "-P", "-m", "bench.experiments.cost.size_child"],
        input=json.dumps(words),
        env={**trusting(variant), "PYTHONPATH": paths},
        stdout=subprocess.PIPE,
        timeout=_LONGEST_S,
        check=True,
        text=True,
    )
    found: dict[str, Any] = json.loads(done.stdout.splitlines()[-1])
    return found
