"""What the rivals experiment shows: error against time and memory for every arm.

Tables of the rivals experiment: who wins where, what pruning helps, and how faithful it is.
"""

import math
from collections.abc import Callable, Iterator, Sequence
from typing import Any

import numpy as np

from bench.experiment import Table
from bench.experiments.rivals.measure import JUDGED
from bench.images.compare import PAIR_BANDS
from bench.images.equal_error import EQUAL_ERROR
from bench.methods.comparison import (
    STAGES,
    AtEqualError,
    at_equal_error,
    at_equal_time,
    beside_best_rival,
    excess,
    frame_seconds,
    is_measured,
    judged_error,
    least_covered,
    megabytes,
)
from bench.plots import Curve, Plot, curves
from bench.records.records import Point, Record, grouped, where
from bench.statistics.estimates import two_sided_factor
from lod.errors import InputError

_LEAST = 1e-4
"""Excesses below this are drawn as this: noise makes some of them negative."""

_COSTS: dict[str, tuple[Callable[[Point], float], str]] = {
    "time": (frame_seconds, "seconds of a frame, all stages"),
    "memory": (megabytes, "most that a process holds (MB)"),
}


def plots(record: Record) -> tuple[Plot, ...]:
    """Draw, for each kind and size of world, the error against time and memory, by arm."""
    windows = grouped(filter(is_measured, record.points), "kind", "objects")
    return tuple(
        plot
        for key, points in windows.items()
        for cost in _COSTS
        for plot in _plot(points, cost, *key)
    )


def point_table(record: Record) -> Table:
    """Return the heads and rows of a table of every field, arm and setting."""
    heads = ("world", "field", "arm", "setting", "excess FLIP", "SSIM", "sticks", "MB")
    measured = [_row(point) for point in record.points if is_measured(point)]
    return (*heads, *(f"{stage} s" for stage in STAGES)), measured


def _plot(points: Sequence[Point], cost: str, kind: str, objects: float) -> Iterator[Plot]:
    of_point, axis = _COSTS[cost]
    drawn = []
    for (arm,), mine in grouped(points, "arm").items():
        settings = grouped(mine, "setting").values()
        known = [each for each in settings if all(math.isfinite(of_point(p)) for p in each)]
        x = [float(np.mean([of_point(p) for p in each])) for each in known]
        y = [max(float(np.mean([excess(p) for p in each])), _LEAST) for each in known]
        if x:
            drawn.append(Curve(arm, x, y))
    if not drawn:
        return
    caption = "Means over fields, settings next to equal error. Nearer to the lower left is better."
    title = f"{kind}, {objects:g} objects: error against {cost}"
    name = f"rivals-{kind.replace(' ', '-')}-{objects:g}-{cost}"
    yield curves(name, title, caption, (axis, "excess FLIP over the whole picture"), drawn)


def _row(point: Point) -> tuple[str, ...]:
    case: dict[str, Any] = point.case
    where = f"{case['kind']}, {case['objects']:g}", str(case["field"] + 1)
    ssim = float(np.mean(point.values("ssim"))) / 1e6
    held = megabytes(point)
    return (
        *where,
        case["arm"],
        f"{case['setting']:g}",
        f"{excess(point):.4f}",
        f"{ssim:.3f}",
        f"{point.column('sticks')[0]:,}",
        f"{held:.0f}" if math.isfinite(held) else "",
        *(_seconds(point, stage) for stage in STAGES),
    )


def _seconds(point: Point, stage: str) -> str:
    try:
        return f"{float(np.median(point.values('us', stage=stage))) / 1e6:.3f}"
    except InputError:
        return ""


_COMPARED = {"time": "seconds", "memory": "megabytes"}
_NOT_HERE = "not measured here"


def summary(record: Record) -> Table:
    """Return a table: in every world what the metric and everything take, and who wins.

    The metric's time and memory are divided by those of the rival that needs least of them at
    equal error: above 1 that rival wins.
    """
    won = (f"{word}, blake ÷ the best rival (95 %)" for word in _COMPARED)
    heads = "world", "blake [s; MB]", "everything [s; MB]", *won
    return heads, [_winners_row(name, points) for name, points in _worlds(record)]


def tables(record: Record) -> tuple[tuple[str, Table], ...]:
    """Return titled tables: each arm, equal time, stages, faithfulness, the walk, and Cycles."""
    return (
        ("Each arm at equal error", _arms_table(record)),
        ("Error in the time that blake takes at equal error", _time_table(record)),
        ("What pruning helps, and what it does not", _stage_table(record)),
        ("Tone, cover and noise at the last setting within equal error", _tone_table(record)),
        ("A walk: what moves that does not move in the whole", _walk_table(record)),
        ("The same cut in Cycles", _cycles_table(record)),
    )


