"""How many parts switch in a step, and does one see it? (§1.2)

``popping`` counts the parts that switch in a walk across a field, seen all round, and predicts
them: a part switches where its disc of radius √(D² − h²) about the eye gains or loses it, so a step
s switches K times the area in one of two such discs and not in the other. Then short walks are
rendered unpruned, pruned with fading and pruned without.

``popping_shipped`` walks through presets as shipped, in shaded pictures of another world. Each walk
is pruned as shipped, and clipped: parts then vanish at their limit all at once.

``films`` pans fast, walks past walkers, stops a turn and flies over trees, as each is pruned (by
motion too, and with parts kept for as long as they are off by less than half a pixel), unpruned,
and with planted faults: parts pop, every other frame is coarser, and motion stutters. Where the
planted clip leaves no more than the unpruned one, its test proves nothing.
"""

import math
from collections.abc import Iterator, Mapping, Sequence
from functools import lru_cache, partial
from itertools import pairwise

import numpy as np
from jaxtyping import Bool

from bench.counting import EYE_HEIGHT_M, FLAT
from bench.experiment import Case, Experiment, Topic
from bench.motion_residual import measure_walk, rows_missing, seen_of
from bench.part_sizes import density_of, prototypes_with, seed_of
from bench.plots import Curve, Plot, curves
from bench.records.claims import UNREPLICATED, Claim, Kind, at_least, at_most, claim, within
from bench.records.provenance import scene_digest
from bench.records.records import Column, Point, Record, columns, grouped, predictions, where
from bench.seeds import first_seed
from bench.statistics.estimates import (
    Estimate,
    in_series,
    two_sided_mean,
    two_sided_paired_ratio,
    two_sided_quantile,
    two_sided_ratio,
)
from lod.arrays import Reals
from lod.camera import Camera, Corner, camera_from_heading
from lod.law import chained_limits
from lod.metric import METRICS
from lod.pruner import prune
from lod.view import View, distance
from scenes.field.species_field import Species, SpeciesField
from scenes.presets.load import load_preset
from scenes.render.variants import choose
from scenes.scene import Scene
from scenes.sticks.prototype import Prototype

# Switches in fields of one species.

SPECIES = ("figure", "tree")
WIDTH_PX, STEP_M, FRAMES = 640, 2.0, 8
DENSER = {"figure": 0.25, "tree": 1.0}
"""Density ÷ that of the experiment `viewing`."""

SIZED = 8
"""The number of fields of which the size and distance of every switch are recorded."""

# Walks that are rendered.

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
WALK_WAYS = {
    "unpruned": ("view.metric=full",),
    "fading": ("view.fade=0.2",),
    "clipped": ("view.fade=0.0",),
}
"""The ways to prune a walk, and the settings of each."""

_WALK_FRAMES = 5

QUANTILE = 0.9999
"""Of the residual over the pixels of a walk."""

# Walks through presets as shipped.

SHIPPED, CLIPPED = "as shipped", "clipped"
SHIPPED_WAYS: dict[str, tuple[str, ...]] = {SHIPPED: (), CLIPPED: ("view.fade=0",)}
SPEED = "camera.speed=1.4"
"""As fast as one walks [m/s], where the preset's eye stands still."""

AT_ONCE = 8
"""The most pairs of frames of a case."""

# Clips of moving cameras.

