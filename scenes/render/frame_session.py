"""Frames of one preset, from its settings to files: the way in which every process renders them."""

import math
import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import cached_property, partial
from pathlib import Path
from typing import Any

from scenes.frame.layers import Layers
from scenes.processes.memory_limit import peak_rss_bytes
from scenes.render.acting_track import replayed
from scenes.render.description import describe_frame
from scenes.render.exr.header import (
    Record,
    Settings,
    frame_header,
    picture_windows,
    preset_from_settings,
)
from scenes.render.exr.layer_file import with_mattes, write_exr
from scenes.render.memory import preflight
from scenes.render.object_keys import identities_in
from scenes.render.render import render_frame
from scenes.scene import Scene

Watch = Callable[[int, int], object]
"""Called with the samples of a frame taken so far, and how many there will be."""


def ignore_progress(samples: int, of: int) -> None:
    """Watch nothing."""


class FrameSession:
    """Renders frames of one preset in this process; its world stays from frame to frame.

    settings  of ``frame_settings``, checked here. Raises InputError for what no preset can be
    """

    def __init__(self, settings: Settings) -> None:
        self.settings = settings
        self._preset = preset_from_settings(settings)
        self._folder: Path | None = None
        self._estimated: set[int] = set()

    @cached_property
    def _scene(self) -> Scene:
        track = self.settings.get("track")
        if track is None or self._folder is None:
            return Scene(self._preset)
        return Scene(self._preset, partial(replayed, self._preset, track, self._folder))

    def preflight(
        self, frames: Sequence[int], folder: str | Path, most_bytes: int | None = None
    ) -> Record:
        """Estimate the memory of frames whose files will lie in ``folder``; the record is empty.

        Raises InputError for the first that is estimated to need more than ``most_bytes`` allow.
        """
        self._folder = Path(folder)
        self._preflight(frames, most_bytes)
        return {}

    def _preflight(self, frames: Sequence[int], most_bytes: int | None) -> None:
        preset, new = self._preset, [each for each in frames if each not in self._estimated]
        if new:
            acted = preset.acting.frames + 1
            preflight(self._scene, new, most_bytes, preset.render.variant, acted)
            self._estimated.update(new)

    def render(
        self,
        frame: int,
        target: str | Path,
        watch: Watch = ignore_progress,
        most_bytes: int | None = None,
    ) -> Record:
        """Render a frame into ``target``, a file that does not exist yet.

        Record: frame, sha256 of the file, seconds {stage: s}, peak_rss_bytes, statistics. Building
        the world counts as the first frame's time. Raises as ``render_layers`` does, and OSError
        where the disk refuses.
        """
        self._folder = Path(target).parent  # where the track of its actors lies
        layers = self.render_layers(frame, watch, most_bytes)
        start = time.perf_counter()
        digest = write_exr(target, layers, self.header(frame), self._preset.output)
        write = time.perf_counter() - start
        return {
            "frame": frame,
            "sha256": digest,
            "seconds": {**layers.seconds, "write": write},
            "peak_rss_bytes": peak_rss_bytes(),
            "statistics": layers.statistics,
        }

    def render_layers(
        self, frame: int, watch: Watch = ignore_progress, most_bytes: int | None = None
    ) -> Layers:
        """Render a frame into arrays, with the seconds and counts of every stage.

        ``watch`` is called with the samples taken so far, and how many there will be. Raises
        InputError for a frame that cannot be or would need more memory than ``most_bytes`` allow
        (``memory_limit``).
        """
        preset, start = self._preset, time.perf_counter()
        self._preflight((frame,), most_bytes)
        scene, world = self._scene, self._scene.world
        seconds = {"world": time.perf_counter() - start}
        frame_input = scene.input(frame, preset.render.variant)
        seconds |= frame_input.seconds
        description, cuts = None, [each.cut for each in frame_input.displayed]
        found = list(identities_in(world, cuts)) if preset.output.cryptomatte else []
        del cuts
        if not frame_input.subframes:
            start = time.perf_counter()
            description = describe_frame(frame_input)
            seconds["describe"] = time.perf_counter() - start
            frame_input = replace(frame_input, displayed=())  # or it would be held twice
        camera, quality = frame_input.camera, frame_input.quality
        samples = math.prod(quality.window_of((camera.width, camera.height)).size) * quality.spp
        samples *= 2 if camera.baseline_m else 1
        taken = 0

        def count(more: int) -> None:
            nonlocal taken
            taken += more
            watch(taken, samples)

        layers = render_frame(frame_input, frame, count, description, most_bytes)
        if layers.coverage:
            layers = with_mattes(layers, {each.object: (each.name, each.of) for each in found})
        return replace(
            layers,
            seconds=seconds | layers.seconds,
            statistics=layers.statistics | frame_input.counts,
        )

    def header(self, frame: int) -> dict[str, Any]:
        """Make the header of a frame's file: all that determines its pixels."""
        fps = self._preset.camera.fps
        header = frame_header(self._scene.camera(frame), fps, self.settings, frame)
        return header | picture_windows(self._preset.render.size, self._preset.render.window)
