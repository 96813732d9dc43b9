"""What the fidelity experiment claims, judged from its raw samples alone."""

from collections.abc import Sequence

from bench.experiments.fidelity.equal_error import EQUAL_ERROR, column, equal_error, excesses
from bench.experiments.fidelity.image_errors import BANDS
from bench.experiments.fidelity.scene import GROUND, PIECES, PIECES_DETAIL, SPECIES
from bench.experiments.fidelity.timing import over_unpruned, timed
from bench.records.claims import Claim, claim
from bench.records.points import Point, grouped, where
from bench.statistics.estimates import two_sided_mean
from bench.statistics.excess_flip import FLOOR

JUDGED_AT_PX = 1.0
FEWEST_PIXELS = 30
_QUOTED = SPECIES, GROUND, "everything"
_SOURCE = "§2.4"


def judge(points: tuple[Point, ...]) -> tuple[Claim, ...]:
    """Return every claim that these points decide."""
    made: list[Claim] = []
    for (view,), chosen in grouped(points, "view").items():
        name = view.replace(" ", "_")
        made.append(_floor(name, view, chosen[0]))
        at = where(chosen, detail=JUDGED_AT_PX)
        made += [_excess(name, p) for p in at if p.case["pruned"] in _QUOTED]
        made += [_luminance(name, p, b) for p in at for b in BANDS[:-1] if _any_light(p, b)]
        made += _rivals(name, view, chosen) + _faster(name, chosen)
    return tuple(made)


def _any_light(point: Point, band: str) -> bool:
    whole = point.case["pruned"] == "everything"
    return whole and point.column("pixels", band=band)[0] >= FEWEST_PIXELS


def pieces(points: Sequence[Point]) -> list[Point]:
    """Return the claims on pieces of the scene that are each pruned alone."""
    at = where(points, detail=PIECES_DETAIL)
    return [p for p in at if p.case["pruned"] in (*PIECES, GROUND)]


def _floor(name: str, view: str, point: Point) -> Claim:
    about = f"The noise of the {view} view is low enough to quote an excess over it."
    words = about, "FLIP of the reference against itself with another seed", _SOURCE
    return claim(
        f"floor/{name}", words, FLOOR, 0, two_sided_mean(column(point, "flip_floor")), "at most"
    )


def _excess(name: str, point: Point) -> Claim:
    metric, pruned = point.case["metric"], point.case["pruned"]
    about = f"As good as whole by {metric} at one pixel, {point.case['view']}; pruned: {pruned}."
    words = about, "excess FLIP, 67 pixels per degree", _SOURCE
    which = f"{metric}/{name}/excess_{pruned}"
    return claim(which, words, EQUAL_ERROR, 0, two_sided_mean(excesses(point)), "at most")


def _luminance(name: str, point: Point, band: str) -> Claim:
    tested, unpruned = (
        column(point, "luminance", picture=which, band=band) for which in ("tested", "reference")
    )
    about = f"Pruning by blake at one pixel keeps the light {band}, {point.case['view']}."
    words = about, "mean luminance ÷ the reference's", _SOURCE
    which = band.replace(" ", "_")
    return claim(
        f"blake/{name}/luminance_{which}", words, 1.0, 0.02, two_sided_mean(tested / unpruned)
    )


def _rivals(name: str, view: str, points: Sequence[Point]) -> list[Claim]:
    """Claim that the default metric needs the fewest parts at equal error, over resampled pairs."""
    made, found = [], equal_error(points)
    ours = found["blake"]
    for rival in found.values():
        if rival is not ours and ours.found and rival.found:
            about = f"At equal error blake needs no more parts than {rival.metric}, {view}."
            words = about, f"parts by blake ÷ parts by {rival.metric} at excess FLIP 0.01", _SOURCE
            which = f"{rival.metric}/{name}/parts"
            made.append(claim(which, words, 1.0, 0, ours.parts_over(rival), "at most"))
    return made


def _faster(name: str, points: Sequence[Point]) -> list[Claim]:
    """Claim that the pruned frame is faster than the unpruned one on the same ground."""
    made = []
    for point in where(timed(points), detail=JUDGED_AT_PX):
        found = over_unpruned(points, point)
        if found is not None:
            view = point.case["view"]
            about = f"Pruned by blake at one pixel a frame takes less time than unpruned, {view}."
            words = about, "time of prune, build and trace ÷ the unpruned frame's", "§4.2"
            made.append(claim(f"blake/{name}/time", words, 1.0, 0, found, "at most"))
    return made