CLIP_WORLD = (
    "render.size=160x90",
    "render.spp=36",
    "world.extent=120.0",
    "species.tree.density=0.002",
    "species.sward.density=0",
    "species.tree.prototypes=2",
    "species.tree.sizes=[0.6]",
    "species.figure.density=0.004",
    "species.figure.prototypes=2",
    "terrain.reach=300.0",
    "terrain.amplitude=1.0",
    "terrain.wavelength=256.0",
)
_TURN = (
    "camera.keys=[{frame=1, position=[0, -30], height=1.7, target=[-32, -10, 1.7]},"
    "{frame=15, position=[0, -30], height=1.7, target=[3.5, -0.7, 1.7]},"
    "{frame=16, position=[0, -30], height=1.7, target=[6, 0, 1.7]},"
    "{frame=99, position=[0, -30], height=1.7, target=[6, 0, 1.7]}]"
)
CLIPS = {
    "pan": (
        "camera.turn=90",
        "camera.speed=0",
        "camera.position=[0, -30]",
        "camera.heading=-25",
        "view.shutter=180",
    ),
    "walk": (
        "camera.speed=1.4",
        "camera.position=[0, -30]",
        "camera.heading=-25",
        "species.figure.patrol=6",
        "view.update_threshold=0.5",
    ),
    "stop": ("view.shutter=180", _TURN),
    "fly-over": (
        "camera.speed=20",
        "camera.height=25",
        "camera.pitch=-25",
        "camera.position=[0, -70]",
        "camera.heading=0",
        "view.shutter=180",
    ),
}
_PLANTED = ("view.fade=0", "view.update_threshold=4")
CLIP_WAYS: dict[str, tuple[tuple[str, ...], ...]] = {
    "pruned": ((),),
    "unpruned": (("view.metric=full", "view.smear=off", "view.update_threshold=0"),),
    "planted faults": (_PLANTED, (*_PLANTED, "view.detail=2")),
}
"""The ways to prune a clip, and their settings, of each in turn from frame to frame.

Of planted faults, parts of one to two pixels are there in every other frame alone, and others are
kept until one must see it: from where the camera turns in one place, nothing of a clip that is just
coarse would pop."""

CLIP_QUANTILE = 0.999
"""Of the residual over those pixels of a frame that the frame before looked at, too."""


def _popping_cases(fields: int, walks: int, unseen: bool) -> list[Case]:
    rest = walks, unseen, choose()
    return [
        *(partial(_measure_switches, name, fields) for name in SPECIES),
        *(partial(measure_walks, way, *rest) for way in WALK_WAYS),
    ]


def _shipped_cases(
    presets: Sequence[str], pairs: int, unseen: bool, size: str, spp: int
) -> list[Case]:
    made: list[Case] = []
    for preset in presets:
        place = f"render.size={size}", f"seed={first_seed(unseen)}", "light.sun_elevation=20"
        looks = (*place, f"render.spp={spp}", SPEED)
        for way in SHIPPED_WAYS:
            for first in range(1, pairs + 1, AT_ONCE):
                some = first, min(AT_ONCE, pairs + 1 - first)
                made.append(partial(measure_steps, preset, way, looks, *some, choose()))
    return made


def _view_at_step(step: int) -> View:
    eye = np.array((0.0, step * STEP_M, EYE_HEIGHT_M))
    camera = camera_from_heading(Corner(0, 0), eye, 0.0, 0.0, 60.0, (WIDTH_PX, 360))
    return View(camera, METRICS["blake"], look_around=True)


def _measure_switches(species: str, fields: int, seed: int) -> Point:
    """Count every field's switches; each has a size and a distance, in thousandths."""
    prototypes, m = prototypes_with(species, None), _view_at_step(0).m
    density = DENSER[species] * density_of(species, m)
    counts, sizes, distances = [], [], []
    for index in range(fields):
        own = seed_of(f"popping {species}", seed, index)
        field = SpeciesField(Species("popping", prototypes, density), own, FLAT)
        P = np.concatenate([tree.P for tree in field.prototypes.part_tables.hierarchies])
        count, before = 0, None
        for step in range(FRAMES + 1):
            view = _view_at_step(step)
            after = prune(field, view), view
            if before is not None:
                for here, there in ((before, after), (after, before)):
                    keys = (seen_of(cut, np.ones(len(cut))).key for cut in (here[0], there[0]))
                    rows = rows_missing(*keys)
                    d = distance(here[1], here[0].parts.position[rows])
                    count += len(rows)
                    if index >= SIZED:
                        continue
                    sizes += np.rint(1000 * P[here[0].part[rows]] / (d * m)).astype(int).tolist()
                    distances += np.rint(1000 * d).astype(int).tolist()
            before = after
        counts.append(count)
    samples = {"switches": counts, "size_mpx": sizes, "distance_mm": distances}
    mean = FRAMES * _expected_switches(prototypes, density, m)
    named = {"topic": "popping", "what": "switches", "species": species}
    looked_at = scene_digest([STEP_M, FRAMES, density], (tree.hierarchy.P for tree in prototypes))
    return Point(named, predictions({"switches": mean}), columns(samples), looked_at)


def _expected_switches(prototypes: tuple[Prototype, ...], density: float, m: float) -> float:
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


