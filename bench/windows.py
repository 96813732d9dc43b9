"""Worlds of a preset that hold so many objects: windows about the eye, on level ground.

The ground ends with the window, so that it is the same few triangles in every frame of it: what
differs is what stands on it.

How is the plain description of a preset's frame made, hashed and sized, before any renderer?
"""

import hashlib
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from lod.pruner import prune
from lod.view import View
from scenes.frame.frame_input import FrameInput, display
from scenes.presets.load import load_preset
from scenes.presets.schema import Preset
from scenes.render.description import describe_frame
from scenes.scene import frame_quality, preset_air, view_at
from scenes.world.light import sun_and_sky
from scenes.world.world import World, build_world


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


def first_view(name: str, size: str, *settings: str) -> tuple[World, Preset, View]:
    """Build a preset's world and the view of its first frame; ``size`` is WxH in pixels."""
    preset = load_preset(name, [f"render.size={size}", *settings])
    world = build_world(preset)
    return world, preset, view_at(world, preset, 1)


def plain_scene(world: World, preset: Preset, view: View) -> dict[str, Any]:
    """Prune every representation of a world, and describe what is displayed as plain arrays."""
    displayed = tuple(display(each, prune(each, view), view) for each in world.representations)
    quality = frame_quality(preset, "scalar_rgb")
    return describe_frame(
        FrameInput(view.camera, displayed, preset_air(preset), sun_and_sky(preset), quality)
    )


def scene_hash(scene: dict[str, Any]) -> str:
    """Hash everything in a plain scene that determines the picture: 16 hexadecimal digits."""
    sha = hashlib.sha256()
    for name, shape in sorted(scene["shapes"].items()):
        sha.update(name.encode())
        for key in ("control_points", "segment_indices", "albedo", "vertices", "faces", "colours"):
            sha.update(np.ascontiguousarray(shape.get(key, ())).tobytes())
        sha.update(scene["ids"][scene["owners"][name]].tobytes())
    return sha.hexdigest()[:16]


def scene_bytes(scene: dict[str, Any]) -> int:
    """Sum the bytes of all arrays of a plain scene."""
    arrays = [a for s in scene["shapes"].values() for a in s.values()]
    arrays += [scene["ids"], *scene["owners"].values()]
    return sum(a.nbytes for a in arrays if isinstance(a, np.ndarray))
