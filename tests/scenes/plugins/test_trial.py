"""A plug-in that misbehaves when it is imported is named, and is in nobody's way."""

import json
import os
import subprocess
import sys
import time
from pathlib import Path

import pytest

from scenes.plugins import trial
from scenes.plugins.guard import StrangersError, guarded

ROOT = Path(__file__).resolve().parents[3]
METRIC = "from lod.metric import Metric\nMETRIC = Metric('{name}', {limit}, 'one of theirs')\n"
PLAIN = "lambda P, R, m: (P + R) / m"
IMPORTS = {
    "exits": ("import sys; sys.exit(0)", "it ends the process, as sys.exit(0) does"),
    "leaves": ("import os; os._exit(0)", "it ends the process"),
    "crashes": ("import ctypes; ctypes.string_at(0)", "it ends the process by signal 11"),
    "hangs": (
        "import time\nwhile True:\n    try: time.sleep(9)\n    except BaseException: pass",
        "hangs",
    ),
    "forks": ("import os; os.fork()", "it forks"),
    "interrupts": ("raise KeyboardInterrupt('no')", "KeyboardInterrupt: no"),
    "fails": ("1 / 0", "ZeroDivisionError: division by zero"),
    "closes": ("import os; os.close(1); os.close(2)", None),
    "prints": ("print('hello'); import os; os.system('echo from C')", None),
    "plain": ("", None),
}


@pytest.fixture
def package(tmp_path, monkeypatch):
    """Modules of each kind, and the metadata that names a metric of each."""
    for name, (code, _) in IMPORTS.items():
        body = f"{code}\n{METRIC.format(name=name, limit=PLAIN)}"
        (tmp_path / f"lodbench_test_{name}.py").write_text(body)
    (tmp_path / "lodbench_test_late.py").write_text(
        METRIC.format(name="late", limit="lambda P, R, m: exit(3)")
    )
    info = tmp_path / "lodbench_strange-1.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: lodbench-strange\nVersion: 1.0\n")
    names = "\n".join(f"{name} = lodbench_test_{name}:METRIC" for name in (*IMPORTS, "late"))
    (info / "entry_points.txt").write_text(f"[lodbench.metrics]\n{names}\nodd = no object\n")
    monkeypatch.syspath_prepend(str(tmp_path))
    monkeypatch.delenv(trial.TRIED, raising=False)
    monkeypatch.setattr(trial, "LONGEST_S", 20)
    trial.import_fault.cache_clear()
    yield tmp_path
    trial.import_fault.cache_clear()


@pytest.mark.usefixtures("package")
@pytest.mark.parametrize("name", IMPORTS)
def test_what_an_import_does_is_said(name, capfd, caplog, monkeypatch):
    if name == "hangs":
        monkeypatch.setattr(trial, "LONGEST_S", 4)
    start, says = time.monotonic(), IMPORTS[name][1]
    found = trial.import_fault(f"lodbench_test_{name}:METRIC", "lodbench-strange 1.0")
    assert time.monotonic() - start < 60
    assert (found is None) if says is None else (says in found)
    assert capfd.readouterr() == ("", "")
    warned = "lodbench_test_prints:METRIC of lodbench-strange 1.0 prints when it is imported"
    assert (warned in caplog.text and "hello" in caplog.text) == (name == "prints")
    tried = os.environ.get(trial.TRIED, "").splitlines()
    assert tried == ([] if says else [f"lodbench_test_{name}:METRIC"])


@pytest.mark.usefixtures("package")
def test_what_the_parent_has_tried_is_not_tried_again(monkeypatch):
    monkeypatch.setenv(trial.TRIED, "x:y\nlodbench_test_exits:METRIC")
    assert trial.import_fault("lodbench_test_exits:METRIC", "someone") is None


def lodbench(folder, *words):
    paths = os.pathsep.join([str(ROOT), str(folder)])
    return subprocess.run(
        [sys.executable, "-P", "-c", "from scenes.plugins import trial; trial.LONGEST_S = 8\n"
         "from bench.cli.main import main; main()", *words],
        env={**os.environ, "PYTHONPATH": paths},
        cwd=folder, capture_output=True, text=True, timeout=300,
    )  # fmt: skip


def test_all_of_them_in_one_list(package):
    done = lodbench(package, "list", "--json")
    assert done.returncode == 0, done.stderr
    (line,) = done.stdout.splitlines()
    metrics = json.loads(line)["metrics"]
    for name, (_, says) in IMPORTS.items():
        assert (says or "one of theirs (from lodbench-strange 1.0)") in metrics[name], name
    assert "SystemExit: 3" in metrics["late"]
    assert "not written as module:object" in metrics["odd"]
    assert "lodbench_test_prints:METRIC of lodbench-strange 1.0 prints" in done.stderr


@pytest.mark.parametrize("name", ["exits", "forks", "late"])
def test_one_that_is_asked_for_costs_a_line(package, name):
    done = lodbench(package, "count", "meadow", "--size", "64x36", "--metric", name, "--json")
    assert (done.returncode, done.stdout) == (2, "")
    assert f"--metric: '{name}'" in done.stderr or name == "late"
    assert "mend or remove lodbench-strange 1.0" in done.stderr
    assert len(done.stderr.splitlines()) == 1


def test_code_of_strangers_is_kept_from_stdout_and_ends_nothing(capfd):
    with pytest.raises(StrangersError, match="SystemExit: 4"), guarded():
        print("words")
        os.system("echo more")
        sys.exit(4)
    with pytest.raises(KeyboardInterrupt), guarded():
        raise KeyboardInterrupt
    out, err = capfd.readouterr()
    assert (out, sorted(err.split())) == ("", ["more", "words"])


def test_a_process_that_forks_among_strangers_ends_there(tmp_path):
    with guarded():
        child = os.fork()
    (tmp_path / str(os.getpid())).touch()
    assert os.waitpid(child, 0)[1] != 0
    assert len(list(tmp_path.iterdir())) == 1
