"""What does motion hide beyond what size and distance leave, by speed and shutter? (§5.2)

Every field is `meadow` with a seed of its own, 640 pixels wide, cut by size and distance alone and
by motion as well. In a finite world everything is counted too, which is the most there is to gain.
Whether the blurred picture misses what motion leaves out is measured in ``pictures``.
"""

from dataclasses import asdict, dataclass

from bench.experiments.motion import pictures as motion_picture
from bench.experiments.motion.moves import FAST, MOVES, PICTURED, Move
from bench.experiments.motion.pictures import Pictures
from bench.images.compare import LEAST_PAIRS
from bench.old_experiment import Effort
from bench.records.provenance import scene_digest
from bench.records.records import Column, Point
from lod.pruner import prune
from scenes.presets.load import load_preset
from scenes.render.variants import choose
from scenes.scene import view_at
from scenes.world.world import World, build_world

FRAME = 5

BARE = "species.sward.density=0"
"""Without grass, of which a whole field has too much to count."""

WORLD = "world.extent=400"
"""The setting of the finite world, in which everything can be counted."""


CUTS: dict[str, dict[str, tuple[str, ...]]] = {
    "endless": {"spatial": ("view.smear=off",), "motion": ()},
    "finite": {
        "everything": ("view.metric=full", WORLD),
        "spatial": ("view.smear=off", WORLD),
        "motion": (WORLD,),
    },
}
"""The settings of every cut of the endless and of the finite world."""


@dataclass(frozen=True)
class Field:
    """A field whose parts are counted; its number is added to the run's seed."""

    number: int


def cases(effort: Effort) -> list[Field | Pictures]:
    """Return the fields that are counted, and the pairs of pictures that are rendered."""
    variant, spp = choose(), effort["samples_per_pixel"]
    return [
        *(Field(number) for number in range(effort["fields"])),
        *(
            Pictures(move, pair, cuts, variant, _samples(move, spp))
            for move, cuts in PICTURED[: effort["pictured"]]
            for pair in range(LEAST_PAIRS)
        ),
    ]


def measure(case: Field | Pictures, seed: int) -> list[Point]:
    """Count the parts of one field by every cut, or measure how far apart blurred pictures are."""
    if isinstance(case, Pictures):
        return motion_picture.measure(case, seed)
    return count_field(seed + case.number)


def count_field(seed: int) -> list[Point]:
    """Count the parts of one field in both worlds, by each of their cuts, for every camera."""
    points = []
    for name, moves in (("endless", MOVES), ("finite", (FAST,))):
        world = world_of(seed, CUTS[name]["spatial"])
        for move in moves:
            cuts = CUTS[name].items()
            counts = (
                Column("parts", [parts(world, move, seed, settings)], {"cut": cut})
                for cut, settings in cuts
            )
            points.append(Point({"world": name, **asdict(move)}, samples=tuple(counts)))
    return points


def world_of(seed: int, settings: tuple[str, ...]) -> World:
    """Build a field of `meadow`, which depends neither on the camera nor on the cut."""
    return build_world(load_preset("meadow", (BARE, f"seed={seed}", *settings)))


def parts(world: World, move: Move, seed: int, settings: tuple[str, ...]) -> int:
    """Count the parts of all species that a field displays."""
    preset = load_preset("meadow", (BARE, f"seed={seed}", *move.settings, *settings))
    view = view_at(world, preset, FRAME)
    return sum(prune(field, view).displayed_parts for field in world.fields)


def _samples(move: Move, spp: int) -> int:
    """Return the samples of a pixel: fewer for moves whose errors are only shown."""
    return spp if move == FAST else min(spp, motion_picture.SHOWN_SPP)


def scene_hash(points: tuple[Point, ...]) -> str:
    """Return the SHA-256 of the preset and of every case."""
    preset = load_preset("meadow", (BARE,)).model_dump(mode="json")
    moves = [asdict(move) for move in MOVES]
    pictures = [
        motion_picture.preset_of(FAST, cut, 0.0, 1).model_dump(mode="json")
        for cut in motion_picture.CUTS
    ]
    pictured = [[asdict(move), cuts] for move, cuts in PICTURED]
    return scene_digest([preset, moves, WORLD, FRAME, pictures, pictured])
