"""How do a frame's parts, time and memory grow with K, the world and the pixels? (§4.1)

A preset is swept as it stands, one quantity at a time, by each metric that has a law. Every step
counts a frame by the pruner and predicts it without; time is the processor's, from pruning to plain
arrays, before any renderer, and memory that of these arrays. Exponents are fitted within a field,
and fields are the replicates, so that no time is compared with one of another machine.
"""

import re
import time
from collections.abc import Iterator, Mapping, Sequence
from functools import partial

import numpy as np

from bench.experiment import Case, OwnPreset
from bench.frame_costs import AT_ORIGIN, frame_bytes, plain_frame
from bench.frame_counts import count
from bench.plots import Curve, Panel, Plot, figure
from bench.records.claims import EXACT, Claim, at_most, claim, within
from bench.records.records import Point, Record, columns, grouped, where
from bench.seeds import first_seed
from bench.statistics.estimates import two_sided_mean, two_sided_paired_ratio
from lod.arrays import Reals
from lod.law import LIMITS, max_ground_distance
from scenes.presets.load import load_preset
from scenes.presets.schema import Preset
from scenes.scene import Scene

USUAL = "crowd", ("view.detail=2",)
"""The preset of a run without a user's own, and what is changed in it."""

METRICS = tuple(name for name in LIMITS if name != "full")

MARGIN = 0.05
"""How far an exponent may be from that of the prediction, and a count from the prediction."""

MOST_PARTS = 3e6
"""The predicted parts from which on a step is left out."""

BEYOND = 2.0
"""The side, in limit distances, from which on the world should not matter."""

SWEEPS: Mapping[str, tuple[str, tuple[float, ...]]] = {
    "density": ("K, objects per m²", (0.25, 0.5, 1.0, 2.0, 4.0)),
    "world": ("side of the world (m)", (0.5, 1.0, BEYOND + 0.5, 10.0, 100.0)),
    "pixels": ("pixels of the picture", (160, 320, 640, 1280, 2560)),
}
"""Axis and steps of each sweep: factors on K, sides in limit distances, and widths [px]."""

_DENSEST = 100.0
"""The largest K that a preset may have [1/m²]."""

COSTS = {"cpu_us": "CPU time", "bytes": "memory"}

GROWN = {
    "parts": ("parts displayed", 1.0),
    "cpu_us": ("CPU time before tracing (s)", 1e-6),
    "bytes": ("memory of plain arrays (MB)", 1e-6),
}
"""What is measured at each step: its axis, and its unit in that of the axis."""


def cases(fields: int, unseen: bool, preset: OwnPreset | None = None) -> list[Case]:
    """Return every sweep by every metric in each field, of a preset or the usual one."""
    own = preset or (USUAL[0], load_preset(*USUAL))
    seeds = [first_seed(unseen, 8) + k for k in range(fields)]
    return [
        partial(measure, own, metric, sweep, first)
        for first in seeds
        for metric in METRICS
        for sweep in SWEEPS
    ]


def measure(own: OwnPreset, metric: str, sweep: str, first: int, seed: int) -> list[Point]:
    """Measure every step of a sweep in one field, those with too many parts apart."""
    name, preset = own
    words = f"view.metric={metric}", f"seed={first + 20 * seed}"
    made: list[Point] = []
    densest = max(each.density for each in preset.species.values())
    for step in SWEEPS[sweep][1]:
        if sweep == "density" and step * densest > _DENSEST:
            continue
        x, changes = _step(preset, words, sweep, step)
        scene = Scene(load_preset(preset, (*words, *changes)))
        found = count(scene.world, scene.view(1))
        if (found.parts.predicted or 0.0) > MOST_PARTS:
            continue
        if not made:
            plain_frame(scene)  # compiles, and is not timed
        start = time.process_time()
        plain = plain_frame(scene)
        spent = time.process_time() - start
        counts = {
            "field": [first],
            "parts": [found.parts.displayed],
            "predicted": [round(1e3 * (found.parts.predicted or 0.0))],
            "cpu_us": [round(1e6 * spent)],
            "bytes": [frame_bytes(plain)],
        }
        named = {"topic": "growth", "preset": name, "metric": metric, "sweep": sweep, "x": x}
        made.append(Point(named | {"step": step}, samples=columns(counts)))
    return made


