"""A small record of the scaling experiment, measured once, and its report."""

from dataclasses import replace

import pytest

from bench.experiment import experiments
from bench.experiments.scaling.measure import sampled_cases
from bench.fields.cases import Case
from bench.old_experiment import Effort
from bench.records.records import write_record
from bench.report.write import write_report
from bench.runs import run_experiment

EXPERIMENTS = experiments()


@pytest.fixture(scope="session")
def record():
    base = Case("density", "figure", "blake", density=0.02, detail=10.0)
    grid = (
        *(replace(base, density=0.01 * k) for k in (1, 3)),
        *(replace(base, sweep="detail", detail=10.0 * k) for k in (1, 2)),
        *(replace(base, sweep="world", extent=50.0 * k) for k in (1, 10, 100)),
        *(replace(base, metric="bounded", detail=5.0 * k) for k in (1, 2)),
    )
    effort = Effort("quick", {"target": 0.1, "least": 3, "most": 20})
    experiment = replace(
        EXPERIMENTS["scaling"], cases=lambda effort, metric: sampled_cases(grid, effort)
    )
    return run_experiment(experiment, effort)


@pytest.fixture(scope="session")
def folder(record, tmp_path_factory):
    place = tmp_path_factory.mktemp("results")
    write_record(record, place)
    write_report(place)
    return place
