"""What is claimed of walks through presets as shipped, judged from every pair of frames."""

from bench.records.claims import Claim
from bench.records.old_claims import claim
from bench.records.records import Point, grouped
from bench.statistics.estimates import two_sided_mean, two_sided_paired_ratio
from lod.arrays import Reals

SHIPPED, CLIPPED = "as shipped", "clipped"
WAYS: dict[str, tuple[str, ...]] = {SHIPPED: (), CLIPPED: ("view.fade=0",)}
"""The ways to prune a walk, and the settings of each."""

QUANTILE = 0.9999
"""The share of a frame's pixels that change by less than what is judged."""

MOST_CHANGE = 0.05
"""The greatest change, as a share of white, that is not seen as a jump."""

MOST_OF_CLIPPING = 0.5

_SOURCE = "§1.2"


def judge(points: tuple[Point, ...]) -> tuple[Claim, ...]:
    """Claim of every walk that nothing pops, changes by much, or by as much as clipped parts do."""
    made = []
    for (preset,), rows in grouped(points, "preset").items():
        ways = {each.case["way"]: each for each in rows}
        made += _of_walk(preset, ways[SHIPPED], ways[CLIPPED])
    return tuple(made)


def changes(point: Point) -> Reals:
    """Return the change at QUANTILE of every pair of frames, as a share of white, (pairs,)."""
    return point.values("changed_ppm") / 1e6


def _of_walk(preset: str, shipped: Point, clipped: Point) -> list[Claim]:
    popped = two_sided_mean(shipped.values("popped"))
    mean = two_sided_mean(changes(shipped))
    ratio = two_sided_paired_ratio(changes(shipped), changes(clipped))
    named = f"99.99th percentile of a frame's unexplained change, {preset}"
    rows = (
        ("popped", f"No part of {preset} comes or goes at more than half its size.", 0, popped),
        ("change", f"Nothing jumps in a walk through {preset}.", MOST_CHANGE, mean),
        ("clipping", f"Parts of {preset} that fade jump less.", MOST_OF_CLIPPING, ratio),
    )
    quantities = "parts popped between two frames", named, f"{named} ÷ that of clipping"
    return [
        claim(f"{preset}/walk/{name}", (about, quantity, _SOURCE), most, 0, found, "at most")
        for (name, about, most, found), quantity in zip(rows, quantities, strict=True)
    ]