def _worlds(record: Record) -> list[tuple[str, list[Point]]]:
    here = [point for point in record.points if "part" not in point.case]
    return [(f"{kind}, {n:g}", row) for (kind, n), row in grouped(here, "kind", "objects").items()]


def _winners_row(world: str, points: Sequence[Point]) -> tuple[str, ...]:
    """Tell what the metric and everything take, and by whom the metric is beaten or not."""
    found = at_equal_error(points)
    costs = ("; ".join(_cost(found, points, arm)) for arm in ("blake", "full"))
    best = (beside_best_rival(found, quantity) for quantity in _COMPARED.values())
    return world, *costs, *(f"{b[0]}: {_told(b[1])}" if b else "not compared" for b in best)


def _arms_table(record: Record) -> Table:
    rows: list[tuple[str, ...]] = []
    for world, points in _worlds(record):
        found = at_equal_error(points)
        arms = [arm for (arm,) in grouped(points, "arm")]
        rows += [(world, arm, *_cost(found, points, arm)) for arm in arms]
    return ("world", "arm", "seconds at equal error", "MB"), rows


def _cost(
    found: dict[str, list[AtEqualError]], points: Sequence[Point], arm: str
) -> tuple[str, str]:
    """Tell an arm's seconds and megabytes at equal error, or why there are none."""
    fields = found.get(arm, [])
    if not fields:
        return _without_errors(where(points, arm=arm))
    reached = all(each.reached for each in fields)
    seconds = f"{np.mean([e.seconds for e in fields]):.2f}" if reached else "never reached"
    return seconds, f"{np.mean([each.megabytes for each in fields]):.0f}"


def _told(ratios: np.ndarray) -> str:
    """Tell a mean ratio with its interval, and who wins where that is decided."""
    if len(ratios) < 2:
        return f"{ratios[0]:.3g}"
    found = two_sided_factor(ratios)
    wins = "the rival wins" if found.low > 1 else "blake wins" if found.high < 1 else "undecided"
    return f"{found.value:.3g} ({found.low:.3g} to {found.high:.3g}), {wins}"


def _without_errors(row: Sequence[Point]) -> tuple[str, str]:
    """Say what is known of an arm where the whole world does not fit."""
    foretold = [p.column("foretold_bytes")[0] for p in row if _has(p, "foretold_bytes")]
    if foretold:
        return "does not fit", f"{max(foretold) / 1e6:,.0f} foretold"
    timed = [p for p in row if math.isfinite(frame_seconds(p))]
    told = ", ".join(
        f"{np.mean([frame_seconds(p) for p in mine]):.2f} at {setting:g}"
        for (setting,), mine in grouped(timed, "setting").items()
    )
    held = [megabytes(p) for p in timed if math.isfinite(megabytes(p))]
    return f"no whole picture; {told}", f"{np.mean(held):.0f}" if held else ""


def _time_table(record: Record) -> Table:
    heads = "world", "arm", "excess FLIP in each field"
    rows: list[tuple[str, ...]] = []
    for world, points in _worlds(record):
        for arm, fields in at_equal_time(points).items():
            told = (f"{each:.4f}" if math.isfinite(each) else "takes longer" for each in fields)
            rows.append((world, arm, ", ".join(told)))
    return heads, rows


def _stage_table(record: Record) -> Table:
    heads = "world", "stage", "blake (s)", "everything (s)", "blake ÷ everything (95 %)"
    rows: list[tuple[str, ...]] = []
    for world, points in _worlds(record):
        blake, full = _nearest(points, "blake"), _nearest(points, "full")
        if not full or len(blake) != len(full):
            continue
        for stage in ("prepare", *STAGES, "cpu"):
            mine, whole = ([_stage(p, stage) for p in row] for row in (blake, full))
            rows.append((world, stage, *_compared(mine, whole, ".3f")))
        mine, whole = ([megabytes(p) for p in row] for row in (blake, full))
        rows.append((world, "MB", *_compared(mine, whole, ".0f")))
        mine, whole = ([_mean(p, "noise") for p in row] for row in (blake, full))
        rows.append((world, "variance of a sample", *_compared(mine, whole, ".4f")))
    return heads, rows


def _compared(mine: list[float], whole: list[float], form: str) -> tuple[str, str, str]:
    """Tell the means of both and their ratio, with its interval where that can be had."""
    means = format(np.mean(mine), form), format(np.mean(whole), form)
    if len(mine) < 2 or not min((*mine, *whole)) > 0:
        return *means, ""
    found = two_sided_factor(np.array(mine) / np.array(whole))
    return *means, f"{found.value:.3g} ({found.low:.3g} to {found.high:.3g})"


