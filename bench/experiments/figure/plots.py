"""What the figure experiment shows: parts against distance, sizes against level, and a table."""

import numpy as np

from bench.experiment import Table
from bench.experiments.figure.cases import EXAGGERATED_PX, PERSON
from bench.experiments.figure.claims import Counted, counted, no_smaller, readings, sized
from bench.experiments.figure.fit import halves, line
from bench.experiments.figure.part_counts import UM_PER_M
from bench.plots.plot import Curve, Plot, curves
from bench.records.claims import Claim, four_decimals
from bench.records.records import Record
from bench.statistics.power_law import LEAST_ROWS, compare_with_log

_BAND = 5, 95
"""The percentiles of the poses at both edges of the band."""

_AXIS = "distance of the eye (m)", "parts displayed"


def plots(record: Record) -> tuple[Plot, ...]:
    """Draw parts against distance for every kind and detail; then sizes against level."""
    by_look: dict[tuple[str, float], list[Counted]] = {}
    for curve in counted(record.points):
        by_look.setdefault((curve.kind, curve.detail), []).append(curve)
    made = [_parts_plot(record, kind, group) for (kind, _), group in by_look.items()]
    return (*made, _sizes_plot(record))


def point_table(record: Record) -> Table:
    """Return a table: every fitted exponent, with those of its nearer and farther half."""
    heads = (
        *("kind", "metric", "detail (px)", "reading", "parts", "from (m)", "to (m)"),
        *("exponent (95 %)", "nearer half", "farther half", "verdict"),
    )
    claims = {claim.name: claim for claim in record.claims}
    return heads, [
        _row(curve, reading[1], reading[2](curve), claims[_name(curve, reading[0])])
        for curve in counted(record.points)
        for reading in readings(curve)
    ]


def _row(curve: Counted, where: str, chosen: np.ndarray, claim: Claim) -> tuple[str, ...]:
    far = curve.distances[chosen]
    nearer, farther = (four_decimals(v) for v in halves(curve.counts, curve.distances, chosen))
    return (
        *(curve.kind, curve.metric, f"{curve.detail:g}", where, str(curve.parts)),
        *(f"{far.min():.4g}", f"{far.max():.4g}"),
        *(claim.measured_text, nearer, farther, claim.verdict),
    )


def _name(curve: Counted, reading: str) -> str:
    return f"{curve.metric}/{curve.kind}/{reading}"


def _parts_plot(record: Record, kind: str, group: list[Counted]) -> Plot:
    exaggerated = group[0].detail == EXAGGERATED_PX
    claims = {claim.name: claim for claim in record.claims}
    told = " ".join(_told(c, claims[_name(c, readings(c)[0][0])]) for c in group)
    about = f", detail exaggerated to {EXAGGERATED_PX:g} px" if exaggerated else ""
    caption = (
        f"Mean over {group[0].counts.shape[1]} random poses and directions, the band from the "
        f"{_BAND[0]}th to the {_BAND[1]}th percentile{about}. Dashed: the line fitted where "
        f"1 < parts < all. Its exponent, claimed −0.5 ± 0.1: {told}"
    )
    drawn = [_curve(curve) for curve in group]
    title = f"Parts of the {kind}{' (exaggerated)' if exaggerated else ''} against distance"
    name = f"{kind}-parts{'-exaggerated' if exaggerated else ''}"
    return curves(name, title, caption, _AXIS, drawn)


def _told(curve: Counted, claim: Claim) -> str:
    nearer, farther = halves(curve.counts, curve.distances, curve.between)
    return (
        f"{curve.metric}: {claim.measured_text}, {four_decimals(nearer)} in its nearer half and "
        f"{four_decimals(farther)} in its farther: {claim.verdict}{_rival(curve)}."
    )


def _rival(curve: Counted) -> str:
    """Say whether the logarithm of distance describes mean counts better than the line does."""
    rows = np.flatnonzero(curve.between.all(axis=1))
    if len(rows) < LEAST_ROWS:
        return ""
    x = np.exp(np.log(curve.distances[rows]).mean(axis=1))
    return f"; of the means, {compare_with_log(x, curve.counts[rows].mean(axis=1)).words}"


def _curve(curve: Counted) -> Curve:
    x = np.exp(np.log(curve.distances).mean(axis=1))
    low, high = np.percentile(curve.counts, _BAND, axis=1)
    chosen = curve.between
    slope, factor = line(curve.counts, curve.distances, chosen)
    ends = np.array((curve.distances[chosen].min(), curve.distances[chosen].max()))
    fitted = ends.tolist(), (factor * ends**slope).tolist()
    mean = curve.counts.mean(axis=1)
    return Curve(curve.metric, x.tolist(), mean.tolist(), low.tolist(), high.tolist(), fitted)


def _sizes_plot(record: Record) -> Plot:
    drawn, told = [], []
    for kind, sizes in sized(record.points).items():
        levels = range(int(sizes["level"].max()) + 1)
        P = [float(np.median(sizes["P_um"][sizes["level"] == n])) / UM_PER_M for n in levels]
        drawn.append(Curve(kind, list(map(float, levels)), [each / P[0] for each in P]))
        share = 100 * no_smaller(sizes["whole"], sizes["P_um"])
        medians = ", ".join(f"{each:.3g}" for each in P)
        told.append(f"{kind}: {medians} m; {share:.0f} % of its parts no smaller than their whole.")
    caption = (
        "Median P of the parts of a level, as a share of the whole object's. The paper conjectures "
        f"that parts shrink with depth for living things of our size only; {PERSON}, animals, "
        "insect and artifact are held to the same claim. Medians by level, from level 0: "
    )
    axis = "level", "median P ÷ P of the whole object"
    words, title = caption + " ".join(told), "How P falls with level"
    return curves("sizes", title, words, axis, drawn, ("linear", "log"))
