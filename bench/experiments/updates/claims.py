"""What the updates experiment claims, judged from its raw counts and times alone (§2)."""

import numpy as np

from bench.records.claims import Claim, claim
from bench.records.records import Point
from bench.statistics.estimates import Estimate, paired_ratio, share

_PAPER, _ISSUE = "§2", "issue 9"
JUDGED_PX = (0.25, 0.5, 1.0)


def judge(points: tuple[Point, ...]) -> tuple[Claim, ...]:
    """Every claim that these points decide."""
    schedules = {p.case["move"]: p for p in points if p.case["what"] == "schedule"}
    made: list[Claim] = []
    if schedules:
        made += [_off(tuple(schedules.values()), threshold) for threshold in JUDGED_PX]
        made += _fewer(schedules)
    return (*made, *(each for p in points if p.case["what"] == "time" for each in _time(p)))


def redrawn(point: Point, rule: str) -> Estimate:
    """Share of the parts that a frame draws anew by a rule."""
    return share(_column(point, f"redrawn {rule}"), _column(point, "parts"))


def off_px(point: Point, rule: str) -> float:
    """The farthest that any part of any field is off [px]."""
    return float(_column(point, f"off {rule}").max()) / 1000


def _off(points: tuple[Point, ...], threshold: float) -> Claim:
    rule = f"{threshold:g} px"
    farthest = max(off_px(point, rule) for point in points)
    about = f"Whatever the camera does, no part is off by more than a threshold of {rule}."
    words = about, "the farthest that a part is off [px]", _ISSUE
    rows = sum(len(point.samples["parts"]) for point in points)
    exact = Estimate(farthest, farthest, farthest, 0.0, 1.0, rows)
    return claim(f"off/{rule.replace(' ', '_')}", words, threshold, 0.0, exact, "at most")


def _fewer(schedules: dict[str, Point]) -> list[Claim]:
    """Of what moves, most may be kept from frame to frame."""
    made = []
    for move, point in schedules.items():
        about = f"Of a crowd in the wind most parts need not be drawn anew in a frame: {move}."
        words = about, "share of the parts drawn anew at ½ px", _PAPER
        made.append(claim(f"{move}/redrawn", words, 0.5, 0.0, redrawn(point, "0.5 px"), "at most"))
    return made


def _time(point: Point) -> list[Claim]:
    whole, kept = _column(point, "all"), _column(point, "scheduled")
    about = "A whole frame takes less time where parts are kept (each by itself, ½ px)."
    words = about, "CPU time, scheduled ÷ all drawn", _ISSUE
    made = [claim("time/whole", words, 1.0, 0.0, paired_ratio(kept, whole), "at most")]
    posing = _column(point, "all, posing")
    about = "Posing what moves is all that keeping parts could save: a fiftieth of a frame at most."
    words = about, "CPU time of posing all that moves ÷ CPU time of the frame, all drawn", _ISSUE
    made.append(claim("time/posing", words, 0.02, 0.0, paired_ratio(posing, whole), "at most"))
    about = "Finding out what to keep takes less time than posing it again."
    words = about, "CPU time of comparing with what was drawn ÷ CPU time of posing", _ISSUE
    ratio = paired_ratio(_column(point, "all, deciding"), posing)
    return [*made, claim("time/deciding", words, 1.0, 0.0, ratio, "at most")]


def _column(point: Point, name: str) -> np.ndarray:
    return np.array(point.samples[name], np.float64)
