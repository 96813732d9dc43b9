"""How much memory does a command need? One model, asked once, before its first frame.

The model of a picture is linear, fitted to the most memory of twelve frames in fresh processes
(relative least squares; 0 to 5.8 M sticks, 0.03 to 1.2 M triangles, 2·10³ to 2·10⁶ pixels, both
drivers):

    bytes = 336 MB + 277·sticks + 204·triangles + 176·pixels + s·samples at once,

s = 187 under Dr.Jit, 355 in scalar variants. Where all sticks are one shape (Dr.Jit, in colours)
and no shutter is open a stick takes 120 in the renderer, but 210 while it is posed: a wood of 34 M
sticks held 7.4 GB. Wavelengths bring colour-science with them: sixteen bands add 232 MB, 705 bytes
a pixel and, under Dr.Jit, 440 a sample at once; motion vectors 126 a stick (where its ends are
next); a denoiser 500 a pixel, mattes 90; and under an open shutter the sticks of two instants are
held at once. A copy of a model takes 20 kB, nearly all of it the renderer's own.

Pruning alone, without a picture (``lodbench count``), takes

    bytes = 380 MB + 24·parts + 150·objects examined + 50·triangles of the ground,

fitted to six counts (0.15 to 119 M parts, 0.04 to 13 M objects, 0.4 to 3.7 GB: 0.97 to 1.17 times
what they took). Parts and objects are held while a picture is made, and added to what that takes.

How many objects, parts and sticks of a species a view will display is estimated before it is
pruned. The law's integral of what an object displays over the ground is taken on the nodes of the
law's own quadrature (``lod.law.spread_nodes``), by pruning the objects of the cells that they fall
in. Its cost does not depend on how much there is to display.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from lod.errors import InputError
from lod.law import spread_nodes
from lod.pruner import Cut, prune
from lod.shapes import Sticks, Triangles, batches_of
from lod.view import View, compile_view
from scenes.field.cells import cell_in_reach, search_spans
from scenes.field.part_tables import PLAIN
from scenes.field.species_field import SpeciesField
from scenes.frame.frame_input import FrameInput, Quality, can_be_copied
from scenes.ground.mesh import QUADS
from scenes.models.catalogue import model_prototypes
from scenes.presets.load import has_acting
from scenes.presets.schema import Preset
from scenes.processes.memory_limit import MemoryLimit, memory_limit, size_text
from scenes.rig.rigged_prototype import RiggedPrototype
from scenes.scene import Scene, World, frame_quality
from scenes.trees.species import Weather

_NODES = 768

_FADING = 1.1
"""Sticks drawn for each estimated one: appearances that fade into one another are both drawn."""


@dataclass(frozen=True)
class FieldForecast:
    """Expected numbers of what a view visits and displays of a species.

    objects  in the cells visited, wherever they can grow
    parts    displayed; sticks, triangles: those of the appearances that the parts show
    copies   objects that share the sticks of a prototype, whose own alone are counted
    """

    objects: float
    parts: float
    sticks: float
    triangles: float
    copies: float = 0.0


def forecast_field(field: SpeciesField, view: View, from_size: float = 0.0) -> FieldForecast:
    """Estimate what a view displays of a species, within some 20 % where that is much.

    What subtends ``from_size`` times the detail is a copy, where that can be. Raises InputError
    where nothing bounds the search.
    """
    from_size *= can_be_copied(field, view)
    view = field.species.seen_in(view)
    cells, bounds = field.cells, field.search_bounds(view)
    side, lattice = cells.side_m, cells.lattice(view.camera.corner)
    x0, x1, y0, y1 = search_spans(cells, view, bounds)
    origin = np.array([lattice.cell_x, lattice.cell_y]), np.array([lattice.rest_x, lattice.rest_y])
    low, high = ((np.array(n) - origin[0]) * side - origin[1] for n in ((x0, y0), (x1, y1)))
    eye, is_window = view.camera.eye[:2], field.extent is not None
    farthest = min(bounds.horizontal, 1e15)  # cells there are as fine as their numbers can say
    if is_window and ((eye < low) | (eye > high)).any():
        # The eye is outside of the window: an even net over that.
        sides = np.indices((32, 24)).reshape(2, -1).T + 0.5
        size = np.maximum(high - low, 0.0)
        xy, area = low + sides / (32, 24) * size, np.full(len(sides), size.prod() / len(sides))
    else:
        if is_window:
            farthest = min(farthest, float(np.hypot(*np.maximum(eye - low, high - eye))))
        net = spread_nodes(np.array([farthest]), view, _NODES, by_area=0.0)
        xy, area = net.xy, net.area
    steps = np.floor((xy + origin[1]) / side)
    number = steps.astype(np.int64) + origin[0]
    middle, compiled = (steps + 0.5) * side - origin[1], compile_view(view)
    near = np.array(
        [cell_in_reach(compiled, *each, side, bounds) for each in middle.tolist()], bool
    )
    near &= ((number >= (x0, y0)) & (number < (x1, y1))).all(axis=1)
    share = area[near] / side**2  # of a cell, or how many, for which a node stands
    cell, node = np.unique(number[near] @ (1, 1j), return_inverse=True)
    weight = np.bincount(node, share, minlength=len(cell))
    x, y = cell.real.astype(np.int64), cell.imag.astype(np.int64)
    samples = field.sample_cells(view.camera.corner, x, y)
    objects = field.instances_in_view(samples, view)
    cut = field.prototypes.cut(objects, view, len(samples))
    of_object = weight[np.searchsorted(cell, samples.cell_x + 1j * samples.cell_y)]
    near = field.copied(objects, view, from_size)
    of_part, part = (of_object * ~near)[cut.object], cut.part.astype(np.int64)
    # Of a part the leaf appearance where none of its own parts is displayed, or else the inner one.
    is_leaf = np.bincount(cut.parent[cut.parent >= 0], minlength=len(cut)) == 0
    tables = field.prototypes.part_tables
    sticks = tables.sticks.count[2 * part + is_leaf]
    triangles = np.zeros(len(part)) if tables.meshes is None else tables.meshes.count[part]
    kept = cut.parts.kept
    if kept is not None:
        triangles = np.where((kept > 0) & (kept < 1 / PLAIN), np.minimum(triangles, 1), triangles)
    copies = float(of_object @ near)
    models = (len(tables.sticks), len(tables.meshes or ())) if copies else (0, 0)
    return FieldForecast(
        objects=float(weight.sum()) * cells.density * side**2,
        parts=float(of_part.sum()) + copies,
        sticks=float(of_part @ sticks) * _FADING + models[0],
        triangles=float(of_part @ triangles) + models[1],
        copies=copies,
    )


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


def preflight(
    scene: Scene,
    frames: Sequence[int] = (),
    most: int | None = None,
    variant: str | None = None,
    acted: int = 0,
) -> "Forecast | None":
    """Raise InputError where a command is estimated to need more memory than it may.

    It is asked once, before the first frame: prototypes and live actors are estimated before they
    are made, and frames before anything of them is pruned but the ground.

    most     bytes that it may hold, as of ``memory_limit``
    variant  in which the frames are rendered; None: they are only pruned
    acted    how many frames that live actors act are kept
    Gives what is estimated of the last frame; None without a limit, where nothing is estimated.
    """
    limit, found = memory_limit(most), None
    if limit.bytes is None:
        return None
    _check_actors(scene.preset, limit, limit.bytes, acted)
    _check_prototypes(scene.preset, limit, limit.bytes)
    for frame in frames:
        view, from_size = scene.view(frame), 0.0
        if variant is not None:
            from_size = scene.copied_from(view, frame_quality(scene.preset, variant))
        found = forecast(scene.world, view, from_size=from_size)
        needed = frame_bytes(found, scene.preset, variant)
        if needed > limit.bytes:
            counts = f"about {found.parts:,.0f} parts and {found.triangles:,.0f} triangles"
            parts = found.parts * limit.bytes / needed / 2
            budget = f" (--max-parts {float(f'{parts:.0e}'):.0f} sets it)" if parts >= 1000 else ""
            rule = f"frame {frame}, with {counts}, needs about {size_text(needed)}"
            cure = f"ask for less detail{budget}, density or size"
            cure += ", or --max-memory 0 to try it all the same"
            raise InputError("--max-memory", limit.told, rule, cure)
    return found


def _check_prototypes(preset: Preset, limit: MemoryLimit, most: int) -> None:
    """Of species with many prototypes the first is made and counted, before the others are."""
    needed = 0.0
    weather = Weather(preset.world.season, preset.wind.speed)
    for name, table in preset.species.items():
        built, kept = table.prototypes, table.prototypes * len(table.sizes)
        if kept <= _FEW_PROTOTYPES or table.density == 0:
            continue
        (first,) = model_prototypes(table.model, 1, (1.0,), False, weather, table.model_sha256)
        needed += len(first.hierarchy) * (built * _BUILT_PART + kept * _KEPT_PART)
        if needed > most:
            rule = f"{kept} prototypes of {name} need about {size_text(needed)}"
            raise InputError("--max-memory", limit.told, rule, "ask for fewer prototypes or sizes")


def _check_actors(preset: Preset, limit: MemoryLimit, most: int, acted: int) -> None:
    if not has_acting(preset):
        return
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
    needed += acted * (_ACTED_FRAME + _ACTED_ACTOR * actors)
    if needed > most:
        kept = f" in {acted:,} frames" if acted else ""
        rule = f"{actors:,} actors{kept} need about {size_text(needed)}"
        fewer = "fewer actors or a smaller acting.frames" if acted else "fewer actors"
        cure = f"ask for {fewer}, or --max-memory 0 to try it all the same"
        raise InputError("--max-memory", limit.told, rule, cure)


@dataclass(frozen=True)
class Forecast:
    """Expected numbers of what a view visits and displays of a world.

    objects          of the fields, visited; parts, sticks: displayed of them
    triangles        of the ground, and of the meshes displayed
    ground           the cut of the ground, from which its triangles are known
    copies           objects that share the sticks of a prototype, whose own alone are counted
    own_triangles    of the meshes of all prototypes, displayed or not
    """

    objects: float
    parts: float
    sticks: float
    triangles: float
    ground: Cut
    copies: float = 0.0
    own_triangles: float = 0.0


def forecast(
    world: World, view: View, of_fields: View | None = None, from_size: float = 0.0
) -> Forecast:
    """Estimate what a view displays of the ground and of the fields.

    ``of_fields`` is the view of the fields where they are pruned by another rule than the ground;
    what stands still and subtends ``from_size`` times the detail shares the sticks of its model.
    What is placed one by one, plumes, dust and what plug-ins make is left out. Raises InputError
    where the ground would have more tiles than it may.
    """
    fields = [forecast_field(each, of_fields or view, from_size) for each in world.fields]
    ground = prune(world.terrain, view)
    return Forecast(
        objects=sum(each.objects for each in fields),
        parts=sum(each.parts for each in fields),
        sticks=sum(each.sticks for each in fields),
        triangles=_ground_triangles(ground) + sum(each.triangles for each in fields),
        ground=ground,
        copies=sum(each.copies for each in fields),
        own_triangles=sum(len(each.prototypes.part_tables.meshes or ()) for each in world.fields),
    )


def _ground_triangles(ground: Cut) -> float:
    # A tile draws those of its quarters that no tile covers: 4 a tile, less one for each that does.
    return 2.0 * QUADS**2 * (3 * ground.displayed_parts + ground.displayed_objects)


_BASE, _COPY = 336e6, 20e3
_STICK, _STICK_IN_ONE, _TRIANGLE, _PIXEL = 277.0, 210.0, 204.0, 176.0
_SAMPLE_JIT, _SAMPLE_SCALAR = 187.0, 355.0
_BASE_SPECTRAL, _PIXEL_SPECTRAL, _SAMPLE_SPECTRAL = 232e6, 705.0, 440.0
_MOVED_STICK, _DENOISED_PIXEL, _MATTED_PIXEL = 126.0, 500.0, 90.0
_BASE_PRUNED = 380e6
_PRUNED_PART, _OBJECT, _GROUND_TRIANGLE, _OWN_TRIANGLE = 24.0, 150.0, 50.0, 700.0


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
    copies: int = 0,
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
    scene += _COPY * copies
    at_once = min(pixels * quality.spp, quality.most_samples)
    kept = math.prod(quality.window_of(size).size)
    return round(scene + pixel * kept + sample * at_once)


def forecast_bytes(found: Forecast) -> int:
    """Predict the bytes that a process holds at most while it prunes such a view."""
    ground = _GROUND_TRIANGLE * _ground_triangles(found.ground)
    own = _OWN_TRIANGLE * found.own_triangles
    return parts_bytes(found.parts) + round(_OBJECT * found.objects + ground + own)


def parts_bytes(parts: float) -> int:
    """Predict the bytes that a process holds which has pruned a view down to so many parts."""
    return round(_BASE_PRUNED + _PRUNED_PART * parts)


def frame_bytes(found: Forecast, preset: Preset, variant: str | None) -> int:
    """Predict the bytes that a process holds at most for a frame of which so much is estimated."""
    if variant is None:
        return forecast_bytes(found)
    extra = ExtraBuffers(preset.output.motion, preset.output.denoise, preset.view.shutter > 0)
    shapes, quality = (round(found.sticks), round(found.triangles)), frame_quality(preset, variant)
    drawn = predict_bytes(*shapes, preset.render.size, quality, extra, round(found.copies))
    own = _OWN_TRIANGLE * found.own_triangles
    return drawn + round(_OBJECT * found.objects + _PRUNED_PART * found.parts + own)


def check_memory(frame_input: FrameInput, most: int | None = None) -> None:
    """Raise InputError where a picture of this input needs more memory than it may."""
    limit, needed = memory_limit(most), predicted_bytes(frame_input)
    if limit.bytes is not None and needed > limit.bytes:
        counts = "{:,} sticks and {:,} triangles".format(*count_shapes(frame_input))
        rule = f"the picture, with {counts}, needs about {size_text(needed)}"
        cure = "ask for less detail, density or size, or --max-memory 0 to try it all the same"
        raise InputError("--max-memory", limit.told, rule, cure)


def predicted_bytes(frame_input: FrameInput) -> int:
    """Predict the bytes that a frame will need, from its input."""
    camera = frame_input.camera
    after, subframes = frame_input.after, frame_input.subframes
    extra = ExtraBuffers(after is not None, frame_input.denoise, bool(subframes))
    size = camera.width, camera.height
    copies = sum(
        len(each.copies.which) for each in frame_input.displayed if each.copies is not None
    )
    return predict_bytes(*count_shapes(frame_input), size, frame_input.quality, extra, copies)


def count_shapes(frame_input: FrameInput) -> tuple[int, int]:
    """Count the sticks and triangles of a frame; of copies, those of their models."""
    looks = [each.shape for each in frame_input.displayed]
    looks += [each.copies.shape for each in frame_input.displayed if each.copies is not None]
    shapes = [shape for look in looks for shape in batches_of(look)]
    sticks = sum(len(shape) for shape in shapes if isinstance(shape, Sticks))
    return sticks, sum(len(shape) for shape in shapes if isinstance(shape, Triangles))
