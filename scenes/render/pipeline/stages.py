"""The stages of a frame in the renderer: described, built and traced, with the time of each."""

import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

from lod.air import Air
from lod.camera import Camera
from scenes.frame.frame_input import FrameInput
from scenes.frame.layers import Layers
from scenes.frame.quality import Quality, SampleWatch
from scenes.render import variants
from scenes.render.description import MEDIUM, Description, describe_frame, with_camera
from scenes.render.pipeline.memory_limit import check_memory


def ignore_samples(samples: int) -> None:
    """Do nothing with a count of samples: the SampleWatch where nobody follows a frame."""


@dataclass(frozen=True, eq=False)
class BuiltFrame:
    """A built scene, ready for any number of pictures.

    scene       a BuiltScene: the renderer's scene, and tables that find parts from hits
    haze        a Haze: the air along rays, and its light
    variant     name of the Mitsuba variant in which it was built and is traced
    statistics  counts for the header: shapes (meshes, and tints of sticks), sticks, triangles
    seconds     time of each stage so far
    """

    scene: Any
    haze: Any
    variant: str
    statistics: dict[str, int]
    seconds: dict[str, float]


def build_frame(frame_input: FrameInput, most_bytes: int | None = None) -> BuiltFrame:
    """Describe and build a frame; it may be traced with other seeds and samples per pixel.

    Raises InputError where it is foretold to need more memory than it may (``memory_limit``).
    """
    check_memory(frame_input, most_bytes, "the picture")
    start = time.perf_counter()
    description = describe_frame(frame_input)
    seconds = {"describe": time.perf_counter() - start}
    built = build(description, frame_input.air, frame_input.quality)
    return replace(built, seconds={**seconds, **built.seconds})


def build(description: Description, air: Air, quality: Quality) -> BuiltFrame:
    """Build the scene of a description, whose arrays it takes over."""
    start = time.perf_counter()
    name = variants.choose(quality.variant, quality.is_spectral)
    variants.use(name)
    from scenes.render.build import build_scene
    from scenes.render.haze import make_haze
    from scenes.render.scattered_layer import with_scattering_layer

    statistics = _statistics(description)
    if quality.haze == "scattered":
        description["light"] = with_scattering_layer(description, air)["light"]
    scene = build_scene(description)
    haze = make_haze(scene, air)
    return BuiltFrame(scene, haze, name, statistics, {"build": time.perf_counter() - start})


def trace(
    built: BuiltFrame, quality: Quality, frame: int = 0, watch: SampleWatch = ignore_samples
) -> Layers:
    """Take one picture of a built frame; its variant is still the one that is set."""
    from scenes.render.build import flush_memory
    from scenes.render.drivers.samples import make_layers

    start = time.perf_counter()
    samples = _driver(built.variant, quality.haze)(built.scene, built.haze, quality, frame, watch)
    seconds = {**built.seconds, "trace": time.perf_counter() - start}
    flush_memory()
    return make_layers(samples, built.scene, seconds, built.statistics)


def move_camera(
    built: BuiltFrame, camera: Camera, air: Air, after: Camera | None = None
) -> BuiltFrame:
    """Give a built frame another camera, with coordinates from the same grid corner.

    It must not be used with scattered haze or a medium if it is far from the camera before: their
    air depends on the eye's place. The eyes of a pair are near enough.
    """
    start = time.perf_counter()
    from scenes.render.haze import make_haze

    scene = built.scene
    scene = replace(scene, description=with_camera(scene.description, camera, after))
    haze = make_haze(scene, air)
    seconds = {"describe": 0.0, "build": time.perf_counter() - start}
    return replace(built, scene=scene, haze=haze, seconds=seconds)


def _driver(variant: str, haze: str) -> Callable[..., Any]:
    """Choose the driver that suits the variant and the kind of haze."""
    if haze == "medium":
        from scenes.render.drivers.volpath import render_medium

        return render_medium
    if variant.startswith("scalar_") or variant.endswith("_spectral"):
        from scenes.render.drivers.scalar_passes import render_passes

        return render_passes
    from scenes.render.drivers.jit import render_jit

    return render_jit


def _statistics(description: Description) -> dict[str, int]:
    shapes, box = description["shapes"].values(), description.get(MEDIUM, {})
    return {
        **{f"medium_{end}_m": round(box[end]) for end in ("bottom", "top") if end in box},
        "shapes": sum(len(s.get("tints", (None,))) for s in shapes),
        "sticks": sum(len(s["segment_indices"]) for s in shapes if s["type"] == "linearcurve"),
        "triangles": sum(len(s["faces"]) for s in shapes if s["type"] == "mesh"),
    }
