"""How many parts switch in a step, and does one see it? (§1.2)

``popping`` counts the parts that switch in a walk across a field, seen all round, and predicts
them: a part switches where its disc of radius √(D² − h²) about the eye gains or loses it, so a step
s switches K times the area in one of two such discs and not in the other. Then short walks are
rendered unpruned, pruned with fading and pruned without.

``popping_shipped`` walks through presets, in shaded pictures of several worlds. Each walk is pruned
as shipped, clipped (parts then vanish at their limit all at once), and at half the detail.
"""

import math
from collections.abc import Iterator, Mapping, Sequence
from functools import partial

import numpy as np

from bench.counting import EYE_HEIGHT_M, FLAT
from bench.experiment import Case, Experiment, Topic
from bench.motion_residual import measure_walk, rows_missing, seen_of
from bench.part_sizes import density_of, prototypes_with, seed_of
from bench.plots import Curve, Panel, Plot, curves, estimated, figure
from bench.records.claims import UNREPLICATED, Claim, at_most, claim, within
from bench.records.provenance import scene_digest
from bench.records.records import Column, Point, Record, columns, grouped, predictions, where
from bench.seeds import first_seed
from bench.statistics.estimates import (
    two_sided_mean,
    two_sided_paired_ratio,
    two_sided_quantile,
    two_sided_ratio,
)
from lod.arrays import Reals
from lod.camera import Corner, camera_from_heading
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
DENSER = {"figure": 0.25, "tree": 1.0}  # density ÷ that of the experiment `viewing`
SIZED = 8  # the number of fields of which the size and distance of every switch are recorded

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

QUANTILE = 0.9999  # of the residual over the pixels of a walk

# Walks through presets as shipped.

SHIPPED, CLIPPED, HALF = "as shipped", "clipped", "at half the detail"
SHIPPED_WAYS = (SHIPPED, CLIPPED, HALF)
SPEED = "camera.speed=1.4"  # as fast as one walks [m/s], where the preset's eye stands still
APART = 12  # frames from one pair of a walk to the next


def _popping_cases(fields: int, walks: int, unseen: bool) -> list[Case]:
    rest = walks, unseen, choose()
    return [
        *(partial(_measure_switches, name, fields) for name in SPECIES),
        *(partial(measure_walks, way, *rest) for way in WALK_WAYS),
    ]


def _shipped_cases(
    presets: Sequence[str], walks: int, pairs: int, unseen: bool, size: str, spp: int
) -> list[Case]:
    looks = f"render.size={size}", f"render.spp={spp}", "light.sun_elevation=20", SPEED
    first = first_seed(unseen, 6)
    return [
        partial(measure_pairs, preset, way, looks, pairs, choose(), world)
        for world in range(first, first + walks)
        for preset in presets
        for way in SHIPPED_WAYS
    ]


def _view_at_step(step: int) -> View:
    eye = np.array((0.0, step * STEP_M, EYE_HEIGHT_M))
    camera = camera_from_heading(Corner(0, 0), eye, 0.0, 0.0, 60.0, (WIDTH_PX, 360))
    return View(camera, METRICS["blake"], look_around=True)


def _measure_switches(species: str, fields: int, seed: int) -> Point:
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
        found = measure_walk(Scene(preset), range(1, _WALK_FRAMES + 1), variant)
        popped += found.popped.tolist()
        changed.append(_ppm(found.switched))
    named = {"topic": "popping", "what": "walk", "way": way}
    looked_at = scene_digest([WALK, WALK_WAYS[way]])
    columns_ = Column("popped", popped), Column("switched", changed, {"quantile": QUANTILE})
    return Point(named, samples=columns_, scene=looked_at)


def measure_pairs(
    preset: str, way: str, looks: tuple[str, ...], pairs: int, variant: str, world: int, seed: int
) -> Point:
    """Measure pairs of frames of a walk, APART frames from each other."""
    detail = load_preset(preset).view.detail / 2
    how = {SHIPPED: (), CLIPPED: ("view.fade=0",), HALF: (f"view.detail={detail}",)}[way]
    scene = Scene(load_preset(preset, (*looks, *how, f"seed={world + 20 * seed}")))
    frames = range(1, 1 + APART * pairs, APART)
    found = [measure_walk(scene, (each, each + 1), variant, shaded=True) for each in frames]
    samples = {
        "frame": [*frames],
        "world_seed": [scene.preset.seed] * pairs,
        "popped": [int(each.popped[0]) for each in found],
        "changed_ppm": [_ppm(each.switched) for each in found],
    }
    named = {"topic": "popping_shipped", "preset": preset, "way": way}
    looked_at = scene_digest([scene.preset.model_dump(mode="json")])
    return Point(named, samples=columns(samples), scene=looked_at)


