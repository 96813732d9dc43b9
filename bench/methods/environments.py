"""Environments of Python for programs that are not dependencies: made on request, pinned whole.

Ask a program that runs in an environment of its own.
"""

import hashlib
import json
import os
import shutil
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import platformdirs

from lod.errors import InputError

_FOLDER = Path(__file__).parent
_MARK = "made-from"


@dataclass(frozen=True)
class Environment:
    """An environment of its own for one program.

    name, about    what tables show
    requirements   file of pinned packages beside this module
    needs_python   the only version of Python that the packages are for; empty = any
    download_mb, disk_mb   what making it downloads, and what it holds then
    """

    name: str
    about: str
    requirements: str
    needs_python: str
    download_mb: int
    disk_mb: int

    @property
    def folder(self) -> Path:
        """Where it is, or would be: among the user's data."""
        users = platformdirs.user_data_path("lodbench", appauthor=False)
        return users / "environments" / self.name

    @property
    def asks(self) -> str:
        """What making it takes, in words."""
        return f"downloads {self.download_mb / 1000:.1f} GB, holds {self.disk_mb / 1000:.1f} GB"

    def python(self) -> Path | None:
        """Return its Python; None where it was not made whole, or from other requirements."""
        mark, python = self.folder / _MARK, self.folder / "bin" / "python"
        whole = mark.is_file() and mark.read_text(encoding="utf-8") == self._digest()
        return python if whole and python.exists() else None

    def needed(self) -> Path:
        """Return its Python. Raises InputError where it was not made."""
        python = self.python()
        if python is None:
            cure = f"`lodbench environments {self.name}` makes it"
            raise InputError(self.name, "no environment", "it is made on request", cure)
        return python

    def make(self) -> Path:
        """Make it anew, and return its Python.

        Raises InputError for a Python that the packages are not for, for a disk that is too full,
        and where the packages cannot be installed.
        """
        here = f"{sys.version_info.major}.{sys.version_info.minor}"
        if self.needs_python and here != self.needs_python:
            rule = f"{self.name} has packages for Python {self.needs_python} alone"
            raise InputError("Python", here, rule)
        self.folder.parent.mkdir(parents=True, exist_ok=True)
        free = shutil.disk_usage(self.folder.parent).free / 1e6
        if free < self.disk_mb + self.download_mb:
            raise InputError(str(self.folder), f"{free:,.0f} MB free", f"{self.name} {self.asks}")
        shutil.rmtree(self.folder, ignore_errors=True)
        python = self.folder / "bin" / "python"
        wanted = str(_FOLDER / self.requirements)
        steps = (
            [sys.executable, "-m", "venv", str(self.folder)],
            [str(python), "-m", "pip", "install", "--no-cache-dir", "--quiet", "-r", wanted],
        )
        for step in steps:
            if subprocess.run(step, stdout=sys.stderr).returncode:
                raise InputError(self.name, "an installation that failed", "see pip's lines above")
        (self.folder / _MARK).write_text(self._digest(), encoding="utf-8")
        return python

    def _digest(self) -> str:
        return hashlib.sha256((_FOLDER / self.requirements).read_bytes()).hexdigest()


CYCLES = Environment(
    "cycles", "Blender (bpy), for examples/runners", "cycles_requirements.txt", "3.11", 460, 1130
)
VIDEO = Environment(
    "video",
    "ColorVideoVDP (cvvdp), with torch and its CUDA libraries",
    "video_requirements.txt",
    "",
    3100,
    5700,
)
ENVIRONMENTS = {each.name: each for each in (CYCLES, VIDEO)}

_LONGEST_S = 3600
_LAST_LINES = 3


def answer_of(environment: Environment, script: str, asked: str, *arguments: str) -> dict[str, Any]:
    """Run a script beside this file in an environment, and return the JSON of its last line.

    Raises InputError where there is no such environment, and where the script fails.
    """
    python = environment.needed()
    mine = {k: v for k, v in os.environ.items() if not k.startswith("PYTHON")}
    done = subprocess.run(
        [str(python), "-I", str(_FOLDER / script), *arguments],
        input=asked,
        env=mine,
        capture_output=True,
        timeout=_LONGEST_S,
        text=True,
    )
    if done.returncode:
        last = " / ".join(done.stderr.strip().splitlines()[-_LAST_LINES:])
        raise InputError(environment.name, f"exit code {done.returncode}", last or "no message")
    found: dict[str, Any] = json.loads(done.stdout.splitlines()[-1])
    return found
