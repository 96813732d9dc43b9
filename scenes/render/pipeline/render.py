"""One frame, from what is visible to finished layers, with the time of each stage."""

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

from lod.atmosphere.air import Air
from lod.camera import Camera
from scenes.frame.displayed import Visible
from scenes.frame.layers import Layers
from scenes.frame.quality import Quality
from scenes.frame.types import USUAL, Extras
from scenes.render.description.describe import MEDIUM, Description, describe, with_camera
from scenes.render.description.medium_box import with_medium
from scenes.render.mitsuba import variants
from scenes.render.pictures.denoise import check_denoiser, denoise
from scenes.world.light import Light


def render_frame(
    camera: Camera,
    visible: Sequence[Visible],
    air: Air,
    light: Light,
    quality: Quality,
    frame: int = 0,
    watch: Callable[[int], object] = lambda samples: None,
    extras: Extras = USUAL,
) -> Layers:
    """Render ``frame``: same arguments, same bytes, within a variant and on any thread count.

    ``watch`` is told how many samples were just taken, again and again.
    Raises InputError for numbers that the renderer would accept silently (NaN, albedo above 1).
    """
    if extras.denoise:
        check_denoiser()
    stage = build_frame(camera, visible, air, light, quality, extras.after)
    layers = trace(stage, quality, frame, watch)
    return with_denoised(layers) if extras.denoise else layers


@dataclass(frozen=True, eq=False)
class BuiltFrame:
    """A scene that is built, ready for any number of pictures of it; ``seconds`` of its stages."""

    built: Any
    haze: Any
    variant: str
    statistics: dict[str, int]
    seconds: dict[str, float]


def build_frame(
    camera: Camera,
    visible: Sequence[Visible],
    air: Air,
    light: Light,
    quality: Quality,
    after: Camera | None = None,
) -> BuiltFrame:
    """Build what ``render_frame`` renders. Of the quality, seed and spp may change later."""
    start = time.perf_counter()
    description = describe_frame(camera, visible, air, light, quality, after)
    seconds = {"describe": time.perf_counter() - start}
    stage = build(description, air, quality)
    return replace(stage, seconds={**seconds, **stage.seconds})


def describe_frame(
    camera: Camera,
    visible: Sequence[Visible],
    air: Air,
    light: Light,
    quality: Quality,
    after: Camera | None = None,
) -> Description:
    """What ``build`` builds, as plain data: after it nobody needs ``visible``."""
    description = describe(camera, visible, light, quality.max_depth, after)
    return with_medium(description, air) if quality.haze == "medium" else description


def build(description: Description, air: Air, quality: Quality) -> BuiltFrame:
    """Build the scene of a description, whose arrays it takes over."""
    start = time.perf_counter()
    name = variants.choose(quality.variant, quality.is_spectral)
    variants.use(name)
    from scenes.render.description.one_shape import in_one_shape
    from scenes.render.haze.haze import make_haze
    from scenes.render.haze.scattered_layer import with_layer
    from scenes.render.mitsuba.build import build_scene

    statistics = _statistics(description)
    if not name.startswith("scalar_") and not name.endswith("_spectral"):
        description.update(in_one_shape(description))
    if quality.haze == "scattered":
        description["light"] = with_layer(description, air)["light"]
    built = build_scene(description)
    haze = make_haze(built, air)
    return BuiltFrame(built, haze, name, statistics, {"build": time.perf_counter() - start})


def trace(
    stage: BuiltFrame,
    quality: Quality,
    frame: int = 0,
    watch: Callable[[int], object] = lambda samples: None,
) -> Layers:
    """One picture of a stage; its variant is still the one that is set."""
    from scenes.render.drivers.accumulate import make_layers
    from scenes.render.mitsuba.build import flush_memory

    start = time.perf_counter()
    samples = _driver(stage.variant, quality.haze)(stage.built, stage.haze, quality, frame, watch)
    seconds = {**stage.seconds, "trace": time.perf_counter() - start}
    flush_memory()
    return make_layers(samples, stage.built, seconds, stage.statistics)


def move_camera(
    stage: BuiltFrame, camera: Camera, air: Air, after: Camera | None = None
) -> BuiltFrame:
    """The same stage from another place, in coordinates of the same corner; not where the air that
    is part of the scene depends on the place.
    """
    start = time.perf_counter()
    from scenes.render.haze.haze import make_haze

    built = stage.built
    built = replace(built, description=with_camera(built.description, camera, after))
    haze = make_haze(built, air)
    seconds = {"describe": 0.0, "build": time.perf_counter() - start}
    return replace(stage, built=built, haze=haze, seconds=seconds)


def with_denoised(layers: Layers) -> Layers:
    """The same with a denoised picture beside the raw one."""
    start = time.perf_counter()
    found = denoise(layers)
    return replace(found, seconds={**found.seconds, "denoise": time.perf_counter() - start})


def _driver(variant: str, haze: str) -> Callable[..., Any]:
    """The way to drive a frame that suits the variant."""
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
        "shapes": len(shapes),
        "sticks": sum(len(s["segment_indices"]) for s in shapes if s["type"] == "linearcurve"),
        "triangles": sum(len(s["faces"]) for s in shapes if s["type"] == "mesh"),
    }
