"""Write docs/python.ipynb, the page of the Python module as a notebook."""

import json
import re
from pathlib import Path
from typing import Any

PAGE = Path(__file__).parent / "python.md"
NOTEBOOK = PAGE.with_suffix(".ipynb")

_BLOCK = re.compile(r"```python\n(.*?)```\n", re.S)
_REFERENCE = "## All names"  # from here on the page is for Sphinx alone


def notebook() -> str:
    """Write the notebook: each Python block of the page is a cell of code, and the text a cell."""
    tutorial = PAGE.read_text(encoding="utf-8").partition(_REFERENCE)[0]
    pieces = _BLOCK.split(tutorial)  # text and code take turns
    cells = [
        _cell(number, "code" if number % 2 else "markdown", piece.strip())
        for number, piece in enumerate(pieces)
        if piece.strip()
    ]
    python = {"display_name": "Python 3", "language": "python", "name": "python3"}
    content = {
        "cells": cells,
        "metadata": {"kernelspec": python, "language_info": {"name": "python"}},
        "nbformat": 4,
        "nbformat_minor": 5,
    }
    return json.dumps(content, indent=1, ensure_ascii=False) + "\n"


def _cell(number: int, kind: str, text: str) -> dict[str, Any]:
    code = {"execution_count": None, "outputs": []} if kind == "code" else {}
    source = text.splitlines(keepends=True)
    return {"cell_type": kind, "id": f"cell-{number}", "metadata": {}, **code, "source": source}


if __name__ == "__main__":
    NOTEBOOK.write_text(notebook(), encoding="utf-8")
