"""Workloads by version: ``meadow@1`` is a preset with the counts that its first frame must give.

The counts are golden: where a preset, a species or the pruner counts otherwise, it is another
workload and takes the next version, so that a changed workload is never mistaken for a changed
system. ``python -m bench.count.workloads`` counts anew and gives changed ones their next version.
"""

import json
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from bench.count.count_frame import Counts, count
from lod.errors import InputError
from scenes.preset.load import load_preset, preset_names
from scenes.world.view import view_at
from scenes.world.world import build_world

_FILE = Path(__file__).with_name("workloads.json")


@dataclass(frozen=True)
class Workload:
    """A preset at a version; ``counts`` by the names of `golden`."""

    preset: str
    version: int
    counts: dict[str, Any]

    @property
    def name(self) -> str:
        """As it is written: ``meadow@1``."""
        return f"{self.preset}@{self.version}"

    def differing(self, counts: Counts) -> list[str]:
        """One line for each count that is not golden."""
        found = golden(counts)
        return [
            f"{name} {found[name]} instead of {wanted}"
            for name, wanted in self.counts.items()
            if found[name] != wanted
        ]


def workloads() -> dict[str, Workload]:
    """Every workload at the version that this program makes, by its preset."""
    data = json.loads(_FILE.read_text(encoding="utf-8"))
    return {each["preset"]: Workload(**each) for each in data}


def workload_named(text: str) -> Workload | None:
    """The workload of ``meadow@1``; None for a preset without a version.

    Raises InputError for a version that this program does not make.
    """
    preset, at, version = text.partition("@")
    if not at:
        return None
    known = workloads().get(preset)
    if known is None or version != str(known.version):
        made = ", ".join(each.name for each in workloads().values())
        cure = "results of another version need the lodbench that made them"
        raise InputError("PRESET", text, f"a workload that this version makes: {made}", cure)
    return known


def golden(counts: Counts) -> dict[str, Any]:
    """What a frame must count: whole numbers alone."""
    return {
        "objects": counts.objects.displayed,
        "parts": counts.parts.displayed,
        "parts_by_level": list(counts.by_level),
        "terrain_tiles": counts.terrain_tiles,
        "terrain_triangles": counts.terrain_triangles,
        "parts_beside": sum(parts.displayed for _, parts in counts.others.values()),
    }


def counted(preset: str) -> Counts:
    """The preset's first frame, as it is."""
    chosen = load_preset(preset)
    world = build_world(chosen)
    return count(world, view_at(world, chosen, 1))


def _renew() -> None:
    old, new = workloads() if _FILE.exists() else {}, []
    for preset, _ in preset_names():
        before, found = old.get(preset), golden(counted(preset))
        same = before is not None and before.counts == found
        version = before.version + (not same) if before else 1
        new.append(asdict(Workload(preset, version, found)))
        print(f"{preset}@{version}{'' if same else ' is new'}")
    _FILE.write_text(json.dumps(new, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    _renew()
