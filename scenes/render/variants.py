"""Which Mitsuba variants work on this machine, each tried in a child process.

libLLVM is not in Mitsuba's wheel: on Linux x86-64 the package karellen-llvm-core brings it into the
environment, which names it (``scenes/__init__.py``), and elsewhere the system's is taken. A wrong
one does not raise: it aborts the process. So every candidate renders a tiny scene in a child first.
Where ``DRJIT_LIBLLVM_PATH`` names one, no other is tried.
"""

import os
import platform
import re
import subprocess
import sys
from collections.abc import Iterator
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
_FOLDERS = (
    "/usr/lib/x86_64-linux-gnu",
    "/usr/lib/aarch64-linux-gnu",
    "/usr/lib64",
    "/usr/lib",
    "/usr/local/lib",
    "/opt/homebrew/opt/llvm/lib",
    "/usr/local/opt/llvm/lib",
    f"{sys.prefix}/lib",
)


@dataclass(frozen=True)
class Probe:
    """What works here.

    variants   every variant of the wheel: True, or why it does not work
    libllvm    path of the libLLVM that the llvm variants use; None without one
    libraries  every libLLVM that was tried: True, or why it does not work
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
    return Probe(variants, libllvm(), _libraries())


def choose(name: str = "auto", spectral: bool = False) -> str:
    """Choose the variant to render with.

    For "auto" it is llvm_ad_rgb where that works, else scalar_rgb, or their ``spectral`` sisters.

    Raises InputError for a variant that is asked for by name and unknown, or does not work.
    """
    if name == "auto" or name.startswith("llvm_"):
        _point_to_library()
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
    if name.startswith("llvm_"):
        _point_to_library()
    return {**os.environ, TRUSTED: name}


def use(name: str) -> None:
    """Make ``name`` Mitsuba's variant in this process, with the libLLVM that passed the probe."""
    if name.startswith("llvm_"):
        _point_to_library()
    import mitsuba

    mitsuba.set_variant(name)


def _point_to_library() -> None:
    """Name the libLLVM that passed; Dr.Jit reads the variable once, when it is first imported."""
    if TRUSTED in os.environ:
        return
    if library := libllvm():
        os.environ[LLVM_PATH] = library


@lru_cache(maxsize=64)
def works(name: str) -> bool | str:
    """True, or why this variant does not work here."""
    if name == os.environ.get(TRUSTED):
        return True
    if not name.startswith("llvm_"):
        return _try(name, None)
    library = libllvm()
    if library:
        return True if name == JIT_VARIANT else _try(name, library)
    found = [f"{Path(path).name}: {why}" for path, why in _libraries().items()]
    return "; ".join(found) or f"no libLLVM was found: {how_to_install()}"


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
    """Path of the newest libLLVM that renders; None without one."""
    return next((path for path, answer in _libraries().items() if answer is True), None)


@lru_cache(maxsize=1)
def _libraries() -> dict[str, bool | str]:
    """Candidates in the order tried, up to the first that renders."""
    tried: dict[str, bool | str] = {}
    for path in candidates():
        tried[path] = _try(JIT_VARIANT, path)
        if tried[path] is True:
            break
    return tried


def candidates() -> list[str]:
    """Every distinct libLLVM here: the environment's, then the system's, the newest first.

    Only the user's where one is named.
    """
    if asked := os.environ.get(LLVM_PATH):
        return [asked]
    found: dict[str, Path] = {}
    for path in _found():
        found.setdefault(str(path.resolve()), path)
    own = packaged_library()
    rest = sorted(map(str, found.values()), key=_version, reverse=True)
    return [*([str(own)] if own else []), *(each for each in rest if Path(each) != own)]


def _found() -> Iterator[Path]:
    for line in _loader_cache():
        if "libLLVM" in line and "=>" in line:
            yield Path(line.split("=>")[1].strip())
    folders = [Path(folder) for folder in _FOLDERS]
    folders += sorted(Path("/usr/lib").glob("llvm-*/lib"))
    for folder in folders:
        for pattern in ("libLLVM*.so*", "libLLVM*.dylib"):
            yield from (path for path in sorted(folder.glob(pattern)) if path.is_file())


def _loader_cache() -> list[str]:
    try:
        done = subprocess.run(["ldconfig", "-p"], capture_output=True, text=True, timeout=20)
    except (OSError, subprocess.TimeoutExpired):
        return []
    return done.stdout.splitlines()


def _version(path: str) -> tuple[tuple[int, ...], str]:
    """(19, 1) of libLLVM.so.19.1, (15, 1) of libLLVM-15.so.1, (0,) where the name does not say."""
    name = Path(path).resolve().name
    return tuple(int(digits) for digits in re.findall(r"\d+", name)) or (0,), path


def _try(variant: str, library: str | None) -> bool | str:
    """Render the tiny scene in a child: True, or why not."""
    if library and not Path(library).is_file():
        return f"there is no file {library}"
    environment = dict(os.environ, **({LLVM_PATH: library} if library else {}))
    try:
        done = subprocess.run(
            [sys.executable, "-P", "-c", _PROBE, variant],
            capture_output=True,
            text=True,
            errors="replace",
            timeout=_TIMEOUT_S,
            env=environment,
        )
    except subprocess.TimeoutExpired:
        return f"no answer in {_TIMEOUT_S} s"
    if done.returncode == 0 and done.stdout.strip().endswith("works"):
        return True
    return _why(done.returncode, done.stderr)


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
