"""Every claim of the reference run follows from its samples: edit its columns, and it changes.

Experiments whose reference record was not made yet are skipped.
"""

import re
from collections.abc import Iterator, Set
from dataclasses import replace
from pathlib import Path

import pytest

from bench.experiment import experiments
from bench.records.records import Column, Point, Record, read_record, where
from bench.report.document import MARKS
from lod.errors import InputError

EXPERIMENTS = experiments()


PLACE = Path(__file__).parents[3] / "results" / "reference"
LONG = {"images", "figure", "viewing"}
EXPERIMENT = [
    pytest.param(name, marks=pytest.mark.slow if name in LONG else ()) for name in EXPERIMENTS
]

FEW = 24

OF_NOTHING = {"share_of_the_parts_lost_that_were_nearer_than_v/figure/eye/640_px"}
"""Shares of what is none: haze takes no part of a person that an eye before a display sees."""

Points = tuple[Point, ...]
Intervals = dict[str, tuple[float, float, float]]


def reference(name: str) -> Record:
    """The largest record of an experiment: topics that were run apart may have records too."""
    made = [read_record(path) for path in sorted(PLACE.glob(f"{name}-*.json.gz"))]
    judged = [record for record in made if record.version == EXPERIMENTS[name].version]
    if not judged:
        pytest.skip("no reference record of this version yet")
    return max(judged, key=lambda record: len(record.points))


def less(row: list[int]) -> list[int]:
    """Numbers that fall by a third or by a half."""
    return [v - v // (2 + k % 2) for k, v in enumerate(row)]


def more(row: list[int]) -> list[int]:
    """Numbers that grow by one, and here and there by a half as well."""
    return [v + 1 + (k % 3) * v // 4 for k, v in enumerate(row)]


def one_less(row: list[int]) -> list[int]:
    """Numbers that fall by one: a share of few among many stays a share."""
    return [max(v - 1, 0) for v in row]


def shifted(row: list[int]) -> list[int]:
    """Numbers that follow a new order."""
    return [*row[1:], *row[:1]]


def quantity(column: Column) -> str:
    return column.quantity


def full_name(column: Column) -> str:
    return repr((column.quantity, column.keys))


def edits(points: Points) -> Iterator[Points]:
    """The points with one column changed, in every way; in all of them, then in some; then other
    scenes."""
    for naming in (quantity, full_name):
        names = dict.fromkeys(naming(c) for p in points for c in p.samples)
        for change in (less, more, shifted, one_less):
            for name in names:
                yield tuple(edited(p, naming, name, change) for p in points)
    for bit in range(4):
        for name in dict.fromkeys(c.quantity for p in points for c in p.samples):
            yield tuple(
                edited(p, quantity, name, less) if number >> bit & 1 else p
                for number, p in enumerate(points)
            )
    for name in dict.fromkeys(full_name(c) for p in points for c in p.samples):
        for only in range(len(points)):
            yield tuple(
                edited(p, full_name, name, one_less) if number == only else p
                for number, p in enumerate(points)
            )
    yield tuple(replace(p, case=p.case | {"scene": str(k)}) for k, p in enumerate(points))


def edited(point: Point, naming, name: str, change) -> Point:
    samples = (
        replace(c, values=change(c.values)) if naming(c) == name else c for c in point.samples
    )
    return replace(point, samples=tuple(samples))


def thinned(points: Points) -> Points:
    """The points with at most FEW samples a column, so that judging them is quick; the columns
    that list every part of an object stay whole."""
    return tuple(
        replace(
            p,
            samples=tuple(
                replace(c, values=c.values[:: max(1, len(c.values) // FEW)]) for c in p.samples
            ),
        )
        if p.case.get("what") != "sizes"
        else p
        for p in points
    )


def intervals(judge, points: Points) -> Intervals:
    """Measured numbers of all claims; none of samples that make no sense."""
    try:
        return {claim.name: (claim.measured, claim.low, claim.high) for claim in judge(points)}
    except (InputError, ValueError, ZeroDivisionError, IndexError, FloatingPointError):
        return {}


def unmoved(judge, points: Points, aside: Set[str] = frozenset()) -> set[str]:
    """Claims whose numbers no edit changes, some aside."""
    before = intervals(judge, points)
    assert before
    left = set(before) - aside
    for changed in edits(points):
        if not left:
            break
        after = intervals(judge, changed)
        left -= {name for name in left if name in after and after[name] != before[name]}
    return left


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("name", EXPERIMENT)
def test_every_claim_changes_with_its_columns(name):
    experiment, points = EXPERIMENTS[name], thinned(reference(name).points)
    assert {claim.verdict for claim in experiment.judged(points)} <= set(MARKS)
    for key, topic in experiment.topics.items():  # each is judged by itself
        if mine := tuple(where(points, topic=key)):
            assert unmoved(topic.claims, mine, OF_NOTHING) == set()


def test_a_claim_that_rests_on_no_column_is_found():
    judge, points = EXPERIMENTS["law"].topics["depth"].claims, reference("law").points
    points = tuple(where(points, topic="depth"))
    fixed = replace(next(judge(points)), estimand="fixed", condition={})
    assert unmoved(lambda points: (*judge(points), fixed), points) == {"fixed"}


@pytest.mark.parametrize("name", EXPERIMENTS)
def test_every_record_is_drawn_and_told_without_gaps(name):
    experiment, record = EXPERIMENTS[name], reference(name)
    drawn = [each for plot in experiment.plots(record) for each in plot.drawings]
    assert drawn and all(len(each.alt) > 80 and "<svg" in each.svg for each in drawn)
    assert not any(re.search(r"\bnan\b", each.svg + each.alt) for each in drawn)
    for _, (heads, rows) in experiment.tables(record):
        assert rows and {len(row) for row in rows} == {len(heads)}
