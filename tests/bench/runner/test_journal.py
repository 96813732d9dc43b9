"""A run that was stopped goes on where it was, to the same records, and nothing else is kept."""

import json
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from bench.cli.main import main
from bench.cli.progress import RunTime, duration_text, seconds_left, time_left_text
from bench.experiments import registry as experiments
from bench.experiments.registry import EXPERIMENTS
from bench.experiments.scaling import measure as scaling
from bench.fields.cases import Case
from bench.records.points import Point, columns
from bench.records.records import read_record, read_records
from bench.runner import journal as journal_file
from bench.runner.dask_cases import serial_executor
from bench.runner.journal import Elapsed, Journal, RunRequest, journal
from bench.statistics.sample_size import StoppingRule

BASE = Case("density", "figure", "blake", density=0.01, detail=20.0)
GRID = tuple(replace(BASE, density=0.01 * k) for k in range(1, 9))


@pytest.fixture
def small(monkeypatch):
    fast = replace(
        EXPERIMENTS["scaling"],
        cases=lambda effort, metric: scaling.sampled_cases(GRID, effort),
        quick={"target": 0.5, "least": 2, "most": 4},
        expected_seconds={"full": 1.0, "quick": 1.0},
    )
    monkeypatch.setattr(experiments, "EXPERIMENTS", {"scaling": fast})


def run(folder: Path, *words: str) -> int:
    with pytest.raises(SystemExit) as left:
        main(["run", "all", "--quick", "-o", str(folder), *words])
    return left.value.code


def stop_after(monkeypatch, cases: int) -> list[Case]:
    """Have Ctrl-C come after so many cases; gives what was measured."""
    measured, measure = [], scaling.measure

    def counted(case, seed):
        if len(measured) == cases:
            raise KeyboardInterrupt
        measured.append(case.case)
        return measure(case, seed)

    monkeypatch.setattr(scaling, "measure", counted)
    return measured


def test_stopped_at_five_random_moments_it_makes_the_unbroken_runs_record(
    small, tmp_path, monkeypatch, capfd
):
    assert run(tmp_path / "whole") == 0
    (whole,) = read_records(tmp_path / "whole")
    stops = np.diff(np.sort(np.random.default_rng(1).choice(8, 5, replace=False)), prepend=0)
    seen = []
    for stop in [*stops.tolist(), None]:
        with monkeypatch.context() as patch:
            measured = stop_after(patch, len(GRID) if stop is None else stop)
            assert run(tmp_path / "broken") == (0 if stop is None else 130)
            seen += measured
    (broken,) = read_records(tmp_path / "broken")
    assert broken.samples_sha256 == whole.samples_sha256 and broken.claims == whole.claims
    assert seen == list(GRID)  # nothing was measured twice
    assert list((tmp_path / "broken" / ".journal").glob("cases-*/*.json")) == []


def test_what_is_done_is_kept_and_can_be_measured_anew(small, tmp_path, capfd):
    assert run(tmp_path, "--json") == 0
    first = json.loads(capfd.readouterr().out)
    assert run(tmp_path, "--json") == 0
    out, err = capfd.readouterr()
    kept = json.loads(out)
    assert (first["kept"], kept["kept"]) == (False, True) and kept["record"] == first["record"]
    assert "scaling is done already (--again measures anew)" in err
    assert run(tmp_path, "--again", "--json") == 0
    again = json.loads(capfd.readouterr().out)
    assert again["kept"] is False
    assert read_record(Path(again["record"])).points == read_record(Path(first["record"])).points


def test_a_lost_or_edited_record_is_measured_again(small, tmp_path):
    assert run(tmp_path) == 0
    (record,) = tmp_path.glob("scaling-*.json")
    asked, kept = RunRequest("scaling", True, 0), journal(tmp_path)
    assert kept.record_of(asked) == record
    record.write_text(record.read_text().replace('"seed": 0', '"seed": 1', 1))
    assert kept.record_of(asked) is None
    record.unlink()
    assert kept.record_of(asked) is None


