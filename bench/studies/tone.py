"""Luminance and coverage of the land at twelve pixels of detail, from hundreds of fields.

``lodbench run cover`` looks at as many fields as ``run all`` has time for, and at twelve pixels
they differ by more than the claim of 2 %. Here are others, that nobody looked at while anything was
built, in clear air or in the preset's own, with the far cover alone: each whole and pruned, band by
band, from the experiment's own code. Every field is in DIR/fields.csv as soon as it is measured, so
a run that was stopped goes on. A row names the sources that made it, and rows of other sources are
refused: they are never judged together. Nothing is timed: processes share the cores.
"""

import csv
import multiprocessing
import os
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor, as_completed
from pathlib import Path

import click

from bench.cli.output import progress_bar, table
from bench.experiments.cover.claims import judge
from bench.experiments.cover.measure import field
from bench.experiments.cover.scene import AIRS, LOOKS, Case
from bench.records.claims import Claim
from bench.records.records import Column, Point, merge_points
from bench.runs import sources
from bench.seeds import first_seed
from lod.errors import InputError
from scenes.files import make_folder, whole_file

DETAIL, FIRST_SEED = 12.0, first_seed(True, 3)
FIELDS = {"aerial": 200, "forest": 500}
"""Number of fields of each look: intervals of 0.3 to 1 % each way, other fields than those of
``lodbench run cover``."""

KEYS = ("look", "air", "seed", "sources")
COLUMNS = (*KEYS, "quantity", "picture", "band", "value")

_OF_BAND = 7
"""Sums of a band: light, land and rays of both pictures, and light along the same rays."""

Key = tuple[str, str, int]
Bands = tuple[Column, ...]


def measure_field(look: str, air: str, seed: int) -> Bands:
    """Measure one field, pruned and whole."""
    case = Case(look, air, DETAIL, cover=True)
    return field(look, seed, (case,))[case]


def read_fields(path: Path) -> dict[Key, Bands]:
    """Read the fields that a file holds in full; none where there is no file.

    Raises InputError for a file that ``write_fields`` did not write, and for rows that other
    sources made.
    """
    found: dict[Key, list[Column]] = {}
    if not path.exists():
        return {}
    try:
        with path.open(newline="", encoding="utf-8") as file:
            rows = csv.DictReader(file)
            if tuple(rows.fieldnames or ()) != COLUMNS:
                raise KeyError(rows.fieldnames)
            for row in rows:
                if row["sources"] != sources():
                    raise KeyError(row["sources"])
                keys: dict[str, str | int | float | bool]
                keys = {"picture": row["picture"], "band": int(row["band"])}
                column = Column(row["quantity"], [int(row["value"])], keys)
                found.setdefault((row["look"], row["air"], int(row["seed"])), []).append(column)
    except (OSError, ValueError, KeyError, TypeError, csv.Error):
        rule = (
            f"a table with the columns {', '.join(COLUMNS)}, written by the sources that are here"
        )
        raise InputError("FOLDER", str(path), rule, "choose another folder") from None
    return {k: tuple(v) for k, v in found.items() if len(v) == _OF_BAND * band_count(k[0])}


def band_count(look: str) -> int:
    """Return the number of bands of distance that a look has."""
    return len(LOOKS[look].edges_m) - 1


def write_fields(path: Path, fields: dict[Key, Bands]) -> None:
    """Write all fields in their order, in place of what the file held."""
    with whole_file(path, overwrite=True) as beside, beside.open("w", newline="") as file:
        rows = csv.writer(file)
        rows.writerow(COLUMNS)
        for key, bands in sorted(fields.items()):
            for each in bands:
                place = each.quantity, each.keys["picture"], each.keys["band"]
                rows.writerow((*key, sources(), *place, each.values[0]))


def judge_fields(fields: dict[Key, Bands]) -> tuple[Claim, ...]:
    """Judge every band of every look and air from all fields, as ``cover`` does."""
    points = (
        Point({"look": look, "air": air, "detail": DETAIL, "cover": True}, samples=bands)
        for (look, air, _), bands in sorted(fields.items())
    )
    return judge(merge_points(points))


def _measure_fields(missing: list[Key], processes: int) -> Iterator[tuple[Key, Bands]]:
    """Measure fields in processes of one thread each, and yield them as they finish."""
    spawned = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(processes, spawned, initializer=_use_one_thread) as pool:
        tasks = {pool.submit(measure_field, *key): key for key in missing}
        for task in as_completed(tasks):
            yield tasks[task], task.result()


def _use_one_thread() -> None:
    """Let everything in this process use one thread."""
    import drjit
    import numba

    from scenes.render.variants import choose, use

    use(choose())
    drjit.set_thread_count(1)
    numba.set_num_threads(1)


@click.command()
@click.argument("folder", type=click.Path(file_okay=False, path_type=Path))
@click.option("--fields", type=click.IntRange(2), help="Of each look.  [default: 200 and 500]")
@click.option("--air", type=click.Choice(AIRS), default="clear", show_default=True)
@click.option(
    "--processes",
    type=click.IntRange(1),
    default=os.cpu_count(),
    show_default="one for each core",
)
def command(folder: Path, fields: int | None, air: str, processes: int) -> None:
    """Measure what FOLDER does not hold yet, and judge all that it holds."""
    path = make_folder(folder, "FOLDER") / "fields.csv"
    found = read_fields(path)
    shares = {look: fields or count for look, count in FIELDS.items()}
    wanted = [(look, air, FIRST_SEED + k) for look, count in shares.items() for k in range(count)]
    # Both looks grow together, so that a run that is stopped has some of each.
    wanted.sort(key=lambda key: (key[2] - FIRST_SEED) / shares[key[0]])
    missing = [key for key in wanted if key not in found]
    with progress_bar("field") as show:
        show(0, len(missing), "fields")
        for done, (key, bands) in enumerate(_measure_fields(missing, processes), 1):
            found[key] = bands
            write_fields(path, found)
            show(done, len(missing), "fields")
    rows: list[tuple[object, ...]] = [("band", "pruned ÷ whole", "within 2 %")]
    for each in judge_fields(found):
        interval = f"{each.measured:.3f} ({each.low:.3f} to {each.high:.3f})"
        rows.append((each.name, interval, each.verdict))
    click.echo(table(rows))
