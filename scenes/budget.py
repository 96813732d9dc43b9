"""A budget of parts for a sequence: one detail for all of its frames, decided before any is made.

Every frame then stands alone, and detail does not jump from frame to frame.
"""

from collections.abc import Sequence
from dataclasses import replace

from lod.budget import fitting_detail
from lod.prune import prune
from lod.view import View
from scenes.preset import Preset
from scenes.world import World, build_world, view_at


def within_budget(preset: Preset, frames: Sequence[int]) -> Preset:
    """The preset at the finest detail whose frames all hold at most ``view.max_parts`` parts.

    The fullest of them uses nearly all of that (``lod.budget``). Without such a limit, the preset
    as it is. Raises InputError where no detail fits.
    """
    most, detail = preset.view.max_parts, preset.view.detail
    if most is None:
        return preset
    world = build_world(preset)
    for number, frame in enumerate(frames):
        view = view_at(world, preset, frame)

        def parts_at(px: float, view: View = view) -> int:
            return parts_displayed(world, replace(view, detail=px))

        if number == 0 or parts_at(detail) > most:
            detail = fitting_detail(parts_at, most, detail).detail
    return preset.model_copy(update={"view": preset.view.model_copy(update={"detail": detail})})


def parts_displayed(world: World, view: View) -> int:
    """Displayed parts of everything but the ground, whose tiles are few."""
    others = (each for each in world.representations if each is not world.terrain)
    return sum(prune(each, view).displayed_parts for each in others)
