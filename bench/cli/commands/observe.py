"""`lodbench observe`: an experiment on what people see, made, simulated and fitted."""

import json
from collections import Counter
from dataclasses import asdict
from pathlib import Path
from typing import Any

import click

from bench.cli.flags import StrictCommand, memory_flag_of_all
from bench.cli.output import output, progress_bar, table, tell_first_run
from lod.errors import InputError
from scenes.files import make_folder, write_text


@click.group("observe")
def command() -> None:
    """Ask people at which τ they see what is left out; see docs/observers.md."""


def plan_of(folder: str) -> dict[str, Any]:
    """Read the plan of an experiment's folder. Raises InputError for what is none."""
    from bench.observers.make import PLAN
    from bench.observers.plan import digest

    path, cure = Path(folder) / PLAN, f"make one with `lodbench observe make {folder}`"
    try:
        plan: dict[str, Any] = json.loads(path.read_text("utf-8"))
        body = {k: v for k, v in plan.items() if k not in ("sha256", "models", "power")}
        whole = plan["sha256"] == digest(body)
    except (OSError, ValueError, TypeError, KeyError, AttributeError):
        raise InputError("DIR", folder, "the folder of an experiment", cure) from None
    if not whole:
        raise InputError("DIR", str(path), "a plan that was not edited", cure)
    return plan


@command.command("make", cls=StrictCommand)
@click.argument("folder", metavar="DIR")
@click.option("--size", metavar="WxH", default="640x360", show_default=True, help="Of a picture.")
@click.option(
    "--spp",
    type=click.IntRange(1, 65536),
    default=256,
    show_default=True,
    metavar="N",
    help="Samples per pixel.",
)
@click.option(
    "--frames",
    type=click.IntRange(2, 240),
    default=24,
    show_default=True,
    metavar="N",
    help="Frames of a clip, 24 a second.",
)
@click.option(
    "--small", is_flag=True, help="The six conditions that try the program, and not all 36."
)
@click.option(
    "--condition",
    "names",
    multiple=True,
    metavar="NAME",
    help='Only this one, as "trees, far, still".',
)
@click.option("--variant", default="auto", metavar="NAME", help="Mitsuba variant, or auto.")
@click.option(
    "--cluster", metavar="N|ADDRESS|FILE", help="Workers to start here, or a Dask scheduler."
)
@memory_flag_of_all
@click.option("--json", "as_json", is_flag=True, help="One JSON object on stdout.")
def make_command(
    folder: str,
    size: str,
    spp: int,
    frames: int,
    small: bool,
    names: tuple[str, ...],
    variant: str,
    cluster: str | None,
    as_json: bool,
) -> None:
    """Render the pairs, and write the page DIR/index.html, which works offline.

    The same command again goes on where it was stopped; finished pictures are kept.
    """
    from bench.observers.make import PAGE, Pictures, make
    from bench.observers.plan import CONDITIONS, SMALL_SET, chosen_conditions
    from bench.observers.simulate import ObserverModel, power
    from bench.runs import dask_executor
    from scenes.presets.load import load_preset
    from scenes.render.pictures import needed_ffmpeg
    from scenes.render.variants import choose

    if small and names:
        raise InputError("--small --condition", "both", "one names the conditions", "leave one out")
    conditions = chosen_conditions(names) if names else SMALL_SET if small else CONDITIONS
    checked = load_preset("meadow", [f"render.size={size}"]).render.size
    if any(each.moving for each in conditions):
        needed_ffmpeg()
    place = make_folder(folder, "DIR").resolve()
    need = power(len(conditions), ObserverModel())
    how = Pictures("x".join(map(str, checked)), spp, frames)
    with output(as_json) as out, dask_executor(cluster, out.note) as spread:
        tell_first_run()
        with progress_bar("condition") as progress:
            plan = make(place, conditions, how, choose(variant), spread, progress, need)
        page = str(Path(folder) / PAGE)
        out.record(
            {"page": page, "plan": plan["sha256"], "conditions": len(conditions), "power": need}
        )
        heads = [("trials", "deviation of log10 τ75", "observers a condition", "observers in all")]
        out.say(f"{page}: {len(conditions)} conditions, ready")
        out.say("For τ75 of a condition within ±15 %, if observers are as the model assumes:")
        out.say(table([*heads, *(tuple(row.values()) for row in need)]))


