"""Presets at their shipped settings against a far finer reference; one case is one place (§2.4).

Place k of a preset is the preset in the world of the k-th seed (``bench.seeds``),
seen from where the preset's eye stands but turned by k × 60°, with the sun 20° high where k is even
and 55° where it is odd. `campfire` keeps its sun, and the eye goes round its fire, which it always
faces. `fly_in` is a flight, of which frames 1, 24 and 48 are judged, at τ = 1 px in place of the
exaggerated one.

A place's reference is traced once. Against it stand the picture of everything pruned as shipped;
of some presets also those of the ground pruned alone, at several details, and of all but the
ground; and the reference itself with other samples, which tells how far the fit can be trusted.

The ground carries the colour of what stands beyond its limit (the far cover), so it is always given
the detail of what stands on it: nothing is then in the picture twice, and nothing is missing.
"""

import gc
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from jaxtyping import Float64

from bench.experiment import Case
from bench.images.differences import REFERENCE, TESTED, Looks, Seen, flips, look, sums_by_band
from bench.records.records import Column, Point, columns
from bench.seeds import first_seed
from lod.arrays import Points, Reals
from lod.metric import Metric
from lod.pruner import prune
from lod.shapes import Sticks, batches_of
from lod.view import View
from scenes.frame.frame_input import DisplayedRepresentation, FrameInput, Quality, display
from scenes.frame.layers import SKY_Z
from scenes.ground.shading import AggregateCover, ResidualCover
from scenes.presets.load import load_preset
from scenes.presets.schema import Preset
from scenes.render.memory import predict_bytes
from scenes.render.variants import choose
from scenes.scene import Scene, frame_quality
from scenes.world.sun_and_sky import sun_and_sky
from scenes.world.world import World

NOTHING, EVERYTHING = "nothing", "everything"
GROUND, REST = "ground alone", "all but the ground"
"""What is pruned, while the rest is the reference's."""

BANDS = 8
"""The number of bands of distance."""

LEAST_SHARE = 0.01
"""The share of the land's rays from which on a band of distance is judged."""

Shown = tuple[DisplayedRepresentation, ...]

FINEST = 1 / 16
"""The finest detail of a reference that is tried [px]."""


@dataclass(frozen=True)
class CoverOf:
    """The cover that is left on the ground by objects with a detail [px] and a metric of their own.

    It is an AggregateCover of ``scenes.ground``.
    """

    cover: AggregateCover
    detail: float
    metric: Metric

    @property
    def highest(self) -> float:
        """Largest height by which the cover can raise the ground [m]."""
        return self.cover.highest

    def residual(
        self, view: View, points: Points, slopes: Float64[np.ndarray, "n 2"] | None = None
    ) -> ResidualCover:
        """Return what is left at points (n, 3) of the ground of a view, however that is pruned."""
        own = replace(view, detail=self.detail, metric=self.metric)
        return self.cover.residual(own, points, slopes)


def display_ground(
    world: World,
    view: View,
    detail: float,
    of_others: float,
    metric_of_others: Metric | None = None,
) -> Shown:
    """Display the ground at a detail [px], under the cover of what is pruned at ``of_others``.

    That is pruned by the view's metric unless it has another.
    """
    terrain, cover = world.terrain, world.terrain.aggregate_cover
    if cover is not None:
        terrain = replace(
            terrain, aggregate_cover=CoverOf(cover, of_others, metric_of_others or view.metric)
        )
    at = replace(view, detail=detail)
    return (display(terrain, prune(terrain, at), at),)


def display_others(world: World, view: View, detail: float) -> Shown:
    """Display all but the ground at a detail [px]."""
    at = replace(view, detail=detail)
    others = (each for each in world.representations if each is not world.terrain)
    return tuple(display(each, prune(each, at), at) for each in others)


