"""What the temporal metric saves where actors act, how far off those are who wait, and who meets.

Walkers with the behaviour ``walk`` in a square, seen from its edge, act twice: everyone updated in
every frame, and by a threshold. Both are timed frame by frame, in turns (CPU time, renderer and
pruner not included). Every fourth frame the displayed sticks of the second are held against the
same sticks of the first, of which some then have chosen other ways: that is more than waiting alone
is to blame for, and it grows with time. The last table counts how near people come to each other.
"""

import time
from collections.abc import Iterator
from dataclasses import dataclass

import click
import numpy as np
from scipy.spatial import cKDTree

from bench.cli.output import table
from lod.arrays import Reals
from lod.pruning.crossfade import blend_weights
from lod.pruning.pruner import prune
from lod.pruning.shapes import Sticks
from lod.pruning.update_schedule import TruePose, displacement_px, initial_state
from lod.pruning.view import View
from scenes.actors.cast import Cast
from scenes.actors.performance import X, Y
from scenes.preset.load import preset_from
from scenes.preset.tables import Preset
from scenes.world.cast import make_cast
from scenes.world.view import view_at
from scenes.world.world import build_world, make_terrain

DENSITY = 0.005
"""Walkers on a square metre of the first table."""

EVERY = 4
"""Frames from one comparison of sticks to the next."""


@dataclass(frozen=True)
class Saving:
    """What a threshold saves: seconds, updates, sticks off [px], and parts displayed.

    later_ratio  seconds, all ÷ some, of the second half of the frames
    """

    actors: int
    seconds_all: float
    seconds_some: float
    later_ratio: float
    updated: float
    off_px: Reals
    parts_ratio: float

    def row(self) -> tuple[str, ...]:
        """Write them as a row of the table."""
        saved = f"{self.seconds_all / self.seconds_some:.2f}"
        off = f"{np.quantile(self.off_px, 0.999):.3f}", f"{self.off_px.max():.3f}"
        seconds = f"{self.seconds_all:.2f}", f"{self.seconds_some:.2f}"
        shares = f"{self.updated:.3f}", f"{self.parts_ratio:.4f}"
        return str(self.actors), *seconds, saved, f"{self.later_ratio:.2f}", *off, *shares


def walkers(count: int, side: float, frames: int, threshold: float, seed: int) -> Preset:
    """Make a preset of walkers in a square, seen from 10 m south of it."""
    options = {"side": min(side, 40.0), "waves": 0.0}
    if side <= 40.0:
        options |= {"centre_x": 0.0, "centre_y": 0.0}
    troupe = {"model": "figure", "count": count, "side": side, "prototypes": 2}
    return preset_from(
        {
            "seed": seed,
            "camera": {"position": (0.0, -side / 2 - 10.0), "height": 2.0},
            "terrain": {"amplitude": 0.0, "reach": 100.0},
            "troupes": {"walker": troupe | {"behaviour": "walk", "options": options}},
            "acting": {"frames": frames, "threshold": threshold},
        }
    )


def saving(count: int, frames: int, threshold: float, seed: int) -> Saving:
    """Let a crowd act in both ways, and compare."""
    side = float(np.sqrt(count / DENSITY))
    presets = [walkers(count, side, frames, each, seed) for each in (0.0, threshold)]
    every, some = (make_cast(each, make_terrain(each)) for each in presets)
    assert every is not None and some is not None
    world, spent = build_world(presets[1]), np.zeros((2, frames))
    off: list[Reals] = []
    updates, parts = 0, np.zeros(2)
    for frame in range(1, frames + 1):
        for way, cast in enumerate((every, some)):
            start = time.process_time()
            cast.performance.frame(frame)
            spent[way, frame - 1] = time.process_time() - start
        updates += int(some.performance.frame(frame).updated.sum())
        if frame % EVERY == 0:
            view = view_at(world, presets[1], frame)
            off.append(sticks_off_px(some, every, view))
            parts += [len(prune(each, view)) for each in (every, some)]
    spent = spent[:, 1:]  # compiling and building fall into the first
    late = spent[:, spent.shape[1] // 2 :].sum(axis=1)
    all_s, some_s = spent.sum(axis=1).tolist()
    return Saving(
        actors=count,
        seconds_all=all_s,
        seconds_some=some_s,
        later_ratio=float(late[0] / late[1]),
        updated=updates / (count * frames),
        off_px=np.concatenate(off),
        parts_ratio=float(parts[1] / max(parts[0], 1)),
    )


def sticks_off_px(shown: Cast, true: Cast, view: View) -> Reals:
    """Compute how far each displayed part of one cast is from where another has it, (p,) [px]."""
    cut = prune(shown, view)
    weights = blend_weights(cut, view)
    there = true.later(cut.parts, view, view.time_s)
    before, now = (
        _pose(cast.appearance(parts, weights), len(cut), view)
        for cast, parts in ((shown, cut.parts), (true, there))
    )
    return displacement_px(initial_state(before), now)


def _pose(sticks: Sticks, parts: int, view: View) -> TruePose:
    due = np.zeros(parts, bool)
    return TruePose(sticks.start, sticks.end, sticks.owner, due, view.camera.eye, view.theta)


def nearest_m(count: int, side: float, frames: int, seed: int) -> Iterator[float]:
    """Let people walk about in a square, and give the least distance of two, frame by frame [m]."""
    preset = walkers(count, side, frames, 0.0, seed)
    cast = make_cast(preset, make_terrain(preset))
    assert cast is not None
    for frame in range(1, frames + 1):
        places = cast.performance.frame(frame).places[:, (X, Y)]
        yield float(cKDTree(places).query(places, 2)[0][:, 1].min())


@click.command("acting")
@click.option("--actors", multiple=True, type=click.IntRange(2, 20_000), default=(300, 1000))
@click.option("--frames", type=click.IntRange(4, 10_000), default=96, show_default=True)
@click.option("--threshold", type=click.FloatRange(0.01, 64), default=0.5, show_default=True)
@click.option("--people", type=click.IntRange(2, 2000), default=200, show_default=True)
@click.option("--seconds", type=click.FloatRange(0.1, 3600), default=60.0, show_default=True)
@click.option("--seed", type=click.IntRange(0, 2**62), default=0, show_default=True)
def command(
    actors: tuple[int, ...],
    frames: int,
    threshold: float,
    people: int,
    seconds: float,
    seed: int,
) -> None:
    """Time actors with and without the temporal metric, and see that nobody walks through another.

    Two of 0.2 m radius overlap where they are less than 0.4 m apart.
    """
    words = "actors|s, all|s, some|saved|later|p99.9 px|max px|updated|parts"
    head = tuple(words.split("|"))
    rows = [saving(count, frames, threshold, seed).row() for count in actors]
    click.echo(table([head, *rows]))
    least = list(nearest_m(people, 40.0, round(24 * seconds), seed))
    overlaps = sum(each < 0.4 for each in least)
    told = f"{people} people in 40 × 40 m for {seconds:g} s: nearest {min(least):.3f} m"
    click.echo(f"\n  {told}, overlapping in {overlaps} of {len(least)} frames")
