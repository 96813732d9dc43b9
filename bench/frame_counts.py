"""How many objects and parts does one frame examine and display, and what does the law predict?

No renderer is needed.
"""

import math
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field, replace

import numpy as np

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
from scenes.scene import World

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


def count(
    world: World, view: View, ground: Cut | None = None, follow: Follow | None = None
) -> Counts:
    """Prune one frame and hold every species against its prediction.

    ground  the cut of the ground, where it is known already
    follow  is called before each step
    """
    watch, by_species = Stopwatch(), {}
    names = [*(each.name for each in (*world.fields, *world.beside)), "ground"]

    def next_step(name: str) -> None:
        if follow is not None:
            follow(names.index(name), len(names), name)

    for each in world.fields:
        next_step(each.name)
        with watch.stage("prune"):
            cut = prune(each, view)
        with watch.stage("predict"):
            predicted = predict(each, view)
        by_species[each.name] = _species_count(cut, predicted, each.species.density)
    others: dict[str, tuple[Tally, Tally]] = {}
    for one in world.beside:
        next_step(one.name)
        with watch.stage("prune"):
            cut = prune(one, view)
        objects = Tally(cut.examined_objects, cut.displayed_objects, None, None)
        others[one.name] = objects, Tally(cut.examined_parts, cut.displayed_parts, None, None)
    next_step("ground")
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


def _species_count(cut: Cut, predicted: CountMoments | None, density: float) -> SpeciesCount:
    def tally(examined: int, displayed: int, what: str) -> Tally:
        if predicted is None:
            return Tally(examined, displayed, None, None)
        mean, variance = (getattr(predicted, f"{what}{k}") for k in ("", "_variance"))
        return Tally(examined, displayed, density * mean, math.sqrt(density * variance))

    levels, by_level = int(cut.level.max(initial=0)) + 1, None
    if predicted is not None:
        by_level = tuple(density * area for area in predicted.parts_by_level)
        levels = max(levels, len(by_level))
    return SpeciesCount(
        tally(cut.examined_objects, cut.displayed_objects, "objects"),
        tally(cut.examined_parts, cut.displayed_parts, "parts"),
        tuple(np.bincount(cut.level, minlength=levels).tolist()),
        by_level,
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
    corner, farthest = np.array(view.camera.corner.lattice(1.0)[:2], np.float64), math.inf
    if each.extent is not None:  # the farthest corner of the window
        eye = np.abs(view.camera.eye[:2] + corner)
        farthest = float(np.hypot(*(eye + each.extent / 2)))
    net = ground_nodes(trees, view, _NODES, farthest)
    area = net.area
    if each.extent is not None:
        inside = (np.abs(net.xy + corner) <= each.extent / 2).all(axis=1)
        area = np.where(inside, area, 0.0)
    if each.species.habitat is not None:
        area = area * each.species.habitat.share(view.camera.corner, net.xy)
    height = each.ground.height(view.camera.corner, net.xy)
    return count_moments(trees, view, replace(net, area=area), height)


def _flat(each: SpeciesField, view: View, ground: float) -> CountMoments:
    trees = each.prototypes.part_tables.hierarchies
    share = 1 / len(trees)
    levels = np.zeros(1 + max(int(tree.level.max()) for tree in trees))
    objects = parts = spread = 0.0
    for tree in trees:
        above = view.camera.eye[2] - ground - tree.position[:, 2]
        areas = disc_areas(limits_seen(tree, view, view.m), above)
        objects += expected_count(share, areas[:1])
        parts += expected_count(share, areas)
        spread += count_variance(share, areas)
        levels += share * np.bincount(tree.level, weights=areas, minlength=len(levels))
    return CountMoments(objects, objects, parts, spread, tuple(levels.tolist()))
