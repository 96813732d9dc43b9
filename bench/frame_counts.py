"""How many objects and parts does one frame examine and display, and what does the law predict?

No renderer is needed.

Which counts must the first frame of a preset give, at which version of the workload?

``meadow@1`` is a preset at a version. Its counts are golden: where a preset, a species or pruning
counts otherwise, it is another workload and takes the next version, so that a changed workload is
never mistaken for a changed system. ``python -m bench.frame_counts`` counts anew and gives
changed ones their next version.
"""

import json
import math
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from lod.errors import InputError
from lod.law import (
    CountMoments,
    count_moments,
    count_variance,
    disc_areas,
    expected_count,
    ground_nodes,
    limits_seen,
)
from lod.pruner import Cut, prune
from lod.view import View
from scenes.field.species_field import SpeciesField
from scenes.presets.load import preset_names
from scenes.scene import Scene
from scenes.world.world import World

_NODES = 2**16
"""Nodes of the law's integral over the ground of one species: right to 0.05 % in the presets."""

Follow = Callable[[int, int, str], object]
"""Called with the number of steps done, the number in all, and a name for what comes next."""


@dataclass(frozen=True)
class Tally:
    """Number of objects, or of parts, in one frame; ``predicted`` is None without a law."""

    examined: int
    displayed: int
    predicted: float | None
    predicted_sd: float | None

    def __add__(self, other: "Tally") -> "Tally":
        known = self.predicted is not None and other.predicted is not None
        return Tally(
            self.examined + other.examined,
            self.displayed + other.displayed,
            self.predicted + other.predicted if known else None,  # type: ignore[operator]
            float(np.hypot(self.predicted_sd, other.predicted_sd)) if known else None,  # type: ignore[arg-type]
        )


@dataclass(frozen=True)
class SpeciesCount:
    """Counts of one species in one frame; ``by_level`` counts its displayed parts."""

    objects: Tally
    parts: Tally
    by_level: tuple[int, ...]
    predicted_by_level: tuple[float, ...] | None


@dataclass(frozen=True)
class Counts:
    """Counts of one frame of a world; ``objects`` and ``parts`` are those of the field's species.

    others: objects and parts of each representation beside the field; no law is claimed of them
    """

    objects: Tally
    parts: Tally
    by_species: dict[str, SpeciesCount]
    others: dict[str, tuple[Tally, Tally]]
    terrain_tiles: int
    terrain_triangles: int
    detail: float
    m: float
    seconds: dict[str, float]

    @property
    def by_level(self) -> tuple[int, ...]:
        """Displayed parts of all species on each level."""
        rows = [each.by_level for each in self.by_species.values()]
        deepest = max((len(row) for row in rows), default=0)
        return tuple(sum(row[k] for row in rows if k < len(row)) for k in range(deepest))


@dataclass
class Stopwatch:
    """Wall-clock seconds spent in named stages."""

    seconds: dict[str, float] = field(default_factory=dict)

    @contextmanager
    def stage(self, name: str) -> Iterator[None]:
        """Add the time spent inside to that stage."""
        start = time.perf_counter()
        try:
            yield
        finally:
            self.seconds[name] = self.seconds.get(name, 0.0) + time.perf_counter() - start


def ignore_steps(done: int, total: int, next_step: str) -> None:
    """Watch nothing."""


def count(
    world: World, view: View, ground: Cut | None = None, follow: Follow = ignore_steps
) -> Counts:
    """Prune one frame and hold every species against its prediction.

    ground  the cut of the ground, where it is known already
    follow  is called before each step
    """
    watch, by_species = Stopwatch(), {}
    steps = len(world.fields) + len(world.beside) + 1
    for done, each in enumerate(world.fields):
        follow(done, steps, each.name)
        with watch.stage("prune"):
            cut = prune(each, view)
        with watch.stage("predict"):
            predicted = predict(each, view)
        by_species[each.name] = _species_count(cut, predicted, each.species.density)
    others: dict[str, tuple[Tally, Tally]] = {}
    for done, one in enumerate(world.beside, len(world.fields)):
        follow(done, steps, one.name)
        with watch.stage("prune"):
            others[one.name] = _tallies(prune(one, view))
    follow(steps - 1, steps, "ground")
    with watch.stage("terrain"):
        ground = prune(world.terrain, view) if ground is None else ground
        triangles = world.terrain.triangle_count(ground.parts)
    nothing = Tally(0, 0, 0.0, 0.0)
    return Counts(
        objects=sum((s.objects for s in by_species.values()), nothing),
        parts=sum((s.parts for s in by_species.values()), nothing),
        by_species=by_species,
        others=others,
        terrain_tiles=ground.displayed_parts,
        terrain_triangles=triangles,
        detail=view.detail,
        m=view.m,
        seconds=watch.seconds,
    )


def predict(each: SpeciesField, view: View) -> CountMoments | None:
    """Predict one species by the law, per unit density; None for a metric without a law.

    The closed form holds on flat ground all round; otherwise the law is integrated over the ground.
    """
    trees, view = each.prototypes.part_tables.hierarchies, each.species.seen_in(view)
    if view.metric.along_axis:
        return None
    low, high = each.ground.bounds()
    if view.look_around and low == high and each.extent is None and not each.species.habitat:
        return _flat(each, view, high)
    farthest = math.inf if each.extent is None else _farthest_corner(each, view)
    net = ground_nodes(trees, view, _NODES, farthest)
    if each.extent is not None:
        net = type(net)(net.xy, np.where(_in_window(each, view, net.xy), net.area, 0.0), net.turn)
    if each.species.habitat is not None:
        area = net.area * each.species.habitat.share(view.camera.corner, net.xy)
        net = type(net)(net.xy, area, net.turn)
    return count_moments(trees, view, net, each.ground.height(view.camera.corner, net.xy))


