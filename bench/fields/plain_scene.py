"""How is the plain description of a preset's frame made, hashed and sized, before any renderer?"""

import hashlib
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
