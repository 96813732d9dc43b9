"""What actors cost, what the temporal metric saves of it, how far off who waits is, and who meets.

Each part is written to a record as soon as it is measured, so that a run that was stopped
goes on with the parts that are not there yet: what a threshold saves of the updates
(``bench.acting``), where the time of an update goes, by what an actor does
(``costs``), and whether people who walk about keep clear of each other and stand on their feet
(``walking``). A part that another run measured than the first has its own provenance.
"""

import json
from collections.abc import Callable, Iterator
from dataclasses import asdict
from functools import partial
from operator import itemgetter
from pathlib import Path
from typing import Any

import click

from bench.acting import (
    Clearance,
    Costs,
    Crowd,
    Feet,
    Meetings,
    Saving,
    clearance,
    cost_rows,
    costs,
    costs_by_behaviour,
    feet_of_actors,
    feet_of_the_field,
    meetings,
    saving,
    saving_rows,
    verdict_rows,
    walking_rows,
)
from bench.cli.output import counted, table
from bench.records.provenance import provenance, scene_digest
from lod.errors import InputError
from scenes.files import whole_file

Record = dict[str, dict[str, Any]]
"""What was measured, by part."""


def measurements(quick: bool, seed: int) -> Iterator[tuple[str, Callable[[], Any]]]:
    """List every part with what measures it; the quick ones are too small to say much."""
    frames, big = (12, 60) if quick else (96, 1000)
    crowds = [Crowd(big), Crowd(big, threshold=1.0), Crowd(big, threshold=2.0)]
    crowds += [Crowd(big, 0.02), Crowd(big, 0.08), Crowd(big, questions=20)]
    crowds += [Crowd(big, questions=100), Crowd(10 * big)]
    crowds += [Crowd(big, threshold=each, waving=True) for each in (0.5, 2.0)]
    for crowd in crowds[: 2 if quick else None]:
        key = f"waiting {crowd.actors} {crowd.density:g} {crowd.questions} {crowd.threshold:g}"
        yield f"{key} waving" if crowd.waving else key, partial(saving, crowd, frames, seed)
    people = 20 if quick else 200
    for side in (40.0, 200.0):
        yield f"costs {side:g}", partial(costs, people, side, frames, seed)
    yield "behaviours 40", partial(costs_by_behaviour, people, 40.0, frames // 4, seed)
    for seconds in (1.0,) if quick else (4.0, 60.0):
        yield f"feet actors {seconds:g}", partial(feet_of_actors, people, 40.0, seconds, seed)
    yield "feet field", partial(feet_of_the_field, people, 6.0, 1.0 if quick else 4.0, seed)
    for seconds in (1.0,) if quick else (60.0, 600.0):
        yield f"clear {seconds:g}", partial(clearance, people, 40.0, seconds, seed)
    yield "meetings playground", partial(meetings, "playground", 6 if quick else 96)


def read_record(path: Path) -> Record:
    """Read a record; it is empty where there is none. Raises InputError for another file."""
    if not path.exists():
        return {}
    try:
        data = json.loads(path.read_text(encoding="utf-8"))
        parts: Record = data["parts"]
        return parts
    except (OSError, ValueError, KeyError, TypeError):
        rule, cure = "a record that this study wrote", "choose another file with -o"
        raise InputError("-o", str(path), rule, cure) from None


def page(parts: Record) -> str:
    """Write a record as text: tables and lines, of the parts that are there."""
    waiting = [_saving(each) for key, each in parts.items() if key.startswith("waiting")]
    spent = [Costs(**each) for key, each in parts.items() if key.startswith("costs")]
    feet = [_feet(each) for key, each in parts.items() if key.startswith("feet")]
    blocks = []
    if waiting:
        blocks.append(table(saving_rows(waiting)))
        blocks.append(_indented(verdict_rows(waiting)))
    if spent:
        blocks.append(table(cost_rows(spent)))
    for key, each in parts.items():
        if key.startswith("behaviours"):
            blocks.append(table(cost_rows([Costs(**one) for one in each["found"]])))
    met = [Meetings(**each) for key, each in parts.items() if key.startswith("meetings")]
    clear = [Clearance(**each) for key, each in parts.items() if key.startswith("clear")]
    if lines := walking_rows(clear, met, feet):
        blocks.append(_indented(lines))
    return "\n\n".join(blocks)


def _indented(lines: list[str]) -> str:
    return "\n".join(f"  {line}" for line in lines)


def _saving(data: dict[str, Any]) -> Saving:
    px = {name: tuple(data[name]) for name in ("at_once_px", "in_time_px")}
    return Saving(**data | px | {"crowd": Crowd(**data["crowd"])})


def _feet(data: dict[str, Any]) -> Feet:
    return Feet(**data | {"slide_mm": tuple(data["slide_mm"])})


@click.command("acting")
@click.option("-o", "path", type=click.Path(path_type=Path), help="Record; goes on with it.")
@click.option("--only", default="", metavar="PARTS", help="Parts whose names begin so.")
@click.option("--quick", is_flag=True, help="Small crowds, to see that it works.")
@click.option("--seed", type=click.IntRange(0, 2**62), default=0, show_default=True)
def command(path: Path | None, only: str, quick: bool, seed: int) -> None:
    """Time actors with and without the temporal metric, and see that nobody walks through another.

    Two people overlap where they are less than 0.4 m apart. A full run takes 20 minutes.
    """
    parts = read_record(path) if path else {}
    asked = [
        each for each in measurements(quick, seed) if each[0].startswith(tuple(only.split(",")))
    ]
    missing = [each for each in asked if each[0] not in parts]
    for name, measure in counted(missing, "part", itemgetter(0)):
        parts[name] = asdict(measure())
        if path:
            origin = asdict(provenance(scene_digest([quick, seed]), seed))
            parts = _kept(path, name, parts, origin)
    click.echo(page(parts))


def _kept(path: Path, name: str, parts: Record, origin: dict[str, Any]) -> Record:
    """Write a new part beside those that another process may have measured meanwhile.

    ``origins`` has the provenance of those parts whose own is another than the record's ``origin``.
    """
    parts = read_record(path) | parts
    before = json.loads(path.read_text(encoding="utf-8")) if path.exists() else {}
    first, origins = before.get("origin", origin), before.get("origins", {})
    if origin != first:
        origins |= {name: origin}
    with whole_file(path, overwrite=True) as partial:
        data = {"by": "lodbench", "origin": first, "origins": origins, "parts": parts}
        partial.write_text(json.dumps(data, indent=1) + "\n", encoding="utf-8")
    return parts
