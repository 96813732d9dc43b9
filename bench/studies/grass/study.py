"""Time and memory of grass in a frame and by density, and whether it ends with an edge.

Frames of `meadow` with grass and without take turns, each in a process of its own; grass alone is
counted, pruned and posed at several densities by three metrics; and its luminance is held against
that of four times finer detail, by distance, across the limit where far cover takes over.
"""

from itertools import product
from operator import itemgetter
from pathlib import Path
from typing import Any

import click
import numpy as np

from bench.cli.output import counted, table
from bench.records.study_record import study_record, write_study_record
from bench.studies.grass.counts import DENSITIES, METRICS, measure_apart
from bench.studies.grass.edge import (
    EDGES_M,
    FINE,
    HEADINGS_DEG,
    TESTED,
    WIDTH_PX,
    Outlook,
    edge_figures,
)
from bench.studies.grass.frames import PRESET, frame_figures, turns_of_frames
from scenes.render.variants import choose

COUNT_SIZE = "640x360"
"""Size of the picture in which parts are counted: the preset's own."""

QUICK = {"size": "64x36", "spp": 1, "turns": 1, "fields": 1, "width": 160}
QUICK_DENSITIES = 0.0125, 1.25


def counts_by_density(
    densities: tuple[float, ...], size: str, variant: str
) -> list[dict[str, Any]]:
    """Measure every density by every metric, each in a fresh process."""
    rows = []
    for density, metric in counted(
        [*product(densities, METRICS)], "count", lambda each: f"{each[0]:g} tufts, {each[1]}"
    ):
        asked = {"density": density, "metric": metric}
        settings = [f"render.size={size}"]
        rows.append(asked | measure_apart({**asked, "settings": settings, "variant": variant}))
    return rows


def across_the_edge(fields: int, width: int, variant: str) -> dict[str, list[dict[str, Any]]]:
    """Compare both details in every band, toward each heading, in worlds of so many seeds."""
    found: dict[str, list[list[np.ndarray]]] = {sun: [] for sun in HEADINGS_DEG}
    for seed, sun in counted(
        [*product(range(1, 1 + fields), HEADINGS_DEG)], "field", itemgetter(1)
    ):
        look = Outlook(width, HEADINGS_DEG[sun], seed)
        found[sun].append([look.sums(detail, variant) for detail in (TESTED, FINE)])
    return {sun: edge_figures(*np.array(each).swapaxes(0, 1)) for sun, each in found.items()}


def report(figures: dict[str, Any], settings: dict[str, Any]) -> str:
    """Write all three parts as tables."""
    frames = figures["frames"]
    heads = ("", "processor [s]", "clock [s]", "stages [s]", "peak [GB]", "sticks", "triangles")
    rows: list[tuple[Any, ...]] = [heads]
    for name, each in frames.items():
        medians = [each[key]["median"] for key in ("cpu_s", "wall_s", "frame_s", "peak_gb")]
        shapes = (each.get("sticks", "-"), each.get("triangles", "-"))
        rows.append((name, *medians, *shapes))
    counts: list[tuple[Any, ...]] = [
        ("tufts/m²", "metric", "parts", "prune [s]", "pose [s]", "count's peak [MB]")
    ]
    for each in figures["counts"]:
        cost = ("-", "-", "-", "does not fit")
        if "refused" not in each:
            pose = "-" if each["pose_s"] is None else each["pose_s"]
            cost = each["parts"], each["prune_s"], pose, each["peak_bytes"] / 1e6
        counts.append((f"{each['density']:g}", each["metric"], *cost))
    bands = [f"{low:g}–{high:g} m" for low, high in zip(*edges_of(settings["width"]), strict=True)]
    edge: list[tuple[Any, ...]] = [("sun", "luminance ÷ finer", *bands)]
    for sun, row in figures["edge"].items():
        for key in ("luminance", "low", "high", "rays"):
            edge.append((sun, key, *("-" if b[key] is None else f"{b[key]:.3f}" for b in row)))
    return "\n\n".join(table(each) for each in (rows, counts, edge))


def edges_of(width: int) -> tuple[list[float], list[float]]:
    """Return where bands begin and end in pictures so wide [m]."""
    edges = [each * width / WIDTH_PX for each in EDGES_M]
    return edges[:-1], edges[1:]


@click.command("grass")
@click.option("--size", default="1280x720", metavar="WxH", show_default=True, help="Of frames.")
@click.option("--spp", default=64, show_default=True, help="Samples a pixel of frames.")
@click.option("--turns", type=click.IntRange(1), default=3, show_default=True)
@click.option("--fields", type=click.IntRange(1), default=4, show_default=True, help="At the edge.")
@click.option("--quick", is_flag=True, help="Tiny pictures and two densities: that it works.")
@click.option("--record", type=click.Path(path_type=Path), help="A file for the figures.")
def command(size: str, spp: int, turns: int, fields: int, quick: bool, record: Path | None) -> None:
    """Measure what grass costs a frame, by density, and whether it has an edge."""
    variant = choose()
    settings: dict[str, Any] = {
        "preset": PRESET,
        "size": size,
        "spp": spp,
        "turns": turns,
        "fields": fields,
        "width": WIDTH_PX,
        **(QUICK if quick else {}),
        "count_size": QUICK["size"] if quick else COUNT_SIZE,
        "densities": list(QUICK_DENSITIES if quick else DENSITIES),
    }
    frames = turns_of_frames(settings["size"], settings["spp"], settings["turns"], variant)
    densities, count_size = tuple(settings["densities"]), settings["count_size"]
    figures = {
        "frames": frame_figures(frames),
        "counts": counts_by_density(densities, count_size, variant),
        "edge": across_the_edge(settings["fields"], settings["width"], variant),
    }
    click.echo(report(figures, settings))
    if record:
        write_study_record(record, study_record("grass", settings, figures, variant))
