"""Fields of one preset in three views, pruned in ways, against a finer reference (§1.2, §2.4).

The reference is the same frame with every species at SPECIES_DETAIL and the ground at
twice that, where nothing is left out for air or fades. Field k is turned by k × TURN_DEG, and
its sun is the k-th of SUN_ELEVATIONS_DEG in turn. Full runs judge worlds and trees that nothing was
fitted to (``bench.seeds``).

Headline pictures show everything pruned at one pixel, and in half of the fields species and ground
alone, under each sun as often, against one reference: FLIP at several counts of samples, and by
bands of distance FLIP of the same place, luminance and how many rays meet the band. Sweeps compare
metrics: species pruned over the reference's ground. Fields are the replicates: every column has a
number for each.
"""

import dataclasses
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache, partial
from typing import Any

import numpy as np
from jaxtyping import Float64

from bench.experiment import Case, OwnPreset
from bench.images.differences import (
    PIXELS_PER_DEGREE,
    REFERENCE,
    TESTED,
    Looks,
    Seen,
    band_sums,
    flip_map,
    flips_by_pixel,
    look,
    sums_by_band,
)
from bench.records.records import Column, Key, Point, columns, grouped, pictures
from bench.seeds import first_seed
from lod.arrays import Points
from lod.metric import METRICS, Metric
from lod.pruner import prune
from lod.view import View
from scenes.frame.frame_input import DisplayedRepresentation, FrameInput, display
from scenes.frame.layers import SKY_Z
from scenes.ground.shading import AggregateCover, ResidualCover
from scenes.models.catalogue import PROTOTYPE_SEED
from scenes.plugins import metric_by_name
from scenes.presets.load import Setting, load_preset, preset_from
from scenes.presets.schema import Preset
from scenes.render.budget import reference_preset
from scenes.render.pictures import auto_exposure, to_srgb
from scenes.render.render import render_frame
from scenes.render.variants import choose
from scenes.scene import Scene, World, frame_quality

VIEWS = {
    "eye level": (),
    "aerial": ("camera.height=40", "camera.pitch=-15"),
    "hazy": ("air.visibility=2km",),
}
GRASS = "grass"  # a view of nothing but grass, whose blades are far longer than they are wide
SWEPT = ("eye level", "aerial", "hazy", GRASS)  # the views in which metrics are compared

METRICS_TRIED = ("blake", "bounded", "solid_angle", "depth", "contrast_weighted")
FEW_METRICS = {"hazy": ("blake", "contrast_weighted"), GRASS: ("blake", "bounded", "solid_angle")}
"""The metrics that are tried in each view, and in those where not all are."""

LEAST_SHARE = 0.005  # the share of the land's rays from which on a band of distance is judged

SPECIES, GROUND, EVERYTHING, NOTHING = "species", "ground", "everything", "nothing"
COARSER = "coarser"
"""What is pruned, while the rest is the reference's.

``NOTHING`` is the reference with other samples, which tells how far errors can be trusted;
``COARSER`` the reference at twice its detail, which tells how far the last halving moved it. The
ground is pruned by the default metric.
"""

PRUNED = {EVERYTHING: "all representations", SPECIES: "species", GROUND: "ground"}
"""What is pruned, in words."""

SPECIES_DETAIL = 1 / 8
"""Detail of the species in the reference [px]; that of the ground is twice as much."""

OWN_BYTES = 4 * 10**9
"""Memory that the reference of a user's own preset may take: it is as fine as that allows."""

SUN_ELEVATIONS_DEG = (10.0, 40.0, 70.0)
TURN_DEG = 30.0
PROTOTYPE_SETS = 4  # the number of sets of trees and people that fields have in turn in a full run

