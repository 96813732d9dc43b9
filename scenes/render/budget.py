"""A budget of parts for a sequence: one detail for all frames, chosen before any.

Every frame then stands alone, and detail does not jump from frame to frame.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import replace

from lod.errors import InputError
from lod.part_budget import MIN_BUDGET_USE, find_detail
from lod.pruner import prune
from lod.view import View
from scenes.field.forecast import forecast_field
from scenes.presets.schema import Preset
from scenes.processes.memory_limit import MemoryLimit, memory_limit, size_text
from scenes.render.memory import forecast, frame_bytes, parts_bytes, preflight
from scenes.render.variants import choose
from scenes.scene import Scene
from scenes.world.world import World

Need = Callable[[int, float], int]
"""What a frame needs at a detail [px], of what there is a budget of; it never grows with it."""

_FAR_OVER = 2.0
"""Over this many times its budget a frame is not pruned: what is estimated of it will do."""

_STEPS = 12
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
    (``lod.part_budget``). Where there are not so many parts to show, the detail is
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
            for _ in range(_STEPS):
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
