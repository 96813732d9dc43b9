"""One frame, from plain settings to a file: the way in which every process renders it.

Settings are nested plain data, everything that determines the pixels: they travel to other
processes and machines, stand in every header and in the manifest, and make the same frame again.
"""

import json
import time
from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import lru_cache
from pathlib import Path
from typing import Any

from scenes.frame.layers import Layers
from scenes.frame.types import FrameInput
from scenes.preset.load import Preset, preset_from
from scenes.render.files.header import frame_header, software
from scenes.render.files.manifest import flatten
from scenes.render.pipeline.memory_model import check_memory, peak_rss_bytes

Settings = Mapping[str, Any]
Record = dict[str, Any]


def frame_settings(preset: Preset, variant: str) -> dict[str, Any]:
    """Everything that determines the pixels: the preset, the variant that auto is, the software."""
    settings = preset.model_dump(mode="json", exclude={"about"})
    settings["render"]["variant"] = variant
    return {**settings, "software": software()}


def preset_from_settings(settings: Settings) -> Preset:
    """The preset that settings hold. Raises InputError for what no preset can be."""
    tables = {name: each for name, each in settings.items() if name != "software"}
    return preset_from(tables, source="settings")


def render_one(
    settings: Settings,
    frame: int,
    target: str | Path,
    watch: Callable[[int, int], object] = lambda taken, of: None,
    most_bytes: int | None = None,
) -> Record:
    """Render a frame into ``target``, a file that does not exist yet.

    Record: frame, sha256 of the file, seconds {stage: s}, peak_rss_bytes, statistics. The world of
    the last settings is kept for the next frame; building it counts as that first frame's time.
    ``watch`` is told how many samples are taken, of how many.
    Raises InputError for a frame that cannot be or would need more than ``most_bytes`` of memory,
    OSError where the disk refuses.
    """
    from scenes.render.files.exr import write_exr

    made, layers = _rendered(settings, frame, most_bytes, watch)
    rendered = time.perf_counter()
    header = frame_header(made.camera, made.fps, {**dict(flatten(settings)), "frame": frame})
    digest = write_exr(target, layers, header, made.form)
    write = time.perf_counter() - rendered
    return {
        "frame": frame,
        "sha256": digest,
        "seconds": {**made.seconds, **layers.seconds, "write": write},
        "peak_rss_bytes": peak_rss_bytes(),
        "statistics": layers.statistics | made.counts,
    }


def _rendered(
    settings: Settings, frame: int, most_bytes: int | None, watch: Callable[[int, int], object]
) -> tuple[FrameInput, Layers]:
    """What a frame was made from, save what is displayed, which has been let go of; its layers."""
    from scenes.render.pictures.denoise import check_denoiser
    from scenes.render.pipeline.render import build, describe_frame, trace, with_denoised
    from scenes.render.pipeline.subframes import render_exposed

    made = _made(settings, frame)
    check_memory(made, most_bytes, f"frame {frame}")
    lit = made.air, made.light, made.quality
    samples = made.camera.width * made.camera.height * made.quality.spp
    counted = _counted(samples, watch)
    if made.instants:
        layers = render_exposed(made.instants, *lit, frame, counted, made.extras.denoise)
        return made, layers
    if made.extras.denoise:
        check_denoiser()
    start = time.perf_counter()
    description = describe_frame(made.camera, made.visible, *lit, made.extras.after)
    spent = {**made.seconds, "describe": time.perf_counter() - start}
    made = replace(made, visible=(), seconds=spent)
    layers = trace(build(description, made.air, made.quality), made.quality, frame, counted)
    return made, with_denoised(layers) if made.extras.denoise else layers


def _counted(of: int, watch: Callable[[int, int], object]) -> Callable[[int], object]:
    """Adds up the samples that a driver says it takes, of so many."""
    taken = 0

    def count(samples: int) -> None:
        nonlocal taken
        taken += samples
        watch(taken, of)

    return count


def _made(settings: Settings, frame: int) -> FrameInput:
    """What the frame is made from, pruned and posed."""
    from scenes.frame.frame_input import assemble_frame

    start = time.perf_counter()
    preset, world = _world(json.dumps(settings, sort_keys=True))
    seconds = {"world": time.perf_counter() - start}
    made = assemble_frame(world, preset, frame, preset.render.variant)
    return replace(made, seconds=seconds | made.seconds)


@lru_cache(maxsize=1)
def _world(settings: str) -> tuple[Preset, Any]:
    """The preset that settings hold, and its world."""
    from scenes.world.world import build_world

    preset = preset_from_settings(json.loads(settings))
    return preset, build_world(preset)
