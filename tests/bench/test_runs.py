"""An experiment is one file: it is listed, run, resumed and reported, and named nowhere else."""

import importlib
import json
import re
from dataclasses import replace
from pathlib import Path

import pytest

from bench import runs
from bench.experiment import experiments
from bench.records.probe import CASES
from bench.records.provenance import machine
from bench.records.records import read_record
from bench.report.document import Section
from bench.runs import (
    Journal,
    RunRequest,
    dask_executor,
    journal,
    run_experiment,
    run_request,
    serial_executor,
    sources,
)
from lod.errors import InputError
from scenes.processes.ownership import owned
from tests.bench.edited import with_cases
from tests.said import said

PAGE = Path(__file__).parents[2] / "docs" / "extend.md"


@pytest.fixture
def tiny(tmp_path, monkeypatch):
    """The example of the manual as a file of ``bench.experiments``, alone there."""
    folder = tmp_path / "experiments"
    folder.mkdir()
    _, code = re.findall(r"```python\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL)
    (folder / "tiny.py").write_text(code, encoding="utf-8")
    package = importlib.import_module("bench.experiments")
    monkeypatch.setattr(package, "__path__", [str(folder)])
    monkeypatch.setattr(runs, "take_probe", lambda preset: {"preset": preset, "counts": {}})
    experiments.cache_clear()
    yield experiments()["tiny"]
    experiments.cache_clear()


def test_one_file_is_listed_run_resumed_and_reported(tiny, tmp_path, capfd):
    code, out, _ = said(capfd, "list", "--json")
    assert code == 0 and "parts of a person against distance" in out
    run = ("run", "tiny", "--quick", "-o", tmp_path / "out", "--json")
    code, out, err = said(capfd, *run)
    assert code == 0, err
    made = json.loads(out)
    (claim,) = made["claims"]
    assert claim["name"] == "parts_displayed/person/80_m_over_20_m"
    assert claim["sentence"] == "Parts displayed ≤ 0.5 (person, 80 m ÷ 20 m)."
    assert claim["verdict"] == "holds" and claim["low"] < claim["measured"] < claim["high"] < 0.5
    record = read_record(Path(made["record"]))
    assert [case["case"] for case in record.notes[CASES]] == ["20, 8", "40, 8", "80, 8"]
    assert all(case["cpu"] and case["seconds"] >= 0 for case in record.notes[CASES])
    code, out, err = said(capfd, *run)
    assert code == 0 and json.loads(out)["kept"] and "done already" in err
    code, _, err = said(capfd, "report", tmp_path / "out")
    assert code == 0, err
    pages = [(tmp_path / "out" / name).read_text() for name in ("report.html", "report.md")]
    assert all(
        tiny.question in page and claim["name"] in page.replace("<wbr>", "") for page in pages
    )
    (told,) = json.loads((tmp_path / "out" / "claims.json").read_text())
    assert told["claims"] == [claim]


def request(seed=0):
    return RunRequest("tiny", ("tiny",), quick=True, seed=seed)


def run(tiny, kept, executor=serial_executor, seed=0):
    return run_request(tiny, request(seed), kept, executor, lambda *_: None)


def test_a_stopped_run_goes_on_where_it_stopped(tiny, tmp_path):
    measured = []

    def stopping(function, cases):
        for case in cases:
            if len(measured) == 2:
                raise KeyboardInterrupt
            measured.append(case[0].args)
            yield function(*case)

    with pytest.raises(KeyboardInterrupt):
        run(tiny, journal(tmp_path), stopping)
    assert len(measured) == 2
    again = []

    def rest(function, cases):
        again.extend(case.args for case, _ in cases)
        return serial_executor(function, cases)

    _, record = run(tiny, journal(tmp_path), rest)
    assert again == [(80.0, 8)]
    whole = run_experiment(tiny, request())
    assert record.points == whole.points and record.claims == whole.claims
    assert journal(tmp_path).record_of(request()) == tmp_path / record.name
    assert journal(tmp_path).record_of(request(seed=1)) is None


SHAPES = [
    None,
    [],
    {"points": 3, "made": {}},
    {"points": [{"case": {}}], "made": {"seconds": 1, "processor_seconds": 1}},
    {"points": [], "made": {"seconds": "1"}},
]


@pytest.mark.parametrize(
    "damage",
    [
        *("", "{", '{"sha256": "", "data": {"points": []}}', "[" * 10**5),
        *(json.dumps({"sha256": runs._sha256(data), "data": data}) for data in SHAPES),
    ],
)
def test_a_damaged_case_is_measured_again(tiny, tmp_path, damage):
    kept = journal(tmp_path)

    def first(function, cases):
        yield function(*cases[0])
        raise ValueError("stopped")

    with pytest.raises(ValueError, match="stopped"):
        run(tiny, kept, first)
    for path in tmp_path.glob(".journal/cases-*/*.json"):
        path.write_text(damage)
    _, record = run(tiny, kept)
    assert record.points == run_experiment(tiny, request()).points


def test_a_journal_that_names_another_record_is_not_believed(tiny, tmp_path):
    (tmp_path / "up").mkdir()
    kept = journal(tmp_path / "up")
    one, _ = run(tiny, kept)
    other, record = run(tiny, kept, seed=1)
    outside = one.rename(tmp_path / one.name)
    for name in (other.name, f"../{outside.name}", str(outside), "..", "", record.name + "x"):
        runs._write(kept._path("record", request()), name)
        assert kept.record_of(request()) is None, name
    assert kept.record_of(request(seed=1)) == other


def test_while_one_measures_others_are_refused(tiny, tmp_path, capfd):
    with owned(tmp_path, "another", "measures there"):
        code, out, err = said(capfd, "run", "tiny", "--quick", "--again", "-o", tmp_path)
    assert (code, out, err.count("\n")) == (2, "", 1)
    assert "measures there; wait for its end, or choose another folder" in err
    assert said(capfd, "run", "tiny", "--quick", "-o", tmp_path)[0] == 0


def test_other_sources_or_another_machine_measure_again(tiny, tmp_path):
    path, _ = run(tiny, journal(tmp_path))
    assert journal(tmp_path).record_of(request()) == path
    assert Journal(tmp_path, "another maker").record_of(request()) is None
    path.write_text(path.read_text().replace("person", "people"))
    assert journal(tmp_path).record_of(request()) is None, "the record is damaged"
    assert re.fullmatch("[0-9a-f]{64}", sources())


@pytest.mark.parametrize(("differs", "kept"), [("platform", True), ("cpu", False)])
def test_another_kernel_goes_on_and_another_processor_does_not(
    tiny, tmp_path, monkeypatch, differs, kept
):
    path, _ = run(tiny, journal(tmp_path))
    elsewhere = replace(runs.provenance("", 0), **{differs: "another"})
    monkeypatch.setattr(runs, "provenance", lambda *_: elsewhere)
    assert journal(tmp_path).record_of(request()) == (path if kept else None)


def test_cases_are_kept_on_another_processor(tiny, tmp_path, monkeypatch):
    """A run that was stopped goes on there, and its record says what was measured where."""
    topic, asked = tiny.topics["tiny"], request()
    whole = list(topic.cases(**topic.sizes("quick" if asked.quick else "full")))
    first = journal(tmp_path).memoised(asked, serial_executor)
    next(first(runs.measured_case, [(whole[0], asked.seed)]))
    elsewhere = replace(runs.provenance("", 0), cpu="another")
    monkeypatch.setattr(runs, "provenance", lambda *_: elsewhere)
    monkeypatch.setattr(runs, "machine", lambda: machine() | {"cpu": "another"})
    _, record = run(tiny, journal(tmp_path))
    assert [each["cpu"] == "another" for each in record.notes[CASES]] == [False, True, True]
    (told,) = (words for name, words in Section(record, "", (), ()).origin if name == "cases")
    assert "1 of " in told and "2 of " in told and " on another, " in told


def test_what_is_timed_is_measured_in_one_go(tiny, tmp_path):
    def never(function, cases):
        raise AssertionError("asked of a cluster")

    _, record = run(replace(tiny, timed=True), journal(tmp_path), never)
    assert len(record.points) == 3
    assert not list(tmp_path.glob(".journal/cases-*/*.json"))


def test_two_claims_of_one_name_are_refused(tiny):
    topic = tiny.topics["tiny"]
    topics = {"tiny": replace(topic, claims=lambda points: 2 * topic.claims(points))}
    twice = replace(tiny, topics=topics)
    with pytest.raises(InputError, match="one name"):
        run_experiment(twice, request())


@pytest.mark.slow
def test_a_cluster_gives_the_same_numbers():
    law = experiments()["law"]
    asked = RunRequest("law", ("depth",), quick=True)
    few = with_cases(law, "depth", law.topics["depth"].cases(fields=3)[:4])
    with dask_executor("2", lambda text: None) as spread:
        assert run_experiment(few, asked, spread).points == run_experiment(few, asked).points
