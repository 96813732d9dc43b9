"""Which Mitsuba variants work on this machine, each tried in a child process.

libLLVM is not in Mitsuba's wheel: on Linux x86-64 the package karellen-llvm-core brings it into the
environment, which names it in ``DRJIT_LIBLLVM_PATH`` (``scenes/__init__.py``), and elsewhere
Dr.Jit looks for the system's. A wrong one does not raise: it aborts the process. So it renders a
tiny scene in a child first.
"""

import os
import platform
import re
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

from lod.errors import InputError
from scenes import LLVM_PATH, packaged_library

TRUSTED = "LODBENCH_TRUSTED_VARIANT"
"""Set for a child: the variant that its parent has tried, with the libLLVM that is named."""

JIT_VARIANT, SCALAR_VARIANT = "llvm_ad_rgb", "scalar_rgb"
_TIMEOUT_S = 120


@dataclass(frozen=True)
class Probe:
    """What works here.

    variants   every variant of the wheel: True, or why it does not work
    libllvm    path of the libLLVM that the llvm variants use; None without one that works
    libraries  of the libLLVM that was tried: True, or why it does not work
    """

    variants: dict[str, bool | str]
    libllvm: str | None
    libraries: dict[str, bool | str]


def probe() -> Probe:
    """Try every variant of the wheel."""
    import mitsuba

    names = list(mitsuba.variants())
    with ThreadPoolExecutor(max_workers=2) as pool:
        variants = dict(zip(names, pool.map(works, names), strict=True))
    return Probe(variants, libllvm(), {_library(): works(JIT_VARIANT)})


def choose(name: str = "auto", spectral: bool = False) -> str:
    """Choose the variant to render with.

    For "auto" it is llvm_ad_rgb where that works, else scalar_rgb, or their ``spectral`` sisters.

    Raises InputError for a variant that is asked for by name and unknown, or does not work.
    """
    colours = "_spectral" if spectral else "_rgb"
    if name == "auto":
        fast, sure = (each.replace("_rgb", colours) for each in (JIT_VARIANT, SCALAR_VARIANT))
        return fast if works(fast) is True else sure
    if (answer := works(name)) is not True:
        import mitsuba

        known = list(mitsuba.variants())
        if name not in known:
            rule = f"auto or one of {', '.join(known)}"
            raise InputError("variant", name, rule, "try --variant auto")
        raise InputError("variant", name, f"does not work here ({answer})", _cure(name))
    if not name.endswith(colours):
        how = "with" if spectral else "without"
        rule = f"{how} --spectral frames are made in an {colours} variant"
        raise InputError("variant", name, rule, "try --variant auto")
    return name


def trusting(name: str) -> dict[str, str]:
    """The environment of a child process that need not try this variant again."""
    return {**os.environ, TRUSTED: name}


def use(name: str) -> None:
    """Make ``name`` Mitsuba's variant in this process, with the libLLVM that passed the probe."""
    import mitsuba

    mitsuba.set_variant(name)


def how_to_install() -> str:
    """Say in words how this platform gets a libLLVM."""
    if sys.platform == "linux" and platform.machine() == "x86_64":
        return "pip install karellen-llvm-core"
    system = {
        "linux": "apt-get install libllvm19, or what your system calls libLLVM 19 or newer",
        "darwin": "brew install llvm",
    }
    return system.get(sys.platform, f"install LLVM, and set {LLVM_PATH} to its LLVM-C.dll")


def libllvm() -> str | None:
    """Path of the libLLVM that renders; None without one."""
    return _library() if works(JIT_VARIANT) is True else None


def _library() -> str:
    return os.environ.get(LLVM_PATH, "what Dr.Jit finds")


@lru_cache(maxsize=64)
def works(variant: str) -> bool | str:
    """Render the tiny scene in a child: True, or why this variant does not work here."""
    if variant == os.environ.get(TRUSTED):
        return True
    library = os.environ.get(LLVM_PATH)
    if variant.startswith("llvm_") and library and not Path(library).is_file():
        return f"there is no file {library}"
    try:
        done = subprocess.run(
            [sys.executable, "-P", "-c", _PROBE, variant],
            capture_output=True,
            text=True,
            errors="replace",
            timeout=_TIMEOUT_S,
        )
    except subprocess.TimeoutExpired:
        return f"no answer in {_TIMEOUT_S} s"
    if done.returncode == 0 and done.stdout.strip().endswith("works"):
        return True
    why = _why(done.returncode, done.stderr)
    return f"{Path(_library()).name}: {why}" if variant.startswith("llvm_") else why


_PROBE = """
import resource, sys

resource.setrlimit(resource.RLIMIT_CORE, (0, 0))  # an abort is an answer, not something to debug
import mitsuba as mi

mi.set_variant(sys.argv[1])
ball = {
    "type": "scene",
    "integrator": {"type": "path", "max_depth": 3},
    "sensor": {
        "type": "perspective",
        "to_world": mi.ScalarTransform4f().look_at([0, -4, 1], [0, 0, 0], [0, 0, 1]),
        "film": {"type": "hdrfilm", "width": 4, "height": 4, "rfilter": {"type": "box"}},
        "sampler": {"type": "multijitter", "sample_count": 4},
    },
    "sky": {"type": "sunsky", "sun_direction": [1, 0, 1]},
    "ball": {"type": "sphere", "bsdf": {"type": "diffuse"}},
}
total = sum(map(float, mi.TensorXf(mi.render(mi.load_dict(ball), seed=1)).array))
if not 0 < total < float("inf"):
    raise RuntimeError(f"the tiny scene came out wrong: its pixels sum to {total}")
print("works")
"""
"""Renders a ball under the sky, in 4 × 4 pixels."""


def _why(code: int, words: str) -> str:
    lines = [line.strip() for line in words.splitlines() if line.strip()]
    telling = ("too old", "LLVM ERROR", "Error:")
    line = next((ln for sign in telling for ln in lines if sign in ln), lines[-1] if lines else "")
    line = re.sub(r"^(\w*Error: )?(\w+\(\): )?", "", line).split(". ")[0]
    line = line if len(line) <= 100 else line[:99] + "…"
    return f"it aborts with signal {-code}: {line}" if code < 0 else line


def _cure(name: str) -> str:
    if name.startswith("llvm_"):
        own, other = packaged_library(), os.environ.get(LLVM_PATH)
        how = how_to_install()
        if own and other and Path(other).resolve() != own:  # named, or loaded by an earlier import
            how = f"unset {LLVM_PATH} and import lodbench before mitsuba, so that {own} is taken"
        return f"{how}; or --variant {SCALAR_VARIANT}"
    if name.startswith("cuda_"):
        return "it needs an NVIDIA GPU and driver; try --variant auto"
    return "try --variant auto"
