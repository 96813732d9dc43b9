"""What the pages tell a reader to type works: shell blocks marked ``sh``, and blocks of Python.

The commands of a page run in their order, in a folder of their own, made smaller by one rule:
pictures have 32x18 pixels and a sample, sequences their first two frames, and experiments their
quick sizes. Blocks without ``sh`` are for other machines or take long, and are not run.
"""

import re
import shlex
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
PAGES = ["README.md", *sorted(f"docs/{each.name}" for each in (ROOT / "docs").glob("*.md"))]
SMALL = {"--size": "32x18", "--spp": "1", "--frames": "1-2"}  # of pictures

pytestmark = pytest.mark.slow


def blocks(page: str, language: str) -> list[str]:
    text = (ROOT / page).read_text(encoding="utf-8")
    return re.findall(rf"```{language}\n(.*?)```", text, re.S)


def smaller(line: str) -> tuple[list[str], str | None]:
    """The words of a command made smaller, and the file that its output goes to."""
    words = shlex.split(re.sub(r"\s#\s.*", "", line.removeprefix(".venv/bin/")))
    target = words[words.index(">") + 1] if ">" in words else None
    words = words[1 : words.index(">")] if target else words[1:]
    if words[0] == "render":
        words = with_values(words, {"--frames": SMALL["--frames"]}, only_there=True)
        words = with_values(words, {k: SMALL[k] for k in ("--size", "--spp")})
    elif words[0] == "run" and "--quick" not in words:
        words.append("--quick")
    return words, target


def with_values(words: list[str], values: dict[str, str], only_there: bool = False) -> list[str]:
    """Give flags these values, each in its place or at the end."""
    words = list(words)
    for flag, value in values.items():
        if flag in words:
            words[words.index(flag) + 1] = value
        elif not only_there:
            words += [flag, value]
    return words


@pytest.mark.parametrize("page", [page for page in PAGES if blocks(page, "sh")])
def test_the_commands_of_a_page_work(page: str, tmp_path: Path) -> None:
    lines = "".join(blocks(page, "sh")).splitlines()
    for words, target in map(smaller, filter(None, lines)):
        done = subprocess.run(
            [sys.executable, "-m", "lodbench", *words], cwd=tmp_path, capture_output=True, text=True
        )
        assert done.returncode == 0, f"{page}: {shlex.join(words)}: {done.stderr}"
        if target:
            (tmp_path / target).write_text(done.stdout, encoding="utf-8")


def test_the_python_of_the_page_works(tmp_path: Path) -> None:
    code = "\n".join(blocks("docs/python.md", "python"))
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=tmp_path, capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr
    assert len(done.stdout.splitlines()) == 8


def test_a_command_is_made_smaller_by_the_rule() -> None:
    words, target = smaller(".venv/bin/lodbench render x -o ####.exr --frames 1-24  # a remark")
    assert words[4:] == ["--frames", "1-2", "--size", "32x18", "--spp", "1"] and target is None
    assert smaller("lodbench show meadow > mine.toml") == (["show", "meadow"], "mine.toml")
