"""How far is a preset's picture, as shipped, from one far finer? One case is one place (§2.4).

A place's reference is traced once. Against it stand the picture of everything pruned as shipped;
of some presets also those of the ground pruned alone, at several details, and of all but the
ground; and the reference itself with other samples, which tells how far the fit can be trusted.
"""

import gc
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from bench.experiments.fidelity.shipped.claims import EVERYTHING, GROUND, NOTHING, REST
from bench.experiments.fidelity.shipped.displayed import (
    Shown,
    display_ground,
    display_others,
    reference_detail,
)
from bench.experiments.fidelity.shipped.pictures import (
    REFERENCE,
    TESTED,
    LandLight,
    Looks,
    Seen,
    band_edges,
    flips,
    look,
)
from bench.experiments.fidelity.shipped.places import Place, places
from bench.old_experiment import Effort
from bench.records.provenance import scene_digest
from bench.records.records import Column, Key, Point, columns
from bench.seeds import first_seed
from lod.view import View
from scenes.frame.frame_input import FrameInput, Quality
from scenes.presets.schema import Preset
from scenes.render.variants import choose
from scenes.scene import frame_quality, preset_air, view_at
from scenes.world.light import sun_and_sky
from scenes.world.world import World, build_world

GROUND_STEPS = (0.5, 1.0, 2.0)
"""The details at which the ground alone is pruned, relative to the shipped one."""


Way = tuple[str, float]
"""What is pruned, and at which detail relative to the shipped one."""


@dataclass(frozen=True)
class Sight:
    """A place that is looked at.

    apart            whether the ground and the rest are also pruned apart
    reference_bytes  the most memory that the reference may be predicted to need
    """

    place: Place
    apart: bool
    looks: Looks
    variant: str
    reference_bytes: int

    @property
    def label(self) -> str:
        """The name of the case, in short."""
        return f"{self.place.preset}, place {self.place.number}"


def cases(effort: Effort) -> list[Sight]:
    """Return the places of every preset."""
    looks, variant = Looks(tuple(effort["samples"]), effort["light_passes"]), choose()
    return [
        Sight(place, name in effort["apart"], looks, variant, effort["reference_bytes"])
        for name, count in effort["presets"].items()
        for place in places(name, count, effort["size"], first_seed(effort["unseen"]))
    ]


@dataclass(frozen=True, eq=False)
class Scene:
    """A place's world as it is looked at; ``edges_m`` are those of its bands of distance."""

    preset: Preset
    world: World
    view: View
    quality: Quality
    edges_m: np.ndarray


def open_scene(case: Sight, seed: int) -> Scene:
    """Build the world of a place; ``seed`` is that of its pictures' samples."""
    preset = case.place.load()
    world, spp = build_world(preset), max(case.looks.samples)
    quality = replace(frame_quality(preset, case.variant), seed=seed, spp=spp)
    view = view_at(world, preset, case.place.frame)
    return Scene(preset, world, view, quality, band_edges(preset))


def measure(case: Sight, seed: int) -> list[Point]:
    """Look at one place: a point of the reference itself, and one of every way to prune it."""
    scene = open_scene(case, seed)
    world, view = scene.world, scene.view
    tau = view.detail
    others = display_others(world, view, tau)
    shipped = (*display_ground(world, view, tau, tau), *others)
    fine, needed = reference_detail(world, view, shipped, scene.quality, case.reference_bytes)
    tested: dict[Way, Seen] = {(EVERYTHING, 1.0): _look(case, scene, shipped, TESTED)}
    del shipped
    whole = display_others(world, view, fine)
    reference = (*display_ground(world, view, fine, fine), *whole)
    seen, again = (_look(case, scene, reference, first) for first in (REFERENCE, TESTED))
    del reference
    tested = {(NOTHING, 1.0): again} | tested
    if case.apart:
        rest = (*display_ground(world, view, fine, tau), *others)
        tested[REST, 1.0] = _look(case, scene, rest, TESTED)
        del rest
        for step in GROUND_STEPS:
            alone = (*display_ground(world, view, step * tau, fine), *whole)
            tested[GROUND, step] = _look(case, scene, alone, TESTED)
    limits = {"reference_ppm": [round(1e6 * fine)], "reference_bytes": [needed]}
    return [
        _point(case, limits | {"detail_ppm": [round(1e6 * tau * way[1])]}, way, each, seen)
        for way, each in tested.items()
    ]


def _look(case: Sight, scene: Scene, shown: Shown, first: int) -> Seen:
    gc.collect()  # a scene that was built before is large
    light, air = sun_and_sky(scene.preset), preset_air(scene.preset)
    frame_input = FrameInput(scene.view.camera, shown, air, light, scene.quality)
    return look(frame_input, case.looks, scene.edges_m, first)


def _point(
    case: Sight, details: dict[str, list[int]], way: Way, tested: Seen, reference: Seen
) -> Point:
    """Make a point: FLIP [ppm], and of both pictures luminance [10⁻⁶] and rays of every band."""
    errors = zip(case.looks.samples, flips(tested.pictures, reference.pictures), strict=True)
    counts = {
        "place": [case.place.number],
        "world_seed": [case.place.load().seed],
        "sticks": [tested.sticks],
        "triangles": [tested.triangles],
    }
    lands = {"tested": tested.land, "reference": reference.land}
    return Point(
        {"preset": case.place.preset, "pruned": way[0], "step": way[1]},
        samples=(
            *columns(counts | details),
            *(Column("flip_ppm", [round(1e6 * each)], {"samples": n}) for n, each in errors),
            *(each for which, land in lands.items() for each in _land(which, land)),
        ),
    )


def _land(which: str, land: LandLight) -> Iterator[Column]:
    for band, (light, rays) in enumerate(zip(land.light, land.rays, strict=True)):
        keys: dict[str, Key] = {"picture": which, "band": band}
        yield Column("light", [round(1e6 * float(light))], keys)
        yield Column("rays", [int(rays)], keys)


def scene_hash(points: tuple[Point, ...]) -> str:
    """Return the SHA-256 of every preset from every place, and of what was pruned."""
    looked = []
    for point in points:
        numbers = zip(point.column("place"), point.column("world_seed"), strict=True)
        for k, seed in numbers:
            place = places(point.case["preset"], k + 1, "1x1", seed - k)[k]
            looked.append(place.load().model_dump(mode="json"))
    return scene_digest([looked, [p.case for p in points], GROUND_STEPS])
