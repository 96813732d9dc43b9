"""What changed between two runs: claim by claim, and whether the samples are the same.

Two records may meet where they ask the same of the same scene on the same kind of machine; commit,
packages and seed may differ, for that is what is compared. Everything else is refused.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

from bench.records.claims import Claim
from bench.records.integrity import Drift, drifts, problems
from bench.records.records import Record, read_record, read_records
from lod.errors import InputError

Change = Literal["same", "within the intervals", "moved", "verdict", "new", "gone"]

_SAME = ("scene", "variant", "threads", "cpu", "cores")
"""What two records must share; an experiment's version and whether it was quick, too."""

_MAY_DIFFER = ("commit", "packages", "platform", "python", "seed")


@dataclass(frozen=True)
class Difference:
    """What became of one claim, which is in both runs or in one of them."""

    name: str
    change: Change
    before: Claim | None
    after: Claim | None

    def as_json(self) -> dict[str, Any]:
        """Return plain data."""
        sides = {"before": self.before, "after": self.after}
        told = {side: claim.as_json() if claim else None for side, claim in sides.items()}
        return {"name": self.name, "change": self.change, **told}


@dataclass(frozen=True)
class Comparison:
    """A comparison of two records of one experiment.

    origin  what else differs in their provenance, as (before, after) by name
    drifts  quantities whose mean is another, whatever the verdicts say
    problems  what cannot be in the second record
    """

    experiment: str
    before: str
    after: str
    same_samples: bool
    origin: dict[str, tuple[Any, Any]]
    differences: tuple[Difference, ...]
    drifts: tuple[Drift, ...]
    problems: tuple[str, ...]

    def as_json(self) -> dict[str, Any]:
        """Return plain data."""
        told = {"differences": [each.as_json() for each in self.differences]}
        return {**vars(self), **told, "drifts": [vars(each) for each in self.drifts]}


def compare(before: Record, after: Record) -> Comparison:
    """Compare two records claim by claim. Raises InputError where they cannot be compared."""
    for key in ("experiment", "version", "quick"):
        _must_share(key, getattr(before, key), getattr(after, key))
    for key in _SAME:
        _must_share(key, getattr(before.provenance, key), getattr(after.provenance, key))
    origin = {
        key: pair
        for key in _MAY_DIFFER
        if len(set(map(str, pair := tuple(getattr(r.provenance, key) for r in (before, after)))))
        > 1
    }
    return Comparison(
        before.experiment,
        before.name,
        after.name,
        before.samples_sha256 == after.samples_sha256,
        origin,
        tuple(_differences(before.claims, after.claims)),
        drifts(before, after),
        problems(after),
    )


def compare_paths(before: Path, after: Path) -> tuple[Comparison, ...]:
    """Compare two records, or the newest of every experiment that two folders share.

    Raises InputError for a record and a folder, and for folders that share no experiment.
    """
    if before.is_dir() != after.is_dir():
        cure = "give a folder and a folder, or a file and a file"
        raise InputError("A B", f"{before} {after}", "two records or two folders", cure)
    if not before.is_dir():
        return (compare(read_record(before), read_record(after)),)
    first, second = _newest(before), _newest(after)
    shared = [key for key in first if key in second]
    if not shared:
        both = {name for name, _ in first} & {name for name, _ in second}
        rule, cure = "records of one experiment in both", "run one experiment into both"
        if both:
            quick, full = (before, after) if (min(both), True) in first else (after, before)
            named = ", ".join(sorted(both))
            rule = f"runs of one kind: of {named} {quick} has quick ones, {full} full"
            cure = f"measure in full: lodbench run {min(both).partition(' ')[0]} -o {quick}"
        raise InputError("A B", f"{before} {after}", rule, cure)
    return tuple(compare(first[key], second[key]) for key in shared)


def _newest(folder: Path) -> dict[tuple[str, bool], Record]:
    newest: dict[tuple[str, bool], Record] = {}
    for record in read_records(folder):
        newest.setdefault((record.subject, record.quick), record)
    return newest


def _must_share(key: str, before: object, after: object) -> None:
    if before != after:
        arrived = f"{str(before)[:40]} and {str(after)[:40]}"
        cure = "runs of the same workload on the same kind of machine can be compared"
        raise InputError(f"{key} of the two records", arrived, "the same in both", cure)


def _differences(before: Iterable[Claim], after: Iterable[Claim]) -> Iterable[Difference]:
    first, second = ({claim.name: claim for claim in claims} for claims in (before, after))
    for name in dict.fromkeys((*first, *second)):
        one, other = first.get(name), second.get(name)
        yield Difference(name, _change(one, other), one, other)


def _change(before: Claim | None, after: Claim | None) -> Change:
    if before is None or after is None:
        return "new" if before is None else "gone"
    if before.verdict != after.verdict:
        return "verdict"
    if before == after:
        return "same"
    apart = before.high < after.low or after.high < before.low
    return "moved" if apart else "within the intervals"
