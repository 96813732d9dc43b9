"""Faults that are planted in the program are caught by the experiments' quick runs.

Each turns a claim from holds to refuted. What is planted is one line of the program, and the
experiment measures and judges as it always does.
"""

from dataclasses import replace

import pytest

from bench.experiments.registry import EXPERIMENTS
from bench.runner.run_experiment import run_experiment
from lod.atmosphere.air import CLEAR
from scenes.render.haze import haze

pytestmark = pytest.mark.slow


def verdicts(name, cases, seed=0):
    """Verdicts of a quick run of some of an experiment's cases."""
    experiment = replace(
        EXPERIMENTS[name], cases=lambda *of: cases, notes=None, accepts_metric=False
    )
    return {
        c.name: c.verdict
        for c in run_experiment(experiment, experiment.effort("quick"), seed).claims
    }


def test_denser_air_in_the_renderer_alone_is_found_by_air(monkeypatch):
    """β is 1.05 times what the air says."""
    experiment = EXPERIMENTS["air"]
    cases = experiment.cases(experiment.effort("quick"))
    cases = [c for c in cases if getattr(c, "way", "") == "jit"]
    if not cases:
        pytest.skip("no variant with a just-in-time compiler works here")
    before = verdicts("air", cases)
    make = haze.make_haze
    monkeypatch.setattr(
        haze,
        "make_haze",
        lambda built, air: make(
            built, air if air == CLEAR else replace(air, visibility_m=air.visibility_m / 1.05)
        ),
    )
    after = verdicts("air", cases)
    for band in ("red", "green", "blue"):
        name = f"jit/beta/{band}"
        assert (before[name], after[name]) == ("holds", "refuted"), name
