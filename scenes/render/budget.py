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

A budget of parts for a sequence gives one detail for all frames, chosen before any: every frame
then stands alone, and detail does not jump. It is the finest at which a frame holds no more parts
than the budget allows, after Funkhouser & Séquin, "Adaptive display algorithm for interactive frame
rates" (SIGGRAPH '93): the cost is given, and the detail follows. By the law of §4.1 the number of
parts falls about as τ⁻²: a few prunes find τ.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from lod.errors import InputError
from lod.law import spread_nodes
from lod.pruner import Cut, prune
from lod.view import View, compile_view
from scenes.field.cells import cell_in_reach, search_spans
from scenes.field.part_tables import PLAIN
from scenes.field.species_field import SpeciesField
from scenes.frame.frame_input import Quality, is_still_whole
from scenes.ground.mesh import QUADS
from scenes.models.catalogue import model_prototypes
from scenes.presets.load import has_acting
from scenes.presets.schema import Preset
from scenes.processes.memory_limit import MemoryLimit, memory_limit, size_text
from scenes.render.variants import choose
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
    """

    objects: float
    parts: float
    sticks: float
    triangles: float


def forecast_field(field: SpeciesField, view: View) -> FieldForecast:
    """Estimate what a view displays of a species, within some 20 % where that is much.

    Raises InputError where nothing bounds the search.
    """
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
    of_part, part = of_object[cut.object], cut.part.astype(np.int64)
    # Of a part the leaf appearance where none of its own parts is displayed, or else the inner one.
    is_leaf = np.bincount(cut.parent[cut.parent >= 0], minlength=len(cut)) == 0
    tables = field.prototypes.part_tables
    sticks = tables.sticks.count[2 * part + is_leaf]
    triangles = np.zeros(len(part)) if tables.meshes is None else tables.meshes.count[part]
    kept = cut.parts.kept
    if kept is not None:
        triangles = np.where((kept > 0) & (kept < 1 / PLAIN), np.minimum(triangles, 1), triangles)
    visited = float(weight.sum())
    return FieldForecast(
        objects=visited * cells.density * side**2,
        parts=float(of_part.sum()),
        sticks=float(of_part @ sticks) * _FADING,
        triangles=float(of_part @ triangles),
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
        copies = variant is not None and frame_quality(scene.preset, variant).draws_copies
        found = forecast(scene.world, scene.view(frame), copies=copies)
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
    """

    objects: float
    parts: float
    sticks: float
    triangles: float
    ground: Cut
    copies: float = 0.0


def forecast(
    world: World, view: View, of_fields: View | None = None, copies: bool = False
) -> Forecast:
    """Estimate what a view displays of the ground and of the fields.

    ``of_fields`` is the view of the fields where they are pruned by another rule than the ground;
    with ``copies`` what stands still and is whole shares the sticks of its prototypes.
    What is placed one by one, plumes, dust and what plug-ins make is left out. Raises InputError
    where the ground would have more tiles than it may.
    """
    fields, copied = [], 0.0
    for each in world.fields:
        fields.append(found := forecast_field(each, of_fields or view))
        if copies and is_still_whole(each, of_fields or view):
            tables, copied = each.prototypes.part_tables, copied + found.objects
            own = len(tables.sticks), len(tables.meshes or ())
            fields[-1] = replace(found, parts=found.objects, sticks=own[0], triangles=own[1])
    ground = prune(world.terrain, view)
    return Forecast(
        objects=sum(each.objects for each in fields),
        parts=sum(each.parts for each in fields),
        sticks=sum(each.sticks for each in fields),
        triangles=_ground_triangles(ground) + sum(each.triangles for each in fields),
        ground=ground,
        copies=copied,
    )


def _ground_triangles(ground: Cut) -> float:
    # A tile draws those of its quarters that no tile covers: 4 a tile, less one for each that does.
    return 2.0 * QUADS**2 * (3 * ground.displayed_parts + ground.displayed_objects)


_BASE = 336e6
_COPY = 20e3
_STICK, _STICK_IN_ONE, _TRIANGLE, _PIXEL = 277.0, 210.0, 204.0, 176.0
_SAMPLE_JIT, _SAMPLE_SCALAR = 187.0, 355.0
_BASE_SPECTRAL, _PIXEL_SPECTRAL, _SAMPLE_SPECTRAL = 232e6, 705.0, 440.0
_MOVED_STICK, _DENOISED_PIXEL, _MATTED_PIXEL = 126.0, 500.0, 90.0
_BASE_PRUNED = 380e6
_PRUNED_PART, _OBJECT, _GROUND_TRIANGLE = 24.0, 150.0, 50.0


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
    return parts_bytes(found.parts) + round(_OBJECT * found.objects + ground)


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
    return drawn + round(_OBJECT * found.objects + _PRUNED_PART * found.parts)


