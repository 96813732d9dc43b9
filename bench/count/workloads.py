"""Which counts must the first frame of a preset give, at which version of the workload?

``meadow@1`` is a preset at a version. Its counts are golden: where a preset, a species or pruning
counts otherwise, it is another workload and takes the next version, so that a changed workload is
never mistaken for a changed system. ``python -m bench.count.workloads`` counts anew and gives
changed ones their next version.
"""

import json
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from bench.count.count_frame import Counts, count
from lod.errors import InputError
from scenes.presets.load import preset_names
from scenes.scene import Scene

_FILE = Path(__file__).with_name("workloads.json")


@dataclass(frozen=True)
class Workload:
    """A preset at a version, with the counts of its first frame by the names of `golden_counts`."""

    preset: str
    version: int
    counts: dict[str, Any]

    @property
    def name(self) -> str:
        """Write preset and version as ``meadow@1``."""
        return f"{self.preset}@{self.version}"

    def mismatches(self, counts: Counts) -> list[str]:
        """Write one line for each count that is not golden."""
        found = golden_counts(counts)
        return [
            f"{name} {found[name]} instead of {wanted}"
            for name, wanted in self.counts.items()
            if found[name] != wanted
        ]


def workloads() -> dict[str, Workload]:
    """Read every workload, at the version that this program makes, by the name of its preset."""
    data = json.loads(_FILE.read_text(encoding="utf-8"))
    return {each["preset"]: Workload(**each) for each in data}


def workload_named(text: str) -> Workload | None:
    """Find the workload that ``meadow@1`` names; None for a preset without a version.

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


def golden_counts(counts: Counts) -> dict[str, Any]:
    """Give the whole numbers of a frame that must repeat exactly on any machine."""
    return {
        "objects": counts.objects.displayed,
        "parts": counts.parts.displayed,
        "parts_by_level": list(counts.by_level),
        "terrain_tiles": counts.terrain_tiles,
        "terrain_triangles": counts.terrain_triangles,
        "parts_beside": sum(parts.displayed for _, parts in counts.others.values()),
    }


def first_frame_counts(preset: str) -> Counts:
    """Count the first frame of a preset without any setting changed."""
    scene = Scene(preset)
    return count(scene.world, scene.view(1))


def _renew_workloads() -> None:
    old, new = workloads() if _FILE.exists() else {}, []
    for preset, _ in preset_names():
        before, found = old.get(preset), golden_counts(first_frame_counts(preset))
        same = before is not None and before.counts == found
        version = before.version + (not same) if before else 1
        new.append(asdict(Workload(preset, version, found)))
        print(f"{preset}@{version}{'' if same else ' is new'}")
    _FILE.write_text(json.dumps(new, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    _renew_workloads()
