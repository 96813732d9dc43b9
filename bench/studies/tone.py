"""Luminance of the land at twelve pixels of detail, from hundreds of fields.

``lodbench run cover`` looks at as many fields as ``run all`` has time for, and at twelve pixels
they differ by more than the claim of 2 %. Here are others, in the preset's own air and with the far
cover alone: each whole and pruned, band by band, from the experiment's own code. Every field is in
DIR/fields.csv as soon as it is measured, so a run that was stopped goes on, and more fields are
added to what is there. With ``--again`` the pruned pictures are measured anew, beside the whole
ones that DIR holds: pruning changes whole pictures only through what is out of view, whose light is
less than 0.1 % of a band. Nothing is timed: processes share the cores.
"""

import csv
import multiprocessing
import os
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor, as_completed
from pathlib import Path

import click
import numpy as np

from bench.cli.output import table
from bench.experiments.cover.claims import TOLERANCE
from bench.experiments.cover.measure import Bands as Columns
from bench.experiments.cover.measure import field, pruned_alone
from bench.experiments.cover.scene import LOOKS, Case
from bench.records.claims import Claim, claim
from bench.statistics.estimates import two_sided_ratio_of_means
from lod.errors import InputError
from scenes.render.files.frame_paths import make_folder
from scenes.render.files.whole_file import whole_file

DETAIL, FIRST_SEED = 12.0, 1000
FIELDS = {"aerial": 200, "forest": 500}
"""Number of fields of each look: intervals of 0.3 to 1 % each way, other fields than those of
``lodbench run cover``."""

TESTED = ("tested", "tested rays")
SUMS = (*TESTED, "whole", "whole rays")
"""The columns of a band in the file: light and rays, pruned and whole."""

COLUMNS = ("look", "seed", "band", *SUMS)

Key = tuple[str, int]
Bands = list[list[int]]
"""The columns SUMS of every band of a field, (bands, 4)."""


def measure_field(look: str, seed: int, whole: Bands | None) -> Bands:
    """Measure one field, pruned and whole, or pruned alone where ``whole`` is known."""
    case = Case(look, "preset", DETAIL, cover=True)
    if whole is None:
        found = _sums(field(look, seed, (case,))[case])
    else:
        known = dict(zip(SUMS, map(list, zip(*whole, strict=True)), strict=True))
        alone = _sums(pruned_alone(look, seed, case))
        found = {**known, **{name: alone[name] for name in TESTED}}
    return [list(row) for row in zip(*(found[name] for name in SUMS), strict=True)]


def _sums(bands: Columns) -> dict[str, list[int]]:
    """Return what a field's columns hold under the names of SUMS, band by band."""
    found: dict[str, list[int]] = {}
    pairs = [(q, p) for p in ("pruned", "whole") for q in ("light", "rays")]
    names = dict(zip(pairs, SUMS, strict=True))
    for each in bands:
        name = names.get((each.quantity, str(each.keys["picture"])))
        if name is not None:
            found.setdefault(name, []).extend(each.values)
    return found


def read_fields(path: Path) -> dict[Key, Bands]:
    """Read the fields that a file holds in full; none where there is no file.

    Raises InputError for a file that ``write_fields`` did not write.
    """
    found: dict[Key, Bands] = {}
    if path.exists():
        try:
            with path.open(newline="", encoding="utf-8") as file:
                rows = csv.DictReader(file)
                if tuple(rows.fieldnames or ()) != COLUMNS:
                    raise KeyError(rows.fieldnames)
                for row in rows:
                    bands = found.setdefault((row["look"], int(row["seed"])), [])
                    bands.append([int(row[name]) for name in SUMS])
            return {key: bands for key, bands in found.items() if len(bands) == band_count(key[0])}
        except (OSError, ValueError, KeyError, TypeError, csv.Error):
            rule = f"a table with the columns {', '.join(COLUMNS)}, as this study writes it"
            cure = "choose another folder, or move the file"
            raise InputError("FOLDER", str(path), rule, cure) from None
    return {}