MIN_BUDGET_USE = 0.98
"""Share of the budget that has to be used before the search ends."""

MAX_PRUNES = 12
"""Number of prunes after which the best detail so far is returned."""

_MAX_FACTOR = 2.0**20
"""Largest factor, up or down, between the first detail and any other that is tried."""


class BudgetFit(NamedTuple):
    """A detail τ [px], the number of parts displayed at it, and the prunes that found it."""

    detail: float
    parts: int
    prunes: int


def find_detail(
    parts_at: Callable[[float], int], most: int, start: float, where: str = "budget"
) -> BudgetFit:
    """Find the detail τ [px] at which at most ``most`` parts are displayed, and nearly as many.

    At least MIN_BUDGET_USE of the budget is used. parts_at(τ) must not grow with τ; where it jumps
    past the budget, the side of the jump below the budget is returned; where even the finest detail
    has fewer, the coarsest one that has as many. ``where`` is what errors call the budget. Raises
    InputError where even the coarsest detail has too many.
    """
    least, greatest = start / _MAX_FACTOR, start * _MAX_FACTOR
    low, high, detail = least, greatest, start
    fit: BudgetFit | None = None
    parts_above: int | None = None
    aim = math.log((1 + MIN_BUDGET_USE) / 2 * most)  # just below the budget
    for prunes in range(1, MAX_PRUNES + 1):
        parts = parts_at(detail)
        if parts <= most:
            high, fit = detail, BudgetFit(detail, parts, prunes)
            if parts >= MIN_BUDGET_USE * most:
                return fit
        else:
            low, parts_above = detail, parts
        # No part changes between details as close as this.
        if high / low < 1 + 1e-6 or detail in (least, greatest):
            break
        if parts_above is None or fit is None:
            # By the law, and ever farther where that is not enough.
            step = 0.5 * (math.log(max(parts, 1)) - aim) * 2.0 ** (prunes - 1)
            step = math.copysign(max(abs(step), 0.02 * 4.0 ** (prunes - 1)), step)
            detail = min(max(detail * math.exp(min(max(step, -14), 14)), low), high)
        else:
            # Secant in logarithms, kept off the ends of the bracket; now and then its middle.
            share = 0.5
            if prunes % 3 and fit.parts:
                rise = math.log(parts_above) - math.log(fit.parts)
                share = min(max((math.log(parts_above) - aim) / rise, 0.02), 0.98)
            detail = low * (high / low) ** share
    if fit is None:
        rule = f"{parts:,} parts are displayed even at {detail:.6g} px"
        raise InputError(where, most, rule, "allow more")
    if parts_above is not None:
        return BudgetFit(fit.detail, fit.parts, prunes)
    # There are not as many parts: the coarsest detail, to a hundredth, that displays them all.
    low, high = fit.detail, max(start, fit.detail)
    while high / low > 1.01:
        middle = math.sqrt(low * high)
        prunes += 1
        low, high = (middle, high) if parts_at(middle) == fit.parts else (low, middle)
    return BudgetFit(low, fit.parts, prunes)


Need = Callable[[int, float], int]
"""What a frame needs at a detail [px], of what there is a budget of; it never grows with it."""

_FAR_OVER = 2.0
"""Over this many times its budget a frame is not pruned: what is estimated of it will do."""

_HALVINGS = 12
"""Halvings, on a logarithmic scale, of the details between which the finest ground is sought."""

FINEST_PX, _FINER, _FILLED = 1 / 8, 2**-0.25, 0.8
"""Finest detail of a reference [px], the step between those that are tried, and the share of the
memory that one is estimated to fill: estimates are within some 20 %."""

_UNPRUNED: dict[str, object] = {"metric": "blake", "max_parts": None}
_UNPRUNED |= {"haze_aware": False, "smear": "off", "update_threshold": 0.0, "fade": 0.0}


