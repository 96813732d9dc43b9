"""What the pages tell a reader to type or to open exists."""

import ast
import importlib.util
import re
import subprocess
import tomllib
from pathlib import Path
from types import ModuleType

import pytest

import lodbench
from bench.cli.main import COMMANDS
from bench.experiment import experiments
from scenes.presets.load import load_preset, preset_names

ROOT = Path(__file__).parents[1]
HOW_TO = sorted((ROOT / "docs").glob("*.md"))
PAGES = [ROOT / "README.md", *HOW_TO, *sorted((ROOT / "results").glob("*.md"))]
TOPICS = {topic for each in experiments().values() for topic in each.topics}
NAMES = {"run": {*experiments(), *TOPICS, "all"}}
PRESETS = dict(preset_names())


def commands(text: str) -> list[list[str]]:
    """Words of every command line that begins with ``lodbench``, up to the end of the line."""
    return [found.split() for found in re.findall(r"\blodbench ([a-z][^\n#|;]*)", text)]


def code(text: str) -> str:
    """What stands between backquotes or in fenced blocks, a line each."""
    blocks = re.findall(r"```\w*\n(.*?)```", text, re.S)
    inline = re.findall(r"`([^`]+)`", re.sub(r"```.*?```", "", text, flags=re.S))
    return "\n".join(blocks + [" ".join(each.split()) for each in inline])


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_commands_exist(page: Path) -> None:
    typed = commands(code(page.read_text(encoding="utf-8")))
    for command, *words in typed:
        assert command in COMMANDS, command
        names = [word for word in words if not word.startswith("-")]
        if command in NAMES and words and names[0].islower() and names[0] != "tiny":
            assert names[0] in NAMES[command], f"{command} {names[0]}"  # tiny: a page makes it
        own_file = any(name.endswith(".toml") for name in names[:1])
        if command in ("render", "count", "usd") and names and names[0].islower() and not own_file:
            assert names[0].partition("@")[0] in PRESETS, f"{command} {names[0]}"


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_modules_files_and_links_exist(page: Path) -> None:
    text = page.read_text(encoding="utf-8")
    for module in re.findall(r"python\s+-m\s+([\w.]+)", text):
        assert module == "pytest" or importlib.util.find_spec(module), module
    for link in re.findall(r"\]\((?!http)([^)#]+)\)", text):
        assert (page.parent / link).exists(), link
    for path in re.findall(r"`((?:lod|scenes|bench|tests)/[\w/.]+)`", text):
        assert "NAME" in path or "tiny" in path or (ROOT / path).exists(), path


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_settings_exist(page: Path) -> None:
    for line in code(page.read_text(encoding="utf-8")).splitlines():
        preset = next((word for word in line.split() if word in PRESETS), "forest")
        for setting in re.findall(r"-D ([a-z][\w.]+=\S+)", line):
            if "NAME" not in setting:
                load_preset(preset, [setting])


def writer(name: str) -> ModuleType:
    """A program of docs/ that writes pages."""
    spec = importlib.util.spec_from_file_location(name, ROOT / "docs" / f"{name}.py")
    assert spec and spec.loader
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_the_page_of_keys_says_what_the_models_say() -> None:
    written = writer("write_keys")
    assert written.PAGE.read_text(encoding="utf-8") == written.page(), "run `make docs`"


def test_pages_quote_the_claims_of_the_records() -> None:
    figures = writer("write_figures")
    assert ROOT / "README.md" in figures.pages()
    for page in figures.pages():
        text = page.read_text(encoding="utf-8")
        assert figures.filled(text, figures.folder_of(page)) == text, f"{page}: run `make docs`"
    text = (ROOT / "results" / "README.md").read_text(encoding="utf-8")
    row = next(line for line in text.splitlines() if line.endswith("` |") and "run " in line)
    changed = text.replace(row, "| changed |")
    assert figures.filled(changed) == text


def test_a_number_within_a_sentence_is_that_of_its_claim() -> None:
    figures = writer("write_figures")
    claims, _ = figures.judged()["cost"]
    name = next(each.name for each in claims if each.measured == each.low == each.high == 1)
    begin, end = f"There is <!-- value: cost {name} -->", "<!-- end of value --> frame."
    assert figures.filled(f"{begin}2{end}") == f"{begin}1 (1 to 1){end}"
    with pytest.raises(ValueError, match="claims are named time"):
        figures.filled("<!-- value: cost time* --><!-- end of value -->")


def test_the_notebook_is_the_page_of_python() -> None:
    written = writer("write_notebook")
    assert written.NOTEBOOK.read_text(encoding="utf-8") == written.notebook(), "run `make docs`"


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_blocks_of_code_have_no_error_of_syntax(page: Path) -> None:
    text = page.read_text(encoding="utf-8")
    blocks = re.findall(r"^```(\S*)\n(.*?)^```$", text, re.S | re.M)
    for language, block in blocks:
        if language in ("sh", "bash"):
            done = subprocess.run(["bash", "-n"], input=block, capture_output=True, text=True)
            assert done.returncode == 0, done.stderr
        elif language == "python":
            ast.parse(block, page.name)
        elif language == "toml":
            tomllib.loads(block)
        else:  # a drawing, what a program prints, a doctest; no command hides there
            assert language in ("", "text", "{toctree}", "{eval-rst}"), language
            assert not re.search(r"^(lodbench|make|pip) ", block, re.M), block


def test_every_name_of_the_module_is_on_its_page() -> None:
    page = (ROOT / "docs" / "python.md").read_text(encoding="utf-8")
    listed = re.search(r":members: (.*)", page)
    assert listed
    assert {*listed[1].split(", "), "Preset"} == set(lodbench.__all__)
    assert "`Preset`" in page  # whose fields are the keys, on a page of their own
