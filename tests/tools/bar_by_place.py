"""Measure the stills of the bar place by place, and judge the places that are done.

`lodbench run stills` goes preset by preset and has a record once all 144 cases are done, some 14
hours later. This keeps the same cases in the same journal, those of each place before those of the
next, so that every preset can be judged from the places that are done so far:

    timeout 150m python -m tests.tools.bar_by_place measure out/bar --cluster 2
    python -m tests.tools.bar_by_place judge out/bar out/so_far

``lodbench run stills -o out/bar`` goes on from there, and writes the record of all places.
"""

import shutil
import uuid
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import partial
from itertools import groupby
from pathlib import Path
from typing import Any

import click

import lodbench  # noqa: F401 - sets the number of threads before the renderer is imported
from bench.experiment import Case, Experiment
from bench.experiments.bar import EXPERIMENT
from bench.images.as_shipped import Place
from bench.runs import (
    JOURNAL,
    CaseExecutor,
    Journal,
    RunRequest,
    dask_executor,
    journal,
    measured_case,
    run_request,
    serial_executor,
)
from scenes.files import make_folder
from scenes.processes.ownership import owned

ASKED = RunRequest("bar", ("stills",))


def place_of(case: Case) -> Place:
    """Return the place that a case looks at."""
    assert isinstance(case, partial)
    return case.args[0]


def by_place(cases: Sequence[Case]) -> list[Case]:
    """Put the cases of every place before those of the next, in their order otherwise."""
    return sorted(cases, key=lambda case: place_of(case).number)


def measured(cases: Sequence[Case], kept: Journal, each: CaseExecutor) -> Iterator[dict[str, Any]]:
    """Measure what is not in the journal, place by place, and give every case's data."""
    return kept.memoised(ASKED, each)(measured_case, [(case, 0) for case in by_place(cases)])


def _nothing(_: Callable[..., Any], cases: Sequence[tuple[Any, ...]]) -> Iterator[Any]:
    if cases:
        raise LookupError
    return iter(())


def _is_done(case: Case, kept: Journal) -> bool:
    try:
        return bool(list(measured([case], kept, _nothing)))
    except LookupError:
        return False


def whole_places(cases: Sequence[Case], kept: Journal) -> int:
    """Return the number of first places of which all cases are done."""
    found = 0
    for _, mine in groupby(by_place(cases), lambda case: place_of(case).number):
        if not all(_is_done(case, kept) for case in mine):
            break
        found += 1
    return found


def of_places(experiment: Experiment, cases: Sequence[Case], count: int) -> Experiment:
    """Return an experiment that asks for the first ``count`` places alone, and notes so."""
    chosen = [case for case in cases if place_of(case).number < count]
    topic = replace(experiment.topics["stills"], cases=lambda **_: chosen)
    said = {"places": f"the first {count} of {max(place_of(c).number for c in cases) + 1}"}
    return replace(experiment, topics={"stills": topic}, notes=lambda _: said)


def _cases() -> list[Case]:
    topic = EXPERIMENT.topics["stills"]
    return topic.cases(**topic.sizes("full"))


@click.group()
def command() -> None:
    """Measure the stills of the bar place by place, and judge the places that are done."""


@command.command()
@click.argument("folder")
@click.option("--cluster", metavar="N", help="Workers to start here.")
def measure(folder: str, cluster: str | None) -> None:
    """Go on with the cases of FOLDER, and tell of each that is done."""
    kept, cases = journal(make_folder(folder)), _cases()
    say = partial(click.echo, err=True)
    with owned(kept.folder, uuid.uuid4().hex, "measures there", say):
        with dask_executor(cluster, say) as each:
            for number, data in enumerate(measured(cases, kept, each), 1):
                made = data["made"]
                click.echo(f"{number} of {len(cases)}: {made['case']}, {made['seconds']:.0f} s")


@command.command()
@click.argument("folder")
@click.argument("target")
def judge(folder: str, target: str) -> None:
    """Write the record of the places that are done in FOLDER into TARGET."""
    cases = _cases()
    count = whole_places(cases, journal(Path(folder)))
    if count < 2:
        raise click.ClickException(f"{count} places are done, and an interval needs two")
    shutil.copytree(Path(folder, JOURNAL), Path(target, JOURNAL))
    kept = journal(Path(target))
    reduced = of_places(EXPERIMENT, cases, count)
    path, _ = run_request(reduced, ASKED, kept, serial_executor, lambda *_: None)
    click.echo(f"{count} places: {path}")


if __name__ == "__main__":
    command()
