"""One view whole, pruned, and by level of detail, side by side: what pruning does, in a picture.

The world is finite, because nothing else can be rendered whole, and the detail is coarse, so that
one sees what is left out.
"""

from pathlib import Path

import click
import numpy as np
from PIL import Image, ImageDraw, ImageFont

from bench.frame_counts import count
from scenes.files import check_ours, make_folder
from scenes.frame.layers import Layers
from scenes.presets.load import Setting, load_preset
from scenes.presets.schema import Preset
from scenes.render.exr.header import frame_settings
from scenes.render.frame_session import FrameSession, ignore_progress
from scenes.render.pictures import (
    DEFAULT_STYLE,
    PictureStyle,
    preview_pixels,
    save_picture,
    to_srgb_8bit,
)
from scenes.render.variants import choose
from scenes.scene import Scene

_GAP, _PAPER, _INK = 6, (255, 255, 255), (40, 40, 44)


def shown_parts(preset: Preset) -> int:
    """Count the parts of all species that the first frame displays."""
    scene = Scene(preset)
    return count(scene.world, scene.view(1)).parts.displayed


def layers_of(preset: Preset) -> Layers:
    """Render the first frame of a preset."""
    variant = choose(preset.render.variant, preset.render.spectral)
    return FrameSession(frame_settings(preset, variant)).render_layers(1, ignore_progress)


def side_by_side(panels: list[tuple[str, np.ndarray]]) -> Image.Image:
    """Lay pictures (h, w, 3) of one size in a row, each over its caption."""
    height, width, _ = panels[0][1].shape
    letters = max(11, width // 24)
    font = ImageFont.load_default(letters)
    size = (len(panels) * (width + _GAP) - _GAP, height + 2 * letters)
    sheet = Image.new("RGB", size, _PAPER)
    draw = ImageDraw.Draw(sheet)
    for number, (caption, pixels) in enumerate(panels):
        left = number * (width + _GAP)
        sheet.paste(Image.fromarray(pixels), (left, 0))
        draw.text((left + 2, height + letters // 3), caption, _INK, font)
    return sheet


@click.command()
@click.option("-o", "path", default="results/gallery/pruning.png", show_default=True)
@click.option("--preset", default="meadow", show_default=True)
@click.option("--extent", default=260.0, show_default=True, help="Side of the world [m].")
@click.option("--detail", default=10.0, show_default=True, help="τ of what is pruned [px].")
@click.option("--size", default="400x225", metavar="WxH", show_default=True)
@click.option("--spp", default=16, show_default=True)
@click.option("--overwrite", is_flag=True, help="Replace a file that lodbench did not make.")
def command(
    path: str, preset: str, extent: float, detail: float, size: str, spp: int, overwrite: bool
) -> None:
    """Render the picture, and say how many parts each half of it displays."""
    target = make_folder(Path(path).parent) / Path(path).name
    check_ours([target], overwrite)
    grass = [name for name, each in load_preset(preset).species.items() if each.model == "sward"]
    wanted = {
        **{f"species.{name}.density": 0.0 for name in grass},  # unpruned, it would be millions
        "world.extent": extent,
        "view.detail": detail,
        "render.size": size,
        "render.spp": spp,
        "output.denoise": True,
    }
    pruned, whole = (
        load_preset(preset, [Setting(key, key, value) for key, value in changes.items()])
        for changes in (wanted, wanted | {"view.metric": "full"})
    )
    captions = [
        f"whole: {shown_parts(whole):,} parts",
        f"pruned at {detail:g} pixels: {shown_parts(pruned):,} parts",
        "by level: dark is coarse, light is fine",
    ]
    with_all, left = layers_of(whole), layers_of(pruned)
    exposure = DEFAULT_STYLE.exposure_of(with_all.rgb)
    light = [
        to_srgb_8bit(each.rgb if each.denoised is None else each.denoised, exposure)
        for each in (with_all, left)
    ]
    pixels = [*light, preview_pixels(left, PictureStyle(view="level"), 1.0)]
    save_picture(side_by_side(list(zip(captions, pixels, strict=True))), target, optimize=True)
    click.echo(f"{target}: {captions[0]}, {captions[1]}")


if __name__ == "__main__":
    command()
