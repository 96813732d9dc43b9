"""How is the program run as a user runs it, in a folder of its own, with cheap frames?"""

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
    """The folder of one measurement, and the variant that renders in it."""

    folder: Path
    variant: str

    def start(self, *words: str) -> subprocess.Popen[str]:
        """Start the program in the folder, in a process group of its own."""
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
        """Run the program to its end."""
        process = self.start(*words)
        out, err = process.communicate(timeout=LONGEST_S)
        return Run(process.returncode, out, err)

    def render(self, out: str, frames: str = f"1-{FRAMES}", *words: str) -> "Run":
        """Run `lodbench render` into a folder."""
        return self.run(*self.command(out, frames), *words)

    def command(self, out: str, frames: str = f"1-{FRAMES}") -> tuple[str, ...]:
        """Return the words of `lodbench render` into a folder."""
        flags = "--frames", frames, "--variant", self.variant, "--json"
        return "render", "tiny.toml", "-o", f"{out}/a.####.exr", *flags

    def hashes(self, out: str) -> dict[str, str]:
        """Return the SHA-256 of every file under a frame's name, by name."""
        return {path.name: file_hash(path) for path in sorted((self.folder / out).glob("*.exr"))}

    def litter(self, out: str) -> list[str]:
        """Return the files of a folder that are neither frames nor the manifest."""
        names = [path.name for path in (self.folder / out).iterdir()]
        return [name for name in names if not name.endswith((".exr", "manifest.json"))]


@dataclass(frozen=True)
class Run:
    """How the program ended: its exit status, its lines on stdout as JSON, and stderr."""

    code: int
    out: str
    err: str

    @property
    def lines(self) -> list[dict[str, Any]]:
        """The JSON objects on stdout."""
        return [json.loads(line) for line in self.out.splitlines()]

    @property
    def rendered(self) -> list[int]:
        """The frames that were rendered and not kept from an earlier run."""
        return [line["frame"] for line in self.lines if line.get("kept") is False]
