"""The study of starting times pairs its processes, and gives the ratio of each pair."""

from pathlib import Path

import pytest

from bench.studies import start
from bench.studies.start import COLD, WARM, Took, report, rounds, timed


def test_a_process_is_timed_by_itself_and_keeps_things_where_it_is_told(tmp_path: Path) -> None:
    code = "import os, time; open(os.environ['LODBENCH_CACHE'] + '/x', 'w'); time.sleep(0.3)"
    took = timed(("-c", code), tmp_path)
    assert took.wall_s > 0.3 > took.cpu_s > 0
    assert (tmp_path / "x").exists()


def test_cold_commands_find_nothing_kept_and_warm_ones_the_same(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    asked: list[tuple[str, Path]] = []

    def note(words: tuple[str, ...], cache: Path) -> Took:
        asked.append((words[0], cache))
        return Took(2.0 if words[0] == "-m" else 0.5, 0.5)

    monkeypatch.setattr(start, "timed", note)
    found = rounds(("count", "meadow"), repeats=8, cold=2)
    assert (len(found[COLD]), len(found[WARM])) == (2, 8)
    assert [word for word, _ in asked] == ["-c", "-m"] * 2 + ["-m"] + ["-c", "-m"] * 8
    assert len({cache for word, cache in asked if word == "-m"}) == 3
    (wall,) = (line for line in report(found).splitlines() if "warm, wall" in line)
    assert wall.split()[-3:] == ["4", "4", "4"]
