"""Time and memory of frames of ever larger worlds, pruned and whole, at an equal picture error.

At the detail τ whose excess FLIP over the whole picture is 0.01, frames of ever larger worlds
(``full_scene``) take turns, whole and pruned: time to a written frame, and the most memory of a
fresh process (``full_turns``), up to the largest whole world within the memory given; pruned ones
go on to 10¹² objects. The detail is found in one world (``full_detail``) and used in all; what it
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
from bench.records.provenance import provenance
from bench.records.records import Point
from bench.statistics.excess_flip import LEAST_PAIRS
from bench.studies.full.equal_error_detail import (
    COARSEST_PX,
    FINEST_PX,
    Searcher,
    detail_of,
    excess_of,
    search,
)
from bench.studies.full.report import plots, table_of, words_of
from bench.studies.full.timed_frames import Runner, largest, started, take_turns
from bench.studies.full.worlds import KINDS, QUICK, Kind, Picture, limit_of, preset_of
from lod.errors import InputError
from scenes.render.mitsuba.variants import choose

START_PX, HALVINGS, SEARCH_SPP = 2.0, 1, 121
QUICK_PICTURE = Picture("32x18", 9)
TAU = click.FloatRange(FINEST_PX, COARSEST_PX)

Say = Callable[[str], object]


@dataclass(frozen=True)
class Effort:
    """picture, turns, most_bytes   of what is timed
    search_spp, halvings            of what finds the detail
    """

    picture: Picture
    turns: int
    most_bytes: int
    search_spp: int
    halvings: int


def found_detail(kind: Kind, effort: Effort, say: Say) -> tuple[float, dict[str, Any]]:
    """τ [px] of equal error, and how it was found: what every detail tried left, and in a larger
    world what the one that was found leaves.
    """
    picture = Picture(effort.picture.size, effort.search_spp)
    searcher = Searcher(kind, kind.searched, picture, LEAST_PAIRS, choose())
    say(f"detail, {kind.searched:g} objects")
    points = search(searcher.measure(), START_PX, effort.halvings)
    found = detail_of(points)
    say(f"detail {found.value:.3f} px, {kind.confirmed:g} objects")
    other = Searcher(kind, kind.confirmed, picture, LEAST_PAIRS, choose()).measure()(found.value)
    tried = {f"{p.case['detail']:.4g}": asdict(excess_of(p)) for p in points}
    return found.value, {
        "detail": asdict(found),
        "objects": kind.searched,
        "spp": effort.search_spp,
        "tried": tried,
        "confirmed": {"objects": kind.confirmed, **asdict(excess_of(other))},
    }


def measured(kind: Kind, detail: float, effort: Effort, say: Say) -> list[Point]:
    """Every world, whole (metric ``full``) and pruned: frames of all of them taking turns."""
    picture, runners = effort.picture, dict[tuple[float, str], Runner]()
    with tempfile.TemporaryDirectory() as folder, ExitStack() as stack:

        def start(objects: float, metric: str) -> Runner:
            say(f"first frame of {objects:.3g} objects, {metric}")
            preset = preset_of(kind, objects, picture, None if metric == "full" else detail)
            return started(stack, Path(folder), preset, effort.most_bytes)

        for objects in kind.worlds:
            runners[objects, "full"] = start(objects, "full")
        if kind.to_the_limit:
            peaks = [runners[each, "full"].peak_bytes for each in kind.worlds]
            last, runner = largest(
                kind.worlds, peaks, effort.most_bytes, lambda objects: start(objects, "full")
            )
            runners[last, "full"] = runner
        for objects in (*(each for each, _ in [*runners]), *kind.beyond):
            runners[objects, "blake"] = start(objects, "blake")
        take_turns([*runners.values()], effort.turns, say)
    limit = limit_of(kind, picture, detail)
    return [_point(kind, *key, picture, limit, runner) for key, runner in runners.items()]


def _point(
    kind: Kind, objects: float, metric: str, picture: Picture, limit: float, runner: Runner
) -> Point:
    side = preset_of(kind, objects, picture, None).world.extent
    case = {"metric": metric, "objects": objects, "side_m": side, "limit_m": limit}
    return Point(case, {}, runner.samples())


def run(name: str, kind: Kind, detail: float | None, effort: Effort, say: Say) -> dict[str, Any]:
    """All of one kind, as plain data."""
    how: dict[str, Any] = {"detail": None, "given": detail}
    if detail is None:
        detail, how = found_detail(kind, effort, say)
    points = measured(kind, detail, effort, say)
    words = json.dumps([asdict(kind), asdict(effort), detail])
    scene = hashlib.sha256(words.encode()).hexdigest()
    threads = os.cpu_count() or 1
    return {
        "kind": name,
        "effort": asdict(effort),
        "tau_px": detail,
        "search": how,
        "points": [asdict(each) for each in points],
        "load": os.getloadavg(),
        "provenance": asdict(provenance(scene, 0, threads, choose())),
    }


def written(folder: Path, found: dict[str, Any]) -> None:
    """The numbers as JSON and the plots as SVG: each file is whole or not there."""
    folder.mkdir(parents=True, exist_ok=True)
    name = found["kind"]
    files = {f"{name}.json": json.dumps(found, indent=1, allow_nan=False) + "\n"}
    files |= {f"{each.name}.svg": each.svg for each in plots(found)}
    for file, text in files.items():
        temporary = folder / f".{file}.part"
        temporary.write_text(text, encoding="utf-8")
        os.replace(temporary, folder / file)


@click.command()
@click.argument("kinds", nargs=-1, type=click.Choice([*KINDS]))
@click.option("-o", "folder", type=click.Path(path_type=Path), metavar="DIR", help="Kept there.")
@click.option("--size", default="320x180", metavar="WxH", show_default=True)
@click.option("--spp", default=64, show_default=True, help="Samples a pixel.")
@click.option("--turns", default=5, type=click.IntRange(2), show_default=True, help="Timed frames.")
@click.option("--max-memory", default="8GB", show_default=True, help="Of the largest whole world.")
@click.option("--detail", type=TAU, help="τ in pixels, instead of the one of equal error.")
@click.option("--quick", is_flag=True, help="Two small worlds: what it prints means nothing.")
def command(
    kinds: tuple[str, ...],
    folder: Path | None,
    size: str,
    spp: int,
    turns: int,
    max_memory: str,
    detail: float | None,
    quick: bool,
) -> None:
    """Measure these KINDS of worlds (all by default), print, and keep where asked."""
    try:
        most = memory_size(max_memory)
        effort = Effort(Picture(size, spp), turns, most, SEARCH_SPP, HALVINGS)
        if quick:
            effort = Effort(QUICK_PICTURE, 3, most, QUICK_PICTURE.spp, 0)
        for name in kinds or KINDS:
            kind = (QUICK if quick else KINDS)[name]
            found = run(name, kind, detail, effort, lambda text: click.echo(text, err=True))
            click.echo(f"\n{words_of(found)}\n{table_of(found)}")
            if folder is not None:
                written(folder, found)
    except InputError as error:
        raise click.UsageError(str(error)) from error
