"""Time and memory of frames of ever larger worlds, pruned and whole, at an equal picture error.

At the detail τ whose excess FLIP over the whole picture is 0.01, frames of ever larger worlds
(``worlds``) take turns, whole and pruned: time to a written frame, and the most memory of a fresh
process (``timed_frames``), up to the largest whole world within the memory given; pruned ones go on
to 10¹² objects. The detail is found in one world (``equal_error_detail``) and used in all; what it
leaves in a larger one is measured, too. Ratios and exponents have 95 % intervals over turns.

More pixels or samples bring the ratio of times nearer to 1: most of a pruned frame is its trace,
which hardly grows with the world. Wall-clock seconds, all cores.
"""

import hashlib
import json
import os
import tempfile
from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import click

from bench.cli.frame_flags import memory_size
from bench.fields.windows import Picture
from bench.records.points import Point, columns, point_json
from bench.records.provenance import provenance
from bench.statistics.excess_flip import LEAST_PAIRS
from bench.studies.full.equal_error_detail import (
    COARSEST_PX,
    FINEST_PX,
    DetailSearch,
    detail_at_equal_error,
    excess_flip,
    search_detail,
)
from bench.studies.full.report import PLOTS, plots, results_table, summary_text
from bench.studies.full.timed_frames import (
    FrameProcess,
    interleave_frames,
    largest_world,
    start_process,
)
from bench.studies.full.worlds import KINDS, QUICK, Kind, limit_distance, world_preset
from lod.errors import InputError
from scenes.render.files.frame_paths import make_folder
from scenes.render.files.whole_file import check_free, made_by_lodbench, whole_file
from scenes.render.mitsuba.variants import choose

START_PX, HALVINGS, SEARCH_SPP = 2.0, 1, 121
QUICK_PICTURE = Picture("32x18", 9)
TAU = click.FloatRange(FINEST_PX, COARSEST_PX)

Say = Callable[[str], object]


@dataclass(frozen=True)
class Effort:
    """How much is measured.

    picture                  size and samples of the timed frames
    turns                    how many frames are timed in each world
    most_bytes               the memory that they may take
    search_spp, halvings     samples and steps of the search for the detail
    """

    picture: Picture
    turns: int
    most_bytes: int
    search_spp: int
    halvings: int


def find_detail(kind: Kind, effort: Effort, say: Say) -> tuple[float, dict[str, Any]]:
    """Find the detail τ [px] of equal error.

    Also gives, as plain data, the error of every detail that was tried, and the error that the one
    found leaves in a larger world.
    """
    picture = Picture(effort.picture.size, effort.search_spp)
    searcher = DetailSearch(kind, kind.searched, picture, LEAST_PAIRS, choose())
    say(f"detail, {kind.searched:g} objects")
    points = search_detail(searcher.measure(), START_PX, effort.halvings)
    found = detail_at_equal_error(points)
    say(f"detail {found.value:.3f} px, {kind.confirmed:g} objects")
    other = DetailSearch(kind, kind.confirmed, picture, LEAST_PAIRS, choose()).measure()(
        found.value
    )
    tried = {f"{p.case['detail']:.4g}": asdict(excess_flip(p)) for p in points}
    return found.value, {
        "detail": asdict(found),
        "objects": kind.searched,
        "spp": effort.search_spp,
        "tried": tried,
        "confirmed": {"objects": kind.confirmed, **asdict(excess_flip(other))},
    }


def measure_worlds(kind: Kind, detail: float, effort: Effort, say: Say) -> list[Point]:
    """Time every world, whole (metric ``full``) and pruned, frames of all of them taking turns."""
    picture, runners = effort.picture, dict[tuple[float, str], FrameProcess]()
    with tempfile.TemporaryDirectory() as folder, ExitStack() as stack:

        def start(objects: float, metric: str) -> FrameProcess:
            say(f"first frame of {objects:.3g} objects, {metric}")
            preset = world_preset(kind, objects, picture, None if metric == "full" else detail)
            return start_process(stack, Path(folder), preset, effort.most_bytes)

        for objects in kind.worlds:
            runners[objects, "full"] = start(objects, "full")
        if kind.to_the_limit:
            peaks = [runners[each, "full"].peak_bytes for each in kind.worlds]
            last, runner = largest_world(
                kind.worlds, peaks, effort.most_bytes, lambda objects: start(objects, "full")
            )
            runners[last, "full"] = runner
        for objects in (*(each for each, _ in [*runners]), *kind.beyond):
            runners[objects, "blake"] = start(objects, "blake")
        interleave_frames([*runners.values()], effort.turns, say)
    limit = limit_distance(kind, picture, detail)
    return [_point(kind, *key, picture, limit, runner) for key, runner in runners.items()]


