"""The program's manners: exit codes, one line for what goes wrong, stdout for JSON alone."""

import errno
import json
import os
import shlex
import signal
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import click
import pytest

from bench.cli import main as cli
from bench.cli.output import output
from lod.errors import InputError

ROOT = Path(__file__).resolve().parents[3]


def leave(arguments: list[str]) -> int:
    with pytest.raises(SystemExit) as left:
        cli.main(arguments)
    assert isinstance(left.value.code, int)
    return left.value.code


@pytest.fixture
def breaking(monkeypatch: pytest.MonkeyPatch) -> Callable[[BaseException], None]:
    """Makes `lodbench count` raise an exception."""

    def plant(error: BaseException) -> None:
        @click.command("count")
        def command() -> None:
            raise error

        monkeypatch.setattr(cli.Commands, "get_command", lambda *_: command)

    monkeypatch.delenv(cli.TRACEBACK, raising=False)
    return plant


def following(error: BaseException, first: BaseException) -> BaseException:
    """An error that was raised while another was handled, as Dr.Jit does."""
    error.__context__ = first
    return error


def test_every_command_has_an_example_that_it_takes() -> None:
    context = click.Context(cli.program, info_name="lodbench")
    for name in cli.COMMANDS:
        command = cli.program.get_command(context, name)
        several = command.commands if isinstance(command, click.Group) else {None: command}
        for below, each in several.items():
            lead, *words = shlex.split((each.epilog or "").partition("lodbench ")[2])
            assert [lead, below] == [name, words.pop(0) if below else None]
            each.make_context(name, words)  # raises for what cannot be


NO_LIBRARY = ImportError("libatomic.so.1: cannot open shared object file: No such file")


@pytest.mark.parametrize(
    ("error", "code", "line"),
    [
        (InputError("--x", 3, "a rule", "a cure"), 2, "error: --x: 3: a rule; a cure"),
        (click.UsageError("two\nlines"), 2, "error: two lines"),
        (click.ClickException("it broke"), 1, "error: it broke"),
        (OSError(errno.ENOSPC, "No space left", "a.exr"), 1, "No space left: 'a.exr'"),
        (MemoryError(), 1, "error: out of memory"),
        (RuntimeError("a\nsurprise"), 1, "RuntimeError: a surprise (LODBENCH_TRACEBACK=1 shows"),
        (NO_LIBRARY, 1, "install it, as by `apt-get install libatomic1`"),
        (following(NameError("_drjit_ext"), NO_LIBRARY), 1, "needs libatomic.so.1 of the system"),
        (ImportError("no name x in y"), 1, "ImportError: no name x in y (LODBENCH_TRACEBACK"),
        (KeyboardInterrupt(), 130, "lodbench: interrupted"),
        (click.Abort(), 130, "lodbench: interrupted"),
    ],
    ids=lambda part: type(part).__name__,
)
def test_what_goes_wrong_is_one_line_and_a_code(
    breaking: Callable[[BaseException], None],
    capsys: pytest.CaptureFixture[str],
    error: BaseException,
    code: int,
    line: str,
) -> None:
    breaking(error)
    assert leave(["count"]) == code
    out, err = capsys.readouterr()
    assert out == ""
    assert err.startswith("lodbench: ")
    assert err.count("\n") == 1
    assert line in err


LATE = """
import os, signal
from bench.cli import main as cli

class Last:
    def __del__(self, kill=os.kill, number=signal.SIGINT):
        kill(here, number)

def interrupted(*anything):
    raise KeyboardInterrupt

here, last, cli.program.invoke = os.getpid(), Last(), interrupted
cli.main(["list"])
"""
"""What it leaves behind interrupts it again, when the interpreter ends."""


def test_an_interrupt_is_the_same_however_often_it_comes() -> None:
    ended = subprocess.run([sys.executable, "-c", LATE], cwd=ROOT, capture_output=True, text=True)
    assert (ended.returncode, ended.stderr) == (130, "lodbench: interrupted\n")


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_after_the_end_does_not_hide_how_it_ended(number: int) -> None:
    words = """
import atexit, time
from bench.cli.main import main
atexit.register(lambda: (print("ends", flush=True), time.sleep(1)))
main(["list", "presets"])
"""
    program = [sys.executable, "-c", words]
    with subprocess.Popen(
        program, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    ) as run:
        assert run.stdout and run.stderr
        while run.stdout.readline() not in ("ends\n", ""):
            pass
        run.send_signal(number)
        assert (run.wait(30), "Traceback" in run.stderr.read()) == (2, False)