def test_nothing_is_taken_for_what_was_asked_otherwise(tmp_path, monkeypatch):
    asked, kept = RunRequest("scaling", True, 0), Journal(tmp_path, "maker")
    calls = []

    def double(case, seed):
        calls.append(case)
        return scaling.measure(case, seed)

    def once(kept, asked, fields=2, seed=0):
        case = scaling.SampledCase(BASE, StoppingRule(0.5, 2, fields)), seed
        return next(iter(kept.memoised(asked, serial_executor)(double, [case])))

    assert once(kept, asked) == once(kept, asked) and len(calls) == 1
    once(Journal(tmp_path, "other sources"), asked)
    once(kept, replace(asked, seed=1))
    once(kept, replace(asked, quick=False))
    once(kept, asked, seed=1)
    once(kept, asked, fields=3)
    assert len(calls) == 6
    maker = journal(tmp_path).maker
    monkeypatch.setattr(journal_file, "sources", lambda: "changed")
    assert journal(tmp_path).maker != maker


def test_a_record_counts_the_time_before_it_was_stopped(small, tmp_path):
    asked, kept = RunRequest("scaling", True, 0), journal(tmp_path)
    assert kept.elapsed(asked) == Elapsed(0.0, 0.0)
    list(kept.memoised(asked, serial_executor)(slowly, [(0.02,), (0.03,)]))
    spent = kept.elapsed(asked)
    assert 0.05 <= spent.seconds < 5 and 0.0 <= spent.processor_seconds < 5
    for path in tmp_path.glob(".journal/cases-*/*.json"):
        path.write_text(json.dumps(json.loads(path.read_text()) | {"seconds": 1000.0}))
    assert run(tmp_path) == 0
    (record,) = read_records(tmp_path)
    assert 2000.0 < record.notes["seconds"] < 2100.0
    assert 0 < record.notes["processor_seconds"] < 100.0


def slowly(seconds):
    time.sleep(seconds)
    return Point({"seconds": seconds}, samples=columns({"n": [1]}))


def test_half_a_file_is_measured_again(tmp_path):
    asked, kept = RunRequest("scaling", True, 0), Journal(tmp_path, "maker")
    cases = [(scaling.SampledCase(BASE, StoppingRule(0.5, 2, 2)), 0)]
    (first,) = kept.memoised(asked, serial_executor)(scaling.measure, cases)
    (path,) = tmp_path.glob(".journal/cases-*/*.json")
    path.write_text(path.read_text()[:-20])
    (second,) = kept.memoised(asked, serial_executor)(scaling.measure, cases)
    assert first == second and json.loads(path.read_text())


def test_one_that_fails_does_not_end_the_others(small, tmp_path, monkeypatch, capfd):
    def fail(case, seed):
        raise RuntimeError("the lamp went out")

    broken = replace(EXPERIMENTS["scaling"], cases=lambda effort, metric: [1], measure=fail)
    others = {"broken": broken, **experiments.EXPERIMENTS}
    monkeypatch.setattr(experiments, "EXPERIMENTS", others)
    assert run(tmp_path) == 1
    err = capfd.readouterr().err
    assert "broken failed: RuntimeError: the lamp went out" in err
    assert "1 of 2 failed: broken" in err
    assert [record.experiment for record in read_records(tmp_path)] == ["scaling"]


def test_time_left_follows_the_pace_so_far():
    assert seconds_left([10.0, 20.0], []) == 30.0
    assert seconds_left([10.0, 20.0], [RunTime(10.0, 25.0), RunTime(10.0, 15.0)]) == 60.0
    assert duration_text(89) == "89 s" and duration_text(600) == "10 min"
    takes = {"a": 10.0, "b": 590.0}
    assert time_left_text(["a", "b"], takes, []) == "about 10 s; 10 min for all that is left"
    assert time_left_text(["b"], takes, [RunTime(10.0, 20.0)]) == "about 20 min"
