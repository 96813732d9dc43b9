"""PNG pictures of frames: one frame, or a sheet of a sequence with its frame numbers."""

import math
import re
from collections.abc import Sequence
from pathlib import Path

from PIL import Image, ImageDraw, ImageFont
from PIL.PngImagePlugin import PngInfo

from lod.errors import InputError
from scenes.render.files.exr import read_exr
from scenes.render.files.header import software
from scenes.render.files.whole_file import whole_file
from scenes.render.pictures.level_view import preview_pixels
from scenes.render.pictures.tone_map import DEFAULT_STYLE, PictureStyle

_GAP, _PAPER, _INK = 6, (24, 24, 26), (220, 220, 220)


def preview(path: str | Path, out_png: str | Path, look: PictureStyle = DEFAULT_STYLE) -> Path:
    """Write one frame as a PNG, exposed for itself."""
    layers = read_exr(path)[0]
    picture = preview_pixels(layers, look, look.exposure_of(layers.rgb))
    return save_picture(Image.fromarray(picture), out_png)


def contact_sheet(
    paths: Sequence[str | Path],
    out_png: str | Path,
    columns: int | None = None,
    width: int = 320,
    look: PictureStyle = DEFAULT_STYLE,
) -> Path:
    """Write frames side by side, ``width`` pixels each; all are exposed for the first."""
    if not paths:
        raise InputError("contact sheet", [], "at least one frame")
    if width < 16:
        raise InputError("contact sheet width", width, "at least 16 pixels a frame")
    tiles, exposure = [], 0.0
    for path in paths:
        layers = read_exr(path)[0]
        exposure = exposure or look.exposure_of(layers.rgb)
        height = max(1, round(width * layers.rgb.shape[0] / layers.rgb.shape[1]))
        picture = Image.fromarray(preview_pixels(layers, look, exposure))
        tiles.append(picture.resize((width, height), Image.Resampling.LANCZOS))
    labels = [frame_label(path) for path in paths]
    return save_sheet(tiles, labels, columns or default_columns(len(tiles)), out_png)


def save_sheet(
    tiles: Sequence[Image.Image], labels: Sequence[str], columns: int, out_png: str | Path
) -> Path:
    """Write pictures row by row as one PNG, each with its label below."""
    return save_picture(_sheet(tiles, labels, columns), out_png)


def default_columns(count: int) -> int:
    """About as many columns as rows, and few gaps in the last row."""
    widest = math.ceil(math.sqrt(count))
    return min(range(widest, min(count, widest + 2) + 1), key=lambda columns: -count % columns)


def frame_label(path: str | Path) -> str:
    """The frame's number as the file name has it; the whole name where it has none."""
    numbers = re.findall(r"\d+", Path(path).stem)
    return numbers[-1] if numbers else Path(path).stem


def _sheet(tiles: Sequence[Image.Image], labels: Sequence[str], columns: int) -> Image.Image:
    size = max(11, tiles[0].width // 22)
    font = ImageFont.load_default(size)
    across = tiles[0].width + _GAP
    down = max(tile.height for tile in tiles) + size + 2 * _GAP
    rows = math.ceil(len(tiles) / columns)
    sheet = Image.new("RGB", (columns * across + _GAP, rows * down + _GAP), _PAPER)
    draw = ImageDraw.Draw(sheet)
    for number, (tile, label) in enumerate(zip(tiles, labels, strict=True)):
        left = _GAP + number % columns * across
        top = _GAP + number // columns * down
        sheet.paste(tile, (left, top))
        draw.text((left + 1, top + tile.height + 2), label, _INK, font)
    return sheet


def save_picture(picture: Image.Image, path: str | Path, optimize: bool = False) -> Path:
    """Write a PNG that says who made it; in fewer bytes and more time where ``optimize``."""
    about = PngInfo()
    about.add_text("Software", software())
    with whole_file(path, overwrite=True) as temporary:
        picture.save(temporary, "PNG", pnginfo=about, optimize=optimize)
    return Path(path)
