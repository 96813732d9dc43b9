"""A budget of parts for a sequence: one detail for all frames, chosen before any.

Every frame then stands alone, and detail does not jump from frame to frame. It is the finest detail
at which a frame holds no more parts than the budget allows, after Funkhouser & Séquin, "Adaptive
display algorithm for interactive frame rates" (SIGGRAPH '93): the cost is given, and the detail
follows. By the law of §4.1 the number of parts falls about as τ⁻²: a few prunes find τ.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import NamedTuple

from lod.air import least_extinction
from lod.errors import InputError
from lod.pruner import prune
from lod.view import View
from scenes.presets.schema import Preset
from scenes.processes.memory_limit import MemoryLimit, memory_limit, size_text
from scenes.render.memory import forecast, forecast_field, frame_bytes, parts_bytes, preflight
from scenes.render.variants import choose
from scenes.scene import Scene, World, frame_quality

MIN_BUDGET_USE = 0.98  # share of the budget that has to be used before the search ends
MAX_PRUNES = 12  # number of prunes after which the best detail so far is returned

_MAX_FACTOR = 2.0**20
"""Largest factor, up or down, between the first detail and any other that is tried."""


class BudgetFit(NamedTuple):
    """A detail τ [px], the number of parts displayed at it, and the prunes that found it."""

    detail: float
    parts: int
    prunes: int


def find_detail(parts_at: Callable[[float], int], most: int, start: float) -> BudgetFit:
    """Find the detail τ [px] at which at most ``most`` parts are displayed, and nearly as many.

    At least MIN_BUDGET_USE of the budget is used. parts_at(τ) must not grow with τ; where it jumps
    past the budget, the side of the jump below the budget is returned; where even the finest detail
    has fewer, the coarsest one that has as many. Raises InputError where even the coarsest detail
    has too many.
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
        raise InputError("--max-parts", most, rule, "allow more")
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

COPIED_FROM = 6.0
"""Of trees that subtend so many times the detail the sticks displayed take the memory of a copy:
references of forest, aerial and campfire take least from about here on."""

LEFT_BY_AIR = 1e-3
"""Share of light that the air leaves of what is farthest away in a reference."""

_UNPRUNED: dict[str, object] = {"metric": "blake", "max_parts": None, "copies": COPIED_FROM}

_UNPRUNED |= {"haze_aware": False, "smear": "off", "update_threshold": 0.0, "fade": 0.0}


def reference_preset(
    preset: Preset,
    frames: Sequence[int],
    most_bytes: int | None = None,
    note: Callable[[str], object] = lambda text: None,
    finest: float = FINEST_PX,
) -> Preset:
    """Give the preset of the references of a preset's frames: as fine as memory allows.

    Nothing is left out for blur or an eye, nothing but what lies so far off that the air leaves
    ``LEFT_BY_AIR`` of its light, and nothing fades. What stands still is whole, as copies of
    models, where that takes less memory. The detail of the rest is the finest, from
    one pixel (from ``finest`` if that is coarser) to ``finest``, at which all frames are estimated
    to need at most so many bytes (``memory_limit``) and the ground can be made; ``note`` is called
    with a line that tells it.
    Raises InputError where not even one pixel fits.
    """
    beta = least_extinction(Scene(preset).air)
    unpruned = _UNPRUNED | {"reach": -math.log(LEFT_BY_AIR) / beta if beta else None}
    plain = {"view": preset.view.model_copy(update=unpruned), "display": None, "eye": None}
    air = preset.air.model_copy(update={"seeing": 0.0})
    scene, limit = Scene(preset.model_copy(update={**plain, "air": air})), memory_limit(most_bytes)
    preflight(scene, (), most_bytes)
    variant = choose(preset.render.variant, preset.render.spectral)
    quality = frame_quality(scene.preset, variant)
    detail, needed, next_finer = 0.0, 0, max(1.0, finest)
    why = f"finer than {finest:g} px is not tried"
    while next_finer > finest * (1 - 1e-9):
        views = (replace(scene.view(frame), detail=next_finer) for frame in frames)
        try:
            found = [
                frame_bytes(
                    forecast(scene.world, view, from_size=scene.copied_from(view, quality)),
                    *(scene.preset, variant),
                )
                for view in views
            ]
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
            detail = find_detail(at, most, detail).detail
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
