"""What other packages bring: listed, counted by, checked; and a broken one costs one line."""

import importlib
import json
import os
import subprocess
import sys
from functools import partial
from pathlib import Path

import pytest

from bench.conformance import FORMULA
from bench.counting import scaling_grid
from bench.experiment import experiments
from bench.experiments.law import EXPERIMENT as law
from bench.experiments.law import measure_scaling
from bench.records.provenance import provenance
from bench.runs import sources
from bench.statistics.estimates import StoppingRule
from lod.metric import METRICS, Metric
from scenes import plugins
from scenes.render.variants import choose, trusting
from tests.bench.edited import with_cases
from tests.said import said

EXPERIMENTS = experiments()


PLACE = Path(__file__).parents[1] / "plugin"
ROOT = PLACE.parents[1]
EXAMPLE = ROOT / "examples" / "plugin"
SMALL = ("--size", "64x36", "-D", 'species={one={model="rabbit", density=0.3}}')
HALFWAY = ("--metric", "halfway")
RAIL = ("-D", 'representations.rail={kind="fence", options={posts=9}}')


@pytest.fixture
def package(monkeypatch):
    """The example package, as if it were installed; gone again afterwards."""
    caches = plugins.installed, plugins.metric_by_name, sources
    monkeypatch.syspath_prepend(str(EXAMPLE))
    monkeypatch.syspath_prepend(str(PLACE))
    importlib.invalidate_caches()
    for each in caches:
        each.cache_clear()
    yield
    for each in caches:
        each.cache_clear()


@pytest.mark.usefixtures("package")
def test_the_list_shows_them_and_what_is_wrong_with_the_broken_ones(capfd):
    code, out, _ = said(capfd, "list", "--json")
    found = json.loads(out)
    assert code == 0
    assert "from lodbench-example 1.0" in found["metrics"]["halfway"]
    assert "from lodbench-example 1.0" in found["representations"]["fence"]
    assert "No module named 'lodbench_nowhere'" in found["metrics"]["missing"]
    assert "nan" in found["metrics"]["often_nan"]
    assert found["metrics"]["blake"] == METRICS["blake"].about  # nobody takes a name of ours


@pytest.mark.usefixtures("package")
def test_a_frame_is_counted_by_a_metric_of_theirs_and_held_against_its_law(capfd):
    flat = "-D", "terrain.amplitude=0", "-D", "terrain.reach=64", "-D", "camera.position=[0, -6]"
    code, out, err = said(capfd, "count", "meadow", *SMALL, *RAIL, *flat, "--json", *HALFWAY)
    assert code == 0, err
    found = json.loads(out)
    parts = found["parts"]
    assert parts["displayed"] > 20
    assert abs(parts["displayed"] - parts["predicted"]) < 4 * parts["predicted_sd"]
    rail = found["others"]["rail"]
    assert rail["objects"]["displayed"] == 1
    assert 1 < rail["parts"]["displayed"] <= 10
    assert rail["parts"]["predicted"] is None


@pytest.mark.usefixtures("package")
@pytest.mark.parametrize(
    ("flags", "says"),
    [
        (("--metric", "missing"), "--metric: 'missing': can be imported"),
        (("--metric", "misnamed"), "is called as its entry point is"),
        (("-D", 'representations.x={kind="no_offer"}'), "not type"),
        (("-D", "representations.x={}"), "representations.x.kind"),
    ],
)
def test_a_broken_one_costs_a_clear_line(capfd, flags, says):
    code, out, err = said(capfd, "count", "meadow", *SMALL, *flags)
    assert (code, out) == (2, "")
    assert says in err
    assert len(err.splitlines()) == 1


@pytest.mark.usefixtures("package")
def test_theirs_keep_the_rules_of_ours(capfd):
    code, out, _ = said(capfd, "doctor", "--check", "halfway", "--check", "fence", "--json")
    assert code == 0
    assert [json.loads(line)["broken"] for line in out.splitlines()] == [{}, {}]


@pytest.mark.usefixtures("package")
def test_check_notices_and_names_what_is_broken(capfd):
    code, out, err = said(capfd, "doctor", "--check", "sloppy", "--check", "missing")
    assert code == 1
    assert "another limit when asked alone" in out
    assert "No module named" in out
    assert "sloppy, missing" in err


