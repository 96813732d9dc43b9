"""How much memory may this process still take, of the machine and of the container it is in?

How much of a world will a view display? Foretold before any of it is pruned but the ground.

Memory that a frame needs, predicted from what its cut displays.

The model is linear, fitted to the most memory of twelve frames in fresh processes (relative least
squares; 0 to 5.8 M sticks, 0.03 to 1.2 M triangles, 2·10³ to 2·10⁶ pixels, both drivers):

    bytes = 336 MB + 277·sticks + 204·triangles + 176·pixels + s·samples at once,

s = 187 under Dr.Jit, 355 in scalar variants. Where all sticks are one shape (Dr.Jit, in colours)
and no shutter is open a stick takes 120: `crowd` with 2.1 M sticks held 0.92 GB at 1280 by 720,
predicted 0.93. Wavelengths bring colour-science with them: sixteen bands add 232 MB, 705 bytes a
pixel and, under Dr.Jit, 440 a sample at once; motion vectors 126 a stick (where its ends are
next); a denoiser 500 a pixel, mattes 90; and under an open shutter the sticks of two instants are
held at once. The constant is what the smallest frames take, less than the fit's since they no
longer import colour-science.
`lodbench study memory` holds it against what processes really take, by every kind of
haze and light as well.

Pruning alone, without a picture (``lodbench count``), takes

    bytes = 380 MB + 60·parts + 120·objects examined + 24·cells + 230·triangles,

set by hand, on the safe side: in nine counts (0.3 to 360 M parts) a part took 11 to 18 bytes, but
trees 30 times as large as usual (`species.tree.sizes=[30]` in `meadow`) took far more. `crowd` at 2
people a square metre, each in a pose of its own, takes more than this says.

What may a command take of the machine's memory? It is refused before it takes more.

Which frames of a sequence need no forecast of memory of their own? Those near one all round.

How much memory this process has held at most.
"""

import math
import os
import sys
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import psutil

from lod.errors import InputError
from lod.motion import eye_relative_to
from lod.pruner import Cut, prune
from lod.shapes import Sticks, Triangles, batches_of
from lod.view import View
from scenes.field.forecast import forecast_field
from scenes.frame.frame_input import FrameInput, Quality
from scenes.ground.mesh import QUADS
from scenes.models.catalogue import model_prototypes
from scenes.presets.load import has_acting
from scenes.presets.schema import Preset
from scenes.rig.rigged_prototype import RiggedPrototype
from scenes.scene import Scene, frame_quality
from scenes.trees.species import Weather
from scenes.world.world import World

_CGROUPS = Path("/sys/fs/cgroup")
_OWN = Path("/proc/self/cgroup")


def free_bytes(cgroups: Path = _CGROUPS, own: Path = _OWN) -> int:
    """Memory that this process may take without any other giving up some [bytes].

    The least of what the machine has available and of what is left of each limit on the control
    groups that the process is in (version 1 or 2), whose file caches count as free.
    """
    left = [int(psutil.virtual_memory().available), *_left_of_groups(cgroups, own)]
    return max(min(left), 0)


def _left_of_groups(cgroups: Path, own: Path) -> Iterator[int]:
    """Yield what is left of each group's limit, from the process's own group up to the root."""
    for line in _text(own).splitlines():
        _, controllers, path = line.split(":", 2)
        if controllers == "":
            root, names = cgroups, ("memory.max", "memory.current", "inactive_file")
        elif "memory" in controllers.split(","):
            root = cgroups / "memory"
            names = ("memory.limit_in_bytes", "memory.usage_in_bytes", "total_inactive_file")
        else:
            continue
        # In a container the path may be the host's, of which only the root is mounted.
        group = root / path.lstrip("/")
        for folder in (group, *group.parents):
            limit, used = (_text(folder / name).strip() for name in names[:2])
            if limit.isdecimal() and used.isdecimal():
                yield int(limit) - int(used) + _cached(folder / "memory.stat", names[2])
            if folder == root:
                break


def _cached(statistics: Path, name: str) -> int:
    rows = (line.split() for line in _text(statistics).splitlines())
    return next((int(value) for key, value in rows if key == name), 0)


def _text(path: Path) -> str:
    try:
        return path.read_text(encoding="ascii", errors="replace")
    except OSError:
        return ""


@dataclass(frozen=True)
class Forecast:
    """Expected numbers of what a view visits and displays of a world.

    cells, objects   of the fields, visited; parts, sticks: displayed of them
    triangles        of the ground, and of the meshes displayed
    ground           the cut of the ground, from which its triangles are known
    """

    cells: float
    objects: float
    parts: float
    sticks: float
    triangles: float
    ground: Cut


def forecast(world: World, view: View, of_fields: View | None = None) -> Forecast:
    """Foretell what a view displays of the ground and of the fields.

    ``of_fields`` is the view of the fields where they are pruned by another rule than the ground.
    What is placed one by one, plumes, dust and what plug-ins make is left out. Raises InputError
    where the ground would have more tiles than it may.
    """
    fields = [forecast_field(each, of_fields or view) for each in world.fields]
    ground = prune(world.terrain, view)
    # A tile draws those of its quarters that no tile covers: 4 a tile, less one for each that does.
    patches = 3 * ground.displayed_parts + ground.displayed_objects
    return Forecast(
        cells=sum(each.cells for each in fields),
        objects=sum(each.objects for each in fields),
        parts=sum(each.parts for each in fields),
        sticks=sum(each.sticks for each in fields),
        triangles=2.0 * QUADS**2 * patches + sum(each.triangles for each in fields),
        ground=ground,
    )


