"""Memory that a frame needs, foretold from what its cut displays; and what this process has held.

The model is linear, fitted to the most memory of twelve frames in fresh processes (relative least
squares; 0 to 5.8 M sticks, 0.03 to 1.2 M triangles, 2·10³ to 2·10⁶ pixels, both drivers):

    bytes = 461 MB + 277·sticks + 204·triangles + 176·pixels + s·samples at once,

s = 187 under Dr.Jit, 355 in scalar variants. `python -m bench.memory_benchmark` holds it against
what processes really take.
"""

import sys
from pathlib import Path

from lod.errors import InputError
from scenes.render.sampling import MOST_SAMPLES

_BASE = 461e6
_STICK, _TRIANGLE, _PIXEL = 277.0, 204.0, 176.0
_SAMPLE_JIT, _SAMPLE_SCALAR = 187.0, 355.0


def foretell(sticks: int, triangles: int, size: tuple[int, int], spp: int, variant: str) -> int:
    """Bytes that the process which renders such a frame holds at most, within some 10 %.

    ``size`` is width and height in pixels, ``spp`` samples per pixel.
    """
    pixels = size[0] * size[1]
    sample = _SAMPLE_SCALAR if variant.startswith("scalar_") else _SAMPLE_JIT
    scene = _STICK * sticks + _TRIANGLE * triangles
    return round(_BASE + scene + _PIXEL * pixels + sample * min(pixels * spp, MOST_SAMPLES))


def check_memory(needed: int, most: int | None, what: str) -> None:
    """Raise InputError, with both figures, where a frame needs more bytes than it may have."""
    if most is not None and needed > most:
        rule = f"{what} needs about {needed / 1e9:.2f} GB"
        cure = "allow more, or ask for less detail, density or size"
        raise InputError("--max-memory", f"{most / 1e9:.2f} GB", rule, cure)


def peak_rss_bytes() -> int:
    """The most memory this program has held; 0 where the system does not say.

    On Linux ``ru_maxrss`` would start from what the process held that started it.
    """
    status = Path("/proc/self/status")
    if status.exists():
        rows = status.read_text(encoding="ascii", errors="replace").splitlines()
        held = [int(row.split()[1]) * 1024 for row in rows if row.startswith("VmHWM")]
        if held:
            return held[0]
    try:
        import resource
    except ImportError:
        return 0
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return peak if sys.platform == "darwin" else peak * 1024