@pytest.mark.slow
@pytest.mark.usefixtures("package")
def test_experiments_that_try_metrics_try_theirs_beside_ours(tmp_path, capfd, monkeypatch):
    grid = scaling_grid("halfway")
    some = [case for case in grid if (case.metric, case.sweep) == ("halfway", "detail")][:3]
    rule = StoppingRule(0.2, 2, 4)
    sampled = [partial(measure_scaling, each, rule) for each in (*grid[:3], *some)]
    fast = with_cases(law, "scaling", sampled)
    monkeypatch.setitem(EXPERIMENTS, "law", fast)
    code, out, err = said(
        capfd, "run", "scaling", "--quick", *HALFWAY, "-o", str(tmp_path), "--json"
    )
    assert code == 0, err
    names = {claim["name"] for claim in json.loads(out)["claims"]}
    assert {f"objects_displayed_over_predicted/{m}/figure" for m in ("halfway", "blake")} <= names
    for wrong, says in (
        (
            ("run", "scaling", "cost", *HALFWAY),
            "experiments that try metrics: law, figure, images",
        ),
        (("run", "scaling", "--metric", "blake"), "ours are tried anyhow"),
        (("run", "scaling", "--metric", "missing"), "No module named"),
    ):
        code, _, err = said(capfd, *wrong, "-o", str(tmp_path))
        assert code == 2 and says in err


WRONG = {
    "answers_with_distances": lambda P, R, m: P / m - R,
    "knows_one_part_at_a_time": lambda P, R, m: P * R.mean() / m,
    "finer_detail_takes_nothing_away": lambda P, R, m: P * m + R,
}


@pytest.mark.parametrize("rule", FORMULA, ids=lambda rule: rule.__name__)
def test_every_rule_of_a_formula_notices(rule):
    assert list(rule(METRICS["blake"])) == []
    assert list(rule(Metric("wrong", WRONG[rule.__name__], "wrong")))


@pytest.mark.usefixtures("package")
def test_records_and_journals_know_who_was_there():
    assert provenance("", 0).packages["lodbench-example"] == "1.0"
    with_it = sources()
    plugins.installed.cache_clear()
    sources.cache_clear()
    sys.path.remove(str(PLACE))
    importlib.invalidate_caches()
    assert sources() != with_it


@pytest.mark.slow
def test_a_frame_is_rendered_with_theirs(tmp_path):
    variant = choose("scalar_rgb")
    paths = os.pathsep.join([str(ROOT), str(PLACE), str(EXAMPLE)])
    program, out = (
        (sys.executable, "-P", "-m", "bench.cli.main"),
        ("-o", "f.####.exr", "--spp", "1"),
    )
    done = subprocess.run(
        [*program, "render", "meadow", *SMALL, *RAIL, *HALFWAY, *out, "--variant", variant],
        env={**trusting(variant), "PYTHONPATH": paths},
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "f.0001.exr").exists()


STROLLERS = """
[terrain]
amplitude = 0
[acting]
frames = 25
[actors.joe]
model = "figure"
position = [0, 4]
heading = 90
behaviour = "{name}"
options = {{ speed = 0.1 }}
"""


@pytest.mark.usefixtures("package")
def test_a_behaviour_of_another_package_moves_an_actor(capfd, tmp_path):
    """At 0.1 m/s it is 0.1 m to the east a second later."""
    for name in ("stroll", "no_function"):
        (tmp_path / f"{name}.toml").write_text(STROLLERS.format(name=name))
    words = "joe course", "--frame", "25", "--json"
    code, out, err = said(capfd, "ask", str(tmp_path / "stroll.toml"), *words)
    assert code == 0, err
    assert json.loads(out)["answer"]["x"] == pytest.approx(0.1, abs=0.01)
    code, out, err = said(capfd, "list")
    assert "stroll" in out + err
    code, _, err = said(capfd, "ask", str(tmp_path / "no_function.toml"), *words)
    assert code == 2
    assert err.count("\n") == 1 and "no_function" in err