def _step(
    preset: Preset, words: Sequence[str], sweep: str, step: float
) -> tuple[float, tuple[str, ...]]:
    """Return where a step is on its axis, and the settings that make it."""
    K = {name: each.density for name, each in preset.species.items()}
    if sweep == "density":
        changes = (f"species.{name}.density={step * each!r}" for name, each in K.items())
        return step * sum(K.values()), tuple(changes)
    if sweep == "pixels":
        width = int(step)
        return width * (width * 9 // 16), (f"render.size={width}x{width * 9 // 16}",)
    endless = Scene(load_preset(preset, (*words, *AT_ORIGIN)))
    view, kinds = endless.view(1), [each.prototypes for each in endless.world.fields]
    limit = max(max_ground_distance(each.part_tables.hierarchies, view) for each in kinds)
    side = float(f"{2 * step * limit:.3g}")
    return side, (f"world.extent={side!r}", *AT_ORIGIN)


# Claims, from raw points alone.


def _rows(points: Sequence[Point], *quantities: str) -> list[Reals]:
    """Return x and each quantity by field and step, (fields, steps), of steps with all fields."""
    fields = max(len(p.column("field")) for p in points)
    whole = [p for p in points if len(p.column("field")) == fields]
    x = np.tile([float(p.case["x"]) for p in whole], (fields, 1))
    return [x, *(np.array([p.values(each) for p in whole]).T for each in quantities)]


def _exponents(x: Reals, y: Reals) -> Reals:
    """Fit y = a·x^b in each field, (fields, steps), and return every b, (fields,)."""
    pairs = zip(np.log(x), np.log(np.maximum(y, 1.0)), strict=True)
    return np.array([np.polyfit(one, other, 1)[0] for one, other in pairs])


def claims(points: Sequence[Point]) -> Iterator[Claim]:
    """Claim exponents and counts as predicted, and that time and memory grow no faster."""
    made = partial(claim, unit="field", source="§4.1", alone=EXACT)
    for (preset, metric), mine in grouped(points, "preset", "metric").items():
        of = {"preset": preset, "metric": metric}
        sweeps = {sweep: row for (sweep,), row in grouped(mine, "sweep").items() if len(row) > 1}
        for sweep, row in sweeps.items():
            x, parts, told = _rows(row, "parts", "predicted")
            bound = within(round(float(_exponents(x, told).mean()), 3), MARGIN)
            found, against = two_sided_mean(_exponents(x, parts)), SWEEPS[sweep][0].split(",")[0]
            estimand = f"exponent of parts displayed against {against}"
            yield made(estimand, bound, of, found, kind="verification")
        every = [_rows(row, "parts", "predicted", *COSTS)[1:] for row in sweeps.values()]
        parts, told, *costs = (np.hstack(row) for row in zip(*every, strict=True))
        whole = two_sided_paired_ratio(parts.sum(axis=1), told.sum(axis=1) / 1e3)
        yield made("parts displayed ÷ predicted", within(1, MARGIN), of, whole, kind="verification")
        beyond = [p for p in sweeps.get("world", ()) if p.case["step"] > BEYOND]
        for cost, spent in zip(COSTS.values(), costs, strict=True):
            found = two_sided_mean(_exponents(np.maximum(parts, 1.0), spent))
            yield made(f"exponent of {cost} against parts displayed", at_most(1), of, found)
        for quantity, cost in COSTS.items() if len(beyond) > 1 else ():
            found = two_sided_mean(_exponents(*_rows(beyond, quantity)))
            where_ = {**of, "side of the world": f"beyond {BEYOND:g} limit distances"}
            estimand = f"exponent of {cost} against side of the world"
            yield made(estimand, within(0, MARGIN), where_, found)


def plots(record: Record) -> Iterator[Plot]:
    """Draw parts with their prediction, time and memory, against what is swept, by metric."""
    for (preset,), mine in grouped(record.points, "preset").items():
        panels, told = [], []
        for sweep, (axis, _) in SWEEPS.items():
            for quantity, (label, unit) in GROWN.items():
                drawn = []
                for (metric,), row in grouped(where(mine, sweep=sweep), "metric").items():
                    x, found, law = _rows(row, quantity, "predicted")
                    line = (x[0].tolist(), (law.mean(axis=0) / 1e3).tolist())
                    y = (unit * found.mean(axis=0)).tolist()
                    drawn.append(
                        Curve(metric, x[0].tolist(), y, line=line if unit == 1 else ((), ()))
                    )
                    if (quantity, metric) == ("parts", METRICS[0]) and len(row) > 1:
                        told.append(f"{_exponents(x, found).mean():.2f} of {axis.split(',')[0]}")
                panels.append(Panel("", (axis, label), drawn))
        caption = (
            "Means of fields; dashed: parts predicted by the law, without free parameters. Time is "
            "the processor's from pruning to plain arrays, memory that of these arrays."
        )
        title = f"Parts of {preset} by {METRICS[0]} grow with the power {', '.join(told)}"
        yield figure(f"growth-{re.sub('[^a-z0-9]+', '-', preset.lower())}", title, caption, panels)
