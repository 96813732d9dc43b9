"""What the updates experiment shows: updates a second against own speed, and a table."""

import numpy as np

from bench.experiment import Table
from bench.experiments.updates.claims import JUDGED_PX, cpu_us, off_px, redrawn
from bench.images.compare import PIXELS_PER_DEGREE
from bench.plots import Curve, Plot, curves
from bench.records.records import Point, Record, where
from lod.motion import critical_hz

FPS = 24.0
FINEST_CPD = PIXELS_PER_DEGREE / 2
"""The finest frequency that a display of so many pixels a degree can show."""


def plots(record: Record) -> tuple[Plot, ...]:
    """Draw how often parts of each class of speed are drawn anew, and what the eye asks for."""
    point = where(record.points, what="schedule", move="rest")[0]
    classes = [c for c in point.samples if c.quantity == "parts" and c.keys]
    lows = [float(c.keys["speed_from"]) for c in classes if any(c.values)]
    lows = [low for low in lows if low > 0]
    speeds = [low * 2**0.5 for low in lows]  # the middle of a class that ends at twice its start
    drawn, words = [], []
    for threshold in JUDGED_PX:
        rates = [FPS * _share(point, threshold, low) for low in lows]
        drawn.append(Curve(f"{threshold:g} px", speeds, rates))
        words.append(f"at {threshold:g} px {rates[0]:.2g} to {rates[-1]:.3g} updates a second")
    degrees = np.array(speeds) * FPS / PIXELS_PER_DEGREE
    eye = critical_hz(degrees, FINEST_CPD).tolist()
    drawn.append(Curve("ω_l + r·u_l (Watson & Ahumada)", speeds, eye))
    span = f"own speeds of {speeds[0]:.2g} to {speeds[-1]:.2g} pixels a frame"
    caption = (
        f"How often parts are drawn anew, 24 frames/s, by threshold; {span}: {'; '.join(words)}. "
        f"The eye asks for {eye[0]:.0f} to {eye[-1]:.0f} (ω_l + r·u_l, Watson & Ahumada 1983, "
        f"at 67 pixels a degree)."
    )
    axis = "own speed on the image (pixels a frame)", "updates a second"
    return (curves("updates", "When parts are drawn again", caption, axis, drawn),)


def _share(point: Point, threshold: float, low: float) -> float:
    anew = sum(point.column("redrawn", rule=f"{threshold:g} px", speed_from=low))
    return anew / sum(point.column("parts", speed_from=low))


def point_table(record: Record) -> Table:
    """Return a table: every camera by every rule; then the time of a frame."""
    heads = "camera", "rule", "parts", "drawn anew", "95 % interval", "farthest off (px)"
    rows = [row for p in where(record.points, what="schedule") for row in _rows(p)]
    return heads, [*rows, *map(_timed, where(record.points, what="time"))]


def _rows(point: Point) -> list[tuple[str, ...]]:
    made: list[tuple[str, ...]] = []
    for rule in (*(f"{t:g} px" for t in JUDGED_PX), "budget"):
        found, parts = redrawn(point, rule), sum(point.column("parts"))
        interval = f"{found.low:.3f}-{found.high:.3f}"
        share = f"{found.value:.3f}"
        row = point.case["move"], rule, str(parts), share, interval, f"{off_px(point, rule):.3f}"
        made.append(row)
    return made


def _timed(point: Point) -> tuple[str, ...]:
    whole, kept = (cpu_us(point, way).mean() / 1e6 for way in ("all", "scheduled"))
    return "time of a frame", f"all {whole:.2f} s", "", f"scheduled {kept:.2f} s", "", ""
