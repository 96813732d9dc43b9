"""What the cost experiment shows: time of every stage, and a table with memory."""

from collections.abc import Sequence

import numpy as np

from bench.experiment import Table
from bench.experiments.cost.claims import (
    SET_UP,
    STAGES,
    own_frame_us,
    own_frames,
    peak_bytes,
    set_up_us,
    stage_us,
    trace_us,
)
from bench.images.compare import errors
from bench.plots import Curve, Plot, curves
from bench.records.records import Point, Record, grouped, where


def plots(record: Record) -> tuple[Plot, ...]:
    """Draw the time of every stage of every warm frame, and that of larger worlds."""
    frames, _ = own_frames(record.points)
    count = len(own_frame_us(frames))
    x = [float(n + 1) for n in range(count)]
    drawn = [
        Curve(name, x, (np.maximum(stage_us(frames, stage), 1) / 1e6).tolist())
        for stage, name in (*STAGES.items(), ("metric", "the metric alone"))
    ]
    words = "; ".join(f"{c.label}: {np.median(c.y):.3g} s" for c in drawn)
    caption = (
        f"Seconds of every stage in {count} frames of meadow that no longer compile, 320 × 180, 8 "
        f"samples a pixel. Medians: {words}; a whole frame "
        f"{np.median(own_frame_us(frames)) / 1e6:.3g} s. The metric alone is three "
        "squares, a root and a comparison for each part examined."
    )
    axis = "frame", "seconds"
    scales = "linear", "log"
    stages = curves("stages", "A frame, stage by stage", caption, axis, drawn, scales)
    kinds = grouped(where(record.points, what="size"), "kind")
    return (stages, *(_by_size(kind, points) for (kind,), points in kinds.items()))


def _by_size(kind: str, points: Sequence[Point]) -> Plot:
    """Draw set-up and trace of both sides against the objects of a world."""
    drawn = []
    for (side,), row in grouped(points, "side").items():
        for name, of_frames in (("set-up", set_up_us), ("trace", trace_us)):
            seconds = [max(float(np.median(of_frames(p))), 1.0) / 1e6 for p in row]
            drawn.append(Curve(f"{name}, {side}", [float(p.case["objects"]) for p in row], seconds))
    words = "; ".join(f"{c.label}: {', '.join(f'{y:.3g}' for y in c.y)} s" for c in drawn)
    caption = (
        f"Seconds of a frame of {kind}, pruned at one pixel and whole, against the objects of its "
        f"world; set-up is pruning, posing, describing and building, medians. {words}. Time to "
        "trace hardly depends on pruning: what pruning saves is set-up and memory."
    )
    axis = "objects in the world", "seconds"
    return curves(f"sizes-{kind}", f"Larger worlds: {kind}", caption, axis, drawn)


def summary(record: Record) -> Table:
    """Return a table: every stage, memory and error of each side of every size of world."""
    stages = {k: STAGES[k] for k in (*SET_UP, "trace")}
    heads = ("world", "objects", "side", *(f"{name} (s)" for name in stages.values()))
    rows = []
    for point in where(record.points, what="size"):
        case = point.case
        times = [np.median(stage_us(point, stage)) / 1e6 for stage in stages]
        error = "" if case["side"] == "whole" else f"{errors(point).mean():.4f}"
        held = f"{np.median(peak_bytes(point)) / 1e6:.0f}", error
        place = case["kind"], f"{case['objects']:g}", case["side"]
        rows.append((*place, *(f"{each:.3f}" for each in times), *held))
    return (*heads, "memory (MB)", "FLIP without noise"), rows


def point_table(record: Record) -> Table:
    """Return a table: median, least and most of everything timed, and the memory held."""
    frames, processes = own_frames(record.points)
    whole = float(np.median(own_frame_us(frames)))
    names = {**STAGES, "metric": "the metric alone", "haze": "haze, in rendering"}
    rows = [_row(name, stage_us(frames, k) / 1e6, whole / 1e6) for k, name in names.items()]
    warm = float(np.median(stage_us(frames, "trace")))
    first = processes.values("first_trace")
    rows.append(_row("set-up of hierarchies", processes.values("world") / 1e6, None))
    rows.append(_row("compiling, in the first render", (first - warm) / 1e6, None))
    for key, after in (("world", "set-up"), ("shoot", "pruning and posing"), ("render", "a frame")):
        held = np.median(processes.values(f"{key}_bytes")) / 1e6
        rows.append((f"most memory held after {after}", f"{held:.0f} MB", "", "", ""))
    return ("what", "median", "least", "most", "share of a frame"), rows


def _row(name: str, seconds: np.ndarray, whole: float | None) -> tuple[str, ...]:
    middle = float(np.median(seconds))
    share = f"{100 * middle / whole:.2g} %" if whole else ""
    return (name, *(f"{v:.4g} s" for v in (middle, seconds.min(), seconds.max())), share)
