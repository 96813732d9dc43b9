"""Judge the bar by the places that are done, before `lodbench run stills` has measured all eight.

    python -m tests.tools.bar_so_far out/bar out/so_far

writes the record of the first places of which all cases are kept in out/bar/.journal. It has a note
of how many they are. Whoever stops there must not choose when by what it says.
"""

import shutil
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
    Journal,
    RunRequest,
    journal,
    measured_case,
    run_request,
    serial_executor,
)

ASKED = RunRequest("bar", ("stills",))


def place_of(case: Case) -> Place:
    """Return the place that a case looks at."""
    assert isinstance(case, partial)
    return case.args[0]


def _nothing(_: Callable[..., Any], cases: Sequence[tuple[Any, ...]]) -> Iterator[Any]:
    if cases:
        raise LookupError
    return iter(())


def _is_done(case: Case, kept: Journal) -> bool:
    try:
        return bool(list(kept.memoised(ASKED, _nothing)(measured_case, [(case, ASKED.seed)])))
    except LookupError:
        return False


def whole_places(cases: Sequence[Case], kept: Journal) -> int:
    """Return the number of first places of which all cases are done; places come in order."""
    found = 0
    for _, mine in groupby(cases, lambda case: place_of(case).number):
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


@click.command()
@click.argument("folder")
@click.argument("target")
def command(folder: str, target: str) -> None:
    """Write the record of the places that are done in FOLDER into TARGET."""
    topic = EXPERIMENT.topics["stills"]
    cases = topic.cases(**topic.sizes("full"))
    count = whole_places(cases, journal(Path(folder)))
    if count < 2:
        raise click.ClickException(f"{count} places are done, and an interval needs two")
    shutil.copytree(Path(folder, JOURNAL), Path(target, JOURNAL))
    reduced = of_places(EXPERIMENT, cases, count)
    path, _ = run_request(reduced, ASKED, journal(Path(target)), serial_executor, lambda *_: None)
    click.echo(f"{count} places: {path}")


if __name__ == "__main__":
    command()
