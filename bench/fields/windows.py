"""Worlds of a preset that hold so many objects: windows about the eye, on level ground.

The ground ends with the window, so that it is the same few triangles in every frame of it: what
differs is what stands on it.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

from scenes.presets.load import load_preset
from scenes.presets.schema import Preset


@dataclass(frozen=True)
class Picture:
    """Size in pixels, as ``320x180``, and samples of each pixel."""

    size: str
    spp: int


def window_preset(
    name: str, settings: Sequence[str], objects: float, picture: Picture, detail: float | None
) -> Preset:
    """Make a preset with a window of so many objects, on average, about the eye.

    ``detail`` is τ [px]; None leaves the world unpruned.
    """
    plain = load_preset(name, settings)
    side = math.sqrt(objects / sum(each.density for each in plain.species.values()))
    keys = [f"world.extent={side!r}", f"render.size={picture.size}", f"render.spp={picture.spp}"]
    keys += [f"terrain.reach={min(plain.terrain.reach, side / math.sqrt(2))!r}"]
    keys += ["terrain.amplitude=0.0"]
    keys += ["view.metric=full"] if detail is None else [f"view.detail={detail!r}"]
    return load_preset(name, [*settings, *keys])