def reference_preset(
    preset: Preset,
    frames: Sequence[int],
    most_bytes: int | None = None,
    note: Callable[[str], object] = lambda text: None,
) -> Preset:
    """Give the preset of the references of a preset's frames: as fine as memory allows.

    Nothing is left out for air, blur or an eye, and nothing fades. The detail is the finest, from
    one pixel to FINEST_PX, at which all frames are estimated to need at most so many bytes
    (``memory_limit``) and the ground can be made; ``note`` is called with a line that tells it.
    Raises InputError where not even one pixel fits.
    """
    plain = {"view": preset.view.model_copy(update=_UNPRUNED), "display": None, "eye": None}
    air = preset.air.model_copy(update={"seeing": 0.0})
    scene, limit = Scene(preset.model_copy(update={**plain, "air": air})), memory_limit(most_bytes)
    preflight(scene, (), most_bytes)
    variant = choose(preset.render.variant, preset.render.spectral)
    detail, needed, next_finer, why = 0.0, 0, 1.0, f"finer than {FINEST_PX:g} px is not tried"
    while next_finer > FINEST_PX * (1 - 1e-9):
        views = (replace(scene.view(frame), detail=next_finer) for frame in frames)
        try:
            found = [frame_bytes(forecast(scene.world, v), scene.preset, variant) for v in views]
        except InputError:
            why = "the ground can be no finer"
            break
        if limit.bytes is not None and max(found) > _FILLED * limit.bytes:
            why = f"finer is too much for {limit.told}"
            break
        detail, needed, next_finer = next_finer, max(found), next_finer * _FINER
    if not detail:
        rule = "a reference at one pixel needs more, or ground that cannot be made"
        raise InputError("--max-memory", limit.told, rule, "allow more, or ask for fewer pixels")
    note(f"lodbench: --reference: {detail:.3g} px, about {size_text(needed)}; {why}")
    view = scene.preset.view.model_copy(update={"detail": detail})
    return scene.preset.model_copy(update={"view": view})


def within_budget(
    preset: Preset,
    frames: Sequence[int],
    most_bytes: int | None = None,
    note: Callable[[str], object] = lambda text: None,
) -> Preset:
    """Choose the finest detail for a preset at which all its frames are within its limits.

    They hold at most ``view.max_parts`` parts; the fullest uses nearly all of that
    (``scenes.render.budget``). Where there are not so many parts to show, the detail is
    the coarsest that shows all there are, or the finest that the ground can have, and ``note`` is
    called with a line that says so. Without such a limit the preset stays as it is. Raises
    InputError where no detail fits, and where so many parts need more memory than ``most_bytes``
    allow (``memory_limit``).
    """
    most = preset.view.max_parts
    if most is None:
        return preset
    scene = Scene(preset)
    preflight(scene, (), most_bytes)
    need = _parts_of(scene, memory_limit(most_bytes), most)
    detail = preset.view.detail
    for number, frame in enumerate(frames):

        def at(px: float, frame: int = frame) -> int:
            return need(frame, px)

        if number == 0 or at(detail) > most:  # it grows while a frame is over
            detail = find_detail(at, most, detail, "--max-parts").detail
    finest = _finest_ground(scene, detail, frames)
    shown = max(need(frame, finest) for frame in frames)
    if shown < MIN_BUDGET_USE * most:
        why = "the ground can be no finer" if finest > detail else "that is all there is"
        note(f"lodbench: --max-parts {most:,}: {shown:,} parts at {finest:.4g} px: {why}")
    return preset.model_copy(update={"view": preset.view.model_copy(update={"detail": finest})})


def _finest_ground(scene: Scene, detail: float, frames: Sequence[int]) -> float:
    """The finest detail from this one on with which the ground of every frame can be made [px]."""
    low, high = math.log(detail), math.log(max(detail, scene.preset.view.detail))
    found = detail
    for frame in frames:

        def can_be(px: float, frame: int = frame) -> bool:
            try:
                prune(scene.world.terrain, replace(scene.view(frame), detail=px))
            except InputError:
                return False
            return True

        if not can_be(found):
            low, high = math.log(found), max(high, math.log(found))
            for _ in range(_HALVINGS):
                middle = (low + high) / 2
                low, high = (low, middle) if can_be(math.exp(middle)) else (middle, high)
            found = math.exp(high)
    return found


def _parts_of(scene: Scene, limit: MemoryLimit, most: int) -> Need:
    def parts_at(frame: int, px: float) -> int:
        view = replace(scene.view(frame), detail=px)
        parts = sum(forecast_field(each, view).parts for each in scene.world.fields)
        if parts > _FAR_OVER * most:
            return round(parts)
        if limit.bytes is not None and parts_bytes(parts) > limit.bytes:
            able = float(f"{0.5 * most * limit.bytes / parts_bytes(most):.0e}")
            rule = (
                f"so many parts need about {size_text(parts_bytes(most))}, more than {limit.told}"
            )
            raise InputError("--max-parts", most, rule, f"try --max-parts {able:.0f}")
        return parts_displayed(scene.world, view)

    return parts_at


def parts_displayed(world: World, view: View) -> int:
    """Count the displayed parts of everything but the ground, whose tiles are few."""
    others = (each for each in world.representations if each is not world.terrain)
    return sum(prune(each, view).displayed_parts for each in others)
