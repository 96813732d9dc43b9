"""Would a record come out otherwise today? A small frame tells, without measuring anything again.

A probe is one frame of a preset: how many parts, sticks and triangles it displays, and its pixels,
64×36. A record keeps the probe of the sources that made it. Where the sources are others now, the
same frame is made again; if it is the same, editing words or moving files has made nothing stale.
"""

import base64
import zlib
from functools import lru_cache
from typing import Any

import numpy as np

from scenes.presets.load import load_preset
from scenes.render.pictures import auto_exposure, to_srgb
from scenes.render.render import render_frame
from scenes.render.variants import choose
from scenes.scene import Scene

NOTE, SOURCES, CASES = "probe", "sources", "cases"
"""The notes of a record that hold its probe, the digest of the sources that made it, and of each
case what measured it and how long that took."""

SIZE = 64, 36
SAME = 0.05
"""The mean difference of two probes' pixels, of 255, up to which they are the same.

Another machine may calculate other last digits.
"""


@lru_cache(maxsize=8)
def take_probe(preset_name: str) -> dict[str, Any]:
    """Make the probe of a preset with the sources that are here, as plain data."""
    words = (f"render.size={SIZE[0]}x{SIZE[1]}", "render.spp=4")
    preset = load_preset(preset_name, words)
    made = Scene(preset).input(1, choose())
    layers = render_frame(made)
    rgb = layers.rgb.astype(np.float64)
    shown = np.rint(255 * np.clip(to_srgb(rgb, auto_exposure(rgb)), 0, 1)).astype(np.uint8)
    parts = {each.name: len(each.cut) for each in made.displayed}
    drawn = {k: layers.statistics[k] for k in ("sticks", "triangles")}
    return {
        "preset": preset_name,
        "counts": parts | drawn,
        "pixels": base64.b64encode(zlib.compress(shown.tobytes(), 9)).decode(),
    }


def has_changed(before: dict[str, Any], after: dict[str, Any]) -> bool:
    """Tell whether two probes show different frames, as one that is no probe does."""
    try:
        if any(before[key] != after[key] for key in ("preset", "counts")):
            return True
        one, other = (_pixels(each) for each in (before, after))
        return bool(np.abs(one - other).mean() > SAME)
    except (TypeError, KeyError, ValueError, zlib.error):
        return True


def _pixels(probe: dict[str, Any]) -> np.ndarray:
    size = 3 * SIZE[0] * SIZE[1]
    data = zlib.decompressobj().decompress(base64.b64decode(probe["pixels"]), size)
    return np.frombuffer(data, np.uint8).astype(np.float64)