def reference_detail(
    world: World, view: View, shown: Shown, quality: Quality, most: int
) -> tuple[float, int]:
    """Find the finest detail [px] of a frame that is predicted to need at most so many bytes.

    ``shown`` is what the view displays at its own detail: sticks and triangles are predicted to
    grow as the parts do. Gives the detail, and the bytes predicted for it.
    """
    size = view.camera.width, view.camera.height

    def bytes_at(detail: float) -> int:
        at, sticks, triangles = replace(view, detail=detail), 0.0, 0.0
        for each, one in zip(world.representations, shown, strict=True):
            grown = len(prune(each, at)) / max(len(one.cut), 1)
            for shape in batches_of(one.shape):
                if isinstance(shape, Sticks):
                    sticks += len(shape) * grown
                else:
                    triangles += len(shape) * grown
        return predict_bytes(round(sticks), round(triangles), size, quality)

    return finest_within(bytes_at, view.detail, most)


def finest_within(bytes_at: Callable[[float], int], start: float, most: int) -> tuple[float, int]:
    """Halve a detail again and again while it is predicted to fit into ``most`` bytes.

    Gives the finest that fits (``start`` itself is not judged) and its bytes. Details below FINEST
    are not tried, nor one that would not fit if bytes grew as at the halving before: even to count
    what it displays takes memory.
    """
    detail, need, growth = start, bytes_at(start), 1.0
    while detail / 2 >= FINEST and need * growth <= most:
        then = bytes_at(detail / 2)
        if then > most:
            break
        detail, need, growth = detail / 2, then, then / need
    return detail, need


SUN_ELEVATIONS = (20.0, 55.0)
"""Elevations of the sun in even and in odd places [degrees]."""

TURN_DEG = 60.0
_ROUND_THE_FIRE = "campfire"
_FLIGHT, _FRAMES = "fly_in", (1, 24, 48)


@dataclass(frozen=True)
class Place:
    """A preset from one place: its name there, settings laid over it, and the frame's number."""

    preset: str
    number: int
    settings: tuple[str, ...]
    frame: int = 1

    @property
    def label(self) -> str:
        """The preset and the number of the place."""
        return f"{self.preset}, place {self.number}"

    def load(self) -> Preset:
        """Load the preset as it is seen here."""
        return load_preset(self.preset, self.settings)


def places(preset: str, count: int, size: str, seed: int) -> list[Place]:
    """Return the first ``count`` places of a preset in pictures of a size (WxH).

    ``seed`` is that of the world of place 0.
    """
    return [_place(preset, k, size, seed + k) for k in range(count)]


def _place(name: str, k: int, size: str, seed: int) -> Place:
    settings = (f"render.size={size}", f"seed={seed}")
    if name == _FLIGHT:
        return Place(name, k, (*settings, "view.detail=1"), _FRAMES[k])
    camera, turn = load_preset(name, ()).camera, k * TURN_DEG
    heading = f"camera.heading={math.fmod(camera.heading + turn, 360.0):g}"
    if name != _ROUND_THE_FIRE:
        sun = f"light.sun_elevation={SUN_ELEVATIONS[k % 2]:g}"
        return Place(name, k, (*settings, heading, sun))
    (x, y), a = camera.position, math.radians(turn)
    east, north = x * math.cos(a) + y * math.sin(a), y * math.cos(a) - x * math.sin(a)
    return Place(name, k, (*settings, heading, f"camera.position=[{east:.6f}, {north:.6f}]"))


GROUND_STEPS = (0.5, 1.0, 2.0)
"""The details at which the ground alone is pruned, relative to the shipped one."""


Way = tuple[str, float]
"""What is pruned, and at which detail relative to the shipped one."""


def cases(
    presets: Mapping[str, int],
    apart: Sequence[str],
    size: str,
    unseen: bool,
    samples: Sequence[int],
    light_passes: int,
    reference_bytes: int,
) -> list[Case]:
    """Return the places of every preset; of those ``apart`` ground and rest stand alone, too."""
    looks = Looks(tuple(samples), light_passes)
    return [
        partial(measure, place, name in apart, looks, choose(), reference_bytes)
        for name, count in presets.items()
        for place in places(name, count, size, first_seed(unseen))
    ]