@command.command("fit", cls=StrictCommand)
@click.argument("files", metavar="FILES...", nargs=-1, required=True)
@click.option("--of", "of", required=True, metavar="DIR", help="Folder of the experiment.")
@click.option("-o", "folder", required=True, metavar="DIR", help="Folder for the record.")
@click.option("--json", "as_json", is_flag=True, help="One JSON object on stdout.")
def fit_command(files: tuple[str, ...], of: str, folder: str, as_json: bool) -> None:
    """Fit the answers in result files: τ75 by observer and by condition, and write a record."""
    from bench.observers.record import answers_record
    from bench.observers.results import read_results
    from bench.records.records import write_record

    plan = plan_of(of)
    place = make_folder(folder)
    read = read_results([Path(each) for each in files], plan)
    why = {each.observer: each.excluded(plan) for each in read.sessions}
    kept = [each for each in read.sessions if not why[each.observer]]
    with output(as_json) as out:
        for line in read.refused:
            out.note(f"lodbench: {line}")
        for observer, reason in why.items():
            if reason:
                out.note(f"lodbench: observer {observer} is excluded: {reason}")
        record = answers_record(kept, plan, why, len(read.refused))
        path = write_record(record, place)
        data = [each.as_json() for each in record.claims]
        out.record(
            {
                "record": str(path),
                "observers": len(kept),
                "excluded": {str(k): v for k, v in why.items() if v},
                "refused": list(read.refused),
                "claims": data,
            }
        )
        rows = [("verdict", "pictures", "τ75 [px]", "observers")]
        rows += [
            (c.verdict_text, c.where, c.measured_text, str(c.replicates)) for c in record.claims
        ]
        out.say(f"{path}: {len(kept)} of {len(why)} observers\n{table(rows)}")


@command.command("simulate", cls=StrictCommand)
@click.argument("experiment", metavar="DIR")
@click.option("-o", "folder", required=True, metavar="DIR", help="Folder for the result files.")
@click.option(
    "--observers",
    type=click.IntRange(1, 9999),
    default=36,
    show_default=True,
    metavar="N",
    help="How many answer as the model says.",
)
@click.option(
    "--guessers", type=click.IntRange(0, 999), default=0, metavar="N", help="How many more guess."
)
@click.option(
    "--lapsers",
    type=click.IntRange(0, 999),
    default=0,
    metavar="N",
    help="How many more lapse in half of all trials.",
)
@click.option("--seed", type=click.IntRange(0, 2**32 - 1), default=0, help="0 by default.")
@click.option("--json", "as_json", is_flag=True, help="One JSON object on stdout.")
def simulate_command(
    experiment: str,
    folder: str,
    observers: int,
    guessers: int,
    lapsers: int,
    seed: int,
    as_json: bool,
) -> None:
    """Send observers of a stated model through the protocol, and write files as the page does."""
    from bench.observers.simulate import Kind, ObserverModel, simulated_files

    plan = plan_of(experiment)
    kinds: list[Kind] = ["observer"] * observers
    kinds += ["guesser"] * guessers
    kinds += ["lapser"] * lapsers
    place, model = make_folder(folder), ObserverModel()
    paths = []
    for name, text in simulated_files(plan, kinds, model, seed):
        write_text(place / name, text)
        paths.append(str(place / name))
    with output(as_json) as out:
        out.record({"files": paths, "model": asdict(model), "kinds": dict(Counter(kinds))})
        out.say(f"{folder}: {len(paths)} files of simulated observers; nobody has looked")