ALONE, ALONE_OF = 3, 6
"""In the first so many of so many fields species and ground are pruned alone, too: under each of
the suns as often, with all sets of trees in twelve fields."""

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

    view         one of VIEWS, GRASS, or the name of a user's own preset
    number       of the field, from 0
    unseen       whether its world and trees are those for judging, or may be looked at by anybody
    size         of its pictures, as ``320x180``
    own          a user's own preset, which keeps its sun and its prototypes
    """

    view: str
    number: int
    unseen: bool
    size: str
    own: Preset | None = dataclasses.field(default=None, hash=False)

    @property
    def label(self) -> str:
        """The number of the field, and the view."""
        return f"field {self.number}, {self.view}"

    def preset(self, seed: int) -> Preset:
        """Load the preset as it is seen here, in a run of a seed."""
        sun = SUN_ELEVATIONS_DEG[self.number % len(SUN_ELEVATIONS_DEG)]
        settings: tuple[str, ...] = (
            f"light.sun_elevation={sun:g}",
            f"seed={first_seed(self.unseen, 1) + 12 * seed + self.number}",
            f"render.size={self.size}",
            f"camera.heading={(20 + self.number * TURN_DEG) % 360:g}",
        )
        if self.own is not None:
            return load_preset(self.own, settings[1:])  # under its own sun
        if self.view == GRASS:
            meadow = load_preset("meadow").model_dump(mode="json")
            grass = {"sward": meadow["species"]["sward"] | {"metric": None}}
            return preset_from(meadow | {"species": grass}, (*_GRASS, *settings), "meadow")
        return load_preset("meadow", (*_WORLD, *VIEWS[self.view], *settings))

    @property
    def prototype_seed(self) -> int:
        """The seed of its trees and people."""
        if not self.unseen or self.own is not None:
            return PROTOTYPE_SEED
        return first_seed(True, 1) + self.number % PROTOTYPE_SETS


@lru_cache(maxsize=1)
def scene_of(field: Field, seed: int) -> Scene:
    """Bind a field to its world in a run of a seed."""
    return Scene(field.preset(seed), prototype_seed=field.prototype_seed)


Shown = tuple[DisplayedRepresentation, ...]


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


def reference(world: World, view: View, fine: float = SPECIES_DETAIL) -> Shown:
    """Display the reference of a view: species at a fine detail [px], ground at twice that."""
    ground = display_ground(world, _plain(view), 2 * fine, fine)
    return (*ground, *display_others(world, _plain(view), fine))


def displayed(
    world: World, view: View, pruned: str, metric: str, detail: float, fine: float = SPECIES_DETAIL
) -> Shown:
    """Display what ``pruned`` says by a metric at a detail [px], and the rest as the reference."""
    mine = replace(view, metric=metric_by_name(metric))
    species = display_others(world, _plain(view), fine)
    if pruned in (SPECIES, EVERYTHING):
        species = display_others(world, mine, detail)
    if pruned == EVERYTHING:
        return (*display_ground(world, view, detail, detail), *species)
    if pruned == GROUND:
        return (*display_ground(world, view, detail, fine), *species)
    if pruned == SPECIES:
        whole = _plain(view)
        ground = display_ground(world, whole, 2 * fine, detail, mine.metric)
        return (*ground, *species)
    return reference(world, view, 2 * fine if pruned == COARSER else fine)


def _plain(view: View) -> View:
    return replace(view, fade=0.0, conditions=None, metric=METRICS["blake"])


def parts_in(world: World, shown: Shown) -> int:
    """Count the parts of the species; tiles of the ground are not parts that a law knows."""
    return sum(len(each.cut) for each in shown if each.name != world.terrain.name)


SHOWN_PX, SHOWN_SPP = (1.0, 4.0), 64
"""Values of τ [px] that are shown, and the samples of a pixel of pictures to look at."""


def pictures_of(points: Sequence[Point]) -> list[dict[str, Any]]:
    """Render for a record's notes the first field in each view: reference, pruned, FLIP maps."""
    views = [view for (view,) in grouped(points, "view") if view in VIEWS]
    first = next(p for p in points if p.case.get("what") == "headline")
    unseen = first.column("prototype_seed")[0] != PROTOTYPE_SEED
    seed = (first.column("world_seed")[0] - first_seed(unseen, 1)) // 12
    variant = choose()
    return [_one(Field(view, 0, unseen, "320x180"), variant, seed) for view in views]


def _one(field: Field, variant: str, seed: int) -> dict[str, Any]:
    scene = scene_of(field, seed)
    world, view = scene.world, scene.view(1)

    def picture(shown: Shown) -> np.ndarray:
        return render_frame(_input(field, shown, variant, seed, SHOWN_SPP)).rgb.astype(np.float64)

    whole = picture(reference(world, view))
    exposure = auto_exposure(whole)
    layers = {"the reference": _bytes(to_srgb(whole, exposure))}
    maps = {}
    for detail in SHOWN_PX:
        shown = displayed(world, view, EVERYTHING, "blake", detail)
        pruned = to_srgb(picture(shown), exposure)
        layers[f"pruned, τ = {detail:g} px"] = _bytes(pruned)
        difference = flip_map(pruned, to_srgb(whole, exposure))
        maps[f"where it differs, τ = {detail:g} px"] = _bytes(difference)
    caption = (
        f"The first field in the {field.view} view. The maps are FLIP of these pictures at "
        f"{PIXELS_PER_DEGREE:g} pixels per degree, dark for no difference and bright for a large "
        f"one; the noise of {SHOWN_SPP} samples a pixel is in them."
    )
    alt = f"The {field.view} view: people and trees on a meadow."
    name = f"fidelity-{field.view.replace(' ', '-')}"
    return pictures(name, (f"Look at it: {field.view}", caption, alt), layers | maps)


def _input(field: Field, shown: Shown, variant: str, seed: int, spp: int) -> FrameInput:
    scene = scene_of(field, seed)
    quality = replace(frame_quality(scene.preset, variant), spp=spp, seed=seed)
    light = scene.light
    return FrameInput(scene.view(1).camera, shown, scene.air, light, quality)


def _bytes(picture: np.ndarray) -> np.ndarray:
    return np.rint(255 * np.clip(picture, 0, 1)).astype(np.uint8)


Way = tuple[str, str, float]  # what is pruned, by which metric, and at which detail [px]


