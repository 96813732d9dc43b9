"""What does a frame cost, stage by stage, and what share of it is the metric? (§4.2)

Every repeat is a fresh process, whose first frame compiles. Times are by the clock, on all cores.
And what do ever larger worlds cost, pruned and whole, and is the picture as good? Each side of each
world has a fresh process; the error is FLIP of what the two saw.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from bench.children import run_in_child
from bench.frame_costs import KINDS, Size, preset_costs, window_costs
from bench.images.compare import flips
from bench.old_experiment import Effort
from bench.records.provenance import scene_digest
from bench.records.records import Column, Point, columns
from bench.seeds import first_seed
from scenes.presets.load import load_preset
from scenes.render.variants import choose

SETTINGS = ("render.size=320x180", "render.spp=8", "species.sward.density=0")
SIDES = "whole", "pruned"
_FRAMES = 4


@dataclass(frozen=True)
class Process:
    """A fresh process; its number is added to the run's seed."""

    number: int
    variant: str


def cases(effort: Effort) -> list[Process | Size]:
    """Return as many processes as the effort says, and every field of every size of world."""
    variant = choose()
    rest = effort["size"], effort["spp"], effort["frames"], tuple(effort["samples"]), variant
    return [
        *(Process(number, variant) for number in range(effort["processes"])),
        *(
            Size(kind, objects, field, effort["unseen"], *rest)
            for kind, sizes in effort["worlds"].items()
            for objects in sizes
            for field in range(effort["fields"])
        ),
    ]


def measure(case: Process | Size, seed: int) -> list[Point]:
    """Run a process, and return the points of its frames and of its start; or of both sides."""
    if isinstance(case, Size):
        return measure_size(case, seed)
    words = [*SETTINGS, f"seed={seed + case.number}"]
    child = run_in_child(preset_costs, words, case.variant, _FRAMES, variant=case.variant)
    return process_points(child.result)


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


def measure_size(case: Size, seed: int) -> list[Point]:
    """Measure one world on both sides: a point for each."""
    made, seen = [], dict[str, list[np.ndarray]]()
    world_seed = first_seed(case.unseen, 4) + 12 * seed + case.field
    for side in SIDES:
        found = run_in_child(window_costs, case, side, world_seed, variant=case.variant).result
        seen[side] = [each.astype(np.float64) for each in found["pictures"]]
        rows = found["rows"]
        counts = {"field": case.field, "peak_bytes": found["peak_bytes"], **found["statistics"]}
        errors = flips(seen[side], seen["whole"]) if side == "pruned" else []
        samples = (
            *(Column("us", [row[stage] for row in rows], {"stage": stage}) for stage in rows[0]),
            *columns({name: [value] for name, value in counts.items()}),
            *(
                Column("flip_ppm", [round(1e6 * error)], {"samples": spp, "number": number})
                for number, (spp, error) in enumerate(zip(case.samples, errors, strict=False))
            ),
        )
        named = {"what": "size", "kind": case.kind, "objects": case.objects, "side": side}
        made.append(Point(named, samples=samples))
    return made


def notes(effort: Effort, seed: int, points: tuple[Point, ...]) -> dict[str, Any]:
    """Return the sizes of the run, and the frames of each process."""
    return {**effort.sizes, "frames_of_each": _FRAMES}


def scene_hash(points: tuple[Point, ...]) -> str:
    """Return the SHA-256 of the presets and of the cases."""
    presets = [("meadow", SETTINGS), *KINDS.values()]
    loaded = [load_preset(*each).model_dump(mode="json") for each in presets]
    return scene_digest([loaded, [p.case for p in points]])
