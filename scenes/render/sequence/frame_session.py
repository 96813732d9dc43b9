"""Frames of one preset, from its settings to files: the way in which every process renders them.

Settings are nested plain data, everything that determines the pixels: they travel to other
processes and machines, stand in every header and in the manifest, and make the same frame again.
"""

import time
from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import cached_property
from pathlib import Path
from typing import Any

from scenes.frame.assemble import assemble_frame
from scenes.preset.load import preset_from
from scenes.preset.tables import Preset
from scenes.render.description.describe import describe_frame
from scenes.render.files.exr import write_exr
from scenes.render.files.header import frame_header, software
from scenes.render.files.manifest import flatten
from scenes.render.pipeline.memory_model import check_memory, peak_rss_bytes
from scenes.render.pipeline.render import render_frame
from scenes.world.world import World, build_world

Settings = Mapping[str, Any]
"""A preset as plain data, with the software that renders it (``frame_settings``)."""

Record = dict[str, Any]
"""What is known of a rendered frame, as plain data (``FrameSession.render``)."""


def frame_settings(preset: Preset, variant: str) -> dict[str, Any]:
    """Collect everything that determines the pixels: preset, variant in place of auto, software."""
    settings = preset.model_dump(mode="json", exclude={"about"})
    settings["render"]["variant"] = variant
    return {**settings, "software": software()}


def preset_from_settings(settings: Settings) -> Preset:
    """Check the preset that settings hold. Raises InputError for what no preset can be."""
    tables = {name: each for name, each in settings.items() if name != "software"}
    return preset_from(tables, source="settings")


class FrameSession:
    """Renders frames of one preset in this process; its world stays from frame to frame.

    settings  of ``frame_settings``, checked here. Raises InputError for what no preset can be
    """

    def __init__(self, settings: Settings) -> None:
        self.settings = settings
        self._preset = preset_from_settings(settings)

    @cached_property
    def _world(self) -> World:
        return build_world(self._preset)

    def render(
        self,
        frame: int,
        target: str | Path,
        watch: Callable[[int, int], object] = lambda samples, of: None,
        most_bytes: int | None = None,
    ) -> Record:
        """Render a frame into ``target``, a file that does not exist yet.

        Record: frame, sha256 of the file, seconds {stage: s}, peak_rss_bytes, statistics. Building
        the world counts as the first frame's time. ``watch`` is called with the samples taken so
        far, and how many there will be. Raises InputError for a frame that cannot be or would need
        more than ``most_bytes`` of memory, OSError where the disk refuses.
        """
        preset, start = self._preset, time.perf_counter()
        world = self._world
        seconds = {"world": time.perf_counter() - start}
        frame_input = assemble_frame(world, preset, frame, preset.render.variant)
        check_memory(frame_input, most_bytes, f"frame {frame}")
        seconds |= frame_input.seconds
        description = None
        if not frame_input.subframes:
            start = time.perf_counter()
            description = describe_frame(frame_input)
            seconds["describe"] = time.perf_counter() - start
            frame_input = replace(frame_input, displayed=())  # or it would be held twice
        camera = frame_input.camera
        samples = camera.width * camera.height * preset.render.spp
        layers = render_frame(frame_input, frame, _adding(samples, watch), description)
        rendered = time.perf_counter()
        settings = {**dict(flatten(self.settings)), "frame": frame}
        header = frame_header(camera, preset.camera.fps, settings)
        digest = write_exr(target, layers, header, preset.output)
        write = time.perf_counter() - rendered
        return {
            "frame": frame,
            "sha256": digest,
            "seconds": {**seconds, **layers.seconds, "write": write},
            "peak_rss_bytes": peak_rss_bytes(),
            "statistics": layers.statistics | frame_input.counts,
        }


def _adding(of: int, watch: Callable[[int, int], object]) -> Callable[[int], object]:
    """Add up the samples that a driver takes at a time, and watch the sum."""
    so_far = 0

    def count(samples: int) -> None:
        nonlocal so_far
        so_far += samples
        watch(so_far, of)

    return count
