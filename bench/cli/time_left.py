"""How long a run of experiments still takes, from what each should take and what some have."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass


@dataclass(frozen=True)
class Took:
    """What an experiment should take, and what it has taken [s]."""

    expected_s: float
    measured_s: float


def seconds_left(expected_s: Iterable[float], took: Iterable[Took]) -> float:
    """What is left at the pace of what is done; at the expected pace before anything is."""
    done = list(took)
    planned, spent = sum(each.expected_s for each in done), sum(each.measured_s for each in done)
    return sum(expected_s) * (spent / planned if planned else 1.0)


def in_words(seconds: float) -> str:
    """``40 s`` or ``12 min``."""
    return f"{seconds:.0f} s" if seconds < 90 else f"{seconds / 60:.0f} min"


def plan(names: Iterable[str], expected_seconds: Mapping[str, float], took: Iterable[Took]) -> str:
    """What comes next, how long that takes, and how long it all does; names begin with the next."""
    done = list(took)
    left = [expected_seconds[name] for name in names]
    first, whole = (in_words(seconds_left(each, done)) for each in (left[:1], left))
    return f"about {first}" if len(left) == 1 else f"about {first}; {whole} for all that is left"
