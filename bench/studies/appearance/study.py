"""Do leaf appearances cover and shine as what they hide does, of kinds that nothing was fitted to?

Objects stand alone on level ground. Of each, displayed down to level 2 and to every finer level
that hides something, the cover is compared with that of the whole object from 64 directions, and
its radiance, path traced, from 16 azimuths at two elevations under three suns. What is within the
limits is said line by line, and nothing here changes what is fitted.
"""

from collections.abc import Iterator
from pathlib import Path

import click

from bench.cli.output import counted, table
from bench.studies.appearance.cases import Case, cases
from bench.studies.appearance.cuts import lone_object
from bench.studies.appearance.light import radiance_ratios
from bench.studies.appearance.record import (
    HEADER,
    Judged,
    fit_digest,
    fit_of,
    read_findings,
    with_table,
    write_findings,
)
from bench.studies.appearance.silhouette import cover_ratios
from lod.errors import InputError
from scenes.files import make_folder
from scenes.render.variants import choose

COARSEST = 2
"""The coarsest level that is judged; those above it are shown by ``--all-levels``."""

_DIGITS = 4


def judged(case: Case, coarsest: int, light: bool) -> Iterator[Judged]:
    """Measure the levels of one object."""
    one = lone_object(case)
    for level in range(min(coarsest, one.finest - 1), one.finest):
        covers = cover_ratios(one, level).round(_DIGITS).tolist()
        radiances = radiance_ratios(one, level).round(_DIGITS).tolist() if light else ()
        yield Judged(case.kind, case.seed, level, tuple(covers), tuple(radiances))


@click.command()
@click.argument("kinds", nargs=-1)
@click.option("-o", "folder", type=click.Path(path_type=Path), metavar="DIR", help="Kept there.")
@click.option("--page", type=click.Path(exists=True, dir_okay=False, path_type=Path))
@click.option("--all-levels", is_flag=True, help="Coarser levels, too.")
@click.option("--cover-only", is_flag=True, help="No light: seconds, and without a renderer.")
@click.option("--again", is_flag=True, help="Anew, in place of what DIR holds.")
def command(
    kinds: tuple[str, ...],
    folder: Path | None,
    page: Path | None,
    all_levels: bool,
    cover_only: bool,
    again: bool,
) -> None:
    """Judge objects of these KINDS, by default all that DIR does not hold yet.

    --page FILE: the table of all findings is written between the marks of this Markdown page, too.
    """
    path = folder and make_folder(folder) / "judged.json"
    found = [] if path is None or again else read_findings(path)
    if path is not None and found and fit_of(path) != fit_digest():
        rule, cure = "findings of the fit as its sources are now", "say --again"
        raise InputError("-o", str(path), rule, cure)
    have = {(each.kind, each.seed) for each in found}
    chosen = [each for each in cases() if not kinds or each.kind in kinds]
    missing = [each for each in chosen if (each.kind, each.seed) not in have]
    for case in counted(missing, "object", lambda case: f"{case.kind}, seed {case.seed}"):
        found += judged(case, 0 if all_levels else COARSEST, not cover_only)
        if path is not None:
            write_findings(path, _in_order(found), choose())
    if page is not None:
        text = with_table(page.read_text(encoding="utf-8"), _in_order(found))
        page.write_text(text, encoding="utf-8")
    asked = {(each.kind, each.seed) for each in chosen}
    rows = [each.cells for each in _in_order(found) if (each.kind, each.seed) in asked]
    click.echo(table([HEADER, *rows]))


def _in_order(found: list[Judged]) -> list[Judged]:
    """Put findings in the order of the cases."""
    place = {(each.kind, each.seed): k for k, each in enumerate(cases())}
    return sorted(found, key=lambda each: place.get((each.kind, each.seed), len(place)))
