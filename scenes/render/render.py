"""One frame from its input to its layers: described, built and traced, with the time of each stage.

A frame whose shutter is open is the mean of sub-frames spread evenly over that time. Taken in the
middles of N equal times, they spread what moves by L over N places: the variance of
its profile grows by L²/12·(1 − 1/N²), that of a box where N → ∞. Sub-frame i of frame f is rendered
whole, haze included, with its share of the samples and the seed ``sampler_seed(seed, f, i)``.
Colour, albedo and coverage are means over all samples; Z, N, ids and motion are those of sub-frame
N // 2.
Where only the camera moves and haze is analytic, the scene is built once; otherwise once for each.
"""

import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from lod.air import Air
from lod.camera import Camera
from lod.errors import InputError
from scenes.frame.frame_input import (
    DisplayedRepresentation,
    FrameInput,
    Quality,
    SampleWatch,
    sampler_seed,
)
from scenes.frame.layers import Coverage, Layers, add_coverage
from scenes.render import variants
from scenes.render.description import MEDIUM, Description, describe_frame, with_camera
from scenes.render.memory import check_memory
from scenes.render.pictures import check_denoiser, denoise_layers


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


def build_frame(
    frame_input: FrameInput, description: Description | None = None, most_bytes: int | None = None
) -> BuiltFrame:
    """Describe and build a frame; it may be traced with other seeds and samples per pixel.

    description  of the frame, where the caller made it and has seen to its memory: its arrays are
                 taken over
    Raises InputError where it is estimated to need more memory than ``most_bytes`` allow, as of
    ``memory_limit``.
    """
    if description is None:
        check_memory(frame_input, most_bytes)
    start, seconds = time.perf_counter(), {}
    if description is None:
        description = describe_frame(frame_input)
        seconds["describe"] = time.perf_counter() - start
    start, quality, light = time.perf_counter(), frame_input.quality, description["light"]
    statistics = _statistics(description)
    name = variants.choose(quality.variant, quality.is_spectral)
    variants.use(name)
    from scenes.render.build import build_scene
    from scenes.render.haze import make_haze
    from scenes.render.light import emitters

    scene, haze = build_scene(description, emitters(light)), make_haze(light, frame_input.air)
    seconds["build"] = time.perf_counter() - start
    return BuiltFrame(scene, haze, name, statistics, seconds)


def trace(
    built: BuiltFrame, quality: Quality, frame: int = 0, watch: SampleWatch = ignore_samples
) -> Layers:
    """Take one picture of a built frame; its variant is still the one that is set."""
    import drjit

    from scenes.render.samples import make_layers

    start = time.perf_counter()
    if built.variant.startswith("scalar_") or built.variant.endswith("_spectral"):
        from scenes.render.scalar_passes import render_passes as driver
    else:
        from scenes.render.jit import render_jit as driver
    samples = driver(built.scene, built.haze, quality, frame, watch)
    seconds = {**built.seconds, "trace": time.perf_counter() - start}
    drjit.flush_malloc_cache()  # what it keeps for its next samples
    return make_layers(samples, built.scene, seconds, built.statistics)


def move_camera(
    built: BuiltFrame, camera: Camera, air: Air, after: Camera | None = None
) -> BuiltFrame:
    """Give a built frame another camera, with coordinates from the same grid corner.

    It must not be used with a medium if it is far from the camera before: the medium depends on the
    eye's place. The eyes of a pair are near enough.
    """
    start = time.perf_counter()
    described = with_camera(built.scene.description, camera, after)
    scene, haze = replace(built.scene, description=described), replace(built.haze, air=air)
    seconds = {"describe": 0.0, "build": time.perf_counter() - start}
    return replace(built, scene=scene, haze=haze, seconds=seconds)


def _statistics(description: Description) -> dict[str, int]:
    shapes, box = list(description["shapes"].values()), description.get(MEDIUM, {})
    copies = description["copies"]
    shapes += [shape for model in copies.models for shape, _ in model]  # each but once
    return {
        **({"copies": len(copies)} if len(copies) else {}),
        **{f"medium_{end}_m": round(box[end]) for end in ("bottom", "top") if end in box},
        "shapes": sum(len(s.get("tints", (None,))) for s in shapes),
        "sticks": sum(len(s["segment_indices"]) for s in shapes if s["type"] == "linearcurve"),
        "triangles": sum(len(s["faces"]) for s in shapes if s["type"] == "mesh"),
    }


