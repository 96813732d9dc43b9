"""`lodbench compare`: what changed between two runs, and what cannot be compared."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from bench.cli.flags import StrictCommand
from bench.cli.output import Output, progress_bar, table

if TYPE_CHECKING:
    from bench.compare_runs import Comparison
    from bench.records.claims import Claim


@click.command("compare", cls=StrictCommand, json="One JSON object per experiment on stdout.")
@click.argument("before", metavar="A")
@click.argument("after", metavar="B")
def command(before: str, after: str, out: Output) -> None:
    """Compare two records, or two folders of them: claims, verdicts and samples."""
    from bench.compare_runs import compare_paths

    with progress_bar("step") as show:
        show(0, 1, "reading records")
        found = compare_paths(Path(before), Path(after))
    for each in found:
        out.record(each.as_json())
        _say(out, each)


def _say(out: Output, found: "Comparison") -> None:
    same = "the same samples" if found.same_samples else "other samples"
    out.say(f"{found.experiment}: {found.before} → {found.after}, {same}")
    for key, (one, other) in found.origin.items():
        out.say(f"  {key}: {_differing(one, other)}")
    changed = [each for each in found.differences if each.change != "same"]
    rows: list[tuple[Any, ...]] = [
        (each.change, each.name, _told(each.before), _told(each.after)) for each in changed
    ]
    kept = len(found.differences) - len(changed)
    out.say(f"  {kept} of {len(found.differences)} claims are the same to the last digit")
    for told in found.problems:
        out.say(f"  wrong: {told}")
    for drift in found.drifts:
        ratio = f"{drift.ratio:.4g} ({drift.low:.4g} to {drift.high:.4g})"
        out.say(f"  drifted: {drift.quantity}, {drift.where}: {ratio} times what it was")
    if rows:
        out.say(table([("", "claim", "before", "after"), *rows]))


def _told(claim: "Claim | None") -> str:
    if claim is None:
        return "–"
    return f"{claim.measured:.4g} ({claim.low:.4g} to {claim.high:.4g}) {claim.verdict}"


def _differing(one: Any, other: Any) -> str:
    if isinstance(one, dict) and isinstance(other, dict):
        names = sorted(k for k in {*one, *other} if one.get(k) != other.get(k))
        return ", ".join(f"{name} {one.get(name)} → {other.get(name)}" for name in names)
    return f"{one} → {other}"
