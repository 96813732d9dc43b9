"""Whatever a user gets wrong: one line on stderr that names it, exit code 2, nothing written.
Every flag that a message names is one that the program has.
"""

import ast
import errno
import json
import os
import re
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path

import click
import pytest

from bench.cli.commands import count
from bench.cli.flags import frame_numbers, memory_limit_bytes
from bench.cli.main import COMMANDS, program
from lod.errors import InputError
from scenes.files import DiskError
from tests.said import said

Run = Callable[..., tuple[int, str, str]]


@pytest.fixture
def run(capfd: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Run:
    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv("LODBENCH_TRACEBACK", raising=False)
    return partial(said, capfd)


def everything(folder: Path) -> dict[Path, bytes | None]:
    return {path: path.read_bytes() if path.is_file() else None for path in folder.rglob("*")}


RENDER = ("render", "meadow", "-o", "out/a.####.exr")
COUNT = ("count", "meadow")

# arguments; then everything that the message says: what is blamed, what arrived, the rule or cure
CASES: list[tuple[tuple[str, ...], tuple[str, ...]]] = [
    # commands and flags
    (("rendr",), ("'rendr'",)),
    (("render",), ("'PRESET'",)),
    (("render", "meadow"), ("'-o'",)),
    # presets
    (("count", "medow"), ("PRESET", "'medow'", "did you mean meadow?")),
    (("count", "misspelt.toml"), ("misspelt.toml: camera.hieght", "did you mean camera.height?")),
    # samples, variant
    ((*RENDER, "--spp", "many"), ("--spp", "'many'", "a whole number")),
    ((*RENDER, "--variant", "fast"), ("variant", "'fast'", "--variant auto")),
    # haze
    ((*COUNT, "--visibility", "20"), ("--visibility", "'20'", "20km or 20m")),
    # frames
    ((*RENDER, "--frames", "9-1"), ("--frames", "'9-1'", "1-9")),
    ((*RENDER, "--frames", "1,,2"), ("--frames", "'1,,2'")),
    ((*RENDER, "--frames", "1-999999"), ("--frames", "'1-999999'", "at most")),
    # numbers
    ((*COUNT, "--density", "figure"), ("--density", "'figure'", "figure=0.002")),
    ((*COUNT, "--density", "elk=1"), ("--density elk", "1", "one of: figure, tree")),
    ((*RENDER, "--metric", "full"), ("--metric", "'full'", "finite world", "world.extent")),
    # said twice, or against one another
    ((*COUNT, "--detail", "2", "--max-parts", "1000"), ("--detail --max-parts", "'both'")),
    ((*COUNT, "-D", "view.detail=2", "--max-parts", "9"), ("-D view.detail --max-parts", "'both'")),
    ((*COUNT, "--seed", "3", "-D", "seed=4"), ("--seed -D seed", "'twice'", "leave one out")),
    ((*COUNT, "-D", "seed=3", "-D", "seed = 4"), ("-D seed", "'twice'")),
    (
        (*"run methods -o out --command true --pack nowhere --settings 1,2,4".split(),),
        ("nowhere", "lodbench pack make"),
    ),
    (
        (*COUNT, "--density", "tree=1", "-D", "species.tree.density=2"),
        ("-D species.tree.density --density tree", "'twice'"),
    ),
    ((*COUNT, "--smear", "window"), ("--smear", "'window'", "--shutter 180")),
    ((*RENDER, "--tone", "linear"), ("--tone", "'alone'", "add --preview")),
    (("verify", "here", "--threads", "2"), ("--threads", "'alone'", "add --repair")),
    (("run", "all", "nosuch", "-o", "out"), ("EXPERIMENT", "'nosuch'", "one of")),
    # what used to mislead
    (("render", "meadow", "-o", f"o/{'n' * 240}.####.exr"), ("-o", "bytes", "another name")),
    (("render", "meadow", "-o", "o/\udcff.####.exr"), ("-o", "UTF-8", "another name")),
    # where frames go
    (("render", "meadow", "-o", "out/a.exr"), ("-o", "'out/a.exr'", "####")),
    (("render", "meadow", "-o", "file/a.####.exr"), ("-o", "'file'", "written")),
    (("render", "meadow", "-o", "/proc/a.####.exr"), ("-o", "'/proc'", "written")),
    (("render", "meadow", "-o", "here/a.####.exr"), ("-o", "'here/a.0001.exr'", "--overwrite")),
    (("render", "meadow", "-o", "here/d.####.exr", "--overwrite"), ("'here/d.0001.exr'",)),
    # experiments and reports
    (("run", "scalling", "-o", "out"), ("EXPERIMENT", "'scalling'", "did you mean scaling?")),
    (("run", "-o", "out"), ("EXPERIMENT",)),
    (("run", "scaling", "--quick", "-o", "file/x"), ("-o", "'file/x'", "written")),
    (
        ("run", "law", "--preset", "bare.toml", "-o", "out"),
        ("--preset", "'bare.toml'", "species", "[species.NAME]"),
    ),
    (
        ("run", "popping", "scaling", "--preset", "meadow", "-o", "out"),
        ("--preset", "popping", "experiments that try presets: law, images, cost, methods"),
    ),
    (("report", "none"), ("DIR", "'none'", "lodbench run")),
    (("report", "spoilt"), ("spoilt", "record")),
]


@pytest.fixture
def litter(tmp_path: Path) -> None:
    """Files and folders that the cases stumble over."""
    (tmp_path / "file").write_text("in the way")
    (tmp_path / "here" / "d.0001.exr").mkdir(parents=True)
    (tmp_path / "here" / "a.0001.exr").write_text("a frame")
    (tmp_path / "misspelt.toml").write_text("[camera]\nhieght = 2\n")
    (tmp_path / "bare.toml").write_text("[camera]\nheight = 2\n")
    (tmp_path / "spoilt").mkdir()
    (tmp_path / "spoilt" / "scaling-0123456789abcdef.json").write_text('{"format": ')


def test_a_current_folder_that_was_removed_is_bad_input(run: Run, tmp_path: Path) -> None:
    """Mitsuba aborts the process there, before a word could be said."""
    (tmp_path / "gone").mkdir()
    os.chdir(tmp_path / "gone")
    (tmp_path / "gone").rmdir()
    code, _, err = run("render", "meadow", "-o", str(tmp_path / "out" / "a.####.exr"))
    assert (code, err.count("\n")) == (2, 1)
    assert "current folder: 'removed'" in err
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("error", "says"),
    [
        (OSError(errno.EMFILE, "Too many open files", "a.json"), ("'a.json'", "ulimit -n")),
        (FileNotFoundError(errno.ENOENT, "No such file", "a.toml"), ("'a.toml'", "stays")),
        (PermissionError(errno.EACCES, "Not allowed", "/x"), ("'/x'", "permissions")),
        (OSError("a reader of pictures gave up"), ("gave up", "put that right")),
        (ConnectionResetError(), ("ConnectionResetError", "put that right")),
        (DiskError(OSError(errno.ENOSPC, "No space"), Path("a.exr")), ("a.exr", "make room")),
    ],
    ids=lambda part: type(part).__name__,
)
def test_an_error_of_the_system_says_which_file_and_what_helps(
    run: Run, monkeypatch: pytest.MonkeyPatch, error: OSError, says: tuple[str, ...]
) -> None:
    def refused(*_: object, **__: object) -> None:
        raise error

    monkeypatch.setattr(count, "preset_from_flags", refused)
    code, _, err = run("count", "meadow")
    assert (code, err.count("\n")) == (1, 1)
    assert all(words in err for words in says)
    assert err.count("then give the same command again") == 1


