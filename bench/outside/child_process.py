"""Ask a program that runs in an environment of its own."""

import json
import os
import subprocess
from pathlib import Path
from typing import Any

from bench.outside.environments import Environment
from lod.errors import InputError

_FOLDER = Path(__file__).parent
_LONGEST_S = 3600
_LAST_LINES = 3


def answer_of(environment: Environment, script: str, asked: str, *arguments: str) -> dict[str, Any]:
    """Run a script beside this file in an environment, and return the JSON of its last line.

    Raises InputError where there is no such environment, and where the script fails.
    """
    python = environment.python()
    if python is None:
        cure = f"`lodbench study environments {environment.name}` makes it"
        raise InputError(environment.name, "no environment", "it is made on request", cure)
    mine = {k: v for k, v in os.environ.items() if not k.startswith("PYTHON")}
    done = subprocess.run(
        [str(python), "-I", str(_FOLDER / script), *arguments],
        input=asked,
        env=mine,
        capture_output=True,
        timeout=_LONGEST_S,
        text=True,
    )
    if done.returncode:
        last = " / ".join(done.stderr.strip().splitlines()[-_LAST_LINES:])
        raise InputError(environment.name, f"exit code {done.returncode}", last or "no message")
    found: dict[str, Any] = json.loads(done.stdout.splitlines()[-1])
    return found