_ADDED = ("clamped", "replaced")  # statistics of samples; the others are of a scene


def render_subframes(
    frame_input: FrameInput, frame: int = 0, watch: SampleWatch = ignore_samples
) -> Layers:
    """Render the sub-frames of ``frame``, one at a time, and average them: same input, same bytes.

    Raises InputError where there are more of them than samples a pixel.
    """
    quality, n = frame_input.quality, len(frame_input.subframes)
    if not 1 <= n <= quality.spp:
        rule = f"from 1 to {quality.spp}, the samples per pixel"
        raise InputError("subframes", n, rule, "raise --spp")
    rgb = albedo = np.zeros(3)
    covered: list[Coverage] = []
    seconds, added = dict[str, float](), dict.fromkeys(_ADDED, 0)
    built: BuiltFrame | None = None
    displayed: tuple[DisplayedRepresentation, ...] = ()
    for number, make_input in enumerate(frame_input.subframes):
        now = make_input()
        if built and now.displayed is displayed and quality.haze == "analytic":
            built = move_camera(built, now.camera, now.air, now.after)
        else:
            built = None  # freed first: a JIT variant would count its shapes, too
            built, displayed = build_frame(now, most_bytes=0), now.displayed
        share = quality.spp // n + (number < quality.spp % n)
        seed = sampler_seed(quality.seed, frame, number)
        layers = trace(built, replace(quality, spp=share, seed=seed), frame, watch)
        rgb = rgb + share / quality.spp * layers.rgb
        albedo = albedo + share / quality.spp * layers.albedo
        if layers.coverage:
            part = layers.coverage
            covered.append(replace(part, share=part.share * (share / quality.spp)))
        seconds = {k: seconds.get(k, 0.0) + each for k, each in layers.seconds.items()}
        added = {k: added[k] + layers.statistics[k] for k in _ADDED}
        if number == n // 2:
            middle = layers
    statistics = {**middle.statistics, **added, "subframes": n}
    if covered:
        columns = [(each.pixel, each.object, each.share) for each in covered]
        coverage = add_coverage(*map(np.concatenate, zip(*columns, strict=True)))
        middle = replace(middle, coverage=coverage)
    return replace(middle, rgb=rgb, albedo=albedo, seconds=seconds, statistics=statistics)


def render_frame(
    frame_input: FrameInput,
    frame: int = 0,
    watch: SampleWatch = ignore_samples,
    description: Description | None = None,
    most_bytes: int | None = None,
) -> Layers:
    """Render ``frame``: same arguments, same bytes, within a variant and on any thread count.

    description  the frame's description, where the caller made it in order to free
                 ``frame_input.displayed`` before the scene is built; its arrays are taken over, so
                 that it cannot be used again, and who has seen to its memory. None: it is made here
    most_bytes   that it may need, as of ``memory_limit``
    Raises InputError for numbers that the renderer would accept silently (NaN, albedo above 1), and
    for what is estimated to need more memory than it may.
    """
    if frame_input.denoise:
        check_denoiser()
    quality, air = frame_input.quality, frame_input.air
    is_pair = bool(frame_input.camera.baseline_m)
    seen = [_seen_by(frame_input, eye) for eye in (0, 1)] if is_pair else [frame_input]
    if frame_input.subframes:
        check_memory(frame_input, most_bytes)
        found = [render_subframes(each, frame, watch) for each in seen]
    else:
        built = build_frame(frame_input, description, most_bytes)
        found = []
        for each in seen:  # both eyes see one scene, built once
            now = move_camera(built, each.camera, air, each.after) if is_pair else built
            found.append(trace(now, quality, frame, watch))
    left, *right = [denoise_layers(each) if frame_input.denoise else each for each in found]
    return replace(left, right=right[0]) if right else left


def _seen_by(frame_input: FrameInput, eye: int) -> FrameInput:
    """The same frame as the left eye of a pair (0) or the right one sees it, and its sub-frames."""

    def at(make: Callable[[], FrameInput]) -> FrameInput:
        return _seen_by(make(), eye)

    return replace(
        frame_input,
        camera=frame_input.camera.pair[eye],
        after=frame_input.after.pair[eye] if frame_input.after else None,
        subframes=tuple(partial(at, make) for make in frame_input.subframes),
    )
