"""Cases on a cluster give the numbers that they give here, in their order."""

import pickle

import pytest

from bench.cli.main import main
from bench.experiments.registry import EXPERIMENTS
from bench.experiments.scaling.measure import SampledCase, measure
from bench.fields.cases import cases
from bench.runner.dask_cases import dask_executor, serial_executor
from bench.runner.run_experiment import run_experiment
from bench.statistics.sample_size import StoppingRule

RULE = StoppingRule(target=0.5, least=2, most=2)


def test_a_cluster_counts_what_is_counted_here():
    pytest.importorskip("distributed")
    grid = sorted(cases(), key=lambda case: case.density)[:3]
    jobs, said = [(SampledCase(case, RULE), 7) for case in grid], []
    with dask_executor("1", said.append) as each:
        there = list(each(measure, jobs))
    here = list(serial_executor(measure, jobs))
    assert [(p.case, p.samples) for p in there] == [(p.case, p.samples) for p in here]
    assert len({str(p.case) for p in here}) == 3
    assert "dashboard at http" in said[0]


def test_here_nothing_is_begun_before_it_is_asked_for():
    calls = []
    results = serial_executor(lambda n: calls.append(n) or n, [(1,), (2,)])
    assert calls == [] and next(results) == 1 and calls == [1]
    with dask_executor(None, calls.append) as each:
        assert each is serial_executor


class Gone(Exception):
    """Sent off to a cluster."""


@pytest.mark.parametrize("name", [name for name, each in EXPERIMENTS.items() if not each.timed])
def test_cases_of_every_experiment_that_is_not_timed_can_be_sent_to_a_cluster(name):
    sent = []

    def send(function, cases):
        again, there = pickle.loads(pickle.dumps((function, list(cases))))
        assert again == function and there == list(cases) and cases
        sent.append(function)
        raise Gone

    with pytest.raises(Gone):
        experiment = EXPERIMENTS[name]
        run_experiment(experiment, experiment.effort("quick"), 3, send)
    assert len(sent) == 1


@pytest.mark.slow
def test_pictures_compared_on_a_cluster_are_those_compared_here():
    pytest.importorskip("distributed")
    experiment = EXPERIMENTS["spectrum"]
    here = run_experiment(experiment, experiment.effort("quick"), 3)
    with dask_executor("2", lambda _: None) as each:
        there = run_experiment(experiment, experiment.effort("quick"), 3, each)
    assert there.samples_sha256 == here.samples_sha256 and there.claims == here.claims


def test_what_is_timed_stays_on_one_machine(tmp_path, capfd):
    timed = [name for name, each in EXPERIMENTS.items() if each.timed]
    if not timed:
        pytest.skip("every experiment can be spread")
    with pytest.raises(SystemExit) as left:
        main(["run", timed[0], "--quick", "-o", str(tmp_path), "--cluster", "2"])
    assert left.value.code == 2 and "--cluster" in capfd.readouterr().err
