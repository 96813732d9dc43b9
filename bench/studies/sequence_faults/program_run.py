"""The program, run in a folder of its own as a user runs it, with frames that cost little."""

import json
import os
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from scenes.render.files.manifest import file_hash
from scenes.render.mitsuba.variants import choose, trusting

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
size = "16x9"
spp = 2
"""
FRAMES = 20
_ROOT = Path(__file__).resolve().parents[3]
LONGEST_S = 600


@dataclass(frozen=True)
class Place:
    """A folder for everything of one measurement, and the variant that works in it."""

    folder: Path
    variant: str

    def start(self, *words: str) -> subprocess.Popen[str]:
        """The program, in a process group of its own, in the folder."""
        (self.folder / "tiny.toml").write_text(PRESET)
        paths = os.pathsep.join([str(_ROOT), *filter(None, [os.environ.get("PYTHONPATH")])])
        return subprocess.Popen(
            [sys.executable, "-P", "-m", "bench.cli.main", *words],
            cwd=self.folder,
            env={**trusting(choose(self.variant)), "PYTHONPATH": paths},
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            start_new_session=True,
        )

    def run(self, *words: str) -> "Run":
        """The program, to its end."""
        process = self.start(*words)
        out, err = process.communicate(timeout=LONGEST_S)
        return Run(process.returncode, out, err)

    def render(self, out: str, frames: str = f"1-{FRAMES}", *words: str) -> "Run":
        """`lodbench render` into a folder."""
        return self.run(*self.command(out, frames), *words)

    def command(self, out: str, frames: str = f"1-{FRAMES}") -> tuple[str, ...]:
        """The words of `lodbench render` into a folder."""
        flags = "--frames", frames, "--variant", self.variant, "--json"
        return "render", "tiny.toml", "-o", f"{out}/a.####.exr", *flags

    def hashes(self, out: str) -> dict[str, str]:
        """SHA-256 by name of every file under a frame's name."""
        return {path.name: file_hash(path) for path in sorted((self.folder / out).glob("*.exr"))}

    def litter(self, out: str) -> list[str]:
        """What is in a folder beside frames and manifest."""
        names = [path.name for path in (self.folder / out).iterdir()]
        return [name for name in names if not name.endswith((".exr", "manifest.json"))]


@dataclass(frozen=True)
class Run:
    """How the program ended: its code, its lines on stdout as JSON, and stderr."""

    code: int
    out: str
    err: str

    @property
    def lines(self) -> list[dict[str, Any]]:
        """The JSON objects on stdout."""
        return [json.loads(line) for line in self.out.splitlines()]

    @property
    def rendered(self) -> list[int]:
        """Frames that were made, not kept."""
        return [line["frame"] for line in self.lines if line.get("kept") is False]
