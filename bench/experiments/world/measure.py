"""Does a frame cost the same in any world, and what does the unpruned one cost? (§4.1)

The same eye in worlds of 10³ to 10¹⁵ objects: from prune to plain scene, in the processor's seconds
of one thread, repeats of all worlds taking turns. Unpruned, every object of a finite window, up to
a stated number of parts.
"""

import hashlib
import json
import math
import time
from typing import Any

from bench.experiments.world.claims import judge
from bench.fields.plain_scene import first_view, plain_scene, scene_bytes, scene_hash
from bench.records.provenance import provenance
from bench.records.records import Point, Record
from bench.runner.experiment import Progress, silent
from bench.runner.run_cases import make_record
from bench.runner.timing import interleaved_seconds
from lod.law.uneven_ground import max_ground_distance
from lod.pruning.pruner import prune
from scenes.preset.load import load_preset

NAME, VERSION = "world", 1

PRESET, SPECIES, SIZE = "crowd", "figure", "96x54"
WORLDS = (1e3, 1e5, 1e6, 1e9, 1e12, 1e15)
UNPRUNED = (1e2, 1e3, 3e3, 1e4)
"""Objects in the window, on average; the last has some 10⁶ parts, which is the ceiling."""

_REPEATS, _QUICK_REPEATS = 31, 8


def run(quick: bool = False, progress: Progress = silent, seed: int = 0) -> Record:
    """Make the frame of every world again and again, and judge the claims."""
    start = time.perf_counter()
    grid = [("blake", n) for n in WORLDS] + [("full", n) for n in UNPRUNED]
    made = []
    for number, (metric, objects) in enumerate(grid):
        progress(number, len(grid) + 1, f"{metric}, {objects:.0e} objects")
        made.append(first_view(PRESET, SIZE, *settings(metric, objects, seed)))
    points = tuple(_point(*case, *each) for case, each in zip(grid, made, strict=True))
    progress(len(grid), len(grid) + 1, "timing")
    repeats = _QUICK_REPEATS if quick else _REPEATS
    tasks = [lambda w=w, p=p, v=v: plain_scene(w, p, v) for w, p, v in made]
    for point, seconds in zip(points, interleaved_seconds(tasks, repeats), strict=True):
        point.samples["cpu_us"] = [round(1e6 * each) for each in seconds]
    progress(len(grid) + 1, len(grid) + 1, "judged")
    return make_record(
        NAME,
        VERSION,
        quick=quick,
        provenance=provenance(_scene_hash(), seed),
        points=points,
        claims=judge(points),
        notes={
            "repeats": repeats,
            "most_parts_unpruned": max(p.samples["parts"][0] for p in points),
        },
        start=start,
    )


def settings(metric: str, objects: float, seed: int) -> tuple[str, ...]:
    """A window of so many objects of the species, on average, about the same eye."""
    side = min(math.sqrt(objects / load_preset(PRESET).species[SPECIES].density), 1e15)
    return f"world.extent={side!r}", f"view.metric={metric}", f"seed={seed}"


def _point(metric: str, objects: float, world: Any, preset: Any, view: Any) -> Point:
    """A world's counts and hash; its first frame, not timed, compiles what is compiled."""
    cuts = [prune(each, view) for each in world.fields]
    plain = plain_scene(world, preset, view)
    reach = 0.0
    if metric != "full":
        reach = max(
            max_ground_distance(each.prototypes.part_tables.hierarchies, view)
            for each in world.fields
        )
    case = {
        "metric": metric,
        "objects": objects,
        "side_m": preset.world.extent,
        "limit_m": reach,
        "scene": scene_hash(plain),
    }
    counts = {
        "objects": [sum(cut.displayed_objects for cut in cuts)],
        "parts": [sum(cut.displayed_parts for cut in cuts)],
        "bytes": [scene_bytes(plain)],
    }
    return Point(case, {}, counts)


def _scene_hash() -> str:
    preset = load_preset(PRESET).model_dump(mode="json")
    words = json.dumps([preset, SIZE, WORLDS, UNPRUNED], sort_keys=True)
    return hashlib.sha256(words.encode()).hexdigest()
