"""Every study can be found, listed and started by its name."""

import pytest

from bench.cli.main import main
from bench.studies.registry import load_study, study_descriptions


def leave(arguments: list[str]) -> int:
    with pytest.raises(SystemExit) as ended:
        main(arguments)
    return int(ended.value.code or 0)


def test_every_study_has_a_line_and_a_command() -> None:
    names = study_descriptions()
    assert {"speed", "tone", "memory"} <= set(names)
    for name, about in names.items():
        assert 20 < len(about) <= 100 and "bench." not in about
        assert load_study(name).get_short_help_str()


def test_the_help_of_the_group_names_them_all(capfd: pytest.CaptureFixture[str]) -> None:
    assert leave(["study"]) == 0
    printed = capfd.readouterr().out
    assert all(name in printed for name in study_descriptions())


def test_a_study_runs_by_its_name(capfd: pytest.CaptureFixture[str]) -> None:
    assert leave(["study", "speed", "--help"]) == 0
    assert "lodbench study speed" in capfd.readouterr().out


def test_an_unknown_study_is_bad_input(capfd: pytest.CaptureFixture[str]) -> None:
    assert leave(["study", "spee"]) == 2
    assert "did you mean speed?" in capfd.readouterr().err
