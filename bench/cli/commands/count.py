"""`lodbench count`: prune one frame and hold it against the law; no renderer is needed."""

from dataclasses import asdict
from typing import TYPE_CHECKING, Any

import click

from bench.cli.flags import StrictCommand, memory_flag, preset_from_flags, view_flags
from bench.cli.output import Output, progress_bar, table, tell_first_run
from scenes.processes.memory_limit import peak_rss_bytes

if TYPE_CHECKING:
    from bench.frame_counts import Counts


@click.command("count", cls=StrictCommand)
@view_flags
@memory_flag
@click.option("--frame", type=click.IntRange(1, 999_999), default=1, help="Frame number, from 1.")
def command(preset: str, frame: int, out: Output, max_memory: int | None, **flags: Any) -> None:
    """Count objects and parts of one frame, examined and displayed, beside the prediction."""
    chosen = preset_from_flags(preset, **flags)
    from bench.frame_counts import Stopwatch, count
    from scenes.render.budget import within_budget
    from scenes.render.memory import preflight
    from scenes.scene import Scene

    tell_first_run()
    watch = Stopwatch()
    with watch.stage("build"):
        chosen = within_budget(chosen, (frame,), max_memory, out.note)
        scene = Scene(chosen)
        preflight(scene, (), max_memory)
        world = scene.world
    with progress_bar("step") as show:
        show(0, 1, "estimating memory")
        with watch.stage("estimate"):
            estimated = preflight(scene, (frame,), max_memory)
        ground = estimated.ground if estimated else None
        counts = count(world, scene.view(frame), ground, show)
    seconds = watch.seconds | counts.seconds
    out.record(as_data(counts, seconds))
    _say(out, counts, seconds)


def as_data(counts: "Counts", seconds: dict[str, float]) -> dict[str, Any]:
    """Give what --json prints, by the names that its readers rely on."""
    return {
        "objects": vars(counts.objects),
        "parts": vars(counts.parts),
        "terrain": {
            "tiles": counts.terrain_tiles,
            "triangles": counts.terrain_triangles,
            "predicted": None,  # the law is about objects; the ground has no Poisson prediction
        },
        "by_species": {name: asdict(each) for name, each in counts.by_species.items()},
        "others": {
            name: {"objects": vars(objects), "parts": vars(parts)}
            for name, (objects, parts) in counts.others.items()
        },
        "by_level": list(counts.by_level),
        "detail": counts.detail,
        "m": counts.m,
        "seconds": seconds,
        "peak_rss_bytes": peak_rss_bytes(),
    }


def _say(out: Output, counts: "Counts", seconds: dict[str, float]) -> None:
    rows: list[tuple[object, ...]] = [("", "examined", "displayed", "predicted", "±")]
    tallies = {"objects": counts.objects, "parts": counts.parts}
    for name, each in counts.by_species.items():
        tallies |= {f"{name}: objects": each.objects, f"{name}: parts": each.parts}
    for name, (objects, parts) in counts.others.items():
        tallies |= {f"{name}: objects": objects, f"{name}: parts": parts}
    rows += [(name, *vars(tally).values()) for name, tally in tallies.items()]
    out.say(table(rows))
    levels: list[tuple[object, ...]] = [("parts by level", *range(len(counts.by_level)))]
    levels.append(("", *counts.by_level))
    out.say(f"\n{table(levels)}")
    ground = f"{counts.terrain_tiles:,} tiles, {counts.terrain_triangles:,} triangles"
    took = ", ".join(f"{stage} {spent:.2f} s" for stage, spent in seconds.items())
    out.say(f"\n  terrain: {ground}\n  τ = {counts.detail:g} px, m = {counts.m:.6g} rad\n  {took}")