def _point(
    kind: Kind, objects: float, metric: str, picture: Picture, limit: float, runner: FrameProcess
) -> Point:
    side = world_preset(kind, objects, picture, None).world.extent
    case = {"metric": metric, "objects": objects, "side_m": side, "limit_m": limit}
    return Point(case, samples=columns(runner.samples()))


def run(name: str, kind: Kind, detail: float | None, effort: Effort, say: Say) -> dict[str, Any]:
    """Measure all worlds of one kind, as plain data."""
    how: dict[str, Any] = {"detail": None, "given": detail}
    if detail is None:
        detail, how = find_detail(kind, effort, say)
    points = measure_worlds(kind, detail, effort, say)
    words = json.dumps([asdict(kind), asdict(effort), detail])
    scene = hashlib.sha256(words.encode()).hexdigest()
    threads = os.cpu_count() or 1
    return {
        "kind": name,
        "effort": asdict(effort),
        "tau_px": detail,
        "search": how,
        "points": [point_json(each) for each in points],
        "load": os.getloadavg(),
        "provenance": asdict(provenance(scene, 0, threads, choose())),
    }


def write_results(folder: Path, found: dict[str, Any]) -> None:
    """Write the numbers as JSON and the plots as SVG; each file is whole or not there."""
    numbers, *figures = result_files(folder, found["kind"])
    files = {numbers: json.dumps(found, indent=1, allow_nan=False) + "\n"}
    files |= {path: each.svg for path, each in zip(figures, plots(found), strict=True)}
    for path, text in files.items():
        with whole_file(path, overwrite=True) as temporary:
            temporary.write_text(text, encoding="utf-8")


def check_results(folder: Path, kinds: tuple[str, ...], overwrite: bool) -> None:
    """Raise InputError where files of others stand in the way, unless ``overwrite``."""
    for kind in kinds:
        numbers, *figures = result_files(folder, kind)
        for path in (numbers, *figures):
            check_free(path, overwrite or made_by_lodbench(numbers))


def result_files(folder: Path, kind: str) -> list[Path]:
    """Name the files in which the results of a kind of worlds are kept, the numbers first."""
    return [folder / f"{kind}.json", *(folder / f"{kind}-{name}.svg" for name in PLOTS)]


@click.command()
@click.argument("kinds", nargs=-1, type=click.Choice([*KINDS]))
@click.option("-o", "folder", type=click.Path(path_type=Path), metavar="DIR", help="Kept there.")
@click.option("--size", default="320x180", metavar="WxH", show_default=True)
@click.option("--spp", default=64, show_default=True, help="Samples a pixel.")
@click.option("--turns", default=5, type=click.IntRange(2), show_default=True, help="Timed frames.")
@click.option("--max-memory", default="8GB", show_default=True, help="Of the largest whole world.")
@click.option("--detail", type=TAU, help="τ in pixels, instead of the one of equal error.")
@click.option("--quick", is_flag=True, help="Two small worlds: what it prints means nothing.")
@click.option("--overwrite", is_flag=True, help="Replace files that this study did not make.")
def command(
    kinds: tuple[str, ...],
    folder: Path | None,
    turns: int,
    max_memory: str,
    detail: float | None,
    quick: bool,
    overwrite: bool,
    **picture: Any,
) -> None:
    """Measure these KINDS of worlds (all by default), print, and keep where asked."""
    try:
        most = memory_size(max_memory)
        if folder is not None:
            check_results(make_folder(folder), kinds or tuple(KINDS), overwrite)
        effort = Effort(Picture(**picture), turns, most, SEARCH_SPP, HALVINGS)
        if quick:
            effort = Effort(QUICK_PICTURE, 3, most, QUICK_PICTURE.spp, 0)
        for name in kinds or KINDS:
            kind = (QUICK if quick else KINDS)[name]
            found = run(name, kind, detail, effort, lambda text: click.echo(text, err=True))
            click.echo(f"\n{summary_text(found)}\n{results_table(found)}")
            if folder is not None:
                write_results(folder, found)
    except InputError as error:
        raise click.UsageError(str(error)) from error