def _flat(each: SpeciesField, view: View, ground: float) -> CountMoments:
    trees = each.prototypes.part_tables.hierarchies
    share = 1 / len(trees)
    levels = np.zeros(1 + max(int(tree.level.max()) for tree in trees))
    objects = parts = spread = 0.0
    for tree in trees:
        above = view.camera.eye[2] - ground - tree.position[:, 2]
        limits = limits_seen(tree, view, view.m)
        areas = disc_areas(limits, above)
        objects += expected_count(share, areas[:1])
        parts += expected_count(share, areas)
        spread += count_variance(share, areas)
        levels += share * np.bincount(tree.level, weights=areas, minlength=len(levels))
    return CountMoments(objects, objects, parts, spread, tuple(float(v) for v in levels))


def _in_window(each: SpeciesField, view: View, xy: np.ndarray) -> np.ndarray:
    half = each.extent / 2  # type: ignore[operator]
    return (np.abs(xy + _corner_m(view)) <= half).all(axis=1)


def _farthest_corner(each: SpeciesField, view: View) -> float:
    eye = np.abs(view.camera.eye[:2] + _corner_m(view))
    return float(np.hypot(*(eye + each.extent / 2)))  # type: ignore[operator]


def _corner_m(view: View) -> np.ndarray:
    corner = view.camera.corner
    return np.array(corner.lattice(1.0)[:2], np.float64)


def _tallies(cut: Cut) -> tuple[Tally, Tally]:
    """Count the objects and parts of a cut of which no law is claimed."""
    return (
        Tally(cut.examined_objects, cut.displayed_objects, None, None),
        Tally(cut.examined_parts, cut.displayed_parts, None, None),
    )


def _species_count(cut: Cut, predicted: CountMoments | None, density: float) -> SpeciesCount:
    levels = int(cut.level.max(initial=0)) + 1
    if predicted is not None:
        levels = max(levels, len(predicted.parts_by_level))
    means: tuple[float | None, float | None] = (None, None)
    spreads: tuple[float | None, float | None] = (None, None)
    if predicted is not None:
        means = density * predicted.objects, density * predicted.parts
        variances = predicted.objects_variance, predicted.parts_variance
        spreads = math.sqrt(density * variances[0]), math.sqrt(density * variances[1])
    by_level = np.bincount(cut.level, minlength=levels)
    return SpeciesCount(
        objects=Tally(cut.examined_objects, cut.displayed_objects, means[0], spreads[0]),
        parts=Tally(cut.examined_parts, cut.displayed_parts, means[1], spreads[1]),
        by_level=tuple(int(n) for n in by_level),
        predicted_by_level=None
        if predicted is None
        else tuple(density * area for area in predicted.parts_by_level),
    )


_FILE = Path(__file__).with_name("workloads.json")


@dataclass(frozen=True)
class Workload:
    """A preset at a version, with the counts of its first frame by the names of `golden_counts`."""

    preset: str
    version: int
    counts: dict[str, Any]

    @property
    def name(self) -> str:
        """Write preset and version as ``meadow@1``."""
        return f"{self.preset}@{self.version}"

    def mismatches(self, counts: Counts) -> list[str]:
        """Write one line for each count that is not golden."""
        found = golden_counts(counts)
        return [
            f"{name} {found[name]} instead of {wanted}"
            for name, wanted in self.counts.items()
            if found[name] != wanted
        ]


def workloads() -> dict[str, Workload]:
    """Read every workload, at the version that this program makes, by the name of its preset."""
    data = json.loads(_FILE.read_text(encoding="utf-8"))
    return {each["preset"]: Workload(**each) for each in data}


def workload_named(text: str) -> Workload | None:
    """Find the workload that ``meadow@1`` names; None for a preset without a version.

    Raises InputError for a version that this program does not make.
    """
    preset, at, version = text.partition("@")
    if not at:
        return None
    known = workloads().get(preset)
    if known is None or version != str(known.version):
        made = ", ".join(each.name for each in workloads().values())
        cure = "results of another version need the lodbench that made them"
        raise InputError("PRESET", text, f"a workload that this version makes: {made}", cure)
    return known


def golden_counts(counts: Counts) -> dict[str, Any]:
    """Give the whole numbers of a frame that must repeat exactly on any machine."""
    return {
        "objects": counts.objects.displayed,
        "parts": counts.parts.displayed,
        "parts_by_level": list(counts.by_level),
        "terrain_tiles": counts.terrain_tiles,
        "terrain_triangles": counts.terrain_triangles,
        "parts_beside": sum(parts.displayed for _, parts in counts.others.values()),
    }


def first_frame_counts(preset: str) -> Counts:
    """Count the first frame of a preset without any setting changed."""
    scene = Scene(preset)
    return count(scene.world, scene.view(1))


def _renew_workloads() -> None:
    old, new = workloads() if _FILE.exists() else {}, []
    for preset, _ in preset_names():
        before, found = old.get(preset), golden_counts(first_frame_counts(preset))
        same = before is not None and before.counts == found
        version = before.version + (not same) if before else 1
        new.append(asdict(Workload(preset, version, found)))
        print(f"{preset}@{version}{'' if same else ' is new'}")
    _FILE.write_text(json.dumps(new, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    _renew_workloads()