@pytest.mark.usefixtures("litter")
@pytest.mark.parametrize(("arguments", "says"), CASES, ids=lambda part: " ".join(part)[:60])
def test_bad_input_is_one_clear_line(
    run: Run, tmp_path: Path, arguments: tuple[str, ...], says: tuple[str, ...]
) -> None:
    before = everything(tmp_path)
    code, out, err = run(*arguments)
    assert code == 2
    assert out == ""
    assert err.startswith("lodbench: error: ")
    assert len(err.splitlines()) == 1
    assert len(err) < 400
    assert "Traceback" not in err
    for words in says:
        assert words in err
    assert everything(tmp_path) == before


@pytest.mark.parametrize(
    ("preset", "least"),
    [("badlands", "light.sun_elevation=1e-9"), ("crowd", "species.tree.density=1e-320")],
)
def test_the_least_that_is_allowed_is_counted(run: Run, preset: str, least: str) -> None:
    """A sun on the horizon, and a density of which the reciprocal is no number."""
    small = "--size", "32x18", "--visibility", "200m"
    code, out, _ = run("count", preset, *small, "-D", least, "--json")
    assert code == 0 and json.loads(out)["parts"]["displayed"] > 0


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write anywhere")
def test_a_folder_without_permission_is_refused(run: Run, tmp_path: Path) -> None:
    (tmp_path / "closed").mkdir(mode=0o555)
    code, _, err = run("render", "meadow", "-o", "closed/a.####.exr")
    assert code == 2
    assert "-o: 'closed': a folder that can be written to" in err