def measure(
    place: Place, apart: bool, looks: Looks, variant: str, reference_bytes: int, seed: int
) -> list[Point]:
    """Look at one place: a point of the reference itself, and one of every way to prune it.

    Where it is ``apart``, the ground and the rest are also pruned alone. The reference may be
    predicted to need ``reference_bytes`` at most; ``seed`` is that of the pictures' samples.
    """
    scene = Scene(place.load())
    world, view = scene.world, scene.view(place.frame)
    quality = frame_quality(scene.preset, variant)
    quality = replace(quality, seed=seed, spp=max(looks.samples))
    edges_m, tau = band_edges(scene.preset), view.detail

    def seen(shown: Shown, first: int) -> Seen:
        gc.collect()  # a scene that was built before is large
        light = sun_and_sky(scene.preset)
        frame_input = FrameInput(view.camera, shown, scene.air, light, quality)
        return look(frame_input, looks, edges_m, first)

    others = display_others(world, view, tau)
    shipped = (*display_ground(world, view, tau, tau), *others)
    fine, needed = reference_detail(world, view, shipped, quality, reference_bytes)
    tested: dict[Way, Seen] = {(EVERYTHING, 1.0): seen(shipped, TESTED)}
    del shipped
    whole = display_others(world, view, fine)
    reference = (*display_ground(world, view, fine, fine), *whole)
    once, again = (seen(reference, first) for first in (REFERENCE, TESTED))
    del reference
    tested = {(NOTHING, 1.0): again} | tested
    if apart:
        rest = (*display_ground(world, view, fine, tau), *others)
        tested[REST, 1.0] = seen(rest, TESTED)
        del rest
        for step in GROUND_STEPS:
            alone = (*display_ground(world, view, step * tau, fine), *whole)
            tested[GROUND, step] = seen(alone, TESTED)
    limits = {"reference_ppm": [round(1e6 * fine)], "reference_bytes": [needed]}
    made = []
    for (pruned, step), each in tested.items():
        case = {"topic": "fidelity_shipped", "preset": place.preset, "pruned": pruned, "step": step}
        about = {"place": [place.number], "world_seed": [scene.preset.seed]}
        drawn = {"sticks": [each.sticks], "triangles": [each.triangles]}
        details = limits | {"detail_ppm": [round(1e6 * tau * step)]}
        samples = columns(about | drawn | details)
        made.append(Point(case, samples=(*samples, *_seen_columns(looks, each, once))))
    return made


def _seen_columns(looks: Looks, tested: Seen, reference: Seen) -> Iterator[Column]:
    """Yield FLIP [ppm], and of both pictures luminance [10⁻⁶] and rays of every band."""
    errors = flips(tested.pictures, reference.pictures)
    for spp, each in zip(looks.samples, errors, strict=True):
        yield Column("flip_ppm", [round(1e6 * each)], {"samples": spp})
    for which, land in (("tested", tested.land), ("reference", reference.land)):
        yield from sums_by_band("light", land.light, {"picture": which})
        yield from sums_by_band("rays", land.rays, {"picture": which}, 1)


def band_edges(preset: Preset) -> np.ndarray:
    """Return the edges of a preset's bands of distance, (bands + 1,) [m].

    They are even in the logarithm, from twice the height of the eye to where air leaves 2 % of the
    contrast, or the ground ends. The first band then begins at the eye, and the last has no end.
    """
    farthest = min(preset.air.visibility or np.inf, preset.terrain.reach)
    edges = np.geomspace(2 * preset.camera.height, farthest, BANDS + 1)
    edges[0], edges[-1] = 0.0, float(SKY_Z)
    return edges


def light_ratios(point: Point) -> Reals:
    """Return the land's mean luminance, pruned ÷ reference, of every place, (places,)."""
    light, rays, whole, of_all = (each.sum(axis=0) for each in _sums(point))
    return np.asarray((light / rays) / (whole / of_all))


def judged_bands(point: Point) -> dict[int, Reals]:
    """Return mean luminance, pruned ÷ reference, of bands in the places that hold enough of them.

    A place holds enough where at least LEAST_SHARE of its land is in the band.
    """
    light, rays, whole, of_all = _sums(point)
    here = (of_all >= LEAST_SHARE * of_all.sum(axis=0)) & (rays > 0)
    return {
        k: (light[k][h] / rays[k][h]) / (whole[k][h] / of_all[k][h])
        for k, h in enumerate(here)
        if h.any()
    }


def _sums(point: Point) -> list[np.ndarray]:
    """Return light and rays of the tested picture, then of the reference, (bands, places) each."""
    return [
        np.array([point.values(name, picture=which, band=k) for k in range(BANDS)])
        for which in ("tested", "reference")
        for name in ("light", "rays")
    ]
