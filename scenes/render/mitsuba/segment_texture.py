"""A Mitsuba texture that colours each segment of a curve shape by a table of albedos."""

from functools import lru_cache
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np

from scenes.render.mitsuba.plugin import load_plugin


def segment_albedo(tint: np.ndarray, tints: np.ndarray) -> Any:
    """Make a texture that gives each segment the albedo, of (k, 3), that its tint (s,) numbers."""
    texture = load_plugin({"type": _registered(str(mi.variant()))})
    texture.tint = mi.UInt32(tint)
    texture.tints = mi.Float(tints.astype(np.float32).reshape(-1))
    return texture


@lru_cache(maxsize=4)
def _registered(variant: str) -> str:
    """Register the texture with the variant that is set; gives its name."""

    class TintOfSegments(mi.Texture):
        """Albedo by the number of the primitive that was met."""

        tint: Any
        tints: Any

        def eval(self, si: Any, active: Any = True) -> Any:
            row = dr.gather(mi.UInt32, self.tint, si.prim_index, active)
            return dr.gather(mi.Color3f, self.tints, row, active)

        def is_spatially_varying(self) -> bool:
            return True

    mi.register_texture("tint_of_segments", TintOfSegments)
    return "tint_of_segments"
