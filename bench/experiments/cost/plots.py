"""What the cost experiment shows: time of every stage, and a table with memory."""

import numpy as np

from bench.experiments.cost.claims import STAGES, frame_us, stage_us
from bench.plots.plot import Curve, Plot, curves
from bench.records.records import Record
from bench.runner.experiment import Table


def plots(record: Record) -> tuple[Plot, ...]:
    """Draw the time of every stage of every warm frame."""
    frames = record.points[0]
    count = len(frame_us(frames))
    x = [float(n + 1) for n in range(count)]
    drawn = [
        Curve(name, x, (np.maximum(stage_us(frames, stage), 1) / 1e6).tolist())
        for stage, name in (*STAGES.items(), ("metric", "the metric alone"))
    ]
    words = "; ".join(f"{c.label}: {np.median(c.y):.3g} s" for c in drawn)
    caption = (
        f"Seconds of every stage in {count} frames of meadow that no longer compile, 320 × 180, 8 "
        f"samples a pixel. Medians: {words}; a whole frame {np.median(frame_us(frames)) / 1e6:.3g} "
        "s. The metric alone is three squares, a root and a comparison for each part examined."
    )
    axis = "frame", "seconds"
    return (curves("stages", "A frame, stage by stage", caption, axis, drawn, ("linear", "log")),)


def point_table(record: Record) -> Table:
    """Return a table: median, least and most of everything timed, and the memory held."""
    frames, processes = record.points
    whole = float(np.median(frame_us(frames)))
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
