"""Part tests, objects and sticks a second, against the memory bandwidth of the machine.

On one core, in the processor's seconds of one thread: part tests a second, objects turned away,
sticks posed and emitted; against the floor of bytes that must move over the memory's measured
bandwidth. Turned away one by one are objects that were drawn, beyond limits a thirtieth of the
view's; with their cells, all objects of the square of cells that was searched. Both bear the time
of everything: of all cells, and of the few objects that are kept. One core against two is by the
clock. Then a frame from prune to plain scene in ever larger worlds around the same eye, and a
million sticks from cut to ready scene. Repeats take turns; medians with their 95 % interval. Times
of compiling, or loading what is compiled, stand apart.
"""

import math
import time
from collections.abc import Callable, Sequence
from typing import Any

import click
import numba
import numpy as np
import psutil

from bench.cli.output import table
from bench.statistics.estimates import two_sided_median
from bench.statistics.timing import interleaved_seconds
from bench.windows import first_view, plain_scene, scene_bytes, scene_hash
from lod.crossfade import blend_weights
from lod.pruner import prune
from lod.view import View
from scenes.field.cells import candidates, cells_in_reach, search_spans
from scenes.field.species_field import SpeciesField
from scenes.field.traversal import node_limits, traverse
from scenes.frame.frame_input import DisplayedRepresentation, FrameInput, Quality
from scenes.presets.load import load_preset
from scenes.scene import preset_air
from scenes.world.light import sun_and_sky

WORLDS = (1e4, 1e6, 1e9, 1e12, 1e15)
"""The mean number of objects in the window, of the species that a world is named for."""

_OUT_BYTES, _BODY_BYTES = 12, 56
"""The bytes that a traversal writes for each displayed part, and reads of each object."""

_FAR = 30.0
"""The factor on detail at which hardly anything of a view's cells is displayed."""

Rows = list[tuple[Any, ...]]


def memory_bandwidth(repeats: int) -> float:
    """Measure the bytes a second that one core moves; a copy both reads and writes."""
    source = np.ones(2**25)
    target = np.zeros_like(source)
    (seconds,) = interleaved_seconds([lambda: np.copyto(target, source)], repeats)
    return 2 * source.nbytes / float(np.median(seconds))


def rate_text(count: int, seconds: Sequence[float]) -> str:
    """Write millions a second, with the interval of the median and the unit."""
    return f"{two_sided_median(count / np.array(seconds) / 1e6):.1f} M/s"


def species_rows(name: str, field: SpeciesField, view: View, repeats: int, speed: float) -> Rows:
    """Time one species: part tests, objects turned away, sticks emitted."""
    cut = prune(field, view)
    instances, weights = cut.parts.state.instances, blend_weights(cut, view)
    nodes, pose_tables = field.prototypes.traversal_tables, field.prototypes.pose_tables
    limits = node_limits(nodes, field.prototypes.part_tables, view, 0.0)
    still = np.zeros(len(instances))
    coarse = View(view.camera, view.metric, view.detail * _FAR, view.offscreen_detail)
    bounds, beyond = field.search_bounds(view), field.search_bounds(coarse)

    def turn_away() -> tuple[Any, int]:
        cells = cells_in_reach(field.cells, view, bounds)
        return candidates(field.cells, view, beyond, cells)

    kept, away, searched = len(turn_away()[0]), turn_away()[1], objects_searched(field, view)
    tests = traverse(pose_tables, nodes, limits, instances, still, view).examined
    sticks = len(field.appearance(cut.parts, weights))
    tasks: list[Callable[[], Any]] = [
        lambda: traverse(pose_tables, nodes, limits, instances, still, view),
        turn_away,
        lambda: field.appearance(cut.parts, weights),
        lambda: blend_weights(cut, view),
    ]
    test_s, away_s, emit_s, look_s = interleaved_seconds(tasks, repeats)
    floor = (len(cut) * _OUT_BYTES + len(instances) * _BODY_BYTES) / speed
    one, any_way = (two_sided_median(np.array(away_s) * 1e9 / n) for n in (away, searched))
    return [
        (f"{name}: part tests", f"{tests:,}", rate_text(tests, test_s)),
        (f"{name}: time ÷ floor", "", f"{np.median(test_s) / floor:.1f}"),
        (
            f"{name}: turned away one by one ({kept:,} kept)",
            f"{away:,}",
            f"{one:.1f} ns each",
        ),
        (f"{name}: and with their cells", f"{searched:,}", f"{any_way:.1f} ns each"),
        (f"{name}: sticks posed and emitted", f"{sticks:,}", rate_text(sticks, emit_s)),
        (f"{name}: parts blended", f"{len(cut):,}", rate_text(len(cut), look_s)),
    ]


def objects_searched(field: SpeciesField, view: View) -> int:
    """Count the objects of all cells that a search goes through, inside the window."""
    x0, x1, y0, y1 = search_spans(field.cells, view, field.search_bounds(view))
    x, y = (each.ravel() for each in np.meshgrid(np.arange(x0, x1), np.arange(y0, y1)))
    many = 1 << 16
    runs = ((x[at : at + many], y[at : at + many]) for at in range(0, len(x), many))
    return sum(len(field.cells.sample(*run)) for run in runs)