def _ppm(changes: np.ndarray) -> int:
    """Return the quantile over pixels, in 10⁻⁶ of white."""
    return round(1e6 * float(np.quantile(changes, QUANTILE)))


# Claims, from raw points alone.

RESIDUAL = "99.99th percentile of the motion-compensated residual"
POPPED = "parts popped between two frames"

MOST_CHANGE = 0.05
"""The greatest residual of a frame, as a share of white, that is not seen as a jump."""

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


def by_walk(point: Point, quantity: str) -> Reals:
    """Return the mean of a quantity over the pairs of every walk, (walks,), in order of seeds."""
    seeds, values = point.values("world_seed"), point.values(quantity)
    return np.array([values[seeds == each].mean() for each in np.unique(seeds)])


def _shipped_claims(points: Sequence[Point]) -> Iterator[Claim]:
    of_walk = partial(_row, unit="walk")
    for (preset,), rows in grouped(points, "preset").items():
        ways, of = {each.case["way"]: each for each in rows}, {"preset": preset, "pruning": SHIPPED}
        changed = {way: by_walk(each, "changed_ppm") / 1e6 for way, each in ways.items()}
        ratio = two_sided_paired_ratio(changed[SHIPPED], changed[CLIPPED])
        yield of_walk(POPPED, at_most(0), of, two_sided_mean(by_walk(ways[SHIPPED], "popped")))
        mean = two_sided_mean(changed[SHIPPED])
        yield of_walk(RESIDUAL, at_most(MOST_CHANGE), of, mean, headline=True)
        yield of_walk(f"{RESIDUAL}, as shipped ÷ clipped", at_most(0.5), of, ratio)


# Plots.

_SHARES = (0.01, 0.05, 0.1, 0.25, 0.5, 0.75, 0.9, 0.95, 0.99)


def _switch_plots(record: Record) -> Iterator[Plot]:
    drawn, words = [], []
    for point in where(record.points, what="switches"):
        metres = point.values("distance_mm") / 1000
        x = np.quantile(metres, _SHARES).tolist()
        drawn.append(Curve(point.case["species"], x, _SHARES))
        within_m = f"half within {x[4]:.0f} m and nine tenths within {x[6]:.0f} m"
        words.append(f"of {point.case['species']}s {within_m}")
    caption = f"The share of switches that are nearer than a distance: {'; '.join(words)}."
    axis = "distance of the switch (m)", "share of the switches"
    if drawn:
        yield curves("popping", "Where parts switch", caption, axis, drawn)


def _shipped_plots(record: Record) -> Iterator[Plot]:
    least, presets = 1e-4, [name for (name,) in grouped(record.points, "preset")]
    ways = {way: points for (way,), points in grouped(record.points, "way").items()}
    drawn, words = [], []
    for number, (way, points) in enumerate(ways.items()):
        at = [k + 0.2 * (number - 1) for k in range(len(presets))]  # beside each other
        found = [two_sided_mean(by_walk(each, "changed_ppm") / 1e6) for each in points]
        drawn.append(estimated(way, at, found, least=least))
        words.append(f"{way} {', '.join(f'{each.value:.4f}' for each in found)}")
    title = "What changes from frame to frame in walks through presets"
    caption = (
        "The 99.99th percentile over pixels of the motion-compensated residual, as a share of "
        "white; both frames of a pair have the same samples. Means over walks with 95 % "
        f"intervals; what is below {least:g} is drawn there. Shaded: at most {MOST_CHANGE:g}. "
        f"{'; '.join(words)} ({', '.join(presets)})."
    )
    axis = "preset", "residual (share of white)"
    allowed = least, MOST_CHANGE
    scale = "linear", "log"
    panels = [Panel("Walks", axis, drawn, scale, "points", presets, between=allowed)]
    yield figure("popping-shipped", title, caption, panels)


EXPERIMENT = Experiment(
    name="popping",
    question="How many parts switch in a step, and does one see parts come and go?",
    version=5,
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
                "presets": ["meadow", "forest", "crowd", "mountain"],
                "walks": 4,
                "pairs": 4,
                "unseen": True,
                "size": "320x180",
                "spp": 64,
            },
            quick={
                "presets": ["meadow"],
                "walks": 2,
                "pairs": 1,
                "unseen": False,
                "size": "64x36",
                "spp": 4,
            },
            seconds=(5000.0, 60.0),
            apart=True,
        ),
    },
    caveats=(
        "Switches are counted all round on flat ground, at steps of two metres.",
        "Pictures are of albedo, in walks through shipped presets shaded by the sun; there is no "
        "shadow, air or bounced light: a shadow that jumps is not seen.",
        "A sample that meets another thing changes its pixel by a 64th of their contrast: what is "
        "below that is not told apart.",
    ),
    rendered=True,
    order=140,
)
