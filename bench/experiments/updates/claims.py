"""What the updates experiment claims, judged from its raw counts and times alone (§2)."""

from bench.records.claims import Claim
from bench.records.old_claims import claim, verification
from bench.records.records import Point, where
from bench.statistics.estimates import Estimate, exactly, two_sided_paired_ratio, two_sided_share
from lod.arrays import Reals

_PAPER, _DERIVED = "§2", "derived: docs/method.md"
JUDGED_PX = (0.25, 0.5, 1.0)


def judge(points: tuple[Point, ...]) -> tuple[Claim, ...]:
    """Return every claim that these points decide."""
    schedules = {p.case["move"]: p for p in where(points, what="schedule")}
    made: list[Claim] = []
    if schedules:
        made += [_off(tuple(schedules.values()), threshold) for threshold in JUDGED_PX]
        made += _fewer(schedules)
    return (*made, *(each for p in where(points, what="time") for each in _time(p)))


def redrawn(point: Point, rule: str) -> Estimate:
    """Estimate the share of the parts that a frame draws anew by a rule."""
    return two_sided_share(point.values("redrawn", rule=rule), point.values("parts"))


def off_px(point: Point, rule: str) -> float:
    """Return the farthest that any part of any field is off [px]."""
    return float(point.values("off_mpx", rule=rule).max()) / 1000


def _off(points: tuple[Point, ...], threshold: float) -> Claim:
    rule = f"{threshold:g} px"
    farthest = max(off_px(point, rule) for point in points)
    about = f"Whatever the camera does, no part is off by more than a threshold of {rule}."
    words = about, "the farthest that a part is off [px]", _DERIVED
    rows = sum(len(point.column("parts")) for point in points)
    name = f"off/{rule.replace(' ', '_')}"
    found = exactly(farthest, rows)
    return verification(claim(name, words, threshold, 0.0, found, "at most"))


def _fewer(schedules: dict[str, Point]) -> list[Claim]:
    """Claim that most of what moves may be left as it was drawn from frame to frame."""
    made = []
    for move, point in schedules.items():
        about = f"Of a crowd in the wind most parts need not be drawn anew in a frame: {move}."
        words = about, "share of the parts drawn anew at ½ px", _PAPER
        made.append(claim(f"{move}/redrawn", words, 0.5, 0.0, redrawn(point, "0.5 px"), "at most"))
    return made


def _time(point: Point) -> list[Claim]:
    whole, kept = cpu_us(point, "all"), cpu_us(point, "scheduled")
    about = "A whole frame takes less time where parts are kept (each by itself, ½ px)."
    words = about, "CPU time, scheduled ÷ all drawn", _DERIVED
    made = [claim("time/whole", words, 1.0, 0.0, two_sided_paired_ratio(kept, whole), "at most")]
    posing = cpu_us(point, "all", "posing")
    about = "Posing what moves is all that keeping parts could save: a fiftieth of a frame at most."
    words = about, "CPU time of posing all that moves ÷ CPU time of the frame, all drawn", _DERIVED
    made.append(
        claim("time/posing", words, 0.02, 0.0, two_sided_paired_ratio(posing, whole), "at most")
    )
    about = "Finding out what to keep takes less time than posing it again."
    words = about, "CPU time of comparing with what was drawn ÷ CPU time of posing", _DERIVED
    ratio = two_sided_paired_ratio(cpu_us(point, "all", "deciding"), posing)
    return [*made, claim("time/deciding", words, 1.0, 0.0, ratio, "at most")]


def cpu_us(point: Point, way: str, stage: str = "frame") -> Reals:
    """Return the CPU time of a stage of every frame that is drawn in a way [µs]."""
    return point.values("cpu_us", way=way, stage=stage)