@pytest.mark.parametrize(
    ("text", "frames"),
    [
        ("9, 1,5", (1, 5, 9)),
        ("1-3,2-5", (1, 2, 3, 4, 5)),
        ("1-40x10", (1, 11, 21, 31)),
        ("3-9x3, 4", (3, 4, 6, 9)),
    ],
)
def test_frames_are_numbers_each_once(text: str, frames: tuple[int, ...]) -> None:
    assert frame_numbers(text) == frames


def test_memory_sizes():
    assert memory_limit_bytes("4GB") == 4_000_000_000 and memory_limit_bytes("1.5 gib") == 3 * 2**29
    for text in ("4", "GB", "0GB", "-1GB", "4TB", "nanGB", ""):
        with pytest.raises(InputError, match="--max-memory"):
            memory_limit_bytes(text)


ROOT = Path(__file__).resolve().parents[3]
FLAG = re.compile(r"(?<![\w-])--[a-z][a-z-]*[a-z]\b")
ARGUMENT = re.compile(FLAG.pattern + r"(=\S+)?")
OF_OTHERS = {
    "--scheduler-file": "dask scheduler",
    "--flatten": "usdcat",
}
"""Flags of other programs, each with a word of the text that names it."""


def flags() -> set[str]:
    """Every flag of every command."""
    context = click.Context(program)
    groups = [program.get_command(context, name) for name in COMMANDS]
    commands = [program, *groups]
    commands += [each for g in groups if isinstance(g, click.Group) for each in g.commands.values()]
    options = [each for command in commands if command for each in command.params]
    found = {flag for each in options for flag in (*each.opts, *each.secondary_opts)}
    return {*found, "--help", "--version"}


def messages() -> Iterator[tuple[str, str]]:
    """Every text in the rooms that names a flag, with its place; docstrings, too.

    A text that is a flag and nothing else is an argument. The programs of a folder that have flags
    of their own, for whoever starts them by hand, name them so, and may name them in messages.
    """
    for room in ("lod", "scenes", "bench"):
        for folder in sorted({path.parent for path in (ROOT / room).rglob("*.py")}):
            texts = [each for path in sorted(folder.glob("*.py")) for each in literals(path)]
            own = {text.split("=")[0] for _, text in texts if ARGUMENT.fullmatch(text)}
            for place, text in texts:
                rest = FLAG.sub(lambda found, own=own: "" if found[0] in own else found[0], text)
                if not ARGUMENT.fullmatch(text):
                    yield place, rest


def literals(path: Path) -> Iterator[tuple[str, str]]:
    """Every text of a file, with its place."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Constant) and isinstance(node.value, str):
            yield f"{path.relative_to(ROOT)}:{node.lineno}", node.value


def unknown(texts: Iterator[tuple[str, str]], known: set[str]) -> list[tuple[str, str]]:
    """Flags that no command has, each with its place."""
    return [
        (place, flag)
        for place, text in texts
        for flag in FLAG.findall(text.replace("var(--", ""))  # a colour of the page
        if flag not in known and OF_OTHERS.get(flag, "\0") not in text
    ]


def test_advice_names_flags_that_exist() -> None:
    assert unknown(messages(), flags()) == []


@pytest.mark.parametrize("text", ["add --nosuch", "--overwite", "(--repair-all)"])
def test_another_flag_would_be_noticed(text: str) -> None:
    assert unknown(iter([("here", text)]), flags()) == [("here", text.split()[-1].strip("()"))]
