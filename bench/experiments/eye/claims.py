"""What the eye experiment claims, judged from its raw points alone."""

from bench.part_sizes import part_counts, shares_kept
from bench.records.claims import Claim
from bench.records.old_claims import claim, verification
from bench.records.records import Point, grouped, where
from bench.statistics.estimates import two_sided_share

JUDGED_AT = 67.0
"""The pixels per degree of the display at which shares are claimed."""

VIEWERS = ("blur", "contrast", "faint", "both")
_DERIVED = "derived: docs/method.md"


def judge(points: tuple[Point, ...]) -> tuple[Claim, ...]:
    """Return every claim that these points decide."""
    made: list[Claim] = []
    for (species,), chosen in grouped(points, "species").items():
        made += [_law(species, viewer, chosen) for viewer in VIEWERS]
        at = where(chosen, pixels_per_degree=JUDGED_AT)
        made += [each for p in at for each in (_square(species, p), _beyond_blur(species, p))]
    return tuple(made)


def _law(species: str, viewer: str, points: list[Point]) -> Claim:
    """Claim the share over all displays."""
    found, law = shares_kept(points, {"viewer": viewer}, {"viewer": "ideal"})
    about = "Display and eye leave the share of the parts that is predicted, with nothing fitted."
    words = about, "share of all parts that is kept, all displays", "§2.1, §4.1"
    return verification(claim(f"{species}/{viewer}/kept", words, law, 0.02, found))


def _square(species: str, point: Point) -> Claim:
    about = "Blur leaves one part in θ_eff² (θ_eff in pixels), at 67 pixels per degree."
    words = about, "share of the parts that blur leaves", "§2.1, §4.1"
    found, _ = shares_kept([point], {"viewer": "blur"}, {"viewer": "ideal"})
    share = point.case["blur_px"] ** -2
    return verification(claim(f"{species}/blur/square", words, share, 0.01, found))


def _beyond_blur(species: str, point: Point) -> Claim:
    blurred = part_counts(point, viewer="blur")
    lost = two_sided_share(blurred - part_counts(point, viewer="both"), blurred)
    about = "At 67 pixels per degree blur decides alone, even for parts of a contrast of 0.1."
    words = about, "share of what blur leaves that contrast takes", _DERIVED
    return verification(claim(f"{species}/both/beyond_blur", words, 0, 0.01, lost, "at most"))
