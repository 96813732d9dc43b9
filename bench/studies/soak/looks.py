"""Which pictures does a soak ask for, and what are the right bytes of each?"""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

PRESET = """
[camera]
speed = 200
[terrain]
amplitude = 3
reach = 64
[placed.insect]
model = "insect"
position = [0.5, 8.0]
[render]
size = "32x18"
spp = 1
"""
PRESET_NAME = "tiny.toml"
FRAMES = tuple(range(1, 13))

LOOKS: Mapping[str, tuple[str, ...]] = {
    "plain": (),
    "seed": ("--seed", "2"),
    "samples": ("--spp", "2"),
}
"""Flags of settings that differ, by name. Frames of two looks are never the same bytes."""


@dataclass(frozen=True)
class Truth:
    """SHA-256 of every frame, rendered alone and undisturbed: by look, then by frame."""

    hashes: Mapping[str, Mapping[int, str]]

    def look_of(self, frame: int, digest: str) -> str | None:
        """Give the look whose frame of that number has these bytes; None where none has."""
        return next((look for look, each in self.hashes.items() if each[frame] == digest), None)


def frame_name(stem: str, frame: int) -> str:
    """Name the file of a frame."""
    return f"{stem}.{frame:04d}.exr"


def frame_number(name: str) -> int:
    """Give the number in a frame's file name."""
    return int(name.split(".")[-2])


def frame_files(folder: Path) -> list[Path]:
    """Find the frames of a folder that a reader of its sequences would take, in order."""
    return sorted(path for path in folder.glob("*.exr") if path.name.split(".")[-2].isdecimal())
