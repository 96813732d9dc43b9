"""What did the study ``full`` find, as a table, a few lines and plots?

Growth is given where the law says something: pruned frames do not grow once the world is larger
than the limit distance; of whole ones, what they cost beyond the smallest of the last WORLDS grows
with what they hold beyond it. How the ratio grows is given for those last worlds, too.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np

from bench.cli.output import table
from bench.experiments.world.claims import added_by_parts, beyond_limit, power_of_worlds, seconds
from bench.plots.plot import Curve, Plot, curves
from bench.records.points import Point, point_from_json
from bench.statistics.estimates import Estimate, two_sided_factor
from bench.statistics.power_law import fit_exponent
from lod.arrays import Reals

WORLDS = 4
"""The number of the largest whole worlds from which growth is fitted: one and a half decades."""

LEAST = 3
"""The fewest worlds from which growth is fitted; what is added needs one more."""

_HEADS = (
    *("objects", "side m", "whole s", "pruned s", "of it trace", "whole ÷ pruned (95 %)"),
    *("processor's s, whole", "pruned", "whole ÷ pruned (95 %)"),
    *("whole MB", "pruned MB", "whole ÷ pruned", "sticks, whole", "pruned"),
)
_TIME, _CPU, _MEMORY = "wall_us", "cpu_us", "peak_bytes"


def points_by_metric(found: dict[str, Any], metric: str) -> list[Point]:
    """Select the points of one metric, from the smallest world to the largest."""
    points = [point_from_json(each) for each in found["points"]]
    mine = [each for each in points if each.case["metric"] == metric]
    return sorted(mine, key=lambda each: each.case["objects"])


def ratios(found: dict[str, Any], column: str = _TIME) -> dict[float, Reals]:
    """Divide whole by pruned in each turn, by the number of objects."""
    pruned = {each.case["objects"]: each for each in points_by_metric(found, "blake")}
    return {
        each.case["objects"]: seconds(each, column) / seconds(pruned[each.case["objects"]], column)
        for each in points_by_metric(found, "full")
    }


def results_table(found: dict[str, Any]) -> str:
    """Write a table with a row for each world; times are medians."""
    whole = {each.case["objects"]: each for each in points_by_metric(found, "full")}
    pruned = points_by_metric(found, "blake")
    return table([_HEADS, *(_row(each, whole.get(each.case["objects"])) for each in pruned)])


def _row(pruned: Point, full: Point | None) -> tuple[object, ...]:
    case = pruned.case
    cells: list[object] = [f"{case['objects']:.3g}", f"{case['side_m']:.4g}"]
    for column in (_TIME, _CPU):
        cells += [full and _middle(full, column), _middle(pruned, column)]
        cells.append(
            full and f"{two_sided_factor(seconds(full, column) / seconds(pruned, column)):.3g}"
        )
    cells.insert(4, _middle(pruned, "trace_us"))
    held = seconds(pruned, _MEMORY)[0], seconds(full, _MEMORY)[0] if full else None
    cells += [held[1] and f"{held[1]:.0f}", f"{held[0]:.0f}"]
    cells += [held[1] and f"{held[1] / held[0]:.2f}", full and f"{full.column('sticks')[0]:,}"]
    return (*cells, f"{pruned.column('sticks')[0]:,}")


def _middle(point: Point, column: str) -> str:
    return f"{float(np.median(seconds(point, column))):.2f}"


def summary_text(found: dict[str, Any]) -> str:
    """Write what was rendered, at which detail, and how time and memory grow."""
    picture = found["effort"]["picture"]
    lines = [f"{found['kind']}, {picture['size']}, {picture['spp']} samples, {_detail(found)}"]
    lines += [f"  {what}: {_exponent(estimate)}" for what, estimate in growth(found).items()]
    return "\n".join(lines)


def _detail(found: dict[str, Any]) -> str:
    how, limit = found["search"], found["points"][0]["case"]["limit_m"]
    at = f"τ = {found['tau_px']:.3f} px, limit {limit:.0f} m"
    if how["detail"] is None:
        return f"{at}, given"
    there, again = how["detail"], how["confirmed"]
    return (
        f"{at}: excess FLIP 0.01 in a world of {how['objects']:g} objects ({there['low']:.3f} to "
        f"{there['high']:.3f} px); {again['excess']:.4f} ({again['low']:.4f} to {again['high']:.4f}"
        f", floor {again['floor']:.4f}) in one of {again['objects']:g}"
    )


def growth(found: dict[str, Any]) -> dict[str, Estimate | None]:
    """Fit the exponent of each quantity; None where there are too few worlds."""
    whole, pruned = points_by_metric(found, "full")[-WORLDS:], points_by_metric(found, "blake")
    beyond = beyond_limit(pruned)
    said = f"{len(beyond)} worlds beyond the limit"
    return {
        f"pruned time against objects, {said}": _flat(beyond, _TIME),
        f"pruned processor's time against objects, {said}": _flat(beyond, _CPU),
        f"pruned memory against objects, {said}": _flat(beyond, _MEMORY),
        "whole time added against sticks added": _added(whole, _TIME),
        "whole processor's time added against sticks added": _added(whole, _CPU),
        "whole memory added against sticks added": _added(whole, _MEMORY),
        f"ratio of times against objects, {len(whole)} worlds": _of_ratio(found, _TIME),
        f"ratio of processor's times against objects, {len(whole)} worlds": _of_ratio(found, _CPU),
        f"ratio of memory against objects, {len(whole)} worlds": _of_ratio(found, _MEMORY),
    }


def _flat(points: Sequence[Point], column: str) -> Estimate | None:
    return power_of_worlds(points, column) if len(points) >= LEAST else None


def _added(points: Sequence[Point], column: str) -> Estimate | None:
    added = added_by_parts(points, column, "sticks")
    return fit_exponent(*added) if len(set(added[0])) >= LEAST else None


def _of_ratio(found: dict[str, Any], column: str) -> Estimate | None:
    rows = list(ratios(found, column).items())[-WORLDS:]
    x = np.repeat([objects for objects, _ in rows], len(rows[0][1]))
    y = np.concatenate([values for _, values in rows])
    return fit_exponent(x, y) if len(rows) >= LEAST else None


def _exponent(found: Estimate | None) -> str:
    return "too few worlds to say" if found is None else f"exponent {found:.3g}"


PLOTS = ("time", "memory", "ratio")


def plots(found: dict[str, Any]) -> tuple[Plot, ...]:
    """Plot time and memory of whole and pruned frames, and their ratios, against the objects.

    They are named by the kind of worlds and by PLOTS, in this order.
    """
    both = {"unpruned": points_by_metric(found, "full"), "pruned": points_by_metric(found, "blake")}
    time = [_curve(label, points, _TIME) for label, points in both.items()]
    memory = [_curve(label, points, _MEMORY) for label, points in both.items()]
    shares = [
        _ratio_curve(label, ratios(found, column))
        for label, column in (("time", _TIME), ("processor's time", _CPU), ("memory", _MEMORY))
    ]
    return (
        _plot("time", found, "seconds for a written frame", time),
        _plot("memory", found, "most memory of the process (MB)", memory),
        _plot("ratio", found, "unpruned ÷ pruned", shares),
    )


def _plot(name: str, found: dict[str, Any], what: str, drawn: list[Curve]) -> Plot:
    title = f"{found['kind']} at τ = {found['tau_px']:.2f} px: {what}"
    axis = "objects in the world", what
    return curves(f"{found['kind']}-{name}", title, title, axis, drawn)


def _curve(label: str, points: Sequence[Point], column: str) -> Curve:
    rows = {each.case["objects"]: seconds(each, column) for each in points}
    return _ratio_curve(label, rows)


def _ratio_curve(label: str, rows: dict[float, Reals]) -> Curve:
    if min(len(values) for values in rows.values()) < 2:
        return Curve(label, [*rows], [float(values[0]) for values in rows.values()])
    told = [two_sided_factor(values) for values in rows.values()]
    bands = [each.low for each in told], [each.high for each in told]
    return Curve(label, [*rows], [each.value for each in told], *bands)
