"""What pops or swims in a walk through a preset as shipped? Shaded frames without noise (§1.2).

The walk is that of place 0, where a preset is judged (``fidelity.shipped.places``). It is pruned as
shipped, and clipped: parts then vanish at their limit all at once. ``unexplained_change`` measures
both, frame by frame.
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from bench.experiments.popping.shipped.claims import QUANTILE, WAYS
from bench.experiments.popping.unexplained_change import walk
from bench.fields.judged_seeds import first_seed
from bench.images.shipped import places
from bench.old_experiment import Effort
from bench.records.provenance import scene_digest
from bench.records.records import Point, columns
from scenes.presets.load import load_preset
from scenes.presets.schema import Preset
from scenes.render.variants import choose
from scenes.world.world import World, build_world

SPEED = "camera.speed=1.4"
"""As fast as one walks [m/s], where the preset's eye stands still."""

AT_ONCE = 8
"""The most pairs of frames of a case."""


@dataclass(frozen=True)
class Steps:
    """Some pairs of frames, from ``first`` and the next on, of a walk in one way."""

    preset: str
    way: str
    settings: tuple[str, ...]
    first: int
    pairs: int
    variant: str

    @property
    def label(self) -> str:
        """The name of the case, in short."""
        return f"{self.preset}, {self.way}, frames {self.first} to {self.first + self.pairs}"


def cases(effort: Effort) -> list[Steps]:
    """Return the walks of every preset in every way, some pairs of frames at a time."""
    made, variant = [], choose()
    for preset in effort["presets"]:
        place = places(preset, 1, effort["size"], first_seed(effort["unseen"]))[0]
        looks = (*place.settings, f"render.spp={effort['spp']}", SPEED)
        for way, more in WAYS.items():
            for first in range(1, effort["pairs"] + 1, AT_ONCE):
                pairs = min(AT_ONCE, effort["pairs"] + 1 - first)
                made.append(Steps(preset, way, (*looks, *more), first, pairs, variant))
    return made


def measure(case: Steps, seed: int) -> Point:
    """Measure pairs of frames: parts that popped, and the change [ppm of white] at QUANTILE."""
    preset, world = _world(case.preset, case.settings)
    frames = range(case.first, case.first + case.pairs + 1)
    found = walk(world, (preset,), frames, case.variant, shaded=True)
    changed = np.quantile(found.switched, QUANTILE, axis=(1, 2))
    samples = {
        "frame": [*frames[1:]],
        "world_seed": [preset.seed] * case.pairs,
        "popped": found.popped.tolist(),
        "changed_ppm": np.rint(1e6 * changed).astype(int).tolist(),
    }
    return Point({"preset": case.preset, "way": case.way}, samples=columns(samples))


@lru_cache(maxsize=1)
def _world(name: str, settings: tuple[str, ...]) -> tuple[Preset, World]:
    preset = load_preset(name, settings)
    return preset, build_world(preset)


def scene_hash(points: tuple[Point, ...]) -> str:
    """Return the SHA-256 of the walks' presets, and of the frames looked at."""
    presets = []
    for point in points:
        (seed,) = set(point.column("world_seed"))
        place = places(point.case["preset"], 1, "1x1", seed)[0]
        settings = (*place.settings, SPEED, *WAYS[point.case["way"]])
        presets.append(load_preset(place.preset, settings).model_dump(mode="json"))
    return scene_digest([presets, [(p.case, p.column("frame")) for p in points]])