def _details(metric: str, details: Sequence[float]) -> list[float]:
    """Return the details at which a metric comes up to the errors of ``blake`` at these [px]."""
    finer = METRICS[metric].finer if metric in METRICS else 1.0
    return [*details] if finer == 1 else sorted({d * k * finer for d in details for k in (0.5, 1)})


def cases(
    fields: int,
    size: str,
    samples: Sequence[int],
    light_passes: int,
    sweep_fields: int,
    sweep_size: str,
    sweep_samples: Sequence[int],
    details: Sequence[float],
    grass_details: Sequence[float],
    unseen: bool,
    metric: str | None = None,
    preset: OwnPreset | None = None,
) -> list[Case]:
    """Return the headline pictures of every field, and the sweeps, with ``metric`` in them.

    A user's own preset stands in place of all views. In its sweeps no species keeps a metric of
    its own, for metrics are compared.
    """
    made: list[Case] = []
    views: Sequence[str] = tuple(VIEWS)
    swept: Sequence[str] = SWEPT
    own = alike = None
    if preset is not None:
        views = swept = preset[:1]
        own = preset[1]
        alike = load_preset(own, [Setting("", f"species.{n}.metric", None) for n in own.species])
    headlines = Looks(tuple(samples), light_passes), choose()
    for number in range(fields):
        alone = (NOTHING, COARSER, SPECIES, GROUND) if number % ALONE_OF < ALONE else ()
        ways = tuple((pruned, "blake", 1.0) for pruned in (EVERYTHING, *alone))
        for view in views:
            field = Field(view, number, unseen, size, own)
            made.append(partial(measure, "headline", field, ways, *headlines))
    for number in range(sweep_fields):
        for view in swept:
            field, grass = Field(view, number, unseen, sweep_size, alike), view == GRASS
            tried = (*FEW_METRICS.get(view, METRICS_TRIED), *([metric] if metric else []))
            several = grass_details if grass else details
            ways = tuple((SPECIES, name, d) for name in tried for d in _details(name, several))
            looks = Looks(tuple(sweep_samples), 0)
            made.append(partial(measure, "sweep", field, ways, looks, choose()))
    return made


def measure(
    what: str, field: Field, ways: tuple[Way, ...], looks: Looks, variant: str, seed: int
) -> list[Point]:
    """Look at the reference of one field, then at each way to prune it: a point for each.

    ``what`` is ``headline`` or ``sweep``.
    """
    scene = scene_of(field, seed)
    world, view = scene.world, scene.view(1)

    def seen_of(shown: Shown, first: int) -> Seen:
        frame_input = _input(field, shown, variant, seed, max(looks.samples))
        return look(frame_input, looks, np.array(EDGES_M), first)

    fine = SPECIES_DETAIL
    if field.own is not None:
        fine = reference_preset(scene.preset, (1,), OWN_BYTES).view.detail
    whole, made = seen_of(reference(world, view, fine), REFERENCE), []
    for pruned, metric, detail in ways:
        shown = displayed(world, view, pruned, metric, detail, fine)
        parts, seen = parts_in(world, shown), seen_of(shown, TESTED)
        counted = {
            "field": [field.number],
            "sun_deg": [round(scene.preset.light.sun_elevation)],
            "world_seed": [scene.preset.seed],
            "prototype_seed": [field.prototype_seed],
            "parts": [parts],
            "sticks": [seen.sticks],
            "triangles": [seen.triangles],
        }
        named: dict[str, Any] = {"topic": "fidelity", "what": what, "view": field.view}
        named |= {"pruned": pruned, "metric": metric, "detail": detail}
        found = _seen_columns(looks, seen, whole, by_band=what == "headline")
        made.append(Point(named, samples=(*columns(counted), *found)))
        del shown, seen
    return made


def _seen_columns(looks: Looks, tested: Seen, whole: Seen, by_band: bool) -> Iterator[Column]:
    """Yield FLIP [10⁻⁶], and what each band of distance shows."""
    bands, count = np.digitize(whole.Z.astype(np.float64).ravel(), EDGES_M[1:-1]), len(EDGES_M) - 1
    for k, flip in enumerate(flips_by_pixel(tested.pictures[0], whole.pictures[0])):
        keys: dict[str, Key] = {"samples": looks.samples[k], "number": k}
        yield Column("flip_ppm", [round(1e6 * float(flip.mean()))], keys)
        if by_band:
            yield from sums_by_band("flip_sum_ppm", np.bincount(bands, flip, count), keys)
    if by_band:
        yield from sums_by_band("pixels", np.bincount(bands, minlength=count), {}, 1)
        for which, seen in (("tested", tested), ("reference", whole)):
            yield from sums_by_band("light", seen.land.light, {"picture": which})
            yield from sums_by_band("rays", seen.land.rays, {"picture": which}, 1)


def judged_bands(point: Point) -> list[int]:
    """Return the bands that hold at least LEAST_SHARE of the reference's land over all fields."""
    bands = range(len(EDGES_M) - 2)
    filled, rays = zip(*(band_sums(point, "rays", band) for band in bands), strict=True)
    every = [each.sum() for each in rays]
    return [b for b in bands if every[b] >= LEAST_SHARE * sum(every) and filled[b].sum() > 0]
