"""`lodbench run`: measure, write the record, say what held."""

from typing import TYPE_CHECKING, Any

import click

from bench.frame_flags import make_folder
from bench.output import Output, output, table
from bench.progress import progress_bar
from bench.spread import spread_over
from lod.errors import InputError
from scenes.preset_errors import nearest_name
from scenes.preset_tables import LARGEST_SEED

if TYPE_CHECKING:
    from bench.claims import Claim


@click.command("run")
@click.argument("experiments", metavar="EXPERIMENT...", nargs=-1)
@click.option("--quick", is_flag=True, help="Fewer points and fields: minutes instead of hours.")
@click.option("--seed", type=click.IntRange(0, LARGEST_SEED), default=0, help="0 by default.")
@click.option("-o", "folder", required=True, metavar="DIR", help="Folder for the records.")
@click.option(
    "--cluster", metavar="N|ADDRESS|FILE", help="Workers to start here, or a Dask scheduler."
)
@click.option("--json", "as_json", is_flag=True, help="One JSON object per experiment on stdout.")
def command(
    experiments: tuple[str, ...],
    quick: bool,
    seed: int,
    folder: str,
    cluster: str | None,
    as_json: bool,
) -> None:
    """Run experiments; each writes one record (JSON) and says which claims held."""
    from bench.experiments import EXPERIMENTS
    from bench.records import write_record

    if not experiments:
        raise InputError(
            "EXPERIMENT", experiments, "at least one", f"try {next(iter(EXPERIMENTS))}"
        )
    for name in experiments:
        if name not in EXPERIMENTS:
            cure = nearest_name(name, EXPERIMENTS)
            raise InputError("EXPERIMENT", name, "no experiment of that name", cure)
        if cluster is not None and EXPERIMENTS[name].run_spread is None:
            able = ", ".join(n for n, each in EXPERIMENTS.items() if each.run_spread)
            raise InputError("--cluster", name, f"experiments that only count: {able}", "leave it")
    place = make_folder(folder)
    with output(as_json) as out, spread_over(cluster, out.note) as each:
        for name in dict.fromkeys(experiments):
            with progress_bar("point") as progress:
                chosen = EXPERIMENTS[name]
                spread = chosen.run_spread if cluster is not None else None
                record = (
                    spread(quick, progress, seed, each)
                    if spread
                    else chosen.run(quick, progress, seed)
                )
            path = write_record(record, place)
            claims = [each.as_json() for each in record.claims]
            out.record({"experiment": name, "record": str(path), "claims": claims})
            _say(out, name, str(path), record.claims)


def _say(out: Output, name: str, path: str, claims: tuple["Claim", ...]) -> None:
    rows: list[tuple[Any, ...]] = [
        ("", "claim", "measured", "95 % interval", "predicted", "source")
    ]
    for each in claims:
        interval = f"{each.low:.4g} to {each.high:.4g}"
        predicted = (
            f"{'≤ ' if each.relation == 'at most' else ''}{each.predicted:g} ± {each.tolerance:g}"
        )
        rows.append((each.verdict, each.name, each.measured, interval, predicted, each.source))
    out.say(f"{name}: {path}\n{table(rows)}")