_BASE = 336e6
_STICK, _STICK_IN_ONE, _TRIANGLE, _PIXEL = 277.0, 120.0, 204.0, 176.0
_SAMPLE_JIT, _SAMPLE_SCALAR = 187.0, 355.0
_BASE_SPECTRAL, _PIXEL_SPECTRAL, _SAMPLE_SPECTRAL = 232e6, 705.0, 440.0
_MOVED_STICK, _DENOISED_PIXEL, _MATTED_PIXEL = 126.0, 500.0, 90.0
_BASE_PRUNED = 380e6
_PRUNED_PART, _OBJECT, _CELL, _MESHED_TRIANGLE = 60.0, 120.0, 24.0, 230.0


@dataclass(frozen=True)
class ExtraBuffers:
    """What is asked of a frame beside a plain picture; each needs memory of its own."""

    motion: bool = False
    denoised: bool = False
    shutter: bool = False


def predict_bytes(
    sticks: int,
    triangles: int,
    size: tuple[int, int],
    quality: Quality,
    extra: ExtraBuffers = ExtraBuffers(),
) -> int:
    """Predict the bytes that a process holds at most for such a frame, within some 20 %.

    ``size`` is width and height in pixels; of the quality samples, window and variant count.
    """
    pixels, spectral, jit = size[0] * size[1], quality.is_spectral, quality.is_jit
    sample = _SAMPLE_JIT + _SAMPLE_SPECTRAL * spectral if jit else _SAMPLE_SCALAR
    pixel = _PIXEL + _PIXEL_SPECTRAL * spectral + _DENOISED_PIXEL * extra.denoised
    pixel += _MATTED_PIXEL * quality.coverage
    in_one = jit and not spectral and not extra.shutter
    stick = _STICK_IN_ONE if in_one else _STICK * (2 if extra.shutter else 1)
    stick += _MOVED_STICK * extra.motion
    scene = _BASE + _BASE_SPECTRAL * spectral + stick * sticks + _TRIANGLE * triangles
    at_once = min(pixels * quality.spp, quality.most_samples)
    kept = math.prod(quality.window_of(size).size)
    return round(scene + pixel * kept + sample * at_once)


def predicted_bytes(frame_input: FrameInput) -> int:
    """Predict the bytes that a frame will need, from its input."""
    camera = frame_input.camera
    after, subframes = frame_input.after, frame_input.subframes
    extra = ExtraBuffers(after is not None, frame_input.denoise, bool(subframes))
    size = camera.width, camera.height
    return predict_bytes(*count_shapes(frame_input), size, frame_input.quality, extra)


def count_shapes(frame_input: FrameInput) -> tuple[int, int]:
    """Count the sticks and triangles of a frame."""
    shapes = [shape for each in frame_input.displayed for shape in batches_of(each.shape)]
    sticks = sum(len(shape) for shape in shapes if isinstance(shape, Sticks))
    return sticks, sum(len(shape) for shape in shapes if isinstance(shape, Triangles))


def forecast_bytes(found: Forecast) -> int:
    """Predict the bytes that a process holds at most while it prunes such a view."""
    columns = _OBJECT * found.objects + _CELL * found.cells + _MESHED_TRIANGLE * found.triangles
    return parts_bytes(found.parts) + round(columns)


def parts_bytes(parts: float) -> int:
    """Predict the bytes that a process holds which has pruned a view down to so many parts."""
    return round(_BASE_PRUNED + _PRUNED_PART * parts)


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


def check_frame_forecast(scene: Scene, frame: int, variant: str, most: int | None) -> None:
    """Raise InputError where a frame is foretold to need more memory than it may (--max-memory)."""
    limit = memory_limit(most)
    if limit.bytes is None:
        return
    found = forecast(scene.world, scene.view(frame))
    _check(limit, frame_bytes(found, scene.preset, variant), found, f"frame {frame}")


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

    def __init__(self, scene: Scene, variant: str) -> None:
        self._scene, self._variant = scene, variant
        self._around: _Around | None = None
        self._asked, self._helps = 0, True

    def check(self, frame: int, most: int | None) -> None:
        """Raise InputError where a frame is foretold to need more than it may (--max-memory)."""
        limit = memory_limit(most).bytes
        if limit is None:
            return
        view = self._scene.view(frame)
        if self._covers(view, limit):
            return
        check_frame_forecast(self._scene, frame, self._variant, most)
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
            found = forecast(self._scene.world, around)
            needed = frame_bytes(found, self._scene.preset, self._variant)
        except InputError:
            return
        camera = view.camera
        ground = self._scene.world.terrain.height(camera.corner, camera.eye[None, :2])
        self._around = _Around(around, float(camera.eye[2] - ground[0]), needed)


def peak_rss_bytes() -> int:
    """Most memory that this process has held [bytes]; 0 where the system does not say.

    On Linux ``ru_maxrss`` would start from what the process held that started it.
    """
    status = Path("/proc/self/status")
    if status.exists():
        rows = status.read_text(encoding="ascii", errors="replace").splitlines()
        held = [int(row.split()[1]) * 1024 for row in rows if row.startswith("VmHWM")]
        if held:
            return held[0]
    try:
        import resource
    except ImportError:
        return 0
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return peak if sys.platform == "darwin" else peak * 1024