def measure_walks(way: str, walks: int, unseen: bool, variant: str, seed: int) -> Point:
    """Measure several walks in worlds of their own; the residual is in 10⁻⁶ of white."""
    popped: list[int] = []
    changed: list[int] = []
    for number in range(walks):
        heading = f"camera.heading={360.0 * number / walks - 170.0}"
        own = f"seed={first_seed(unseen, 5) + 20 * seed + number}"
        preset = load_preset("meadow", (*WALK, *WALK_WAYS[way], heading, own))
        found = measure_walk((Scene(preset),), range(1, _WALK_FRAMES + 1), variant)
        popped += found.popped.tolist()
        changed.append(round(1e6 * float(np.quantile(found.switched, QUANTILE))))
    named = {"topic": "popping", "what": "walk", "way": way}
    looked_at = scene_digest([WALK, WALK_WAYS[way]])
    columns_ = Column("popped", popped), Column("switched", changed, {"quantile": QUANTILE})
    return Point(named, samples=columns_, scene=looked_at)


def measure_steps(
    preset: str,
    way: str,
    looks: tuple[str, ...],
    first: int,
    pairs: int,
    variant: str,
    seed: int,
) -> Point:
    """Measure pairs of frames, from ``first`` and the next on; the preset has a seed of its own."""
    scene = _shipped_scene(preset, (*looks, *SHIPPED_WAYS[way]))
    frames = range(first, first + pairs + 1)
    found = measure_walk((scene,), frames, variant, shaded=True)
    samples = {
        "frame": [*frames[1:]],
        "world_seed": [scene.preset.seed] * pairs,
        "popped": found.popped.tolist(),
        "changed_ppm": _ppm_by_frame(found.switched, QUANTILE),
    }
    named = {"topic": "popping_shipped", "preset": preset, "way": way}
    looked_at = scene_digest([scene.preset.model_dump(mode="json")])
    return Point(named, samples=columns(samples), scene=looked_at)


@lru_cache(maxsize=1)
def _shipped_scene(name: str, settings: tuple[str, ...]) -> Scene:
    return Scene(load_preset(name, settings))


def _ppm_by_frame(changes: np.ndarray, quantile: float) -> list[int]:
    """Return a quantile over the pixels of each frame, in 10⁻⁶ of white, ignoring NaN."""
    return np.rint(1e6 * np.nanquantile(changes, quantile, axis=(1, 2))).astype(int).tolist()


def clip_scenes(clip: str, way: str, *settings: str) -> list[Scene]:
    """Return the scenes of a clip, of one world, whose frames take turns."""
    first, *others = (
        load_preset("meadow", (*CLIP_WORLD, *CLIPS[clip], *turn, *settings))
        for turn in CLIP_WAYS[way]
    )
    scene = Scene(first)
    return [scene, *(scene.with_preset(each) for each in others)]


def measure_clip(clip: str, way: str, frames: tuple[int, int], variant: str, seed: int) -> Point:
    """Measure the frames of a clip in one way, both ends included."""
    first, last = frames
    scenes, numbers = clip_scenes(clip, way), range(first, last + 1)
    found = measure_walk(scenes, numbers, variant)
    cameras = (scenes[0].camera(number) for number in numbers)
    known = np.stack([pixels_seen_before(*both) for both in pairwise(cameras)])
    samples = {
        "frame": [*numbers[1:]],
        "popped": found.popped.tolist(),
        "residual_ppm": _ppm_by_frame(np.where(known, found.residual, np.nan), CLIP_QUANTILE),
        "changed_ppm": _ppm_by_frame(np.where(known, found.switched, np.nan), CLIP_QUANTILE),
    }
    named = {"topic": "films", "clip": clip, "way": way}
    looked_at = scene_digest([CLIP_WORLD, CLIPS[clip], CLIP_WAYS[way]])
    return Point(named, samples=columns(samples), scene=looked_at)


def pixels_seen_before(before: Camera, now: Camera) -> Bool[np.ndarray, "h w"]:
    """Mark pixels of ``now`` whose direction the camera ``before`` has in its picture, too."""
    tan_x, tan_y = now.tan_half
    x = tan_x * (2 * (np.arange(now.width) + 0.5) / now.width - 1)
    y = tan_y * (1 - 2 * (np.arange(now.height) + 0.5) / now.height)
    ray = now.forward + x[None, :, None] * now.right + y[:, None, None] * now.up
    depth = ray @ before.forward
    tan_x, tan_y = before.tan_half
    across, up = abs(ray @ before.right), abs(ray @ before.up)
    return (across < tan_x * depth) & (up < tan_y * depth)


