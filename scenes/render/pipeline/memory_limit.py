"""What may a command take of the machine's memory? It is refused before it takes more."""

import os
from dataclasses import dataclass

import psutil

from lod.errors import InputError
from lod.view import View
from scenes.frame.assemble import frame_quality
from scenes.frame.frame_input import FrameInput
from scenes.models.catalogue import model_prototypes
from scenes.preset.acting import has_acting
from scenes.preset.tables import Preset
from scenes.render.pipeline.free_memory import free_bytes
from scenes.render.pipeline.memory_model import (
    ExtraBuffers,
    count_shapes,
    forecast_bytes,
    predict_bytes,
    predicted_bytes,
)
from scenes.rig.rigged_prototype import RiggedPrototype
from scenes.trees.species import Weather
from scenes.world.forecast import Forecast, forecast
from scenes.world.view import view_at
from scenes.world.world import World

VARIABLE = "LODBENCH_MAX_MEMORY"
"""Environment variable of a limit for a command that renders in many ways, and its children."""

DEFAULT_SHARE = 0.8
"""Of the memory that is free, what a command takes at most unless it is told otherwise."""


_FEW_PROTOTYPES = 64
_BUILT_PART, _KEPT_PART = 4100.0, 2900.0
"""Bytes for each part of a prototype: while prototypes are built, and in the tables of each size
(``meadow`` with 60 trees took 1.2 GB more than with one, and with 4 in 64 sizes 2.2 GB)."""

_POSABLE_PART, _RIGID_PART = 4000.0, 1000.0
"""Bytes that a live actor takes for each part of its model, with joints and without (measured: 2.4
to 2.9 kB for figures and animals, 0.75 kB for trees)."""

_ACTED_FRAME, _ACTED_ACTOR = 2000.0, 500.0
"""Bytes of a frame that is acted, and of each actor in it, while a track is made and packed
(measured: 1.2 kB, and 0.15 kB to 0.4 kB by how many joints messages hold)."""


@dataclass(frozen=True)
class MemoryLimit:
    """Bytes that this process may hold; None = as many as it needs. ``told``: in words."""

    bytes: int | None
    told: str = ""


def memory_limit(most: int | None = None) -> MemoryLimit:
    """Make the limit that --max-memory sets: bytes, 0 for no limit, None for the default.

    The default is what the environment's ``LODBENCH_MAX_MEMORY`` says in bytes; without it
    DEFAULT_SHARE of what is free, and what the process holds already counts as free.
    """
    told = os.environ.get(VARIABLE, "")
    if most is None and told.isdecimal():
        most = int(told)
    if most == 0:
        return MemoryLimit(None)
    if most is not None:
        return MemoryLimit(most, size_text(most))
    free = free_bytes() + psutil.Process().memory_info().rss
    allowed = round(DEFAULT_SHARE * free)
    return MemoryLimit(allowed, f"{size_text(allowed)}, {DEFAULT_SHARE:.0%} of what is free")


def size_text(size: float) -> str:
    """Write bytes in MB or GB with three digits, as ``1 MB`` or ``2.51 GB``."""
    return f"{size / 1e9:.3g} GB" if 1e9 <= size < 1e12 else _small_or_large(size)


def _small_or_large(size: float) -> str:
    return f"{size / 1e6:.3g} MB" if size < 1e9 else f"{size / 1e9:,.0f} GB"


def check_pruning(world: World, view: View, most: int | None, what: str) -> Forecast | None:
    """Raise InputError where pruning a view is foretold to need more than it may (--max-memory).

    The forecast is given; None without a limit, where nothing is foretold.
    """
    limit = memory_limit(most)
    if limit.bytes is None:
        return None
    found = forecast(world, view)
    _check(limit, forecast_bytes(found), found, what)
    return found


def check_frame_forecast(
    world: World, preset: Preset, frame: int, variant: str, most: int | None
) -> None:
    """Raise InputError where a frame is foretold to need more memory than it may (--max-memory)."""
    limit = memory_limit(most)
    if limit.bytes is None:
        return
    found = forecast(world, view_at(world, preset, frame))
    _check(limit, frame_bytes(found, preset, variant), found, f"frame {frame}")


def frame_bytes(found: Forecast, preset: Preset, variant: str) -> int:
    """Predict the bytes that a process holds at most for a frame of which so much is foretold."""
    extra = ExtraBuffers(preset.output.motion, preset.output.denoise, preset.view.shutter > 0)
    shapes, quality = (round(found.sticks), round(found.triangles)), frame_quality(preset, variant)
    drawn = predict_bytes(*shapes, preset.render.size, quality, extra)
    return max(forecast_bytes(found), drawn)


