"""Bars on stderr: on terminals only, never beside JSON, and of what is made once and then kept."""

import sys

import click
import pytest
from click.testing import CliRunner

from bench.cli.main import program
from bench.cli.output import bars_are_shown, counted, frame_progress, making_shown, progress_bar
from scenes.processes.progress import tell, work


def make_something():
    with making_shown(), work("fitting things", 34):
        tell()
        tell(12.0)
        tell(22.0)


def test_what_is_made_is_shown_with_the_time_left_and_cleared(monkeypatch, capsys):
    monkeypatch.setattr(sys.stderr, "isatty", lambda: True)
    make_something()
    said = capsys.readouterr().err.replace("\r", "\n")
    assert "fitting things 0/34" in said and "fitting things 12/34" in said and " left" in said
    assert said.splitlines()[-1].strip() == ""


def test_away_from_a_terminal_nothing_is_shown(capsys):
    make_something()
    assert capsys.readouterr().err == ""


def test_items_are_counted_and_the_next_is_named_before_it_begins(monkeypatch, capsys):
    monkeypatch.setattr(sys.stderr, "isatty", lambda: True)
    said = []
    for _ in counted(["one", "two"], "thing"):
        said.append(capsys.readouterr().err)
    assert "one:" in said[0] and " 0/2 " in said[0]
    assert "two:" in said[1] and " 1/2 " in said[1] and "<" in said[1]


@pytest.mark.parametrize(("flags", "shown"), [([], True), (["--json"], False)])
def test_no_bar_stands_beside_json(flags, shown, monkeypatch):
    @click.command()
    @click.option("--json", "as_json", is_flag=True)
    def command(as_json):
        monkeypatch.setattr(sys.stderr, "isatty", lambda: True)
        assert bars_are_shown() is shown
        with progress_bar("step") as show, frame_progress(2) as frames:
            show(0, 2, "one")
            frames.show_samples(1, 0, 0)
        make_something()

    result = CliRunner().invoke(command, flags)
    assert result.exit_code == 0, result.output
    assert bool(result.stderr) is shown


@pytest.mark.parametrize(
    ("words", "does_the_work"),
    [
        (["report", "records"], "bench.report.write.write_report"),
        (["compare", "a", "b"], "bench.records.compare_runs.compare_paths"),
    ],
    ids=["report", "compare"],
)
def test_commands_that_read_records_show_a_bar_on_a_terminal_alone(
    words, does_the_work, monkeypatch
):
    def work_on(*arguments):
        if callable(arguments[-1]):
            arguments[-1](0, 3, "reading records")
        return []

    monkeypatch.setattr(does_the_work, work_on)
    assert invoked(words).stderr == ""
    monkeypatch.setattr("click.testing._NamedTextIOWrapper.isatty", lambda self: True)
    assert "reading records" in invoked(words).stderr
    assert invoked([*words, "--json"]).stderr == ""


def invoked(words):
    result = CliRunner().invoke(program, words)
    assert result.exit_code == 0, result.output
    return result


def test_a_frame_tells_what_is_made_for_it_and_how_long_that_takes(monkeypatch, capsys):
    monkeypatch.setattr(sys.stderr, "isatty", lambda: True)
    clock = iter((100.0, 106.0))
    monkeypatch.setattr("bench.cli.output.time.monotonic", lambda: next(clock))
    with frame_progress(2) as frames:
        for done in (1.0, 3.0):
            frames.show_samples(1, 0, 0, ("fitting things", done, 5))
    said = capsys.readouterr().err
    assert "fitting things 1/5" in said and "fitting things 3/5, 6 s left" in said
