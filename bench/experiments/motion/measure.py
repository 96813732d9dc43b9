"""What does motion hide beyond what size and distance leave, by speed and shutter? (§5.2)

Every field is `meadow` of a seed of its own, 640 pixels wide, cut by size and distance alone and by
motion as well. In a finite world everything is counted too: what there would be to gain at all.
Whether what motion leaves out is missed in the blurred picture is asked by ``motion_picture``.
"""

import hashlib
import json
import time
from dataclasses import asdict

from bench.experiments.motion import pictures as motion_picture
from bench.experiments.motion.claims import judge
from bench.experiments.motion.moves import FAST, MOVES, PICTURED, Move
from bench.records.provenance import provenance
from bench.records.records import Point, Record
from bench.runner.dask_cases import CaseExecutor, serial_executor
from bench.runner.experiment import Progress, silent
from bench.runner.run_cases import make_record, merge_points, run_cases
from bench.statistics.excess_flip import LEAST_PAIRS
from lod.pruning.pruner import prune
from scenes.preset.load import load_preset
from scenes.render.mitsuba.variants import choose
from scenes.world.view import view_at
from scenes.world.world import World, build_world

NAME, VERSION = "motion", 2
FIELDS, QUICK_FIELDS = 12, 4
FRAME = 5

WORLD = "world.extent=400"
"""The finite world in which everything can be counted."""


CUTS: dict[str, dict[str, tuple[str, ...]]] = {
    "endless": {"spatial": ("view.smear=off",), "motion": ()},
    "finite": {
        "everything": ("view.metric=full", WORLD),
        "spatial": ("view.smear=off", WORLD),
        "motion": (WORLD,),
    },
}
"""Settings of every cut of the endless world, and of the finite one."""


def run(
    quick: bool = False,
    progress: Progress = silent,
    seed: int = 0,
    each: CaseExecutor = serial_executor,
) -> Record:
    """Count every field by every cut, render, and judge the claims; quick renders one pan."""
    start, variant = time.perf_counter(), choose()
    seeds = [seed + k for k in range(QUICK_FIELDS if quick else FIELDS)]
    cases = [(f"field {each_seed}", (each_seed,)) for each_seed in seeds]
    spp = motion_picture.QUICK_SPP if quick else motion_picture.SPP
    pictures = [
        (f"pictures of {_name(move)}", (move, pair, cuts, (variant, _samples(move, spp), seed)))
        for move, cuts in (PICTURED[:1] if quick else PICTURED)
        for pair in range(LEAST_PAIRS)
    ]
    found = run_cases(progress, each, (measure, cases), (motion_picture.measure, pictures))
    points = merge_points(found)
    return make_record(
        NAME,
        VERSION,
        quick=quick,
        provenance=provenance(_scene_hash(), seed, variant=variant),
        points=points,
        claims=judge(points),
        notes={"fields": len(seeds), "samples_per_pixel": spp},
        start=start,
    )


def measure(seed: int) -> list[Point]:
    """Parts of one field in either world, by each of its cuts, of every camera."""
    points = []
    for name, moves in (("endless", MOVES), ("finite", (FAST,))):
        world = world_of(seed, CUTS[name]["spatial"])
        for move in moves:
            cuts = CUTS[name].items()
            samples = {cut: [parts(world, move, seed, settings)] for cut, settings in cuts}
            points.append(Point({"world": name, **asdict(move)}, {}, samples))
    return points


def world_of(seed: int, settings: tuple[str, ...]) -> World:
    """A field of `meadow`: neither camera nor cut is any part of it."""
    return build_world(load_preset("meadow", (f"seed={seed}", *settings)))


def parts(world: World, move: Move, seed: int, settings: tuple[str, ...]) -> int:
    """Parts of all species that a field displays."""
    preset = load_preset("meadow", (f"seed={seed}", *move.settings, *settings))
    view = view_at(world, preset, FRAME)
    return sum(prune(field, view).displayed_parts for field in world.fields)


def _samples(move: Move, spp: int) -> int:
    """Samples a pixel: the other moves show how errors grow, and bound nothing."""
    return spp if move == FAST else min(spp, motion_picture.SHOWN_SPP)


def _name(move: Move) -> str:
    return f"{move.turn:g}°/s, {move.speed:g} m/s, shutter {move.shutter:g}°"


def _scene_hash() -> str:
    """SHA-256 of the preset and of every case."""
    preset = load_preset("meadow").model_dump(mode="json")
    moves = [asdict(move) for move in MOVES]
    pictures = [
        motion_picture.preset_of(FAST, cut, 0.0, 1).model_dump(mode="json")
        for cut in motion_picture.CUTS
    ]
    pictured = [[asdict(move), cuts] for move, cuts in PICTURED]
    text = json.dumps([preset, moves, WORLD, FRAME, pictures, pictured], sort_keys=True)
    return hashlib.sha256(text.encode()).hexdigest()
