"""What leaving out hidden objects could save at most: ``python -m bench.studies.occlusion``.

An object in view is hidden where none of so many rays a pixel from the eye meets any of it. All
that is hidden is then left out, whatever shadow and light it casts, and what is left is described,
built and traced beside the whole: no culling saves more, as each must still find what is hidden,
and keep what casts a shadow into the picture. "Behind ground" are those that the ground's own
horizon hides with all of their bounds; the others are hidden by what stands before them, or are too
thin for the rays. Wall-clock seconds; described and built once each, traced by turns, the best of
two.
"""

import time
from dataclasses import dataclass, replace
from typing import Any

import click
import numpy as np

from bench.cli.output import table
from lod.pruning.parts import Sticks
from lod.pruning.view import View, in_view
from scenes.frame.frame_input import shoot
from scenes.frame.types import FrameInput, Quality, Visible
from scenes.preset.load import Preset, load_preset
from scenes.render.description.describe import object_ids
from scenes.render.mitsuba.variants import choose
from scenes.render.pipeline.render import Stage, staged, taken
from scenes.terrain.horizon import horizon
from scenes.world.world import World, build_world, view_at


@dataclass(frozen=True, eq=False)
class Seen:
    """Objects of one representation: of each cut row, whether its object is hidden; and counts of
    objects in view, hidden of these, behind ground of these; of parts in view, and hidden.
    """

    hidden: np.ndarray
    counts: np.ndarray


def preset_at(name: str, size: str, spp: int) -> Preset:
    """A preset in its own air and from where it is looked at."""
    return load_preset(name, [f'render.size="{size}"', f"render.spp={spp}"])


def met(stage: Stage, quality: Quality, rays: int) -> np.ndarray:
    """Numbers of objects that a ray from the eye meets first, rays of each pixel."""
    found = [
        np.unique(taken(stage, replace(quality, spp=1, seed=quality.seed + each), 1).object)
        for each in range(rays)
    ]
    return np.unique(np.concatenate(found))


def seen_of(world: World, view: View, one: Visible, first: int, met: np.ndarray) -> Seen:
    """Which objects of a representation nobody sees. first: number of its first object."""
    parts = one.cut.parts
    roots = np.flatnonzero(parts.whole < 0)
    row = np.zeros(int(parts.object.max(initial=0)) + 1, np.int64)
    row[parts.object[roots]] = np.arange(len(roots))
    whole = parts.take(roots)
    inside = in_view(view, whole.centre, whole.bound)
    unseen = inside & ~np.isin(whole.object + first, met)
    low, high = (whole.centre + s * whole.bound[:, None] for s in (-1, 1))
    ground = horizon(world.terrain.relief, view, world.terrain.reach)
    behind = unseen & (ground.hides(view, low, high) if ground else np.zeros(len(roots), bool))
    of = row[parts.object]
    counts = [inside.sum(), unseen.sum(), behind.sum(), inside[of].sum(), unseen[of].sum()]
    return Seen(unseen[of], np.array(counts))


def without(one: Visible, hidden: np.ndarray) -> Visible:
    """The same without the sticks of hidden parts."""
    shape = one.shape
    if not isinstance(shape, Sticks):
        return one
    keep = ~hidden[shape.owner]
    names = ("start", "end", "start_radius", "end_radius", "tint", "owner")
    return replace(one, shape=replace(shape, **{k: getattr(shape, k)[keep] for k in names}))


def traced(stages: list[Stage], quality: Quality) -> list[float]:
    """Least seconds of two frames of each, by turns."""
    seconds: tuple[list[float], ...] = ([], [])
    for _ in range(2):
        for stage, found in zip(stages, seconds, strict=True):
            start = time.perf_counter()
            taken(stage, quality, 1)
            found.append(time.perf_counter() - start)
    return [min(each) for each in seconds]


def stage_for(made: FrameInput, visible: tuple[Visible, ...]) -> Stage:
    """What is visible, built."""
    return staged(made.camera, visible, made.air, made.light, made.quality)


def measured(name: str, size: str, spp: int, rays: int) -> dict[str, Any]:
    """One preset's first frame: counts, and seconds of whole frames with all and without."""
    preset = preset_at(name, size, spp)
    world = build_world(preset)
    shoot(world, preset, 1, choose("auto"))  # compiled walks
    made = shoot(world, preset, 1, choose("auto"))
    view, quality = view_at(world, preset, 1), made.quality
    found = met(stage_for(made, made.visible), quality, rays)  # compiled kernels, too
    every = stage_for(made, made.visible)
    firsts = object_ids([one.cut for one in made.visible])
    left, counts, sticks = list(made.visible[:1]), np.zeros(5, np.int64), np.zeros(2)
    for one, first in list(zip(made.visible, firsts, strict=True))[1:]:
        seen = seen_of(world, view, one, first, found)
        counts += seen.counts
        left.append(without(one, seen.hidden))
        sticks += (len(one.shape), len(left[-1].shape))
    fewer = stage_for(made, tuple(left))
    ready = [sum(stage.seconds.values()) for stage in (every, fewer)]
    looks = made.seconds["appearance"] * np.array((1.0, sticks[1] / sticks[0]))
    trace = traced([every, fewer], quality)
    whole = [made.seconds["prune"] + a + b + c for a, b, c in zip(looks, ready, trace, strict=True)]
    return {
        "counts": counts,
        "sticks": sticks,
        "ready": looks + ready,
        "trace": trace,
        "all": whole,
    }


@click.command()
@click.argument("names", nargs=-1)
@click.option("--size", default="1280x720", metavar="WxH", show_default=True)
@click.option("--spp", default=16, show_default=True)
@click.option("--rays", default=16, show_default=True, help="probes a pixel")
def main(names: tuple[str, ...], size: str, spp: int, rays: int) -> None:
    """Measure the presets of these NAMES, or four."""
    for name in names or ("meadow", "crowd", "forest", "mountain"):
        found = measured(name, size, spp, rays)
        objects, hidden, behind, parts, unseen = found["counts"].tolist()
        rows: list[tuple[object, ...]] = [
            ("objects in view", objects, ""),
            ("hidden", hidden, f"{hidden / objects:.1%}"),
            ("of these behind ground", behind, f"{behind / max(hidden, 1):.1%}"),
            ("parts in view", parts, ""),
            ("of hidden objects", unseen, f"{unseen / parts:.1%}"),
            ("sticks, all and left", *(f"{n:.0f}" for n in found["sticks"])),
        ]
        for key in ("ready", "trace", "all"):
            before, after = found[key]
            rows.append((f"{key} [s]", f"{before:.2f}", f"{after:.2f} ({after / before:.2f})"))
        click.echo(f"{name}, {size}, {spp} samples, {rays} probes a pixel")
        click.echo(table(rows))


if __name__ == "__main__":
    main()
