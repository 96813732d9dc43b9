"""What a plug-in does when it is imported, found out in a process of its own.

A stranger's module may end the process, crash it, hang, fork or print. It does so there first, and
only one that does none of it but print is imported here. Children of this process need not try it
again.
"""

import json
import logging
import os
import re
import signal
import subprocess
import sys
import tempfile
from contextlib import suppress
from functools import cache
from typing import BinaryIO

LONGEST_S = 30
TRIED = "LODBENCH_TRIED_PLUGINS"
"""Set for children: the objects that their parent has tried, as module:object, a line each."""

_OBJECT = re.compile(r"\w+(\.\w+)*:\w+(\.\w+)*(\s*\[.*\])?")
_CHILD = (sys.executable, "-P", "-m", "scenes.plugins.trial_child")


@cache
def import_fault(value: str, owner: str) -> str | None:
    """Say why an object, given as module:object, must not be imported here; None if it may be.

    What it prints when it is imported is logged as a warning that names its ``owner``.
    """
    if not _OBJECT.fullmatch(value):
        return "it is not written as module:object"
    tried = os.environ.get(TRIED, "").splitlines()
    if value in tried:
        return None
    with tempfile.TemporaryFile() as answer, tempfile.TemporaryFile() as printed:
        fault = _tried(value, answer, printed)
        printed.seek(0)
        if words := " ".join(printed.read(200).decode(errors="replace").split()):
            log = logging.getLogger(__name__)
            log.warning("lodbench: %s of %s prints when it is imported: %s", value, owner, words)
    if fault is None:
        os.environ[TRIED] = "\n".join([*tried, value])
    return fault


def _tried(value: str, answer: BinaryIO, printed: BinaryIO) -> str | None:
    paths = os.pathsep.join(filter(None, sys.path))
    process = subprocess.Popen(
        [*_CHILD, str(os.getpid()), str(answer.fileno()), value],
        stdin=subprocess.DEVNULL,
        stdout=printed,
        stderr=subprocess.DEVNULL,
        pass_fds=(answer.fileno(),),
        env={**os.environ, "PYTHONPATH": paths},
        start_new_session=True,
    )
    try:
        code = process.wait(LONGEST_S)
    except subprocess.TimeoutExpired:
        return f"it hangs: no end after {LONGEST_S} s"
    finally:
        with suppress(ProcessLookupError):
            os.killpg(process.pid, signal.SIGKILL)  # and what it may have started
        process.wait()
    answer.seek(0)
    try:
        said, forks = json.loads(answer.read())
    except ValueError:
        return f"it ends the process by signal {-code}" if code < 0 else "it ends the process"
    return said or ("it forks" if forks else None)