def thread_rows(name: str, field: SpeciesField, view: View, repeats: int) -> Rows:
    """Time the traversal of a species on one core and on two, by the clock, taking turns."""
    spent: dict[int, list[float]] = {1: [], 2: []}
    for _ in range(repeats):
        for count, seconds in spent.items():
            numba.set_num_threads(count)
            start = time.perf_counter()
            field.cut(view)
            seconds.append(time.perf_counter() - start)
    numba.set_num_threads(1)
    found = two_sided_median(np.array(spent[1]) / np.array(spent[2]))
    return [(f"{name}: prune on two cores, times as fast", "", f"{found:.2f}")]


def world_rows(name: str, species: str, size: str, repeats: int) -> Rows:
    """Time one frame in ever larger worlds around one eye, with bytes and hash of its scene."""
    cases, made = [], []
    for objects in WORLDS:
        density = load_preset(name).species[species].density
        side = min(math.sqrt(objects / density), 1e15)
        world, preset, view = first_view(name, size, f"world.extent={side!r}")
        cases.append(lambda w=world, p=preset, v=view: plain_scene(w, p, v))
        made.append(plain_scene(world, preset, view))
    seconds = interleaved_seconds(cases, repeats)
    last = np.array(seconds[-1])
    rows: Rows = [("objects in the window", "scene MB", "hash", "s", "÷ the largest world's")]
    for objects, each, spent in zip(WORLDS, made, seconds, strict=True):
        among = f"{two_sided_median(np.array(spent) / last):.3f}"
        megabytes = f"{scene_bytes(each) / 1e6:.1f}"
        rows.append(
            (f"{objects:.0e}", megabytes, scene_hash(each), f"{np.median(spent):.3f}", among)
        )
    return rows


def ready_scene_rows(variant: str, size: str, repeats: int) -> Rows:
    """Measure wall seconds and memory from a cut to a ready scene, for a million sticks.

    All cores work. A smaller scene comes first, so that nothing is loaded or compiled while it is
    timed. Memory is what the first of the repeats takes.
    """
    from scenes.render.render import build_frame
    from scenes.render.variants import choose

    process, quality = psutil.Process(), Quality(choose(variant))
    for one, times in (("64x36", 1), (size, repeats)):
        world, preset, view = first_view("crowd", one)
        field, light, air = world.fields[0], sun_and_sky(preset), preset_air(preset)
        cut = prune(field, view)
        spent, grown = [], 0
        for _ in range(times):
            before, start = process.memory_info().rss, time.perf_counter()
            shape = field.appearance(cut.parts, blend_weights(cut, view))
            seen = (DisplayedRepresentation(field.name, cut, shape),)
            held = build_frame(FrameInput(view.camera, seen, air, light, quality)).scene
            spent.append(time.perf_counter() - start)
            grown = grown or process.memory_info().rss - before
            primitives = sum(map(len, held.owners))
            del held, seen
    share = 1e6 / len(shape)
    among = f"{two_sided_median(np.array(spent) * share):.2f} s"
    what = f"cut to ready scene ({primitives:,} primitives), for 1 M sticks"
    return [(what, f"{len(shape):,}", f"{among}, {grown * share / 1e6:.0f} MB")]


@click.command()
@click.option("--quick", is_flag=True, help="Small pictures, eight repeats.")
@click.option("--variant", default="auto", show_default=True, help="For the ready scene.")
@click.option("--ready", "only_ready", is_flag=True, help="Only from cut to ready scene.")
@click.option("--worlds", "only_worlds", is_flag=True, help="Only one frame in larger worlds.")
def command(quick: bool, variant: str, only_ready: bool, only_worlds: bool) -> None:
    """Measure and print."""
    if only_worlds:
        numba.set_num_threads(1)
        print_worlds(quick)
        return
    size, repeats = ("320x180", 8) if quick else ("1280x720", 11)
    last: Rows = [("all cores", "sticks", ""), *ready_scene_rows(variant, size, repeats)]
    if only_ready:
        click.echo(table(last))
        return
    numba.set_num_threads(1)
    start = time.perf_counter()
    meadow, crowd = first_view("meadow", size), first_view("crowd", size)
    plain_scene(*first_view("meadow", "64x36"))
    plain_scene(*first_view("crowd", "64x36"))
    click.echo(f"worlds made, walks compiled or loaded: {time.perf_counter() - start:.1f} s")
    speed = memory_bandwidth(repeats)
    rows: Rows = [("on one core", "how many", "median (95 %)")]
    rows.append(("memory moved by a copy", "", f"{speed / 1e9:.1f} GB/s"))
    for name, (world, _, view), number in (("trees", meadow, 1), ("figures", crowd, 0)):
        rows += species_rows(name, world.fields[number], view, repeats, speed)
        rows += thread_rows(name, world.fields[number], view, repeats)
    click.echo(table(rows))
    print_worlds(quick)
    click.echo("")
    click.echo(table(last))


def print_worlds(quick: bool) -> None:
    """Measure and print one frame in ever larger worlds."""
    size, repeats = ("160x90", 8) if quick else ("320x180", 41)
    for name, species in (("crowd", "figure"), ("forest", "broadleaf")):
        click.echo(f"\nOne frame of {name}, from prune to plain scene")
        click.echo(table(world_rows(name, species, size, repeats)))
