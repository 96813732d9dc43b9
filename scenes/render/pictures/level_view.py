"""What previews show of a frame: its light, or the detail level of what each pixel meets.

Colours of levels run from dark to light through viridis (Smith & van der Walt 2015), which the
colour-blind read too, and are shaded a little by the normal, for the shape to show. Every level is
that of one sample of the pixel. The legend below names those that are in the picture.
"""

import numpy as np
from PIL import Image, ImageDraw, ImageFont

from scenes.frame.layers import Layers
from scenes.render.pictures.tone_map import PictureStyle, to_srgb_8bit

LEVELS = 13
"""Levels that have a colour of their own; finer ones have that of the last."""

SKY = (214, 218, 222)
"""Where nothing is met."""

_VIRIDIS = np.array(
    ((68, 1, 84), (59, 82, 139), (33, 145, 140), (94, 201, 98), (253, 231, 37)), np.float64
)
_FROM = np.array((-0.4, -0.6, 0.7))
_DARKEST = 0.7
_PAPER, _INK = (24, 24, 26), (220, 220, 220)


def level_colours() -> np.ndarray:
    """8-bit sRGB of each level, coarse to fine, (LEVELS, 3)."""
    at, anchors = np.linspace(0, len(_VIRIDIS) - 1, LEVELS), np.arange(len(_VIRIDIS))
    return np.stack([np.interp(at, anchors, column) for column in _VIRIDIS.T], axis=1)


def preview_pixels(layers: Layers, look: PictureStyle, exposure: float) -> np.ndarray:
    """Make a frame's pixels for a preview in a style, 8-bit sRGB, (h, w, 3)."""
    return (
        level_pixels(layers)
        if look.view == "level"
        else to_srgb_8bit(layers.rgb, exposure, look.tone)
    )


def level_pixels(layers: Layers) -> np.ndarray:
    """Colour a frame by level, with a legend in its lowest rows, 8-bit sRGB, (h, w, 3)."""
    colours = level_colours()[np.minimum(layers.level.astype(np.int64), LEVELS - 1)]
    facing = np.clip(layers.N @ (_FROM / np.linalg.norm(_FROM)), 0.0, 1.0)
    shaded = colours * (_DARKEST + (1 - _DARKEST) * facing)[..., None]
    met = layers.object > 0
    picture = np.where(met[..., None], np.rint(shaded), SKY).astype(np.uint8)
    return _with_legend(picture, int(layers.level[met].max(initial=0)))


def _with_legend(picture: np.ndarray, deepest: int) -> np.ndarray:
    """Squares with the numbers of the levels, coarse to fine, over the lowest rows."""
    height, width = picture.shape[:2]
    size = max(8, height // 24)
    if width < (LEVELS + 3) * 5 * size / 2:
        return picture
    image = Image.fromarray(picture)
    draw, font = ImageDraw.Draw(image), ImageFont.load_default(size)
    top = height - size - 4
    draw.rectangle((0, top - 2, width, height), _PAPER)
    draw.text((4, top - 1), "level", _INK, font)
    for level, colour in enumerate(level_colours().astype(int).tolist()):
        if level > deepest:
            break
        left = 4 + round((5 * level / 2 + 3) * size)
        draw.rectangle((left, top, left + size - 2, top + size - 2), tuple(colour))
        more = "+" if level == LEVELS - 1 < deepest else ""
        draw.text((left + size + 1, top - 1), f"{level}{more}", _INK, font)
    return np.asarray(image)
