"""A small record of the experiment law, measured once, and its report."""

import shutil
from dataclasses import replace
from functools import partial

import pytest

from bench.counting import Case
from bench.experiments.law import EXPERIMENT, measure_scaling
from bench.records.records import write_record
from bench.report.write import write_report
from bench.runs import RunRequest, run_experiment
from bench.statistics.estimates import StoppingRule


@pytest.fixture(scope="session")
def record():
    base = Case("density", "figure", "blake", density=0.02, detail=10.0)
    grid = (
        *(replace(base, density=0.01 * k) for k in (1, 3)),
        *(replace(base, sweep="detail", detail=10.0 * k) for k in (1, 2)),
        *(replace(base, sweep="world", extent=50.0 * k) for k in (1, 10, 100)),
        *(replace(base, metric="bounded", detail=5.0 * k) for k in (1, 2)),
    )
    sampled = [partial(measure_scaling, case, StoppingRule(0.1, 3, 20)) for case in grid]
    topic = replace(EXPERIMENT.topics["scaling"], cases=lambda **sizes: sampled)
    experiment = replace(EXPERIMENT, topics={"scaling": topic})
    return run_experiment(experiment, RunRequest("law", ("scaling",), quick=True))


@pytest.fixture(scope="session")
def folder(record, tmp_path_factory):
    place = tmp_path_factory.mktemp("results")
    write_record(record, place)
    write_report(place)
    return place


@pytest.fixture(scope="module")
def browser():
    """The chromium of the system, without a window."""
    chromium = shutil.which("chromium")
    if chromium is None:
        pytest.skip("chromium is not installed")
    from playwright.sync_api import sync_playwright

    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=chromium, args=["--no-sandbox"])
        yield browser
        browser.close()
