"""Which frames of a sequence need no forecast of memory of their own? Those near one all round."""

from dataclasses import dataclass, replace

import numpy as np

from lod.errors import InputError
from lod.motion import eye_relative_to
from lod.view import View
from scenes.preset.tables import Preset
from scenes.render.pipeline.memory_limit import check_frame_forecast, frame_bytes, memory_limit
from scenes.world.forecast import forecast
from scenes.world.view import view_at
from scenes.world.world import World

_NEAR = 0.5
"""Share of its height above the ground by which an eye may move."""

_FAR_BELOW = 8.0
"""How often what was foretold all round must fit into the limit."""


@dataclass(frozen=True)
class _Around:
    """What was foretold all round an eye: its view, its height above the ground [m], the bytes."""

    view: View
    height: float
    bytes: int


class Foresight:
    """Foretells the memory of a world's frames, and spares those that an earlier forecast covers.

    An eye that moves by at most half its height above the ground is then at least half as far from
    all ground as before, and all round it displays at most four times the parts: they grow as 1/m²
    on even ground (``lod.law``), and shorter distances are a finer m. Such frames need no forecast
    where eight times that fits into the limit, wherever they look.
    """

    def __init__(self, world: World, preset: Preset, variant: str) -> None:
        self._world, self._preset, self._variant = world, preset, variant
        self._around: _Around | None = None
        self._asked, self._helps = 0, True

    def check(self, frame: int, most: int | None) -> None:
        """Raise InputError where a frame is foretold to need more than it may (--max-memory)."""
        limit = memory_limit(most).bytes
        if limit is None:
            return
        view = view_at(self._world, self._preset, frame)
        if self._covers(view, limit):
            return
        check_frame_forecast(self._world, self._preset, frame, self._variant, most)
        self._asked += 1
        if self._asked > 1 and self._helps:  # one frame alone would pay for nothing
            self._look_around(view)
            self._helps = self._covers(view, limit)

    def _covers(self, view: View, limit: int) -> bool:
        known = self._around
        if known is None or _FAR_BELOW * known.bytes > limit or view.m < known.view.m:
            return False
        moved = eye_relative_to(known.view.camera.corner, view.camera) - known.view.camera.eye
        return bool(np.linalg.norm(moved) <= _NEAR * known.height)

    def _look_around(self, view: View) -> None:
        """Foretell what is displayed all round, if a metric knows that, at rest."""
        try:
            around = replace(view, look_around=True, shutter=None)
            needed = frame_bytes(forecast(self._world, around), self._preset, self._variant)
        except InputError:
            return
        camera = view.camera
        ground = self._world.terrain.height(camera.corner, camera.eye[None, :2])
        self._around = _Around(around, float(camera.eye[2] - ground[0]), needed)
