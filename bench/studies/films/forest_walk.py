"""What pops from frame to frame in a walk through a forest, unpruned, fading and clipped?

The walk is measured unpruned, fading and clipped, in a wood small enough to be held whole, and so
coarsely that branches which come and go are several pixels large. DIR keeps what is measured, pair
by pair; the same command goes on where it was stopped. Then it prints, and writes a sheet of
stills, how many parts popped and the quantiles of what motion does not explain
(``unexplained_change``), as ``lodbench run popping`` measures it: both frames of a pair have the
same samples, so that there is no noise in it.
"""

import zipfile
from functools import lru_cache
from itertools import product
from operator import itemgetter
from pathlib import Path

import click
import numpy as np
from PIL import Image

from bench.cli.output import counted, table
from bench.experiments.popping.claims import WAYS
from bench.experiments.popping.unexplained_change import Walk, walk
from lod.errors import InputError
from scenes.files import check_ours, make_folder, whole_file
from scenes.presets.load import load_preset
from scenes.presets.schema import Preset
from scenes.render.pictures import save_picture
from scenes.render.variants import choose
from scenes.world.world import World, build_world

WOOD = (
    "species.sward.density=0",
    "world.extent=60.0",
    "terrain.reach=300.0",
    "view.haze_aware=false",
)
QUANTILES = (0.99, 0.999, 0.9999)
_STILLS = 5


def walk_settings(way: str, size: str, spp: int, detail: float) -> tuple[str, ...]:
    """Give the settings that are laid over the preset ``forest`` for one way of pruning."""
    picture = f"render.size={size}", f"render.spp={spp}", f"view.detail={detail}"
    return (*WOOD, *picture, *WAYS[way])


def measure_pair(folder: Path, way: str, first: int, settings: tuple[str, ...]) -> None:
    """Measure a frame and the next, unless that is done."""
    path = folder / f"{way}.{first:04d}.npz"
    if path.exists():
        return
    preset, world = _forest(settings)
    found = walk(world, (preset,), (first, first + 1), choose())
    with whole_file(path, where="DIR") as temporary, temporary.open("wb") as stream:
        np.savez(stream, **{name: getattr(found, name) for name in Walk.__dataclass_fields__})


@lru_cache(maxsize=len(WAYS))
def _forest(settings: tuple[str, ...]) -> tuple[Preset, World]:
    preset = load_preset("forest", settings)
    return preset, build_world(preset)


def load_walk(folder: Path, way: str) -> Walk:
    """Read all pairs of frames of a way that a folder holds."""
    names, pieces = Walk.__dataclass_fields__, []
    for path in sorted(folder.glob(f"{way}.*.npz")):
        try:
            pieces.append(dict(np.load(path)))
        except (OSError, ValueError, TypeError, zipfile.BadZipFile):
            pieces.append({})
        if names.keys() - pieces[-1].keys():
            rule = "a pair of frames, as this study keeps them"
            raise InputError("DIR", str(path), rule, "choose another folder, or remove it")
    return Walk(**{name: np.concatenate([each[name] for each in pieces]) for name in names})


def table_rows(walks: dict[str, Walk]) -> list[tuple[object, ...]]:
    """Make a table row for each way, after the heads."""
    shares = [f"{q:.2%}" for q in QUANTILES]
    rows: list[tuple[object, ...]] = [("way", "pairs", "popped", *shares, "÷ clipped")]
    clipped = np.quantile(walks["clipped"].switched, QUANTILES[-1])
    for way, found in walks.items():
        changes = np.quantile(found.switched, QUANTILES)
        counts = f"{found.popped.min()} to {found.popped.max()}"
        cells = [f"{v:.4f}" for v in (*changes, changes[-1] / clipped)]
        rows.append((way, len(found.popped), counts, *cells))
    return rows


def stills(walks: dict[str, Walk]) -> Image.Image:
    """Lay out stills of every way, and under each what switched since the frame before."""
    rows = []
    for found in walks.values():
        chosen = np.linspace(0, len(found.picture) - 1, _STILLS).astype(int)
        rows += [np.hstack(found.picture[chosen]), np.hstack(found.switched[chosen])]
    grey = np.clip(np.vstack(rows), 0.0, 1.0) ** (1 / 2.2)
    return Image.fromarray(np.rint(255 * grey).astype(np.uint8))


@click.command()
@click.argument("folder", type=click.Path(path_type=Path), metavar="DIR")
@click.option("--frames", default=120, show_default=True)
@click.option("--every", default=1, help="Only each so many-th pair of frames.", show_default=True)
@click.option("--size", default="160x90", metavar="WxH", show_default=True)
@click.option("--spp", default=36, show_default=True)
@click.option("--detail", default=6.0, help="τ in pixels.", show_default=True)
@click.option("--overwrite", is_flag=True, help="Replace a sheet.png that lodbench did not make.")
def command(
    folder: Path, frames: int, every: int, size: str, spp: int, detail: float, overwrite: bool
) -> None:
    """Measure a walk through a forest into DIR, three ways, and print what pops."""
    make_folder(folder)
    check_ours([folder / "sheet.png"], overwrite, "DIR")
    for first, way in counted([*product(range(1, frames, every), WAYS)], "pair", itemgetter(1)):
        measure_pair(folder, way, first, walk_settings(way, size, spp, detail))
    walks = {way: load_walk(folder, way) for way in WAYS}
    click.echo(table(table_rows(walks)))
    save_picture(stills(walks), folder / "sheet.png")
