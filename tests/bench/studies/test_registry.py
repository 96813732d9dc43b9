"""Every study can be found, listed and started by its name."""

import pytest

from bench.cli.main import main
from bench.studies.registry import load_study, study_descriptions


def leave(arguments: list[str]) -> int:
    with pytest.raises(SystemExit) as ended:
        main(arguments)
    return int(ended.value.code or 0)


def test_every_study_has_a_line_and_a_command(capfd: pytest.CaptureFixture[str]) -> None:
    assert leave(["study"]) == 0
    printed = capfd.readouterr().out
    for name, about in study_descriptions().items():
        assert 20 < len(about) <= 100 and "bench." not in about and name in printed
        assert load_study(name).get_short_help_str()
        assert leave(["study", name, "--help"]) == 0
        assert leave(["study", f"{name}s"]) == 2
        assert f"did you mean {name}?" in capfd.readouterr().err