def band_count(look: str) -> int:
    """Number of bands of distance that a look has."""
    return len(LOOKS[look].edges_m) - 1


def write_fields(path: Path, fields: dict[Key, Bands]) -> None:
    """Write all fields in their order, in place of what the file held."""
    with whole_file(path, overwrite=True) as beside, beside.open("w", newline="") as file:
        rows = csv.writer(file)
        rows.writerow(COLUMNS)
        for (look, seed), bands in sorted(fields.items()):
            rows.writerows([look, seed, k, *sums] for k, sums in enumerate(bands))


def judge_bands(fields: dict[Key, Bands], look: str) -> list[Claim]:
    """Judge the claim of every band of a look from all its fields."""
    sums = np.array([bands for key, bands in sorted(fields.items()) if key[0] == look], np.float64)
    edges = LOOKS[look].edges_m
    words = "The land keeps its tone.", "mean luminance ÷ that of everything", "§2.4"
    return [
        claim(
            f"{look}, {edges[k]:g} to {edges[k + 1]:g} m",
            words,
            1.0,
            TOLERANCE,
            two_sided_ratio_of_means(*sums[:, k].T),
        )
        for k in range(band_count(look))
    ]


def _measure_fields(
    missing: list[Key], wholes: dict[Key, Bands], processes: int
) -> Iterator[tuple[Key, Bands]]:
    """Measure the missing fields in processes of one thread each, and yield them as they finish.

    Whole pictures that ``wholes`` holds are not rendered again.
    """
    spawned = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(processes, spawned, initializer=_use_one_thread) as pool:
        tasks = {pool.submit(measure_field, *key, wholes.get(key)): key for key in missing}
        for task in as_completed(tasks):
            yield tasks[task], task.result()


def _use_one_thread() -> None:
    """Let everything in this process use one thread."""
    import drjit
    import numba

    from scenes.render.mitsuba.variants import choose, use

    use(choose())
    drjit.set_thread_count(1)
    numba.set_num_threads(1)


@click.command()
@click.argument("folder", type=click.Path(file_okay=False, path_type=Path))
@click.option("--fields", type=click.IntRange(2), help="Of each look.  [default: 200 and 500]")
@click.option(
    "--processes",
    type=click.IntRange(1),
    default=os.cpu_count(),
    show_default="one for each core",
)
@click.option("--again", is_flag=True, help="Pruned pictures anew, of all that FOLDER holds.")
def command(folder: Path, fields: int | None, processes: int, again: bool) -> None:
    """Measure what FOLDER does not hold yet, and judge all that it holds."""
    path = make_folder(folder, "FOLDER") / "fields.csv"
    wholes = read_fields(path) if again else {}
    # What is measured anew takes the place of the old when all of it is there.
    target = folder / "again.csv" if again else path
    found = read_fields(target)
    shares = {look: fields or FIELDS[look] for look in LOOKS}
    wanted = [(look, FIRST_SEED + k) for look, count in shares.items() for k in range(count)]
    # Both looks grow together, so that a run that is stopped has some of each.
    wanted.sort(key=lambda key: (key[1] - FIRST_SEED) / shares[key[0]])
    missing = [key for key in sorted(wholes) or wanted if key not in found]
    with click.progressbar(
        _measure_fields(missing, wholes, processes), len(missing), "fields"
    ) as arriving:
        for key, bands in arriving:
            found[key] = bands
            write_fields(target, found)
    target.replace(path)
    rows: list[tuple[object, ...]] = [("band", "fields", "pruned ÷ whole", "within 2 %")]
    for look in LOOKS:
        count = sum(key[0] == look for key in found)
        for each in judge_bands(found, look):
            interval = f"{each.measured:.3f} ({each.low:.3f} to {each.high:.3f})"
            rows.append((each.name, count, interval, each.verdict))
    click.echo(table(rows))