# Claims, from raw points alone.

RESIDUAL = "99.99th percentile of the motion-compensated residual"
POPPED = "parts popped between two frames"

MOST_CHANGE = 0.05
"""The greatest residual of a frame, as a share of white, that is not seen as a jump."""

MOST_RATIO = 1.1
"""Greatest ratio of the residual of a clip to that of the unpruned clip."""

_row = partial(claim, unit="frame", source="§1.2", alone=UNREPLICATED)


def _popping_claims(points: Sequence[Point]) -> Iterator[Claim]:
    for point in where(points, what="switches"):
        counts, of = point.values("switches"), {"species": point.case["species"]}
        check = partial(_row, kind="verification")
        found = two_sided_ratio(counts, np.full(len(counts), point.prediction("switches")))
        estimand = "parts switched per step ÷ predicted"
        yield check(estimand, within(1, 0.1), of, found, unit="field", source="§4.1")
        size, at = two_sided_quantile(point.values("size_mpx") / 1000, 0.95), "at the switch"
        widest, of = "95th percentile of P ÷ (d·θ)", {**of, "when": at}
        yield check(widest, at_most(1.0), of, size, unit="switch", source="§2.4")
    if walks := {p.case["way"]: p for p in where(points, what="walk")}:
        yield from _of_walks(walks)


def _of_walks(walks: Mapping[str, Point]) -> Iterator[Claim]:
    def worst(way: str) -> Reals:
        return walks[way].values("switched", quantile=QUANTILE) / 1e6

    scene, of_walk = {"scene": "meadow in a window of 120 m"}, partial(_row, unit="walk")
    for way in ("fading", "clipped"):
        found = two_sided_mean(walks[way].values("popped"))
        planted = way == "clipped"  # which is meant to pop, and shows that the test finds it
        of = {**scene, "pruning": way}
        yield _row(POPPED, at_most(0), of, found, violation_expected=planted)
    found, of = two_sided_mean(worst("unpruned")), {**scene, "pruning": "unpruned"}
    yield of_walk(RESIDUAL, at_most(0.01), of, found, kind="verification")
    found = two_sided_paired_ratio(worst("fading"), worst("clipped"))
    for most, extent in ((1.0, "less than clipping"), (0.5, "less than half of clipping")):
        of = {**scene, "reduction": extent}
        yield of_walk(f"{RESIDUAL}, fading ÷ clipped", at_most(most), of, found)


def changes(point: Point, column: str = "changed_ppm") -> Reals:
    """Return the residual of every pair of frames, as a share of white, (pairs,)."""
    return point.values(column) / 1e6


def _walked(values: Reals, wholes: Reals | None = None) -> Estimate:
    """Estimate the mean over the frames of one walk, or its ratio to that of other pictures."""
    found = two_sided_mean(values) if wholes is None else two_sided_paired_ratio(values, wholes)
    return in_series(found, values if wholes is None else values - found.value * wholes)


def _shipped_claims(points: Sequence[Point]) -> Iterator[Claim]:
    for (preset,), rows in grouped(points, "preset").items():
        ways = {each.case["way"]: each for each in rows}
        shipped, of = ways[SHIPPED], {"preset": preset, "pruning": SHIPPED}
        popped, mean = _walked(shipped.values("popped")), _walked(changes(shipped))
        ratio = _walked(changes(shipped), changes(ways[CLIPPED]))
        yield _row(POPPED, at_most(0), of, popped)
        yield _row(RESIDUAL, at_most(MOST_CHANGE), of, mean, headline=True)
        yield _row(f"{RESIDUAL}, as shipped ÷ clipped", at_most(0.5), of, ratio)


def _film_claims(points: Sequence[Point]) -> Iterator[Claim]:
    for (clip,), rows in grouped(points, "clip").items():
        ways, of = {each.case["way"]: each for each in rows}, {"clip": clip}
        yield _row(POPPED, at_most(0), of, _walked(ways["pruned"].values("popped")))
        residuals = {way: changes(point, "residual_ppm") for way, point in ways.items()}
        for way, bound in (
            ("pruned", at_most(MOST_RATIO)),
            ("planted faults", at_least(MOST_RATIO)),
        ):
            found = _walked(residuals[way], residuals["unpruned"])
            estimand = f"99.9th percentile of the motion-compensated residual, {way} ÷ unpruned"
            kind: Kind = "measurement" if way == "pruned" else "verification"
            yield _row(estimand, bound, of, found, kind=kind)