def _tone_table(record: Record) -> Table:
    light = [f"light {band}" for band in PAIR_BANDS[:-1]]
    heads = ("world", "arm", "setting", "excess FLIP", "relMSE", *light, "least cover", "variance")
    rows = []
    for world, points in _worlds(record):
        for (arm,), mine in grouped(filter(is_measured, points), "arm").items():
            near = _nearest(mine, arm)
            tones = [
                "" if not t else f"{np.mean(t):.3f}" for t in zip(*map(_tones, near), strict=True)
            ]
            settings = sorted({f"{p.case['setting']:g}" for p in near})
            rows.append(
                (
                    *(world, arm, ", ".join(settings)),
                    f"{np.mean([excess(p) for p in near]):.4f}",
                    f"{np.mean([_mean(p, 'relmse_bias') for p in near]):.4f}",
                    *tones,
                    f"{min(map(least_covered, near)):.2f}",
                    f"{np.mean([_mean(p, 'noise') for p in near]):.3f}",
                )
            )
    return heads, rows


def _tones(point: Point) -> list[float]:
    """Return light ÷ that of the whole in each band; 1 where the whole has nothing there."""
    found = []
    for band in PAIR_BANDS[:-1]:
        tested, whole = (
            float(point.values("luminance", picture=p, band=band).mean())
            for p in ("tested", "reference")
        )
        found.append(tested / whole if whole else 1.0)
    return found


def _walk_table(record: Record) -> Table:
    heads = ("world", "arm", "setting", "FLIP", "residual of a step (1e-3)", "JOD of 10")
    rows: list[tuple[str, ...]] = []
    for point in where(record.points, part="walk"):
        case = point.case
        jod = f"{_mean(point, 'jod'):.2f}" if _has(point, "jod") else _NOT_HERE
        row = f"{case['kind']}, {case['objects']:g}", str(case["arm"]), f"{case['setting']:g}"
        flip, residual = _mean(point, "flip"), _mean(point, "residual")
        rows.append(
            (*row, f"{flip:.4f}", f"{1e3 * residual:.2f}", jod if _is_judged(point) else "")
        )
    return heads, rows


def _is_judged(point: Point) -> bool:
    return point.case["arm"] in JUDGED


_CYCLES_STAGES = "describe", "synchronise", "build", "trace"


def _cycles_table(record: Record) -> Table:
    plain = "world", "frame", "renderer", "excess FLIP", "variance", "light", "MB"
    heads = (*plain, *(f"{stage} (s)" for stage in _CYCLES_STAGES))
    points = where(record.points, part="cycles")
    if not points:
        return heads, [("all", _NOT_HERE, "cycles", *[""] * (len(heads) - 3))]
    names = "kind", "objects", "arm", "setting", "renderer"
    rows = []
    for (kind, n, arm, setting, renderer), row in grouped(points, *names).items():
        held = [megabytes(p) for p in row if math.isfinite(megabytes(p))]
        apart = np.mean([_mean(p, "flip") - _mean(p, "flip_floor") for p in row])
        frame = "everything" if arm == "full" else f"{arm}, {setting:g} px"
        means = (np.mean([_mean(p, name) for p in row]) for name in ("noise", "light"))
        stages = ([_stage(p, s) for p in row if _has(p, "us", stage=s)] for s in _CYCLES_STAGES)
        rows.append(
            (
                *(f"{kind}, {n:g}", frame, str(renderer), f"{apart:.4f}"),
                *(f"{each:.4f}" for each in means),
                f"{np.mean(held):.0f}" if held else "",
                *(f"{np.mean(each):.3f}" if each else "" for each in stages),
            )
        )
    return heads, rows


def _nearest(points: Sequence[Point], arm: str) -> list[Point]:
    """Return each field's point of an arm at its last weighed setting within equal error.

    Where no setting is within it, the finest that was weighed.
    """
    found = []
    for row in grouped(filter(is_measured, where(points, arm=arm)), "field").values():
        weighed = [p for p in row if math.isfinite(megabytes(p))]
        within = [p for p in weighed if judged_error(p) <= EQUAL_ERROR]
        found += within[-1:] or weighed[:1]
    return found


def _stage(point: Point, stage: str) -> float:
    return float(np.median(point.values("us", stage=stage))) / 1e6


def _mean(point: Point, quantity: str) -> float:
    return float(point.values(quantity).mean()) / 1e6


def _has(point: Point, quantity: str, **keys: str) -> bool:
    try:
        point.column(quantity, **keys)
    except InputError:
        return False
    return True
