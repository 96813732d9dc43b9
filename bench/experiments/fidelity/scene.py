"""What does the fidelity experiment look at? Fields of one preset in three views, pruned in ways.

The reference is the same frame with every species at SPECIES_DETAIL and the ground at
GROUND_DETAIL, where nothing is left out for air or fades. Field k is turned by k × TURN_DEG, and
its sun is the k-th of SUN_ELEVATIONS_DEG in turn. Full runs judge worlds and trees that nothing was
fitted to (``bench.seeds``).
"""

from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any

import numpy as np

from bench.experiments.fidelity.shipped.displayed import Shown, display_ground, display_others
from bench.old_experiment import Effort
from bench.records.provenance import scene_digest
from bench.records.records import Point
from bench.seeds import first_seed
from lod.metric import METRICS
from lod.view import View
from scenes.frame.layers import SKY_Z
from scenes.models.catalogue import PROTOTYPE_SEED
from scenes.plugins import metric_by_name
from scenes.presets.load import load_preset, preset_from
from scenes.presets.schema import Preset
from scenes.scene import view_at
from scenes.world.world import World, build_world

VIEWS = {
    "eye level": (),
    "aerial": ("camera.height=40", "camera.pitch=-15"),
    "hazy": ("air.visibility=2km",),
}
GRASS = "grass"
"""A view of nothing but grass, whose blades are far longer than they are wide."""

SWEPT = ("eye level", "aerial", GRASS)
"""The views in which metrics are compared."""

METRICS_TRIED = ("blake", "bounded", "solid_angle", "depth")
GRASS_METRICS = ("blake", "bounded", "solid_angle")

SPECIES, GROUND, EVERYTHING, NOTHING = "species", "ground", "everything", "nothing"
"""What is pruned, while the rest is the reference's.

``NOTHING`` is the reference with other samples, which tells how far errors can be trusted. The
ground is pruned by the default metric.
"""

SPECIES_DETAIL, GROUND_DETAIL = 1 / 8, 1 / 4
"""Details of the reference [px]."""

SUN_ELEVATIONS_DEG = (10.0, 40.0, 70.0)
TURN_DEG = 30.0
PROTOTYPE_SETS = 4
"""The number of sets of trees and people that fields have in turn in a full run."""

ALONE_EVERY = 3
"""In every so many-th field species and ground are pruned alone, too."""

EDGES_M = (0.0, 20.0, 60.0, 150.0, 400.0, 1000.0, 2000.0, 5000.0, float(SKY_Z))
"""Edges of the bands of distance [m]; the last band is not judged."""

_WORLD = (
    "world.extent=20000",
    "terrain.reach=10000",
    "render.max_depth=3",
    "species.sward.density=0",
)
_GRASS = (*("world.extent=80", "terrain.reach=80", "render.max_depth=3", "camera.pitch=-6"),)


@dataclass(frozen=True)
class Field:
    """One field as one view sees it.

    number       of the field, from 0
    unseen       whether its world and trees are those for judging, or may be looked at by anybody
    size         of its pictures, as ``320x180``
    """

    view: str
    number: int
    unseen: bool
    size: str

    def preset(self, seed: int) -> Preset:
        """Load the preset as it is seen here, in a run of a seed."""
        sun = SUN_ELEVATIONS_DEG[self.number % len(SUN_ELEVATIONS_DEG)]
        settings = (
            f"seed={first_seed(self.unseen, 1) + 12 * seed + self.number}",
            f"render.size={self.size}",
            f"light.sun_elevation={sun:g}",
            f"camera.heading={(20 + self.number * TURN_DEG) % 360:g}",
        )
        if self.view == GRASS:
            return preset_from(_grass_alone(), (*_GRASS, *settings), "meadow")
        return load_preset("meadow", (*_WORLD, *VIEWS[self.view], *settings))

    @property
    def prototype_seed(self) -> int:
        """The seed of its trees and people."""
        if not self.unseen:
            return PROTOTYPE_SEED
        return first_seed(True, 1) + self.number % PROTOTYPE_SETS


def _grass_alone() -> dict[str, Any]:
    """Return `meadow` with its grass alone, by the metric of the view."""
    meadow = load_preset("meadow").model_dump(mode="json")
    return meadow | {"species": {"sward": meadow["species"]["sward"] | {"metric": None}}}


def fields(effort: Effort) -> list[Field]:
    """Return every field in every view, for the headline pictures."""
    rest = effort["unseen"], effort["size"]
    return [Field(view, k, *rest) for k in range(effort["fields"]) for view in VIEWS]


def swept_fields(effort: Effort) -> list[Field]:
    """Return the fields in which metrics are compared."""
    rest = effort["unseen"], effort["sweep_size"]
    return [Field(view, k, *rest) for k in range(effort["sweep_fields"]) for view in SWEPT]


@lru_cache(maxsize=1)
def world_of(field: Field, seed: int) -> World:
    """Build the world of a field in a run of a seed."""
    return build_world(field.preset(seed), None, field.prototype_seed)


def reference(world: World, view: View) -> Shown:
    """Display the reference of a view."""
    return (*_whole_ground(world, view), *_whole_species(world, view))


def displayed(world: World, view: View, pruned: str, metric: str, detail: float) -> Shown:
    """Display what ``pruned`` says by a metric at a detail [px], and the rest as the reference."""
    mine = replace(view, metric=metric_by_name(metric))
    species = _whole_species(world, view)
    if pruned in (SPECIES, EVERYTHING):
        species = display_others(world, mine, detail)
    if pruned == EVERYTHING:
        return (*display_ground(world, view, detail, detail), *species)
    if pruned == GROUND:
        return (*display_ground(world, view, detail, SPECIES_DETAIL), *species)
    if pruned == SPECIES:
        whole = _plain(view)
        ground = display_ground(world, whole, GROUND_DETAIL, detail, mine.metric)
        return (*ground, *species)
    return reference(world, view)


def _plain(view: View) -> View:
    return replace(view, fade=0.0, conditions=None, metric=METRICS["blake"])


def _whole_ground(world: World, view: View) -> Shown:
    return display_ground(world, _plain(view), GROUND_DETAIL, SPECIES_DETAIL)


def _whole_species(world: World, view: View) -> Shown:
    return display_others(world, _plain(view), SPECIES_DETAIL)


def field_view(field: Field, seed: int) -> View:
    """Return the view of a field, as its preset has it."""
    return view_at(world_of(field, seed), field.preset(seed), 1)


def parts_in(world: World, shown: Shown) -> int:
    """Count the parts of the species; tiles of the ground are not parts that a law knows."""
    return sum(len(each.cut) for each in shown if each.name != world.terrain.name)


def edges() -> np.ndarray:
    """Return the edges of the bands of distance, (bands + 1,) [m]."""
    return np.array(EDGES_M)


def scene_hash(points: tuple[Point, ...]) -> str:
    """Return the SHA-256 of every view and every case."""
    presets = [Field(v, 0, False, "1x1").preset(0).model_dump(mode="json") for v in (*VIEWS, GRASS)]
    constants = [SPECIES_DETAIL, GROUND_DETAIL, SUN_ELEVATIONS_DEG, TURN_DEG, EDGES_M]
    return scene_digest([presets, [p.case for p in points], constants])
