"""What does motion hide beyond what size and distance leave, by speed and shutter? (§5.2)

Every field is `meadow` of a seed of its own, 640 pixels wide, cut by size and distance alone and by
motion as well. In a finite world everything is counted too: what there would be to gain at all.
"""

import hashlib
import json
import time
from dataclasses import asdict, dataclass
from datetime import UTC, datetime

from bench.experiments import Progress, silent
from bench.motion_claims import judge
from bench.provenance import provenance
from bench.records import Point, Record
from lod.prune import prune
from scenes.preset import load_preset
from scenes.world import build_world, view_at

NAME, VERSION = "motion", 1
FIELDS, QUICK_FIELDS = 16, 4
FRAME = 5

WORLD = "world.extent=400"
"""The finite world in which everything can be counted."""


@dataclass(frozen=True)
class Move:
    """What the camera does while the shutter is open [degrees/s, m/s, degrees of 360 a frame]."""

    turn: float
    speed: float
    shutter: float

    @property
    def settings(self) -> tuple[str, ...]:
        """As settings of a preset."""
        keys = {"camera.turn": self.turn, "camera.speed": self.speed, "view.shutter": self.shutter}
        return tuple(f"{key}={value}" for key, value in keys.items())


MOVES = (
    *(Move(turn, 0.0, 180.0) for turn in (0.0, 5.0, 15.0, 45.0, 90.0, 180.0)),
    *(Move(90.0, 0.0, shutter) for shutter in (45.0, 90.0, 360.0)),
    *(Move(0.0, speed, 180.0) for speed in (1.4, 14.0, 100.0)),
)
"""Pans at one shutter; one pan at other shutters; walks, drives and flights ahead."""

FAST = Move(90.0, 0.0, 180.0)


def run(quick: bool = False, progress: Progress = silent, seed: int = 0) -> Record:
    """Count every field by every cut; judge the claims."""
    start = time.perf_counter()
    seeds = [seed + k for k in range(QUICK_FIELDS if quick else FIELDS)]
    points = []
    for number, move in enumerate(MOVES):
        progress(number, len(MOVES) + 1, _name(move))
        cuts = {"spatial": ("view.motion_aware=false",), "motion": ()}
        points.append(_point("endless", move, seeds, cuts))
    progress(len(MOVES), len(MOVES) + 1, "a finite world")
    cuts = {
        "everything": ("view.metric=full", WORLD),
        "spatial": ("view.motion_aware=false", WORLD),
        "motion": (WORLD,),
    }
    points.append(_point("finite", FAST, seeds, cuts))
    progress(len(MOVES) + 1, len(MOVES) + 1, "judged")
    return Record(
        experiment=NAME,
        version=VERSION,
        quick=quick,
        made=datetime.now(UTC).strftime("%Y-%m-%dT%H:%M:%SZ"),
        provenance=provenance(_scene_hash(), seed),
        points=tuple(points),
        claims=judge(tuple(points)),
        notes={"fields": len(seeds), "seconds": round(time.perf_counter() - start, 1)},
    )


def _point(world: str, move: Move, seeds: list[int], cuts: dict[str, tuple[str, ...]]) -> Point:
    samples = {
        cut: [parts(move, each, settings) for each in seeds] for cut, settings in cuts.items()
    }
    return Point({"world": world, **asdict(move)}, {}, samples)


def parts(move: Move, seed: int, settings: tuple[str, ...]) -> int:
    """Parts of all species that a field displays."""
    preset = load_preset("meadow", (f"seed={seed}", *move.settings, *settings))
    world = build_world(preset)
    view = view_at(world, preset, FRAME)
    return sum(prune(field, view).displayed_parts for field in world.fields)


def _name(move: Move) -> str:
    return f"{move.turn:g}°/s, {move.speed:g} m/s, shutter {move.shutter:g}°"


def _scene_hash() -> str:
    """SHA-256 of the preset and of every case."""
    preset = load_preset("meadow").model_dump(mode="json")
    text = json.dumps([preset, [asdict(move) for move in MOVES], WORLD, FRAME], sort_keys=True)
    return hashlib.sha256(text.encode()).hexdigest()
