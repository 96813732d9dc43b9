"""How much comes and goes from frame to frame, how large is it, and does fading hide it? (§1.2)

Switches of a walk across a field, seen all round, are counted and predicted. A part switches where
its disc of radius √(D² − h²) about the eye gains or loses it, so a step s switches K times the area
in one of two such discs and not in the other. Then short walks are rendered unpruned, pruned with
fading and pruned without; ``unexplained_change`` measures what motion does not explain.
"""

import math
from dataclasses import dataclass

import numpy as np

from bench.counting import EYE_HEIGHT_M, FLAT
from bench.experiments.popping.claims import QUANTILES, SWITCHED, WAYS
from bench.experiments.popping.unexplained_change import seen_of, walk
from bench.old_experiment import Effort
from bench.part_sizes import density_of, prototypes_with, seed_of
from bench.part_sizes import scene_hash as fields_hash
from bench.records.provenance import scene_digest
from bench.records.records import Column, Point, columns, predictions
from bench.seeds import first_seed
from lod.arrays import Reals
from lod.camera import Corner, camera_from_heading
from lod.law import chained_limits
from lod.metric import METRICS
from lod.pruner import Cut, prune
from lod.view import View, distance
from scenes.field.species_field import Species, SpeciesField
from scenes.presets.load import load_preset
from scenes.render.variants import choose
from scenes.sticks.prototype import Prototype
from scenes.world.world import build_world

SPECIES = ("figure", "tree")
WIDTH_PX, STEP_M, FRAMES = 640, 2.0, 8
DENSER = {"figure": 0.25, "tree": 1.0}
"""Density ÷ that of the experiments on haze and eye."""

SIZED = 8
"""The number of fields of which the size and distance of every switch are recorded."""

_RENDERED = 5

WALK = (
    "render.size=128x72",
    "render.spp=36",
    "world.extent=120.0",
    "species.tree.density=0.002",
    "species.sward.density=0",
    "species.figure.density=0.003",
    "species.tree.prototypes=2",
    "species.figure.prototypes=2",
    "species.tree.sizes=[0.6]",
    "camera.speed=2.8",
    "view.haze_aware=false",
    "view.detail=4.0",
    "terrain.reach=300.0",
    "terrain.amplitude=1.0",
    "terrain.wavelength=256.0",
)


@dataclass(frozen=True)
class Switches:
    """A species whose switches are counted, and the number of fields."""

    species: str
    fields: int


@dataclass(frozen=True)
class Walks:
    """The number of walks that are pruned in one way, and the variant that renders them.

    unseen  whether their worlds are those for judging, or may be looked at by anybody
    """

    way: str
    walks: int
    unseen: bool
    variant: str


def cases(effort: Effort) -> list[Switches | Walks]:
    """Return switches of every species, then walks in every way."""
    walks = effort["walks"], effort["unseen"]
    switches = [Switches(name, effort["fields"]) for name in SPECIES]
    return [*switches, *(Walks(way, *walks, choose()) for way in WAYS)]


def measure(case: Switches | Walks, seed: int) -> Point:
    """Count the switches of a species, or measure changes that motion does not explain."""
    return _switches(case, seed) if isinstance(case, Switches) else _walks(case, seed)


def view_at_step(step: int) -> View:
    """Return the view all round after ``step`` steps of the walk."""
    eye = np.array((0.0, step * STEP_M, EYE_HEIGHT_M))
    camera = camera_from_heading(Corner(0, 0), eye, 0.0, 0.0, 60.0, (WIDTH_PX, 360))
    return View(camera, METRICS["blake"], look_around=True)


def _switches(case: Switches, seed: int) -> Point:
    """Count every field's switches; each has a size and a distance, in thousandths."""
    species = case.species
    prototypes, m = prototypes_with(species, None), view_at_step(0).m
    density = DENSER[species] * density_of(species, m)
    counts, sizes, distances = [], [], []
    for index in range(case.fields):
        own = seed_of(f"popping {species}", seed, index)
        field = SpeciesField(Species("popping", prototypes, density), own, FLAT)
        P = np.concatenate([tree.P for tree in field.prototypes.part_tables.hierarchies])
        count, before = 0, None
        for step in range(FRAMES + 1):
            view = view_at_step(step)
            after = prune(field, view), view
            if before is not None:
                for here, there in ((before, after), (after, before)):
                    rows = only_in(here[0], there[0])
                    d = distance(here[1], here[0].parts.position[rows])
                    count += len(rows)
                    if index >= SIZED:
                        continue
                    sizes += np.rint(1000 * P[here[0].part[rows]] / (d * m)).astype(int).tolist()
                    distances += np.rint(1000 * d).astype(int).tolist()
            before = after
        counts.append(count)
    samples = {"switches": counts, "size_mpx": sizes, "distance_mm": distances}
    mean = FRAMES * expected_switches(prototypes, density, m)
    named = {"what": "switches", "species": species}
    return Point(named, predictions({"switches": mean}), columns(samples))


def only_in(here: Cut, there: Cut) -> np.ndarray:
    """Return the rows of the parts that are displayed in one cut and not in another."""
    one, other = (seen_of(cut, np.ones(len(cut))).key for cut in (here, there))
    _, first = np.unique(np.concatenate((other, one)), axis=0, return_index=True)
    return np.asarray(first[first >= len(other)] - len(other))


def expected_switches(prototypes: tuple[Prototype, ...], density: float, m: float) -> float:
    """Predict the mean number of parts that a step switches, by the law alone (§4.1)."""
    total = 0.0
    for tree in (each.hierarchy for each in prototypes):
        height = EYE_HEIGHT_M - tree.position[:, 2]
        squared = chained_limits(tree, METRICS["blake"], m) ** 2 - height**2
        total += float(in_one_only(np.sqrt(np.maximum(squared, 0.0)), STEP_M).sum())
    return total * density / len(prototypes)


def in_one_only(radius: Reals, step: float) -> Reals:
    """Return the area in one of two equal discs and not in the other, (n,) [m²].

    ``step`` is the distance between their centres [m].
    """
    share = np.clip(step / np.maximum(2 * radius, 1e-300), 0.0, 1.0)
    lens = 2 * radius**2 * (np.arccos(share) - share * np.sqrt(1 - share**2))
    return 2 * (math.pi * radius**2 - lens)


def _walks(case: Walks, seed: int) -> Point:
    """Count the parts that pop between frames, and measure changes that motion does not explain."""
    popped: list[int] = []
    changes: dict[float, list[int]] = {}
    for number in range(case.walks):
        heading = f"camera.heading={360.0 * number / case.walks - 170.0}"
        own = f"seed={first_seed(case.unseen, 5) + 20 * seed + number}"
        preset = load_preset("meadow", (*WALK, *WAYS[case.way], heading, own))
        found = walk(build_world(preset), (preset,), range(1, _RENDERED + 1), case.variant)
        popped += found.popped.tolist()
        for share, value in zip(QUANTILES, np.quantile(found.switched, QUANTILES), strict=True):
            changes.setdefault(share, []).append(round(1e6 * float(value)))
    changed = (Column(SWITCHED, row, {"quantile": q}) for q, row in changes.items())
    return Point({"what": "walk", "way": case.way}, samples=(Column("popped", popped), *changed))


def scene_hash(points: tuple[Point, ...]) -> str:
    """Return the SHA-256 of the walks, of all cases and of what the fields hold."""
    return scene_digest([WALK, WAYS, STEP_M, FRAMES, DENSER, fields_hash(points)])
