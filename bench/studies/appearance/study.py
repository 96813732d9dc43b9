"""Do leaf appearances cover and shine as what they hide does, of kinds that nothing was fitted to?

Trees stand alone on level ground. Of each, displayed down to level 2 and to every finer level that
hides something, the cover is compared with that of the whole tree from 64 directions, and its
radiance, path traced, from 16 azimuths at two elevations under three suns. What is within the
limits is said line by line, and nothing here changes what is fitted.
"""

from collections.abc import Iterator

import click

from bench.cli.output import table
from bench.studies.appearance.cuts import Case, cases, lone_tree
from bench.studies.appearance.light import radiance_ratios
from bench.studies.appearance.silhouette import cover_ratios

COARSEST = 2
"""The coarsest level that is judged; those above it are shown by ``--all-levels``."""

MEAN_COVER, EACH_COVER, RADIANCE = 0.05, 0.15, 0.03
"""How far the mean cover, that from each direction, and the radiance may be from the whole's."""

HEADER = (
    "tree",
    "level",
    "mean cover",
    "worst direction",
    "radiance, from … to",
    "within",
)


def rows(case: Case, coarsest: int, light: bool) -> Iterator[tuple[object, ...]]:
    """Measure the lines of the table for one tree."""
    tree = lone_tree(case)
    for level in range(min(coarsest, tree.finest - 1), tree.finest):
        covers = cover_ratios(tree, level)
        worst = covers[abs(covers - 1).argmax()]
        held = abs(covers.mean() - 1) <= MEAN_COVER and abs(worst - 1) <= EACH_COVER
        shines = ""
        if light:
            ratios = radiance_ratios(tree, level)
            held = held and bool((abs(ratios - 1) <= RADIANCE).all())
            shines = f"{ratios.min():.3f} … {ratios.max():.3f}"
        where = f"{case.kind}, seed {case.seed}", level
        yield (*where, f"{covers.mean():.3f}", f"{worst:.3f}", shines, "yes" if held else "no")


@click.command()
@click.argument("kinds", nargs=-1)
@click.option("--all-levels", is_flag=True, help="Coarser levels, too.")
@click.option("--cover-only", is_flag=True, help="No light: seconds, and without a renderer.")
def command(kinds: tuple[str, ...], all_levels: bool, cover_only: bool) -> None:
    """Judge the trees of these KINDS, by default all."""
    chosen = [each for each in cases() if not kinds or each.kind in kinds]
    found: list[tuple[object, ...]] = [HEADER]
    with click.progressbar(chosen, label="trees") as arriving:
        for case in arriving:
            found += rows(case, 0 if all_levels else COARSEST, not cover_only)
    click.echo(table(found))
