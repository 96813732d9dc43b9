"""The record of what people answered."""

from collections.abc import Mapping, Sequence
from datetime import UTC, datetime
from typing import Any

from bench.experiment import experiments
from bench.experiments.observers import answer_points
from bench.observers.plan import EXCLUSIONS
from bench.observers.results import Session
from bench.records.provenance import provenance
from bench.records.records import Record
from lod.errors import InputError


def answers_record(
    sessions: Sequence[Session], plan: Mapping[str, Any], why: Mapping[int, str], refused: int
) -> Record:
    """Make a record of the sessions that are used; ``why`` says of each observer why he is not.

    Raises InputError where no condition has two observers.
    """
    experiment = experiments()["observers"]
    points = tuple(answer_points(sessions, plan))
    if not points:
        rule = "2 observers of one condition, or more, who are not excluded"
        raise InputError("FILES", len(sessions), rule, "ask more people")
    count = {reason: sum(each == reason for each in why.values()) for reason in EXCLUSIONS}
    notes = {
        "plan": plan["sha256"],
        "observers": len(sessions),
        "excluded": count,
        "files_refused": refused,
        "simulated": any(each.session.startswith("simulated") for each in sessions),
    }
    made = datetime.now(UTC).strftime("%Y-%m-%dT%H:%M:%SZ")
    origin = provenance(plan["sha256"], plan["seed"])
    return Record(
        experiment.name,
        experiment.version,
        False,
        made,
        origin,
        points,
        experiment.judged(points),
        notes,
    )
