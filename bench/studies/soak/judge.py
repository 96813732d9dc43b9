"""Which promises does a command, or a folder after it, break?"""

import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from bench.studies.soak.program import Run

LOST = "frames lost"
PASSED = "wrong frames that verify passes"
REFUSED = "right frames that verify fails"
STUCK = "folders that cannot go on"
TRACEBACK = "tracebacks"
SILENT = "failures without a reason"
CODE = "exit codes that are not documented"
NOT_JSON = "lines under --json that are not JSON"
HANGS = "commands that hang"
PROCESSES = "processes left"
FILES = "temporary files left"
KINDS = (
    *(LOST, PASSED, REFUSED, STUCK, TRACEBACK, SILENT),
    *(CODE, NOT_JSON, HANGS, PROCESSES, FILES),
)
"""What is counted, and must stay 0."""

_CODES = {0, 1, 2}
_SIGNAL_CODES = {"INT": 130, "TERM": 143, "HUP": 129, "KILL": -9}
_CRASH = re.compile(
    r"Traceback \(most recent call last\)|Exception ignored|Fatal Python error|leaked semaphore"
    r"|Segmentation fault|core dumped"
)
_SPEAKS_JSON = ("render", "long", "verify", "repair")


@dataclass(frozen=True)
class Broken:
    """A promise that was broken: which of KINDS, how often, and how that was seen."""

    kind: str
    text: str
    times: int = 1


def judge_run(run: Run) -> list[Broken]:
    """Judge how one command ended, whatever else went on beside it."""
    broken = []
    said = "\n".join(text for text in (run.out, run.err) if text)
    if found := _CRASH.search(said):
        broken.append(Broken(TRACEBACK, said[found.start() :][-600:]))
    if run.code is None:
        broken.append(Broken(HANGS, f"after {', '.join(run.signals) or 'no signal'}"))
    elif run.code not in _CODES | {_SIGNAL_CODES[name] for name in run.signals}:
        broken.append(Broken(CODE, f"{run.code} after {', '.join(run.signals) or 'no signal'}"))
    if run.code in (1, 2) and run.err is not None and "lodbench: " not in run.err:
        broken.append(Broken(SILENT, f"exit {run.code}, and stderr is {run.err[-200:]!r}"))
    if run.left:
        broken.append(Broken(PROCESSES, "; ".join(run.left), len(run.left)))
    if run.command.verb in _SPEAKS_JSON and run.out:
        lines = run.out.splitlines()
        whole = lines if run.out.endswith("\n") else lines[:-1]
        ended = run.code in (0, 1, 2)
        if len(list(run.lines())) < len(lines if ended else whole):
            broken.append(Broken(NOT_JSON, run.out[-300:]))
    return broken


def judge_verdict(
    run: Run, looks: Mapping[str, str | None], right: set[str], manifest_harmed: bool
) -> list[Broken]:
    """Judge what `verify` said of a folder at rest.

    looks            by name of every file that is asked for: whose bytes it has, None for nobody's
    right            names whose bytes and record are as they should be
    manifest_harmed  the record was damaged, so that it need not know what is right
    """
    faults = {Path(line["path"]).name: line["wrong"] for line in run.lines() if "path" in line}
    listed = {name for name in faults if name.endswith((".exr", ".part"))}
    judged = any("frames" in line for line in run.lines())
    wrong = {name for name, look in looks.items() if look is None}
    broken = []
    if judged and (passed := wrong - listed):
        broken.append(Broken(PASSED, ", ".join(sorted(passed)), len(passed)))
    if manifest_harmed:
        return broken
    if judged and (failed := right & listed):
        first = min(failed)
        text = f"{first}: {faults[first]}, and {len(failed) - 1} more"
        broken.append(Broken(REFUSED, text, len(failed)))
    elif not judged and right:
        said = (run.err or "").strip()
        broken.append(Broken(REFUSED, f"verify gives no verdict: {said[-300:]}", len(right)))
    elif judged and run.code and not listed:
        broken.append(Broken(REFUSED, f"exit {run.code}, and no frame is wrong: {run.out}"))
    return broken
