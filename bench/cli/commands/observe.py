"""`lodbench observe`: an experiment on what people see, made, simulated and fitted."""

import json
import math
from collections import Counter
from dataclasses import asdict
from pathlib import Path
from typing import Any

import click

from bench.cli.flags import StrictCommand, memory_flag_of_all
from bench.cli.output import Output, progress_bar, table, tell_first_run
from lod.errors import InputError
from scenes.files import make_folder, write_text


@click.group("observe")
def command() -> None:
    """Ask people at which τ they see what pruning leaves out (docs/observers.md)."""


def plan_of(folder: str) -> dict[str, Any]:
    """Read the plan of an experiment's folder. Raises InputError for what is none."""
    from bench.observers.make import PLAN, plan_body
    from bench.records.records import content_sha256

    path, cure = Path(folder) / PLAN, f"make one with `lodbench observe make {folder}`"
    try:
        plan: dict[str, Any] = json.loads(path.read_text("utf-8"))
        whole = plan["sha256"] == content_sha256(plan_body(plan))
    except (OSError, ValueError, TypeError, KeyError, AttributeError):
        raise InputError("DIR", folder, "the folder of an experiment", cure) from None
    if not whole:
        raise InputError("DIR", str(path), "a plan that was not edited", cure)
    return plan


_OUT = click.option("-o", "folder", required=True, metavar="DIR", help="Folder to write to.")
_MANY = click.IntRange(0, 9999)


@command.command("make", cls=StrictCommand)
@click.argument("folder", metavar="DIR")
@click.option("--size", metavar="WxH", help="Picture size; 576x324, or 320x180 with --small.")
@click.option("--spp", type=click.IntRange(1, 2**16), default=256, show_default=True, metavar="N")
@click.option("--frames", type=click.IntRange(2, 240), default=24, show_default=True, metavar="N")
@click.option("--small", is_flag=True, help="The six conditions that try the program, not all 36.")
@click.option("--cluster", metavar="N|ADDRESS|FILE", help="Workers here, or a Dask scheduler.")
@memory_flag_of_all
def make_command(
    folder: str, small: bool, cluster: str | None, out: Output, **pictures: Any
) -> None:
    """Render the pairs, and write the page DIR/index.html, which works offline.

    The same command again goes on where it was stopped; finished pictures are kept.
    """
    from bench.observers.make import PAGE, Pictures, make
    from bench.observers.plan import CONDITIONS, SMALL_SET
    from bench.observers.simulate import ObserverModel, power
    from bench.runs import dask_executor
    from scenes.render.pictures import needed_ffmpeg

    conditions = SMALL_SET if small else CONDITIONS
    pictures["size"] = pictures["size"] or ("320x180" if small else "576x324")
    how = Pictures(**pictures)
    how.preset(conditions[0], 1.0)  # which refuses a size that cannot be
    needed_ffmpeg()
    place, need = make_folder(folder, "DIR").resolve(), power(len(conditions), ObserverModel())
    with dask_executor(cluster, out.note) as spread:
        tell_first_run()
        foreseen = how.estimated_seconds(conditions)
        out.note(f"lodbench: about {foreseen / 7200:.1f} h on two cores to render all")
        with progress_bar("condition") as progress:
            plan = make(place, conditions, how, spread, progress, need)
        page = str(Path(folder) / PAGE)
        spent = sum(plan["seconds"].values())
        seconds = {"seconds_estimated": foreseen, "seconds_spent": spent}
        out.record({"page": page, "plan": plan["sha256"], "power": need, **seconds})
        heads = ("trials", "deviation of log10 τ75", "observers a condition", "observers in all")
        out.say(f"{page}: {len(conditions)} conditions, ready; {spent / 3600:.2f} h of one core")
        out.say("For τ75 of a condition within ±15 %, if observers are as the model assumes:")
        out.say(table([heads, *(tuple(row.values()) for row in need)]))


@command.command("fit", cls=StrictCommand)
@click.argument("files", metavar="FILES...", nargs=-1, required=True)
@click.option("--of", required=True, metavar="DIR", help="Folder of the experiment.")
@_OUT
def fit_command(files: tuple[str, ...], of: str, folder: str, out: Output) -> None:
    """Fit the answers in result files: τ75 by observer and by condition, and write a record."""
    from bench.experiments.observers import answers_record
    from bench.observers.results import read_results
    from bench.records.records import write_record

    plan, place = plan_of(of), make_folder(folder)
    sessions, refused = read_results([Path(each) for each in files], plan)
    why = {each.observer: each.excluded(plan) for each in sessions}
    used = [each for each in sessions if not why[each.observer]]
    excluded = {str(observer): reason for observer, reason in why.items() if reason}
    for line in refused:
        out.note(f"lodbench: {line}")
    for observer, reason in excluded.items():
        out.note(f"lodbench: observer {observer} is excluded: {reason}")
    notes = {
        "excluded": dict(Counter(excluded.values())),
        "files_refused": len(refused),
        "simulated": sum(each.session.startswith("simulated") for each in used),
    }
    record = answers_record(used, plan, notes)
    path = write_record(record, place)
    claims = [each.as_json() for each in record.claims]
    told = {"excluded": excluded, "refused": refused, "claims": claims}
    out.record({"record": str(path), "observers": len(used), **told})
    rows = [("verdict", "pictures", "τ75 [px]", "observers")]
    rows += [(c.verdict_text, c.where, c.measured_text, str(c.replicates)) for c in record.claims]
    out.say(f"{path}: {len(used)} of {len(sessions)} observers\n{table(rows)}")


@command.command("simulate", cls=StrictCommand)
@click.argument("experiment", metavar="DIR")
@click.option("--observers", type=_MANY, default=36, show_default=True, metavar="N")
@click.option("--guessers", type=_MANY, default=0, metavar="N", help="So many more only guess.")
@click.option("--seed", type=click.IntRange(0, 2**32 - 1), default=0, help="0 by default.")
@_OUT
def simulate_command(
    experiment: str, observers: int, guessers: int, seed: int, folder: str, out: Output
) -> None:
    """Send observers of a stated model through the protocol, and write files as the page does."""
    from bench.observers.psychometric import GUESS
    from bench.observers.results import result_text
    from bench.observers.simulate import ObserverModel, simulated_sessions

    plan, place, model = plan_of(experiment), make_folder(folder), ObserverModel()
    lapse = [math.nan] * observers + [GUESS] * guessers
    paths = []
    for content in simulated_sessions(plan, lapse, model, seed):
        paths.append(place / f"observer-{content['observer']:04d}-{content['session']}.json")
        write_text(paths[-1], result_text(content))
    out.record({"files": [str(each) for each in paths], "model": asdict(model)})
    out.say(f"{folder}: {len(paths)} files of simulated observers; nobody has looked")
