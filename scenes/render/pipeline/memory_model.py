"""Memory that a frame needs, foretold from what its cut displays; and what this process has held.

The model is linear, fitted to the most memory of twelve frames in fresh processes (relative least
squares; 0 to 5.8 M sticks, 0.03 to 1.2 M triangles, 2·10³ to 2·10⁶ pixels, both drivers):

    bytes = 336 MB + 277·sticks + 204·triangles + 176·pixels + s·samples at once,

s = 187 under Dr.Jit, 355 in scalar variants. Where all sticks are one shape (Dr.Jit, in colours)
and no shutter is open a stick takes 120: `crowd` with 2.1 M sticks held 0.92 GB at 1280 by 720,
foretold 0.93. Wavelengths bring colour-science with them: sixteen bands add 232 MB, 705 bytes a
pixel and, under Dr.Jit, 440 a sample at once; motion vectors 126 a stick (where its ends are
next); a denoiser 500 a pixel; and under an open shutter the sticks of two instants are held at
once. The constant is what the smallest frames take, less than the fit's since they no longer
import colour-science.
`lodbench study memory` holds it against what processes really take, by every kind of
haze and light as well.
"""

import sys
from dataclasses import dataclass
from pathlib import Path

from lod.errors import InputError
from lod.pruning.shapes import Sticks, Triangles
from scenes.frame.types import FrameInput
from scenes.render.drivers.sample_counts import MOST_SAMPLES

_BASE = 336e6
_STICK, _STICK_IN_ONE, _TRIANGLE, _PIXEL = 277.0, 120.0, 204.0, 176.0
_SAMPLE_JIT, _SAMPLE_SCALAR = 187.0, 355.0
_BASE_SPECTRAL, _PIXEL_SPECTRAL, _SAMPLE_SPECTRAL = 232e6, 705.0, 440.0
_MOVED_STICK, _DENOISED_PIXEL = 126.0, 500.0


@dataclass(frozen=True)
class ExtraBuffers:
    """What a frame is asked for beside a plain picture: each needs memory of its own."""

    motion: bool = False
    denoised: bool = False
    shutter: bool = False


def predict_bytes(
    sticks: int,
    triangles: int,
    size: tuple[int, int],
    spp: int,
    variant: str,
    beside: ExtraBuffers = ExtraBuffers(),
) -> int:
    """Bytes that the process which renders such a frame holds at most, within some 20 %.

    ``size`` is width and height in pixels, ``spp`` samples per pixel.
    """
    pixels, spectral = size[0] * size[1], variant.endswith("_spectral")
    jit = not variant.startswith("scalar_")
    sample = _SAMPLE_JIT + _SAMPLE_SPECTRAL * spectral if jit else _SAMPLE_SCALAR
    pixel = _PIXEL + _PIXEL_SPECTRAL * spectral + _DENOISED_PIXEL * beside.denoised
    in_one = jit and not spectral and not beside.shutter
    stick = _STICK_IN_ONE if in_one else _STICK * (2 if beside.shutter else 1)
    stick += _MOVED_STICK * beside.motion
    scene = _BASE + _BASE_SPECTRAL * spectral + stick * sticks + _TRIANGLE * triangles
    return round(scene + pixel * pixels + sample * min(pixels * spp, MOST_SAMPLES))


def predicted_bytes(made: FrameInput) -> int:
    """Bytes that a frame will need, from what it is made from."""
    size, quality = (made.camera.width, made.camera.height), made.quality
    beside = ExtraBuffers(made.extras.after is not None, made.extras.denoise, bool(made.instants))
    return predict_bytes(*count_shapes(made), size, quality.spp, quality.variant, beside)


def count_shapes(made: FrameInput) -> tuple[int, int]:
    """Sticks and triangles."""
    shapes = [each.shape for each in made.visible]
    sticks = sum(len(shape) for shape in shapes if isinstance(shape, Sticks))
    return sticks, sum(len(shape) for shape in shapes if isinstance(shape, Triangles))


def check_memory(made: FrameInput, most: int | None, what: str) -> None:
    """Raise InputError, with both figures, where a frame needs more bytes than it may have."""
    needed = predicted_bytes(made) if most is not None else 0
    if most is not None and needed > most:
        counts = "with {:,} sticks and {:,} triangles,".format(*count_shapes(made))
        rule = f"{what}, {counts} needs about {needed / 1e9:.2f} GB"
        cure = "allow more, add --fit, or ask for less detail, density or size"
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
