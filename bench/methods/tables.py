"""What the report says of methods beside its plots: who is ahead, and what every setting shows."""

import math
from collections.abc import Callable, Iterable, Sequence
from functools import partial

import numpy as np

from bench.experiment import Table
from bench.methods.comparison import (
    COSTS,
    EQUAL_SHARE,
    MARGIN,
    RULES,
    AtEqualError,
    at_equal_error,
    band_ratios,
    beside_best,
    error,
    excess,
    frame_seconds,
    is_measured,
    judged_error,
    megabytes,
    optional,
    passes,
)
from bench.methods.runner import STAGES
from bench.records.records import Point, Record, grouped, where
from bench.statistics.estimates import two_sided_factor


def _summary_table(record: Record) -> Table:
    """Show what the metric and the reference take in every world, and who is ahead.

    The metric's time and memory are divided by those of the baseline that needs least of them at
    equal error: above 1 that baseline is ahead.
    """
    heads = "world", "blake [s; MB]", "unpruned [s; MB]"
    rows: list[tuple[str, ...]] = []
    for world, points in _worlds(record):
        found = at_equal_error(points)
        costs = ["; ".join(_cost(found, points, method)) for method in ("blake", "full")]
        for quantity, _, _ in COSTS.values():
            best = beside_best(found, quantity)
            costs.append(f"{best[0]}: {_ahead(best[1])}" if best else "not compared")
        rows.append((world, *costs))
    return (*heads, *(f"{cost}, blake ÷ the best baseline (95 %)" for cost in COSTS)), rows


def tables(record: Record) -> tuple[tuple[str, Table], ...]:
    """Return titled tables of who is ahead, methods and stages."""
    return (
        ("The metric beside the unpruned reference and the best baseline", _summary_table(record)),
        ("Each method at equal error", _methods_table(record)),
        ("Each of four methods ÷ the best of the others", _each_table(record)),
        ("What each setting shows", _settings_table(record)),
        ("What pruning helps, and what it does not", _stage_table(record)),
    )


def _worlds(record: Record) -> list[tuple[str, list[Point]]]:
    here = [point for point in record.points if "part" not in point.case]
    return [(f"{kind}, {n:g}", row) for (kind, n), row in grouped(here, "kind", "objects").items()]


def _methods_table(record: Record) -> Table:
    rows: list[tuple[str, ...]] = []
    for world, points in _worlds(record):
        found = at_equal_error(points)
        rows += [(world, m, *_cost(found, points, m)) for (m,) in grouped(points, "arm")]
    return ("world", "method", "seconds at equal error", "MB"), rows


FOUR = "bare", "blake", "discrete", "stochastic"
"""The methods that stand against one another, each beside the best of the other three."""


def _each_table(record: Record) -> Table:
    rows: list[tuple[str, ...]] = []
    for world, points in _worlds(record):
        for rule in RULES:
            found = at_equal_error(points, rule)
            for mine in FOUR:
                told = []
                for quantity, _, _ in COSTS.values():
                    best = beside_best(found, quantity, mine, FOUR)
                    told.append(f"{best[0]}: {_ahead(best[1], mine, best[0])}" if best else "–")
                rows.append((world, rule, mine, *told))
    return ("world", "error by", "method", *(f"{cost} ÷ best other (95 %)" for cost in COSTS)), rows


def _settings_table(record: Record) -> Table:
    heads = "world", "method", "setting", "error", "excess FLIP", "coverage, luminance by band"
    rows: list[tuple[str, ...]] = []
    for world, points in _worlds(record):
        measured = filter(is_measured, points)
        for (method, setting), row in grouped(measured, "arm", "setting").items():
            bands = ", ".join(f"{c:.3f} {lit:.3f}" for c, lit in band_ratios(row).values())
            means = (f"{np.mean([f(p) for p in row]):.4f}" for f in (error, excess))
            passed = "" if passes(row) else ": does not pass"
            rows.append((world, method, f"{setting:g}", *means, f"{bands}{passed}"))
    return heads, rows


def _cost(
    found: dict[str, list[AtEqualError]], points: Sequence[Point], method: str
) -> tuple[str, str]:
    if fields := found.get(method):
        reached = all(each.reached for each in fields)
        seconds = f"{np.mean([e.seconds for e in fields]):.2f}" if reached else "never reached"
        return seconds, f"{np.mean([each.megabytes for each in fields]):.0f}"
    row = where(points, arm=method)
    needed = [1e6 * optional(p, "foretold_bytes")[0] for p in row]
    if np.isfinite(needed).any():
        return "does not fit", f"{np.nanmax(needed) / 1e6:,.0f} estimated"
    timed = [p for p in row if math.isfinite(frame_seconds(p))]
    told = ", ".join(
        f"{np.mean([frame_seconds(p) for p in mine]):.2f} at {setting:g}"
        for (setting,), mine in grouped(timed, "setting").items()
    )
    return f"no reference; {told}", _mean([megabytes(p) for p in timed], ".0f")


def _ahead(ratios: np.ndarray, mine: str = "blake", other: str = "baseline") -> str:
    """Tell a mean ratio with its interval, and who is ahead, or that both are equivalent."""
    if len(ratios) < 2:
        return f"{ratios[0]:.3g}"
    found = two_sided_factor(ratios)
    told = [f"{mine} ahead"] * (found.high < 1) + [f"{other} ahead"] * (found.low > 1)
    if 1 - MARGIN <= found.low and found.high <= 1 + MARGIN:
        told.append(f"equivalent within ±{100 * MARGIN:g} %")
    return f"{found:.3g}, {', '.join(told) or 'inconclusive'}"


def _stage_table(record: Record) -> Table:
    heads = "world", "stage", "blake (s)", "unpruned (s)", "blake ÷ unpruned (95 %)"
    stages: dict[str, tuple[Callable[[Point], float], str]] = {
        **{name: (partial(_stage, stage=name), ".3f") for name in ("prepare", *STAGES, "cpu")},
        "MB": (megabytes, ".0f"),
        "variance of a sample": (lambda p: float(optional(p, "noise").mean()), ".4f"),
    }
    rows: list[tuple[str, ...]] = []
    for world, points in _worlds(record):
        blake, full = _nearest(points, "blake"), _nearest(points, "full")
        if not full or len(blake) != len(full):
            continue
        for name, (of_point, form) in stages.items():
            mine, reference = (np.array([of_point(p) for p in row]) for row in (blake, full))
            ratio = ""
            if len(mine) > 1 and min(*mine, *reference) > 0:
                ratio = f"{two_sided_factor(mine / reference):.3g}"
            means = (format(row.mean(), form) for row in (mine, reference))
            rows.append((world, name, *means, ratio))
    return heads, rows


def _mean(values: Iterable[float], form: str) -> str:
    known = [each for each in values if math.isfinite(each)]
    return format(np.mean(known), form) if known else ""


def _stage(point: Point, stage: str) -> float:
    return float(np.median(optional(point, "us", stage=stage)))


def _nearest(points: Sequence[Point], method: str) -> list[Point]:
    """Return each field's point of a method at its last weighed setting within equal error.

    Where no setting is within it, the finest that was weighed.
    """
    found = []
    for row in grouped(filter(is_measured, where(points, arm=method)), "field").values():
        weighed = [p for p in row if math.isfinite(megabytes(p))]
        fine = [p for p in weighed if judged_error([p]) <= EQUAL_SHARE]
        found += fine[-1:] or weighed[:1]
    return found