# Plots.

_SHARES = (0.01, 0.05, 0.1, 0.25, 0.5, 0.75, 0.9, 0.95, 0.99)


def _switch_plots(record: Record) -> Iterator[Plot]:
    drawn, words = [], []
    for point in where(record.points, what="switches"):
        metres = point.values("distance_mm") / 1000
        x = np.quantile(metres, _SHARES).tolist()
        drawn.append(Curve(point.case["species"], x, _SHARES))
        words.append(f"of {point.case['species']}s half within {x[4]:.1f} m, 9 in 10 {x[6]:.1f} m")
    caption = f"The share of switches that are nearer than a distance: {'; '.join(words)}."
    axis = "distance of the switch (m)", "share of the switches"
    if drawn:
        yield curves("popping", "Where parts switch", caption, axis, drawn)


def _shipped_plots(record: Record) -> Iterator[Plot]:
    for (preset,), points in grouped(record.points, "preset").items():
        name, about = f"shipped-{preset}", f"A walk through {preset}: the 99.99th percentile"
        yield _residual_plot(name, preset, about, points, MOST_CHANGE)


def _film_plots(record: Record) -> Iterator[Plot]:
    for (clip,), points in grouped(record.points, "clip").items():
        about = "A clip: the 99.9th percentile"
        yield _residual_plot(f"film-{clip}", clip, about, points, None)


def _residual_plot(
    name: str, what: str, about: str, points: list[Point], most: float | None
) -> Plot:
    drawn = [Curve(p.case["way"], p.column("frame"), changes(p).tolist()) for p in points]
    words = "; ".join(f"{c.label} {np.mean(c.y):.4f}, at most {max(c.y):.4f}" for c in drawn)
    if most is not None:
        frames = points[0].column("frame")
        drawn.append(Curve("not seen as a jump", [frames[0], frames[-1]], [most] * 2))
    caption = (
        f"{about} over pixels of the motion-compensated residual, as a share of white; both frames "
        f"of a pair have the same samples. Mean over frames: {words}."
    )
    axis = "frame", "residual (share of white)"
    title, scale = f"Change from frame to frame: {what}", ("linear", "linear")
    return curves(f"popping-{name}", title, caption, axis, drawn, scale)


EXPERIMENT = Experiment(
    name="popping",
    question="How many parts switch in a step, and does one see parts come and go?",
    version=4,
    topics={
        "popping": Topic(
            about="what comes and goes from frame to frame, its size, and what fading leaves",
            cases=_popping_cases,
            claims=_popping_claims,
            plots=_switch_plots,
            full={"fields": 100, "walks": 12, "unseen": True},
            quick={"fields": 24, "walks": 3, "unseen": False},
            seconds=(260.0, 70.0),
        ),
        "popping_shipped": Topic(
            about="motion-compensated residual of walks through presets as shipped",
            cases=_shipped_cases,
            claims=_shipped_claims,
            plots=_shipped_plots,
            full={
                "presets": ["forest", "mountain", "meadow"],
                "pairs": 48,
                "unseen": True,
                "size": "320x180",
                "spp": 16,
            },
            quick={"presets": ["meadow"], "pairs": 2, "unseen": False, "size": "64x36", "spp": 4},
            seconds=(900.0, 60.0),
            apart=True,
        ),
        "films": Topic(
            about="the same of a fast pan, a walk, a turn that stops and a flight over trees",
            cases=lambda clips, frames: [
                partial(measure_clip, clip, way, frames, choose())
                for clip in clips
                for way in CLIP_WAYS
            ],
            claims=_film_claims,
            plots=_film_plots,
            full={"clips": list(CLIPS), "frames": [1, 24]},
            quick={"clips": ["stop"], "frames": [14, 17]},
            seconds=(600.0, 60.0),
            apart=True,
        ),
    },
    caveats=(
        "Switches are counted all round on flat ground, at steps of two metres.",
        "Pictures are of albedo, in walks through shipped presets shaded by the sun; there is no "
        "shadow, air or bounced light: a shadow that jumps is not seen.",
        "One walk through each shipped preset, 1.4 m a second for two seconds, and one clip of "
        "each kind: pairs of frames are neighbours, so intervals over them are somewhat too "
        "narrow.",
        "Clips are measured in sharp pictures, as no open shutter would show them.",
    ),
    rendered=True,
    order=140,
)
