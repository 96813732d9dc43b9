"""Count the first frame of every preset, and keep the counts as golden.

Run as ``python -m tests.tools.golden_counts`` where a preset, a species or pruning is meant to
count otherwise; it prints the presets whose counts changed.
"""

import json
from pathlib import Path

from bench.frame_counts import count
from scenes.presets.load import preset_names
from scenes.scene import Scene

FILE = Path(__file__).resolve().parents[1] / "bench" / "golden_counts.json"


def golden_counts(preset):
    """Give the whole numbers of a preset's first frame, which repeat exactly on any machine."""
    scene = Scene(preset)
    counts = count(scene.world, scene.view(1))
    return {
        "objects": counts.objects.displayed,
        "parts": counts.parts.displayed,
        "parts_by_level": list(counts.by_level),
        "terrain_tiles": counts.terrain_tiles,
        "terrain_triangles": counts.terrain_triangles,
        "parts_beside": sum(parts.displayed for _, parts in counts.others.values()),
    }


if __name__ == "__main__":
    before = json.loads(FILE.read_text(encoding="utf-8"))
    found = {name: golden_counts(name) for name, _ in preset_names()}
    FILE.write_text(json.dumps(found, indent=1) + "\n", encoding="utf-8")
    print(*(name for name in found if before.get(name) != found[name]), sep="\n")
