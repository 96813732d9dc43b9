"""What posing a crowd costs: ``python -m bench.studies.posing [-o FILE] [--quick]``.

Sticks posed in a second on one core, by the walk alone and with all that is handed to the renderer;
the same of the first frame of the preset ``crowd``, with all that it takes before: finding and
placing the walkers, pruning, the origins of their parts; and the cost of a displayed part as the
field grows from 10⁴ to 10⁶ figures under the same eye, and as the same eye resolves more of them.
Repeats of all cases take turns; times of compiling stand
apart. Seconds are those of the processor, all of it in one thread, so that what else runs there
counts little; they are facts of one machine.
"""

import json
import math
import time
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import click
import numpy as np
from numba import set_num_threads

from bench.cli.output import table
from bench.records.provenance import provenance
from bench.statistics.estimates import median
from lod.camera import Corner, camera_from_heading
from lod.pruning.crossfade import blend_weights
from lod.pruning.parts import BlendWeights
from lod.pruning.pruner import Cut, prune
from lod.pruning.view import View
from scenes.field.species_field import Species, SpeciesField
from scenes.models.catalogue import people
from scenes.plugins.entry_points import metric_named
from scenes.preset.load import load_preset
from scenes.rig.pose import pose_sticks
from scenes.terrain.terrain import Terrain
from scenes.world.world import build_world, view_at

DENSITY = 0.025
"""Walkers per m²: about 10⁵ within the limit distance of a person, 1.15 km at one pixel."""

PATROL_M, EYE_M, SEED = 20.0, 1.6, 7
WINDOWS = (1e4, 3e4, 1e5, 3e5, 1e6)
"""Figures in the field."""

COARSE_PX = 4.2
"""Detail at which the limit distance of every person is within the smallest window."""

SHARP_PX = 0.9
"""Detail at which more than 10⁵ walkers are displayed."""

FINER_PX = (8.0, 4.0, 2.0, 1.0)
_FLAT = Terrain(seed=0, amplitude=0.0, wavelength=1024.0, hurst=1.0, reach=1000.0)
_TARGET = 10e6


@dataclass(frozen=True)
class Row:
    """One case: its name, what it handles, and the processor's seconds of every repeat."""

    case: str
    figures: int
    parts: int
    sticks: int
    seconds: list[float]

    def per(self, number: int) -> str:
        """Nanoseconds for each of so many, with the interval of the median."""
        found = median(np.array(self.seconds) * 1e9 / number)
        return f"{found.value:.1f} ({found.low:.1f} to {found.high:.1f})"


def crowd(figures: float | None) -> SpeciesField:
    """Walkers in a square window that holds so many on average; without end where None."""
    side = None if figures is None else math.sqrt(figures / DENSITY)
    return SpeciesField(Species("figure", people(0, 8), DENSITY, PATROL_M), SEED, _FLAT, side)


def view(detail: float, metric: str = "blake") -> View:
    """From eye height, all round, a while after everyone set out."""
    camera = camera_from_heading(
        Corner(0, 0), np.array((0.0, 0.0, EYE_M)), 0.0, 0.0, 60.0, (640, 360)
    )
    return View(camera, metric_named(metric), detail, look_around=True, time_s=100.0)


def interleaved(tasks: Sequence[Callable[[], Any]], repeats: int) -> list[list[float]]:
    """The processor's seconds of every repeat of each task, the tasks taking turns."""
    seconds: list[list[float]] = [[] for _ in tasks]
    for _ in range(repeats):
        for task, times in zip(tasks, seconds, strict=True):
            start = time.thread_time()
            task()
            times.append(time.thread_time() - start)
    return seconds


def posing_rows(repeats: int, share: float) -> list[Row]:
    """Posing what is displayed of 10⁵ walkers, and every part of 10⁴: the walk, and emitting."""
    rows = []
    near, far = ("every part", 1e4, "full"), ("as displayed", 1.3e5, "blake")
    for name, figures, metric in (far, near):
        field = crowd(figures * share)
        seen = view(SHARP_PX, metric)
        cut = prune(field, seen)
        walk, sticks = _walk(field, cut, blend_weights(cut, seen))
        shown = blend_weights(cut, seen)
        tasks = walk, lambda field=field, cut=cut, shown=shown: field.appearance(cut.parts, shown)
        for task, seconds in zip(("walk", "emit"), interleaved(tasks, repeats), strict=True):
            counts = cut.displayed_objects, cut.displayed_parts, sticks
            rows.append(Row(f"{task}, {name}", *counts, seconds))
    return rows


def preset_rows(repeats: int) -> list[Row]:
    """The first frame of the preset ``crowd``, people alone: each step, and all of them."""
    preset = load_preset("crowd", ["species.tree.density=0"])
    world = build_world(preset)
    (field,), seen = world.fields, view_at(world, preset, 1)
    cut = prune(field, seen)
    shown = blend_weights(cut, seen)
    sticks = len(field.appearance(cut.parts, shown))

    def whole() -> Any:
        fresh = prune(field, seen)
        return field.appearance(fresh.parts, blend_weights(fresh, seen))

    tasks = {
        "find, place and prune": lambda: prune(field, seen),
        "of which place": lambda: field.later(cut.parts, seen, seen.time_s),
        "origins of parts": cut.tell,
        "pose and emit": lambda: field.appearance(cut.parts, shown),
        "all of it": whole,
    }
    seconds = interleaved(list(tasks.values()), repeats)
    counts = cut.displayed_objects, cut.displayed_parts, sticks
    return [Row(name, *counts, times) for name, times in zip(tasks, seconds, strict=True)]