def test_a_traceback_is_there_for_those_who_ask(
    breaking: Callable[[BaseException], None], monkeypatch: pytest.MonkeyPatch
) -> None:
    breaking(RuntimeError("surprise"))
    monkeypatch.setenv(cli.TRACEBACK, "1")
    with pytest.raises(RuntimeError, match="surprise"):
        cli.main(["count"])


def test_the_version_is_said(capsys: pytest.CaptureFixture[str]) -> None:
    assert leave(["--version"]) == 0
    assert capsys.readouterr().out.startswith("lodbench, version ")


@pytest.mark.parametrize("name", cli.COMMANDS)
def test_every_command_explains_itself(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert leave([name, "--help"]) == 0
    assert f"lodbench {name}" in capsys.readouterr().out


def test_list_names_presets_metrics_and_experiments(capfd: pytest.CaptureFixture[str]) -> None:
    assert leave(["list"]) == 0
    words = capfd.readouterr().out
    assert all(word in words for word in ("meadow", "blake", "solid_angle", "scaling"))
    assert leave(["list", "--json"]) == 0
    listed = json.loads(capfd.readouterr().out)
    assert set(listed) == {
        *("presets", "metrics", "representations", "experiments"),
        *("behaviours", "models"),
    }
    assert all(about for section in listed.values() for about in section.values())


def test_mistakes_are_found_before_anything_heavy_is_imported() -> None:
    heavy = {"mitsuba", "OpenEXR", "numba", "scipy", "statsmodels", "matplotlib", "colour"}
    code = (
        "import sys, bench.cli.main\n"
        "try: bench.cli.main.main(['render', 'meadow', '-o', 'out/a.####.exr', '--spp', '0'])\n"
        "except SystemExit as left: print(left.code, *sys.modules)"
    )
    done = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True)
    status, *modules = done.stdout.split()
    assert status == "2"
    assert heavy.isdisjoint(modules)


def test_under_json_stdout_holds_json_alone(capfd: pytest.CaptureFixture[str]) -> None:
    with output(as_json=True) as out:
        print("a library talks")
        subprocess.run(["echo", "a library in C talks"], check=True)
        out.say("words for people")
        out.record({"n": 1})
        out.note("progress")
    os.write(1, b"afterwards\n")
    seen = capfd.readouterr()
    assert seen.out == '{"n": 1}\nafterwards\n'
    assert "words for people" not in seen.err
    for words in ("a library talks", "a library in C talks", "progress"):
        assert words in seen.err


def test_json_has_no_nan(capfd: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(ValueError, match="JSON"), output(as_json=True) as out:
        out.record({"n": float("nan")})
    assert capfd.readouterr().out == ""


def completed(line: str, **more: str) -> list[str]:
    words = {"COMP_WORDS": line, "COMP_CWORD": str(len(line.split()) - 1)}
    variables = os.environ | {"_LODBENCH_COMPLETE": "bash_complete"} | words | more
    command = [sys.executable, "-m", "bench.cli.main"]
    done = subprocess.run(command, env=variables, capture_output=True, text=True, check=True)
    return done.stdout.split()


@pytest.mark.parametrize(
    ("line", "answers"),
    [
        ("lodbench rep", ["plain,report"]),
        ("lodbench count me", ["plain,meadow"]),
        ("lodbench render ./mine", ["file,./mine"]),
        ("lodbench count meadow -D render.crop", ["plain,render.crop="]),
        ("lodbench render meadow --view sp", ["plain,species"]),
    ],
)
def test_a_line_is_completed(line: str, answers: list[str]) -> None:
    assert completed(line) == answers


def test_a_shell_reads_the_script_of_completion() -> None:
    script = completed("", _LODBENCH_COMPLETE="bash_source")
    assert "_lodbench_completion" in " ".join(script)
