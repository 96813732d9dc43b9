"""A picture of every preset, and the same frame by detail level, as a gallery page.

Frames are rendered into a scratch folder; what stays are two PNGs for each preset and a page.
"""

import subprocess
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path

import click
from PIL import Image

from scenes.preset.load import preset_names
from scenes.render.files.frame_paths import make_folder
from scenes.render.files.whole_file import check_ours, whole_file

FRAMES = {"campfire": 30, "fly_in": 40, "playground": 48}
"""The frame of a preset that shows most; presets that are not named show frame 1."""


def render_preset(name: str, size: str, spp: int, folder: Path) -> Path:
    """Render one frame of a preset as EXR, and give its path."""
    frame = FRAMES.get(name, 1)
    flags = f"--frames {frame} --size {size} --spp {spp} --denoise --overwrite".split()
    target = folder / name / f"{name}.####.exr"
    subprocess.run(
        [sys.executable, "-m", "bench.cli.main", "render", name, "-o", str(target), *flags],
        check=True,
    )
    return target.with_name(f"{name}.{frame:04d}.exr")


def save_pictures(frame: Path, name: str, folder: Path) -> None:
    """Write both pictures of a frame: its light, denoised, and its detail levels."""
    from scenes.render.files.exr import read_exr
    from scenes.render.pictures.contact_sheet import preview, save_picture
    from scenes.render.pictures.tone_map import DEFAULT_STYLE, PictureStyle, to_srgb_8bit

    layers = read_exr(frame)[0]
    light = layers.rgb if layers.denoised is None else layers.denoised
    picture = Image.fromarray(
        to_srgb_8bit(light, DEFAULT_STYLE.exposure_of(light), DEFAULT_STYLE.tone)
    )
    save_picture(picture, folder / f"{name}.png", optimize=True)
    preview(frame, folder / f"{name}_level.png", PictureStyle(view="level"))


def gallery_page(presets: Sequence[tuple[str, str]]) -> str:
    """Write the gallery as Markdown, from the names of presets and what they show."""
    head = (
        "# What there is to see\n\nEvery preset, and beside it the same frame by detail level"
        " (`--view level`): dark is coarse, light is fine. Made by"
        " `lodbench study gallery`, 16"
        " samples a pixel, denoised. [Clips](motion.md) of what motion hides lie beside.\n"
    )
    rows = [
        f"\n## {name}\n\n{about}\n\n![{name}]({name}.png) ![{name} by level]({name}_level.png)\n"
        for name, about in presets
    ]
    return head + "".join(rows)


@click.command()
@click.argument("names", nargs=-1)
@click.option("-o", "folder", default="results/gallery", metavar="DIR", show_default=True)
@click.option("--size", default="640x360", metavar="WxH", show_default=True)
@click.option("--spp", default=16, show_default=True)
@click.option("--overwrite", is_flag=True, help="Replace files that lodbench did not make.")
def command(names: tuple[str, ...], folder: str, size: str, spp: int, overwrite: bool) -> None:
    """Render the presets of these NAMES, or all, and write the page of all that have pictures."""
    target = make_folder(folder)
    wanted = [name for name, _ in preset_names() if name in names or not names]
    pictures = [f"{name}{kind}.png" for name in wanted for kind in ("", "_level")]
    check_ours([target / each for each in (*pictures, "README.md")], overwrite)
    with tempfile.TemporaryDirectory() as scratch:
        for name in wanted:
            save_pictures(render_preset(name, size, spp, Path(scratch)), name, target)
    done = [each for each in preset_names() if (target / f"{each[0]}_level.png").exists()]
    with whole_file(target / "README.md", overwrite=True) as page:
        page.write_text(gallery_page(done), "utf-8")
