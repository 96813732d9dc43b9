"""A budget of parts or of memory for a sequence: one detail for all frames, chosen before any.

Every frame then stands alone, and detail does not jump from frame to frame.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace

from lod.errors import InputError
from lod.pruning.detail_for_budget import find_detail
from lod.pruning.pruner import prune
from lod.pruning.view import View
from scenes.frame.assemble import assemble_frame
from scenes.preset.tables import Preset
from scenes.render.mitsuba.variants import choose
from scenes.render.pipeline.memory_model import predicted_bytes
from scenes.world.view import view_at
from scenes.world.world import World, build_world

Need = Callable[[int, float], int]
"""What a frame needs at a detail [px], of what there is a budget of; it never grows with it."""


def within_budget(preset: Preset, frames: Sequence[int]) -> Preset:
    """Choose the finest detail for a preset at which all its frames are within its limits.

    They hold at most ``view.max_parts`` parts, and are predicted to need at most
    ``view.max_memory`` bytes; the fullest uses nearly all of that
    (``lod.pruning.detail_for_budget``). Without such limits the preset stays as it is. Raises
    InputError where no detail fits.
    """
    view = preset.view
    if view.max_parts is None and view.max_memory is None:
        return preset
    world, details = build_world(preset), []
    if view.max_parts is not None:
        details.append(_fitting(_parts_of(world, preset), view.max_parts, view.detail, frames))
    if view.max_memory is not None:
        details.append(_fitting_memory(world, preset, view.max_memory, frames))
    return _at_detail(preset, max(details))


def _fitting(need: Need, most: int, start: float, frames: Sequence[int]) -> float:
    """The detail at which every frame's need is met: it grows while a frame is over."""
    detail = start
    for number, frame in enumerate(frames):

        def at(px: float, frame: int = frame) -> int:
            return need(frame, px)

        if number == 0 or at(detail) > most:
            detail = find_detail(at, most, detail).detail
    return detail


def _fitting_memory(world: World, preset: Preset, most: int, frames: Sequence[int]) -> float:
    """The detail at which every frame's bytes are met, less those that an empty frame needs."""
    variant = choose(preset.render.variant, preset.render.spectral)

    def bytes_at(frame: int, px: float) -> int:
        return predicted_bytes(assemble_frame(world, _at_detail(preset, px), frame, variant))

    made = assemble_frame(world, preset, frames[0], variant)
    least = predicted_bytes(replace(made, displayed=()))
    if most <= least:
        rule = f"a frame of this size needs about {least / 1e9:.2f} GB with nothing in it"
        cure = "allow more, or ask for fewer pixels or samples"
        raise InputError("--max-memory --fit", f"{most / 1e9:.2f} GB", rule, cure)

    def above_least(frame: int, px: float) -> int:
        return max(bytes_at(frame, px) - least, 0)

    return _fitting(above_least, most - least, preset.view.detail, frames)


def _at_detail(preset: Preset, detail: float) -> Preset:
    return preset.model_copy(update={"view": preset.view.model_copy(update={"detail": detail})})


def _parts_of(world: World, preset: Preset) -> Need:
    def parts_at(frame: int, px: float) -> int:
        return parts_displayed(world, replace(view_at(world, preset, frame), detail=px))

    return parts_at


def parts_displayed(world: World, view: View) -> int:
    """Count the displayed parts of everything but the ground, whose tiles are few."""
    others = (each for each in world.representations if each is not world.terrain)
    return sum(prune(each, view).displayed_parts for each in others)
