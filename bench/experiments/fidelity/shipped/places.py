"""In which places is a preset judged? Fixed by a rule, and never looked at while scenes are built.

Place k of a preset is the preset in the world of the k-th seed (``bench.seeds``),
seen from where the preset's eye stands but turned by k × 60°, with the sun 20° high where k is even
and 55° where it is odd.

`campfire` keeps its sun, and the eye goes round its fire, which it always faces. `fly_in` is a
flight, of which frames 1, 24 and 48 are judged, at τ = 1 px in place of the exaggerated one.
"""

import math
from dataclasses import dataclass

from scenes.presets.load import load_preset
from scenes.presets.schema import Preset

SUN_ELEVATIONS = (20.0, 55.0)
"""Elevations of the sun in even and in odd places [degrees]."""

TURN_DEG = 60.0
_ROUND_THE_FIRE = "campfire"
_FLIGHT, _FRAMES = "fly_in", (1, 24, 48)


@dataclass(frozen=True)
class Place:
    """A preset from one place: its name there, settings laid over it, and the frame's number."""

    preset: str
    number: int
    settings: tuple[str, ...]
    frame: int = 1

    def load(self) -> Preset:
        """Load the preset as it is seen here."""
        return load_preset(self.preset, self.settings)


def places(preset: str, count: int, size: str, seed: int) -> list[Place]:
    """Return the first ``count`` places of a preset in pictures of a size (WxH).

    ``seed`` is that of the world of place 0.
    """
    return [_place(preset, k, size, seed + k) for k in range(count)]


def _place(name: str, k: int, size: str, seed: int) -> Place:
    settings = (f"render.size={size}", f"seed={seed}")
    if name == _FLIGHT:
        return Place(name, k, (*settings, "view.detail=1"), _FRAMES[k])
    camera, turn = load_preset(name, ()).camera, k * TURN_DEG
    heading = f"camera.heading={math.fmod(camera.heading + turn, 360.0):g}"
    if name != _ROUND_THE_FIRE:
        sun = f"light.sun_elevation={SUN_ELEVATIONS[k % 2]:g}"
        return Place(name, k, (*settings, heading, sun))
    (x, y), a = camera.position, math.radians(turn)
    east, north = x * math.cos(a) + y * math.sin(a), y * math.cos(a) - x * math.sin(a)
    return Place(name, k, (*settings, heading, f"camera.position=[{east:.6f}, {north:.6f}]"))
