"""`lodbench run`, `report` and `doctor`: what they print is what they found."""

import json
from dataclasses import replace
from pathlib import Path

import pytest

from bench.cli.commands.run import _chosen
from bench.cli.main import main
from bench.experiments import registry as experiments
from bench.experiments.registry import EXPERIMENTS
from bench.records.claims import Claim
from bench.records.points import Point
from bench.records.records import read_record
from bench.runner import run_experiment as run_module
from bench.runner.experiment import Effort
from scenes.render import variants

HELD = Claim("slope", "slope of objects", "an exponent", "§4.1", 1.0, 0.02, 1.001, 0.99, 1.01)
FAILED = Claim("ratio", "measured ÷ predicted", "a ratio", "§4.1", 1.0, 0.02, 1.5, 1.4, 1.6)


def left_with(*arguments: str) -> int:
    with pytest.raises(SystemExit) as left:
        main(arguments)
    assert isinstance(left.value.code, int)
    return left.value.code


@pytest.fixture
def asked(monkeypatch: pytest.MonkeyPatch) -> list[tuple[bool, int]]:
    """Plants an experiment that takes no time; gives what it was asked for."""
    calls: list[tuple[bool, int]] = []

    def cases(effort: Effort, metric: str | None) -> list[bool]:
        return [effort.name == "quick"]

    def measure(quick: bool, seed: int) -> Point:
        calls.append((quick, seed))
        return Point({"n": 1})

    fake = replace(
        EXPERIMENTS["scaling"],
        cases=cases,
        measure=measure,
        judge=lambda points: (HELD, FAILED),
        scene_hash=lambda points: "scene",
        notes=None,
        timed=True,
        expected_seconds={"full": 1.0, "quick": 1.0},
    )
    monkeypatch.setitem(experiments.EXPERIMENTS, "scaling", fake)
    monkeypatch.setattr(run_module, "take_probe", lambda preset: {"preset": preset})
    return calls


def test_a_run_names_its_record_and_its_claims(
    asked: list[tuple[bool, int]], capfd: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    folder = str(tmp_path / "records")
    assert left_with("run", "scaling", "--quick", "--seed", "4", "-o", folder, "--json") == 0
    out, err = capfd.readouterr()
    assert err == "lodbench: scaling, 1 of 1: about 1 s\n"
    result = json.loads(out)
    assert set(result) == {"experiment", "record", "kept", "claims"}
    assert read_record(Path(result["record"])).claims == (HELD, FAILED)
    keys = {"name", "source", "predicted", "measured", "low", "high", "verdict"}
    assert all(keys <= set(claim) for claim in result["claims"])
    assert [claim["verdict"] for claim in result["claims"]] == ["holds", "refuted"]
    assert asked == [(True, 4)]


def test_the_same_experiment_twice_is_run_once(
    asked: list[tuple[bool, int]], capfd: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    assert left_with("run", "scaling", "scaling", "-o", str(tmp_path)) == 0
    out = capfd.readouterr().out
    assert asked == [(False, 0)]
    assert "holds" in out
    assert "refuted" in out


def test_doctor_says_what_works(
    capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    found = variants.Probe({"scalar_rgb": True, "llvm_ad_rgb": "no libLLVM was found"}, None, {})
    monkeypatch.setattr(variants, "probe", lambda: found)
    monkeypatch.setattr(variants, "choose", lambda _: "scalar_rgb")
    assert left_with("doctor", "--json") == 0
    told = json.loads(capfd.readouterr().out)
    assert told["variants"] == {"scalar_rgb": True, "llvm_ad_rgb": "no libLLVM was found"}
    assert told["libllvm"] is None
    assert told["memory"]["total_bytes"] >= told["memory"]["available_bytes"] > 0
    assert told["disk"]["free_bytes"] > 0
    assert told["cpu"]["threads"] >= 1
    assert told["packages"]["mitsuba"]
    assert left_with("doctor") == 0
    words = capfd.readouterr().out
    assert "no libLLVM was found" in words
    assert "apt install libllvm19" in words


def test_all_leaves_out_what_stands_apart() -> None:
    every = _chosen(("all",), None)
    assert set(every) == {name for name, each in EXPERIMENTS.items() if not each.apart}
    assert set(EXPERIMENTS) - set(every) >= {"fidelity_shipped"}
    assert _chosen(("fidelity_shipped",), None) == ("fidelity_shipped",)
