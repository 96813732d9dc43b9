"""What the haze experiment claims, judged from its raw points alone."""

import numpy as np

from bench.part_sizes import BOUNDS_M, SIZES, part_counts, shares_kept
from bench.records.claims import Claim
from bench.records.old_claims import claim, verification
from bench.records.records import Point, grouped
from bench.statistics.estimates import two_sided_share

BIG = SIZES[len(BOUNDS_M) - 1 :]
"""The classes of size over 1 m."""

SMALL = SIZES[: len(BOUNDS_M) - 1]
"""The classes of size under 1 m."""

JUDGED_AT_M = 2e3
"""The visibility at which shares are claimed: V = 2 km."""

_DERIVED = "derived: docs/method.md"
KIND = "species", "viewer", "width"
"""The keys that points of different visibility share."""


def judge(points: tuple[Point, ...]) -> tuple[Claim, ...]:
    """Return every claim that these points decide."""
    made: list[Claim] = []
    for kind, chosen in grouped(points, *KIND).items():
        name = "/".join(map(str, kind))
        made.append(_law(name, chosen))
        made.append(_near(name, chosen))
        at = [point for point in chosen if point.case["visibility"] == JUDGED_AT_M]
        made += [each for point in at for each in _shares(name, kind[0], point)]
    return tuple(made)


def _law(name: str, points: list[Point]) -> Claim:
    """Claim the share over all visibilities."""
    found, law = shares_kept(points, {"air": "hazy"}, {"air": "clear"})
    about = "Haze leaves the share of the parts that is predicted, with nothing fitted."
    words = about, "share of all parts that is kept, all visibilities", "§2.1, §4.1"
    return verification(claim(f"{name}/kept", words, law, 0.02, found))


def _near(name: str, points: list[Point]) -> Claim:
    """Claim that little of what is lost, over all visibilities, was nearer than V."""
    near = sum(_near_counts(p, "clear") - _near_counts(p, "hazy") for p in points)
    lost = sum(part_counts(p, air="clear") - part_counts(p, air="hazy") for p in points)
    about = "Haze takes nothing that is nearer than the visibility."
    words = about, "share of the parts lost that were nearer than V", _DERIVED
    found = two_sided_share(np.asarray(near, np.float64), np.asarray(lost, np.float64))
    return verification(claim(f"{name}/lost_near", words, 0, 0.01, found, "at most"))


def _near_counts(point: Point, air: str) -> np.ndarray:
    return point.values("parts_nearer_than_V", air=air)


def _shares(name: str, species: str, point: Point) -> list[Claim]:
    """Claim at V = 2 km that at most half of the big parts are kept, and 95 % of the small."""
    made = []
    if species == "tree":
        kept, _ = shares_kept([point], {"air": "hazy"}, {"air": "clear"}, BIG)
        about = "At V = 2 km at least half of the parts over 1 m are gone."
        words = about, "share of parts over 1 m that is kept", _DERIVED
        made.append(claim(f"{name}/kept_over_1m", words, 0.5, 0, kept, "at most"))
    clear = part_counts(point, SMALL, air="clear")
    lost = two_sided_share(clear - part_counts(point, SMALL, air="hazy"), clear)
    about = "At V = 2 km hardly any part under 1 m is gone."
    words = about, "share of parts under 1 m that is lost", _DERIVED
    made.append(claim(f"{name}/lost_under_1m", words, 0, 0.05, lost, "at most"))
    return made
