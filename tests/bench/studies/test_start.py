"""The study of starting times pairs its processes, and gives the ratio of each pair."""

import json
from pathlib import Path

import pytest

from bench.studies import start
from bench.studies.start import COLD, WARM, Took, counting, figures, first_frame, rounds, timed


def test_a_process_is_timed_by_itself_and_keeps_things_where_it_is_told(tmp_path: Path) -> None:
    code = "import os, time; open(os.environ['LODBENCH_CACHE'] + '/x', 'w'); time.sleep(0.3)"
    took = timed(("-c", code + "; print(7)"), tmp_path)
    assert took.wall_s > 0.3 > took.cpu_s > 0
    assert took.said == "7\n"
    assert (tmp_path / "x").exists()


@pytest.fixture
def asked(monkeypatch: pytest.MonkeyPatch) -> list[tuple[str, Path]]:
    """The processes that were asked for; imports take half a second and commands two."""
    asked: list[tuple[str, Path]] = []

    def note(words: tuple[str, ...], cache: Path) -> Took:
        asked.append((words[0], cache))
        said = json.dumps({"seconds": {"trace": 1.5, "write": 9.0}}) + '\n{"done": 1}'
        return Took(2.0 if words[0] == "-m" else 0.5, 0.5, said)

    monkeypatch.setattr(start, "timed", note)
    return asked


def test_cold_commands_find_nothing_kept_and_warm_ones_the_same(asked, tmp_path: Path) -> None:
    found = rounds(counting(("count", "meadow")), 8, 2, tmp_path)
    assert (len(found[COLD]), len(found[WARM])) == (2, 8)
    assert [word for word, _ in asked] == ["-c", "-m"] * 2 + ["-m"] + ["-c", "-m"] * 8
    assert len({cache for word, cache in asked if word == "-m"}) == 3
    warm = figures(found[WARM])
    assert [warm[name] for name in ("imports_s", "ratio", "low", "high")] == [0.5, 4, 4, 4]


def test_a_first_frame_is_held_against_its_trace_and_its_imports(asked, tmp_path: Path) -> None:
    found = figures(rounds(first_frame("meadow", tmp_path, "llvm_ad_rgb"), 0, 1, tmp_path)[COLD])
    assert (found["own_s"], found["ratio"], found["low"]) == (1.5, 1.0, None)
    assert len(asked) == 2