def _walk(field: SpeciesField, cut: Cut, shown: BlendWeights) -> tuple[Callable[[], Any], int]:
    """The compiled walk over the sticks of a cut, ready to go, and how many they are."""
    atlas, pose_tables = field.troupe.atlas, field.troupe.pose_tables
    order = np.argsort(cut.parts.object, kind="stable")
    ordered = shown.take(order)
    owner, stick, _, _ = atlas.sticks_of(cut.parts.part[order], ordered)
    rows, instances = cut.parts.object[order][owner], cut.parts.state.instances
    columns = (getattr(atlas.sticks, k) for k in ("start", "end", "start_joint", "end_joint"))
    start, end, start_joint, end_joint = columns

    def walk() -> Any:
        return pose_sticks(pose_tables, instances, rows, stick, start, end, start_joint, end_joint)

    return walk, len(stick)


def frame_rows(cases: Sequence[tuple[str, SpeciesField, View]], repeats: int) -> list[Row]:
    """Whole frames, from the field to its sticks: searched, pruned, posed and emitted."""

    def frame(field: SpeciesField, seen: View) -> tuple[Cut, int]:
        cut = prune(field, seen)
        return cut, len(field.appearance(cut.parts, blend_weights(cut, seen)))

    cuts = [frame(field, seen) for _, field, seen in cases]
    tasks = [lambda field=f, seen=v: frame(field, seen) for _, f, v in cases]
    return [
        Row(name, cut.displayed_objects, cut.displayed_parts, sticks, seconds)
        for (name, _, _), (cut, sticks), seconds in zip(
            cases, cuts, interleaved(tasks, repeats), strict=True
        )
    ]


def growing(share: float) -> list[tuple[str, SpeciesField, View]]:
    """The same eye in ever larger fields."""
    fields, detail = [n * share for n in WINDOWS], COARSE_PX / math.sqrt(share)
    return [(f"{n:,.0f} in the field", crowd(n), view(detail)) for n in fields]


def resolving(share: float) -> list[tuple[str, SpeciesField, View]]:
    """The same field, without end, through ever sharper eyes."""
    details = [px / math.sqrt(share) for px in FINER_PX]
    return [(f"detail {px:.3g} px", crowd(None), view(px)) for px in details]


def flatness(rows: Sequence[Row]) -> tuple[float, float, float]:
    """Cost of a displayed part in the last row over that in the first, repeat by repeat, with the
    95 % interval of the median.
    """
    last, first = (np.array(row.seconds) / row.parts for row in (rows[-1], rows[0]))
    found = median(last / first)
    return found.value, found.low, found.high


def _shown(title: str, rows: Sequence[Row], per_stick: bool) -> str:
    heads = ("case", "figures displayed", "parts", "sticks", "median s", "ns a part (95 %)")
    lines: list[tuple[Any, ...]] = [(*heads, "M sticks/s" if per_stick else "ns a stick (95 %)")]
    for row in rows:
        middle = float(np.median(row.seconds))
        last = f"{row.sticks / middle / 1e6:.1f}" if per_stick else row.per(row.sticks)
        counts = row.figures, row.parts, row.sticks
        lines.append((row.case, *counts, f"{middle:.4f}", row.per(row.parts), last))
    return f"\n{title}\n{table(lines)}"


def run(repeats: int, share: float) -> dict[str, Any]:
    """All cases; ``share`` of the full number of figures."""
    set_num_threads(1)
    start = time.perf_counter()
    seen = view(1.0)
    cut = prune(crowd(20.0), seen)
    crowd(20.0).appearance(cut.parts, blend_weights(cut, seen))
    compiling = time.perf_counter() - start
    return {
        "compiling_s": compiling,
        "posing": posing_rows(repeats, share),
        "preset": preset_rows(repeats),
        "growing": frame_rows(growing(share), repeats),
        "resolving": frame_rows(resolving(share), repeats),
    }


@click.command()
@click.option("-o", "path", metavar="FILE", help="Write the numbers there, as JSON.")
@click.option("--quick", is_flag=True, help="A twentieth of the figures, eight repeats.")
def main(path: str | None, quick: bool) -> None:
    """Measure, print, and write where asked."""
    found = run(*((8, 0.05) if quick else (11, 1.0)))
    told = f"Making the walkers and compiling, or loading what is: {found['compiling_s']:.1f} s"
    click.echo(told)
    target = f"Posing, one core (target {_TARGET / 1e6:g} M sticks/s)"
    click.echo(_shown(target, found["posing"], per_stick=True))
    click.echo(_shown("The preset crowd, frame 1", found["preset"], per_stick=True))
    for name, title in (("growing", "The field grows"), ("resolving", "The eye resolves more")):
        click.echo(_shown(title, found[name], per_stick=False))
        value, low, high = flatness(found[name])
        click.echo(f"cost of a part, last ÷ first: {value:.3f} ({low:.3f} to {high:.3f})")
    if path:
        rows = {k: [asdict(row) for row in found[k]] for k in found if k != "compiling_s"}
        origin = asdict(provenance("walkers", SEED))
        body = {"quick": quick, "compiling_s": found["compiling_s"], **rows, "provenance": origin}
        Path(path).write_text(json.dumps(body, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
