"""Files of results: read and checked, excluded by rule, and counted.

A file is what the page writes when a session ends: JSON whose ``sha256`` is that of ``content`` as
canonical JSON, in which every number is whole. It finds changes; it is no signature.
"""

import json
from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Literal

import numpy as np
from pydantic import BaseModel, Field, ValidationError

from bench.observers import plan as fixed
from bench.records.records import content_sha256
from lod.errors import InputError

FORMAT, FORMAT_VERSION = "lodbench-observer", 1
LARGEST_FILE = 4_000_000


class Trial(BaseModel, strict=True):
    """One answer: what was shown, on which side the pruned picture was, and what was said."""

    condition: int = Field(ge=0)
    caught: bool
    level: int = Field(ge=0, lt=len(fixed.FITTED_LEVELS))
    side: Literal[0, 1]
    answer: Literal[0, 1]
    ms: int = Field(ge=0)


class Screen(BaseModel, strict=True):
    """What matters of the screen: pixels in a degree of sight, in thousandths."""

    millipixels_per_degree: int = 0


class Session(BaseModel, strict=True):
    """The answers of one observer."""

    plan: str
    observer: int = Field(ge=1)
    session: str
    finished: str
    screen: Screen
    trials: tuple[Trial, ...] = Field(strict=False)

    def counts(self) -> dict[int, tuple[np.ndarray, np.ndarray]]:
        """Return right answers and trials shown by level, (levels,) each, of every condition."""
        found = {}
        for number in sorted({each.condition for each in self.trials}):
            mine = [each for each in self.trials if each.condition == number]
            level, right = zip(*((t.level, t.answer == t.side) for t in mine), strict=True)
            found[number] = fixed.counts(np.array(level), np.array(right))
        return found

    def excluded(self, plan: Mapping[str, Any]) -> str:
        """Return the first of EXCLUSIONS that holds; an empty text where none does."""
        missed = sum(each.answer != each.side for each in self.trials if each.caught)
        ppd = self.screen.millipixels_per_degree / 1000 / fixed.PIXELS_PER_DEGREE
        holds = (
            len(self.trials) < plan["block_trials"],
            missed > fixed.MOST_CATCHES_MISSED,
            np.median([each.ms for each in self.trials] or [0]) < fixed.SHORTEST_MEDIAN_MS,
            abs(ppd - 1) > fixed.MOST_OFF_DISTANCE,
        )
        return next((why for why, so in zip(fixed.EXCLUSIONS, holds, strict=True) if so), "")


class ResultFile(BaseModel, strict=True):
    """A file as the page writes it."""

    format: Literal["lodbench-observer"]
    format_version: Literal[1]
    sha256: str
    content: Session


def result_text(content: Mapping[str, Any]) -> str:
    """Write a result file as the page does."""
    head = {"format": FORMAT, "format_version": FORMAT_VERSION}
    return json.dumps({**head, "sha256": content_sha256(content), "content": content}) + "\n"


def read_results(paths: Sequence[Path], plan: Mapping[str, Any]) -> tuple[list[Session], list[str]]:
    """Read result files of a plan; also return a line for each file that cannot be used."""
    sessions: dict[int, tuple[Session, Path]] = {}
    refused = []
    for path in paths:
        try:
            session = read_result(path, plan)
            _, first = sessions.setdefault(session.observer, (session, path))
            if first != path:
                rule = f"one file of observer {session.observer}, who has {first.name} as well"
                raise InputError("FILES", str(path), rule, "keep one of them")
        except InputError as error:
            refused.append(str(error))
    return [session for session, _ in sessions.values()], refused


def read_result(path: Path, plan: Mapping[str, Any]) -> Session:
    """Read one file. Raises InputError for one that is broken, foreign or edited."""
    try:
        with path.open("rb") as opened:
            body = json.loads(opened.read(LARGEST_FILE).decode("utf-8"))
        file = ResultFile.model_validate(body)
        whole = file.sha256 == content_sha256(body["content"])
    except ValidationError as error:
        first = error.errors()[0]
        rule = f"a file that the page saved; {'.'.join(map(str, first['loc']))}: {first['msg']}"
        raise InputError("FILES", str(path), rule, "leave it out") from None
    except (OSError, ValueError, RecursionError) as error:
        rule = f"a readable JSON file ({type(error).__name__})"
        raise InputError("FILES", str(path), rule, "save it again from the page") from None
    session = file.content
    block = plan["blocks"][(session.observer - 1) % len(plan["blocks"])]
    most = {(k, c): plan["catches" if c else "trials"] for k in block for c in (False, True)}
    shown = Counter((each.condition, each.caught) for each in session.trials)
    faults = {
        "content with the SHA-256 it names: it was edited or damaged": not whole,
        "a file of this experiment, and it is of another": session.plan != plan["sha256"],
        f"trials of the block of observer {session.observer}": any(
            n > most.get(trial, 0) for trial, n in shown.items()
        ),
    }
    for rule, holds in faults.items():
        if holds:
            raise InputError("FILES", str(path), rule, "take the file that the page saved")
    return session
