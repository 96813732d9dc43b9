"""Does a frame cost the same in any world, and what does the unpruned one cost? (§4.1)

The same eye looks at worlds of 10³ to 10¹⁵ objects. Times are CPU seconds of one thread, from prune
to plain scene, and all worlds take turns. Unpruned, every object of a finite window is displayed,
up to a stated number of parts.
"""

import math
from dataclasses import dataclass, replace
from typing import Any

from bench.old_experiment import Effort
from bench.records.provenance import scene_digest
from bench.records.records import Column, Point, columns
from bench.statistics.timing import interleaved_seconds
from bench.windows import first_view, plain_scene, scene_bytes
from bench.windows import scene_hash as plain_hash
from lod.law import max_ground_distance
from lod.pruner import prune
from scenes.presets.load import load_preset

PRESET, SPECIES, SIZE = "crowd", "figure", "96x54"
WORLDS = (1e3, 1e5, 1e6, 1e9, 1e12, 1e15)
UNPRUNED = (1e2, 1e3, 3e3, 1e4)
"""The mean number of objects in an unpruned window; the last has some 10⁶ parts, the most."""


@dataclass(frozen=True)
class AllWorlds:
    """The case that times the frame of every world, all worlds in turns."""

    repeats: int


def cases(effort: Effort) -> list[AllWorlds]:
    """Return the one case of all worlds together: what is compared is timed in turns."""
    return [AllWorlds(effort["repeats"])]


def measure(case: AllWorlds, seed: int) -> list[Point]:
    """Make the frame of every world again and again: counts, and time of each repeat."""
    grid = [("blake", n) for n in WORLDS] + [("full", n) for n in UNPRUNED]
    views = [first_view(PRESET, SIZE, *settings(*each, seed)) for each in grid]
    points = [_point(*each, *view) for each, view in zip(grid, views, strict=True)]
    tasks = [lambda w=w, p=p, v=v: plain_scene(w, p, v) for w, p, v in views]
    times = interleaved_seconds(tasks, case.repeats)
    return [
        replace(point, samples=(*point.samples, Column("cpu_us", [round(1e6 * t) for t in row])))
        for point, row in zip(points, times, strict=True)
    ]


def notes(effort: Effort, seed: int, points: tuple[Point, ...]) -> dict[str, int]:
    """Return the repeats, and the parts of the largest world that was not pruned."""
    return {**effort.sizes, "most_parts_unpruned": max(p.column("parts")[0] for p in points)}


def settings(metric: str, objects: float, seed: int) -> tuple[str, ...]:
    """Return settings of a window that has so many objects of the species, on average."""
    side = min(math.sqrt(objects / load_preset(PRESET).species[SPECIES].density), 1e15)
    return f"world.extent={side!r}", f"view.metric={metric}", f"seed={seed}"


def _point(metric: str, objects: float, world: Any, preset: Any, view: Any) -> Point:
    """Count and hash a world; its first frame, which is not timed, compiles."""
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
        "scene": plain_hash(plain),
    }
    counts = {
        "objects": [sum(cut.displayed_objects for cut in cuts)],
        "parts": [sum(cut.displayed_parts for cut in cuts)],
        "bytes": [scene_bytes(plain)],
    }
    return Point(case, samples=columns(counts))


def scene_hash(points: tuple[Point, ...]) -> str:
    """Return the SHA-256 of the preset and the worlds."""
    preset = load_preset(PRESET).model_dump(mode="json")
    return scene_digest([preset, SIZE, WORLDS, UNPRUNED])
