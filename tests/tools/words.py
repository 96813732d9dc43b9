"""Find words of this project's own where a reader expects the terms of the field.

Run by `make lint` as ``python tests/tools/words.py``: README, the manual, and every string that the
program can print are held against a short list; code between backquotes is left alone. It exits
with 1 where a word of the list stands.
"""

import ast
import re
import sys
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]

INSTEAD = {
    r"\bforet(old|ells?|ell)\b": "estimated",
    r"\brivals?\b": "baseline",
    r"\barms? of the comparison\b|\bevery arm\b|\ball arms\b": "method",
    r"\bundecided\b": "inconclusive",
    r"\bfails? as expected\b": "expected violation",
    r"\bthe bare law\b|\bbare law\b": "flat-ground model",
    r"\bnothing fitted\b": "no free parameters",
    r"\bhardly ever\b|\bnext to nothing\b": "a percentile or a bound",
    r"\bseen once\b": "unrecorded observation",
    r"\bstands? apart from\b": "not in `run all`",
    r"\bmade anew\b|\bwrit(e|ten) anew\b|\bdrawn anew\b": "rebuilt, rewritten, redrawn",
    r"\bdear to make\b": "expensive",
    r"\bstrangers?'?\b|\bStrangersError\b": "other packages' code, PluginError",
    r"\bas good as (the )?whole\b|\bnobody tells\b": "FLIP to the unpruned reference ≤ …",
    r"\bwhat there is to see\b": "the scene, the gallery",
    r"\bis promised\b|\bpromises of\b": "guarantees",
    r"\bkeeps? its tone\b": "luminance ratio",
    r"\bfills as much of\b": "coverage ratio",
    r"\bmotion does not explain\b": "motion-compensated residual",
    r"\brestless(ness)?\b": "motion bounds",
}
BANNED = {re.compile(word, re.IGNORECASE): cure for word, cure in INSTEAD.items()}


def pages() -> Iterator[Path]:
    """README, the manual, the pages of results, and templates of what the program writes."""
    yield ROOT / "README.md"
    yield from sorted((ROOT / "docs").glob("*.md"))
    yield from sorted((ROOT / "results").glob("*.md"))
    yield from sorted((ROOT / "bench").rglob("*.jinja"))
    yield from sorted((ROOT / "bench").rglob("*.html"))


def strings(path: Path) -> Iterator[tuple[int, str]]:
    """Texts of a Python file with their lines: all of what it can print, and its docstrings."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Constant) and isinstance(node.value, str) and " " in node.value:
            yield node.lineno, node.value


def breaches() -> Iterator[str]:
    """Each banned word with its place and what to write instead."""
    for path in pages():
        for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1):
            yield from _found(path, number, re.sub(r"`[^`]*`", "", line))
    for room in ("lod", "scenes", "bench"):
        for path in sorted((ROOT / room).rglob("*.py")):
            for number, text in strings(path):
                yield from _found(path, number, text)


def _found(path: Path, number: int, text: str) -> Iterator[str]:
    for word, cure in BANNED.items():
        if match := word.search(text):
            yield f"{path.relative_to(ROOT)}:{number}: “{match[0]}”; write: {cure}"


if __name__ == "__main__":
    found = list(breaches())
    print("\n".join(found))
    sys.exit(bool(found))
