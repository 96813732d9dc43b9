"""Where does a measurement come from? What two rows must share before they may be compared."""

import hashlib
import json
import os
import platform
import subprocess
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

import numpy as np
import psutil

from scenes.plugins import packages
from scenes.processes.cache import PACKAGES, source_digest

_PACKAGES = (
    *("lodbench", "numpy", "scipy", "numba", "statsmodels", "mitsuba", "drjit", "OpenEXR"),
    *("karellen-llvm-core", "colour-science", "flip-evaluator"),
)
_ROOT = Path(__file__).resolve().parents[2]


@dataclass(frozen=True)
class Provenance:
    """What made the numbers.

    scene     SHA-256 of all that was measured: cases, settings, prototypes
    seed      the seed from which every field's own seed is derived
    variant   the renderer's variant; None where nothing was rendered
    threads   worker threads of the measurement
    cpu, cores, platform, python   the machine
    packages  name → version; those that bring metrics or representations, too
    commit    of the source, with ``+changes`` where files differ from it; None outside a checkout
    """

    scene: str
    seed: int
    variant: str | None
    threads: int
    cpu: str
    cores: int
    platform: str
    python: str
    packages: dict[str, str]
    commit: str | None


def provenance(scene: str, seed: int, threads: int = 1, variant: str | None = None) -> Provenance:
    """Return the provenance of a measurement that is made here and now."""
    versions = {name: each for name in _PACKAGES if (each := package_version(name)) is not None}
    return Provenance(
        scene=scene,
        seed=seed,
        variant=variant,
        threads=threads,
        cpu=cpu_name(),
        cores=os.cpu_count() or 1,
        platform=platform.platform(),
        python=platform.python_version(),
        packages=versions | packages(),
        commit=_commit(_ROOT),
    )


def machine() -> dict[str, Any]:
    """Say what measures one case here and now: sources, packages, processor, memory and load.

    ``digest`` is of ``lod``, ``scenes``, ``bench`` and the lock: records of one are of one program,
    whatever else was committed between its cases.
    """
    lock = _ROOT / "requirements.lock"
    locked = lock.read_bytes() if lock.is_file() else b""
    return {
        "commit": _commit(_ROOT),
        "digest": hashlib.sha256(source_digest(PACKAGES).encode() + locked).hexdigest(),
        "packages": {name: each for name in _PACKAGES if (each := package_version(name))},
        "libllvm": Path(os.environ.get("DRJIT_LIBLLVM_PATH", "")).name,
        "cpu": cpu_name(),
        "cores": os.cpu_count() or 1,
        "memory_bytes": psutil.virtual_memory().total,
        "load": round(psutil.getloadavg()[0], 2),
    }


def scene_digest(words: object, arrays: Iterable[np.ndarray] = ()) -> str:
    """Return the SHA-256 of plain data, as JSON with sorted keys, and of the bytes of arrays.

    It is the ``scene`` of a measurement whose settings are ``words``.
    """
    digest = hashlib.sha256(json.dumps(words, sort_keys=True).encode())
    for array in arrays:
        digest.update(np.ascontiguousarray(array).tobytes())
    return digest.hexdigest()


def cpu_name() -> str:
    """Give the processor's name as the system has it; elsewhere what Python knows of it."""
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
    except OSError:
        lines = []
    names = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.processor() or platform.machine()


def package_version(package: str) -> str | None:
    """Give the version of an installed package; None where it is not installed."""
    try:
        return version(package)
    except PackageNotFoundError:
        return None


@cache
def _commit(root: Path) -> str | None:
    """Return the commit of a checkout; an installed copy in someone else's checkout has none."""
    if not (root / ".git").exists():
        return None
    head = _git(root, "rev-parse", "HEAD")
    if not head:
        return None
    changes = _git(root, "status", "--porcelain", "--untracked-files=no")
    return head if changes == "" else f"{head}+changes"


def _git(root: Path, *words: str) -> str | None:
    try:
        done = subprocess.run(
            ("git", "-C", str(root), *words), capture_output=True, text=True, timeout=20, check=True
        )
    except (OSError, subprocess.SubprocessError):
        return None
    return done.stdout.strip()
