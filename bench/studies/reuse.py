"""Pruning time that frames save by going on from the cut of the frame before.

A camera walks at 1.4 m/s and 24 frames a second. Every frame is pruned from scratch, and from what
held of the frame before (``scenes.reuse.field_reuse``), the two taking turns, in the processor's
seconds
of one thread; the first frame, which holds nothing yet, and compiling are left out, and frames that
begin anew at the edge of a grid square are not. Two ratios: of the cut alone, and with all that is
known of its parts, for which who walks must be put in place in any frame.
"""

import time
from dataclasses import dataclass
from typing import Any

import click
import numba
import numpy as np

from bench.cli.output import table
from bench.fields.plain_scene import first_view
from bench.statistics.estimates import median
from lod.pruning.parts import Representation
from lod.pruning.pruner import prune
from scenes.field.species_field import SpeciesField
from scenes.reuse.field_reuse import Hold, cut_after
from scenes.reuse.terrain_reuse import Boxes, ground_after
from scenes.terrain.terrain import Terrain
from scenes.world.view import view_at

_FRAMES, _QUICK_FRAMES = 48, 12


@dataclass(frozen=True)
class Spent:
    """Seconds of each frame of one representation, (frames,): the cut, and all of its parts."""

    scratch: np.ndarray
    after: np.ndarray
    scratch_parts: np.ndarray
    after_parts: np.ndarray


def spent(name: str, size: str, frames: int) -> dict[str, Spent]:
    """Of every representation that fields of a preset are, and of its ground."""
    world, preset, _ = first_view(name, size, "camera.speed=1.4")
    found: dict[str, Spent] = {}
    everything: list[Representation] = [world.terrain, *world.fields]
    for each in everything:
        rows: list[tuple[float, ...]] = []
        hold: Hold | None = None
        boxes: Boxes | None = None
        for frame in range(1, frames + 2):
            view = view_at(world, preset, frame)
            start = time.thread_time()
            cut = prune(each, view)
            pruned = time.thread_time()
            _ = cut.parts
            told = time.thread_time()
            if isinstance(each, SpeciesField):
                cut, hold = cut_after(each, view, hold)
            elif isinstance(each, Terrain):
                cut, boxes = ground_after(each, view, boxes)
            went_on = time.thread_time()
            _ = cut.parts
            end = time.thread_time()
            rows.append((pruned - start, went_on - told, told - start, end - told))
        found[each.name] = Spent(*np.array(rows[1:]).T)
    return found


def ratio(after: np.ndarray, scratch: np.ndarray) -> str:
    """Median of the frames' own ratios, with its 95 % interval."""
    found = median(after / scratch)
    return f"{found.value:.2f} ({found.low:.2f} to {found.high:.2f})"


def rows_of(name: str, found: dict[str, Spent]) -> list[tuple[Any, ...]]:
    """One row of each representation, one of all fields, and one of everything."""
    fields = [each for key, each in found.items() if key != "terrain"]
    sums = {"all species": fields, "species and ground": [*found.values()]}
    cases = [(key, [each]) for key, each in found.items()] + list(sums.items())
    rows: list[tuple[Any, ...]] = []
    for key, them in cases:
        a, b, c, d = (
            np.sum([getattr(each, column) for each in them], axis=0)
            for column in ("scratch", "after", "scratch_parts", "after_parts")
        )
        scratch, after = (f"{1e3 * np.median(each):.1f}" for each in (a, b))
        rows.append((f"{name}: {key}", scratch, after, ratio(b, a), ratio(d, c)))
    return rows


@click.command()
@click.option("--quick", is_flag=True, help="Twelve frames.")
@click.option("--size", default="1280x720", show_default=True, help="Of the picture.")
def command(quick: bool, size: str) -> None:
    """Measure and print."""
    numba.set_num_threads(1)
    rows: list[tuple[Any, ...]] = [
        ("on one core", "scratch ms", "after ms", "ratio of cuts (95 %)", "with parts (95 %)")
    ]
    for name in ("meadow", "crowd"):
        rows += rows_of(name, spent(name, size, _QUICK_FRAMES if quick else _FRAMES))
    click.echo(table(rows))