def check_memory(frame_input: FrameInput, most: int | None, what: str) -> None:
    """Raise InputError where a frame, as it was pruned, needs more memory than it may."""
    limit, needed = memory_limit(most), predicted_bytes(frame_input)
    if limit.bytes is not None and needed > limit.bytes:
        counts = "with {:,} sticks and {:,} triangles,".format(*count_shapes(frame_input))
        raise _refusal(limit, f"{what}, {counts} needs about {size_text(needed)}", "")


def check_prototypes(preset: Preset, most: int | None) -> None:
    """Raise InputError where the tables of all prototypes are foretold to need more than they may.

    It is asked before they are made, of species with many: the first of each is made and counted;
    and of live actors, whose bodies are made with them.
    """
    check_acting(preset, most)
    limit, needed = memory_limit(most), 0.0
    weather = Weather(preset.world.season, preset.wind.speed)
    for name, table in preset.species.items():
        built, kept = table.prototypes, table.prototypes * len(table.sizes)
        if limit.bytes is None or kept <= _FEW_PROTOTYPES or table.density == 0:
            continue
        (first,) = model_prototypes(table.model, 1, (1.0,), False, weather, table.model_sha256)
        needed += len(first.hierarchy) * (built * _BUILT_PART + kept * _KEPT_PART)
        if needed > limit.bytes:
            rule = f"{kept} prototypes of {name} need about {size_text(needed)}"
            raise InputError("--max-memory", limit.told, rule, "ask for fewer prototypes or sizes")


def check_acting(preset: Preset, most: int | None, frames: int = 0) -> None:
    """Raise InputError where live actors are foretold to need more memory than they may.

    frames  how many of those that they act are kept
    """
    limit = memory_limit(most)
    if limit.bytes is None or not has_acting(preset):
        return
    actors, needed = _actors_bytes(preset)
    needed += frames * (_ACTED_FRAME + _ACTED_ACTOR * actors)
    if needed > limit.bytes:
        kept = f" in {frames:,} frames" if frames else ""
        rule = f"{actors:,} actors{kept} need about {size_text(needed)}"
        fewer = "fewer actors or a smaller acting.frames" if frames else "fewer actors"
        cure = f"ask for {fewer}, or --max-memory 0 to try it all the same"
        raise InputError("--max-memory", limit.told, rule, cure)


def _actors_bytes(preset: Preset) -> tuple[int, float]:
    """Count the live actors of a preset, and foretell the bytes of them and of their prototypes."""
    weather = Weather(preset.world.season, preset.wind.speed)
    actors, needed = 0, 0.0
    kinds: dict[tuple[str, str | None, float], int] = {}
    alone = ((each, 1, each.size, each.prototype) for each in preset.actors.values())
    in_troupes = ((each, each.count, 1.0, each.prototypes) for each in preset.troupes.values())
    for table, count, size, prototypes in (*alone, *in_troupes):
        model = table.model, table.model_sha256
        (first,) = model_prototypes(model[0], 1, (1.0,), True, weather, model[1])
        parts = len(first.hierarchy)
        part = _POSABLE_PART if isinstance(first, RiggedPrototype) else _RIGID_PART
        actors += count
        needed += count * parts * part
        made = kinds.get((*model, size), 0)
        kinds[(*model, size)] = max(made, prototypes)
        needed += max(prototypes - made, 0) * parts * (_BUILT_PART + _KEPT_PART)
    return actors, needed


def _check(limit: MemoryLimit, needed: int, found: Forecast, what: str) -> None:
    if limit.bytes is None or needed <= limit.bytes:
        return
    counts = f"with about {found.parts:,.0f} parts and {found.triangles:,.0f} triangles,"
    parts = found.parts * limit.bytes / needed / 2
    budget = f" (--max-parts {float(f'{parts:.0e}'):.0f} sets it)" if parts >= 1000 else ""
    raise _refusal(limit, f"{what}, {counts} needs about {size_text(needed)}", budget)


def _refusal(limit: MemoryLimit, rule: str, budget: str) -> InputError:
    cure = f"ask for less detail{budget}, density or size, or --max-memory 0 to try it all the same"
    return InputError("--max-memory", limit.told, rule, cure)
