"""What does the figure experiment claim of its raw counts, sizes and times? (§2.3–4)

The claims are stated alike for every kind. The paper makes the one about distance for its human
figure alone, and conjectures that the one about size holds for living things of our size only: that
an insect or a windmill refutes it would agree with the paper.
"""

from collections.abc import Callable, Iterable
from dataclasses import dataclass

import numpy as np

from bench.experiments.figure.cases import EXAGGERATED_PX, PERSON, Distances, looked_from
from bench.experiments.figure.fit import Chosen, Counts, exponent, rank_correlation
from bench.records.claims import Claim
from bench.records.old_claims import claim
from bench.records.records import Point, grouped, where
from bench.statistics.estimates import exactly, two_sided_median

COUNTED, SIZED, POSED = "parts against distance", "sizes", "posing"

SQUARE_ROOT, NEARLY = -0.5, 0.1
FEW = 0.05
"""The share of parts that may be no smaller than their whole, for "generally smaller"."""


@dataclass(frozen=True, eq=False)
class Counted:
    """One curve as counted: counts (distances, poses) at distances (distances, poses) [m].

    parts  number of parts of the whole object
    fits   distance from which the object fits into the picture [m]
    """

    kind: str
    metric: str
    detail: float
    parts: int
    fits: float
    distances: Distances
    counts: Counts

    @property
    def between(self) -> Chosen:
        """Whether more than one part is displayed and not all, (distances, poses)."""
        return (self.counts > 1) & (self.counts < self.parts)

    @property
    def whole(self) -> Chosen:
        """Whether the object fits into the picture and is displayed, (distances, poses)."""
        return (self.counts > 0) & (self.distances >= self.fits)

    @property
    def visible(self) -> Chosen:
        """Whether anything of the object is displayed, (distances, poses)."""
        return self.counts > 0


def counted(points: Iterable[Point]) -> list[Counted]:
    """Return the curves of a record, in the order they come."""
    curves = grouped(where(points, what=COUNTED), "kind", "metric", "detail")
    return [
        Counted(
            kind,
            metric,
            detail,
            parts=rows[0].case["parts"],
            fits=rows[0].case["fits"],
            distances=looked_from(
                np.array([row.case["distance"] for row in rows]), len(rows[0].column("parts"))
            ),
            counts=np.array([row.column("parts") for row in rows], np.int64),
        )
        for (kind, metric, detail), rows in curves.items()
    ]


def sized(points: Iterable[Point]) -> dict[str, dict[str, np.ndarray]]:
    """Return level, whole and P [µm] of every part, by kind."""
    return {
        point.case["kind"]: {
            each.quantity: np.array(each.values, np.int64) for each in point.samples
        }
        for point in where(points, what=SIZED)
    }


def judge(points: tuple[Point, ...]) -> tuple[Claim, ...]:
    """Return every claim that these points decide."""
    rng = np.random.Generator(np.random.Philox(np.random.SeedSequence((0, 0xB007))))
    made = [_square_root(curve, *reading, rng) for curve in counted(points)
            for reading in readings(curve)]  # fmt: skip
    for kind, table in sized(points).items():
        made += _falls(kind, table, rng)
    return (*made, *map(_quaternions, where(points, what=POSED)))


Reading = tuple[str, str, Callable[[Counted], Chosen]]

_USUAL: Reading = ("exponent", "where 1 < parts < all", lambda curve: curve.between)
_VISIBLE: Reading = (
    "exponent_visible",
    "at all distances at which it is visible",
    lambda curve: curve.visible,
)
_WHOLE: Reading = (
    "exponent_whole",
    "from where all of it is in the picture",
    lambda curve: curve.whole,
)


def readings(curve: Counted) -> tuple[Reading, ...]:
    """Return readings of a claim: a name, distances in words, and which counts are meant.

    The paper claims it of its person alone, "for those distances over which the figure was
    visible", which comes first. Others are where anything changes, and from where all of it is in
    the picture; and its detail was exaggerated.
    """
    all_of_them = (_VISIBLE, _USUAL, _WHOLE)
    if curve.detail == EXAGGERATED_PX:
        words = f", detail exaggerated to {EXAGGERATED_PX:g} px"
        return tuple((f"{n}_exaggerated", about + words, keep) for n, about, keep in all_of_them)
    return all_of_them if curve.kind == PERSON else (_USUAL,)


def _square_root(
    curve: Counted,
    name: str,
    where: str,
    keep: Callable[[Counted], Chosen],
    rng: np.random.Generator,
) -> Claim:
    found = exponent(curve.counts, curve.distances, keep(curve), rng)
    about = f"Parts of the {curve.kind} drop off with the square root of the distance, {where}."
    words = about, f"exponent of parts against distance, {where}", "§4"
    return claim(f"{curve.metric}/{curve.kind}/{name}", words, SQUARE_ROOT, NEARLY, found)


def _falls(kind: str, table: dict[str, np.ndarray], rng: np.random.Generator) -> list[Claim]:
    level, whole, size = table["level"], table["whole"], table["P_um"]
    found = rank_correlation(level, size, _alike(table), rng)
    about = f"The deeper its level, the smaller a part of the {kind}."
    words = about, "rank correlation of P with level", "§2.3"
    rank = claim(f"sizes/{kind}/rank", words, 0, 0, found, "at most")
    share = no_smaller(whole, size)
    about = f"Parts of the {kind} are generally smaller than their whole."
    words = about, "share of parts no smaller than their whole", "§2.3"
    return [
        rank,
        claim(f"sizes/{kind}/no_smaller", words, 0, FEW, exactly(share, len(whole) - 1), "at most"),
    ]


def no_smaller(whole: np.ndarray, size: np.ndarray) -> float:
    """Return the share of the parts that are no smaller than the whole that owns them."""
    return float(np.mean(size[1:] >= size[whole[1:]]))


def _alike(table: dict[str, np.ndarray]) -> np.ndarray:
    """Number the groups of parts of one level and one size, in wholes of one size."""
    size = table["P_um"]
    keys = np.stack((table["level"], size, size[table["whole"]]), axis=1)
    return np.unique(keys, axis=0, return_inverse=True)[1].ravel()


def _quaternions(point: Point) -> Claim:
    task = point.case["task"]
    ratios = point.values("quaternions_ns") / point.values("matrices_ns")
    about = f"{_TASKS[task]} by quaternions costs less than by rotation matrices."
    words = about, "time by quaternions ÷ time by matrices, on this machine", "§3.3"
    return claim(f"posing/{PERSON}/{task}", words, 1, 0, two_sided_median(ratios), "at most")


_TASKS = {
    "composing": "Composing the turns of all joints",
    "composing_and_placing": "Composing them and placing two points on every joint",
}
