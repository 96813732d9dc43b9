"""Memory that a frame needs, predicted from what its cut displays.

The model is linear, fitted to the most memory of twelve frames in fresh processes (relative least
squares; 0 to 5.8 M sticks, 0.03 to 1.2 M triangles, 2·10³ to 2·10⁶ pixels, both drivers):

    bytes = 336 MB + 277·sticks + 204·triangles + 176·pixels + s·samples at once,

s = 187 under Dr.Jit, 355 in scalar variants. Where all sticks are one shape (Dr.Jit, in colours)
and no shutter is open a stick takes 120: `crowd` with 2.1 M sticks held 0.92 GB at 1280 by 720,
predicted 0.93. Wavelengths bring colour-science with them: sixteen bands add 232 MB, 705 bytes a
pixel and, under Dr.Jit, 440 a sample at once; motion vectors 126 a stick (where its ends are
next); a denoiser 500 a pixel, mattes 90; and under an open shutter the sticks of two instants are
held at once. The constant is what the smallest frames take, less than the fit's since they no
longer import colour-science.
`lodbench study memory` holds it against what processes really take, by every kind of
haze and light as well.

Pruning alone, without a picture (``lodbench count``), takes

    bytes = 380 MB + 60·parts + 120·objects examined + 24·cells + 230·triangles,

set by hand, on the safe side: in nine counts (0.3 to 360 M parts) a part took 11 to 18 bytes, but
trees 30 times as large as usual (`species.tree.sizes=[30]` in `meadow`) took far more. `crowd` at 2
people a square metre, each in a pose of its own, takes more than this says.
"""

import math
from dataclasses import dataclass

from lod.shapes import Sticks, Triangles, batches_of
from scenes.frame.frame_input import FrameInput
from scenes.frame.quality import Quality
from scenes.world.forecast import Forecast

_BASE = 336e6
_STICK, _STICK_IN_ONE, _TRIANGLE, _PIXEL = 277.0, 120.0, 204.0, 176.0
_SAMPLE_JIT, _SAMPLE_SCALAR = 187.0, 355.0
_BASE_SPECTRAL, _PIXEL_SPECTRAL, _SAMPLE_SPECTRAL = 232e6, 705.0, 440.0
_MOVED_STICK, _DENOISED_PIXEL, _MATTED_PIXEL = 126.0, 500.0, 90.0
_BASE_PRUNED = 380e6
_PRUNED_PART, _OBJECT, _CELL, _MESHED_TRIANGLE = 60.0, 120.0, 24.0, 230.0


@dataclass(frozen=True)
class ExtraBuffers:
    """What is asked of a frame beside a plain picture; each needs memory of its own."""

    motion: bool = False
    denoised: bool = False
    shutter: bool = False


def predict_bytes(
    sticks: int,
    triangles: int,
    size: tuple[int, int],
    quality: Quality,
    extra: ExtraBuffers = ExtraBuffers(),
) -> int:
    """Predict the bytes that a process holds at most for such a frame, within some 20 %.

    ``size`` is width and height in pixels; of the quality samples, window and variant count.
    """
    pixels, spectral, jit = size[0] * size[1], quality.is_spectral, quality.is_jit
    sample = _SAMPLE_JIT + _SAMPLE_SPECTRAL * spectral if jit else _SAMPLE_SCALAR
    pixel = _PIXEL + _PIXEL_SPECTRAL * spectral + _DENOISED_PIXEL * extra.denoised
    pixel += _MATTED_PIXEL * quality.coverage
    in_one = jit and not spectral and not extra.shutter
    stick = _STICK_IN_ONE if in_one else _STICK * (2 if extra.shutter else 1)
    stick += _MOVED_STICK * extra.motion
    scene = _BASE + _BASE_SPECTRAL * spectral + stick * sticks + _TRIANGLE * triangles
    at_once = min(pixels * quality.spp, quality.most_samples)
    kept = math.prod(quality.window_of(size).size)
    return round(scene + pixel * kept + sample * at_once)


def predicted_bytes(frame_input: FrameInput) -> int:
    """Predict the bytes that a frame will need, from its input."""
    camera = frame_input.camera
    after, subframes = frame_input.after, frame_input.subframes
    extra = ExtraBuffers(after is not None, frame_input.denoise, bool(subframes))
    size = camera.width, camera.height
    return predict_bytes(*count_shapes(frame_input), size, frame_input.quality, extra)


def count_shapes(frame_input: FrameInput) -> tuple[int, int]:
    """Count the sticks and triangles of a frame."""
    shapes = [shape for each in frame_input.displayed for shape in batches_of(each.shape)]
    sticks = sum(len(shape) for shape in shapes if isinstance(shape, Sticks))
    return sticks, sum(len(shape) for shape in shapes if isinstance(shape, Triangles))


def forecast_bytes(found: Forecast) -> int:
    """Predict the bytes that a process holds at most while it prunes such a view."""
    columns = _OBJECT * found.objects + _CELL * found.cells + _MESHED_TRIANGLE * found.triangles
    return parts_bytes(found.parts) + round(columns)


def parts_bytes(parts: float) -> int:
    """Predict the bytes that a process holds which has pruned a view down to so many parts."""
    return round(_BASE_PRUNED + _PRUNED_PART * parts)
