"""The verdicts of the reference run follow from its samples: change those by hand, and they change.

Experiments whose reference record was not made yet are skipped.
"""

import json
from dataclasses import replace
from pathlib import Path

import pytest

from bench.experiments.registry import EXPERIMENTS
from bench.records.records import read_record
from bench.report.words import MARKS
from lod.errors import InputError

PLACE = Path(__file__).parents[3] / "results" / "reference"
LONG = {"scaling", "fidelity", "figure"}
EXPERIMENT = [
    pytest.param(name, marks=pytest.mark.slow if name in LONG else ()) for name in EXPERIMENTS
]


def reference(name):
    paths = sorted(PLACE.glob(f"{name}-*.json"))
    if not paths:
        pytest.skip("no reference record yet")
    return read_record(paths[0])


def edited(record, change):
    """Every column of every point's samples changed."""
    points = tuple(
        replace(point, samples={
            name: change(row, number, column)
            for column, (name, row) in enumerate(point.samples.items())
        })
        for number, point in enumerate(record.points)
    )  # fmt: skip
    return replace(record, points=points)


def one_column(which, change):
    return lambda row, number, column: change(row) if column == which else row


CHANGES = (
    lambda row, number, column: [v * (1 + number % 3) for v in row],
    lambda row, number, column: [v * (1 + number) for v in row] if column else row,
    lambda row, number, column: [v * (1 + 8 * (column % 2)) for v in row],
    lambda row, number, column: [v // 5 for v in row],
    lambda row, number, column: [v * (9 - 8 * (column % 2)) for v in row],
    lambda row, number, column: row[::-1] if column == len(row) % 2 else row,
    *(one_column(which, lambda row: row[::-1]) for which in range(4)),
    *(one_column(which, lambda row: [9 * v for v in row]) for which in range(4)),
)


def verdicts(name, record):
    try:
        return {claim.name: claim.verdict for claim in EXPERIMENTS[name].judge(record)}
    except (InputError, ValueError, ZeroDivisionError, IndexError):
        return {}  # samples that make no sense are no verdict either


@pytest.mark.parametrize("name", EXPERIMENT)
def test_a_record_changed_by_hand_changes_its_verdicts(name):
    record = reference(name)
    before = verdicts(name, record)
    assert before and set(before.values()) <= set(MARKS)
    changed = (verdicts(name, edited(record, change)) for change in CHANGES)
    assert any(after and after != before for after in changed)


def test_a_record_changed_by_hand_is_not_even_read(tmp_path):
    path = next(iter(sorted(PLACE.glob("air-*.json"))))
    body = json.loads(path.read_text(encoding="utf-8"))
    body["content"]["points"][0]["samples"] = {}
    (tmp_path / path.name).write_text(json.dumps(body), encoding="utf-8")
    with pytest.raises(InputError, match="SHA-256"):
        read_record(tmp_path / path.name)
