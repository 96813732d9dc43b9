"""Pictures and films of frames for people: exposure, a named tone curve, sRGB, PNG and mp4.

The encoding is colour-science's. Pictures are for looking at; measure the EXR. A preview shows a
frame's light, or the detail level of what each pixel meets: colours of levels run from dark to
light through viridis (Smith & van der Walt 2015), or for each species from dark to light through a
hue of its own (Okabe & Ito 2008), which the colour-blind read too; both are shaded a little by the
normal, for the shape to show. A film is made where ffmpeg is there: that of imageio-ffmpeg,
or one on the PATH. A denoised picture comes by Open Image Denoise by way of ``mitsuba-oidn`` (the
extra ``denoise``), guided by albedo and normals; it is never to be measured.
"""

import contextlib
import errno
import itertools
import math
import re
import shutil
import subprocess
import tempfile
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image, ImageDraw, ImageFont
from PIL.PngImagePlugin import PngInfo

from lod.errors import InputError
from scenes.files import whole_file
from scenes.frame.layers import Layers
from scenes.render.exr.header import software

KEY = 0.18
"""Where the exposure puts the log-average luminance (Reinhard et al. 2002, equations 1 and 2)."""

_DARKEST = 1e-4

_WHITE = 4.0  # exposed light that ``reinhard`` makes white

TONE_CURVES: dict[str, Callable[[np.ndarray], np.ndarray]] = {
    "filmic": lambda x: x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14),
    "reinhard": lambda x: x * (1 + x / _WHITE**2) / (1 + x),
    "linear": lambda x: x,
}
"""From exposed light to display light, on each channel, before it is cut off at 1: Narkowicz's fit
to the ACES filmic curve ("ACES Filmic Tone Mapping Curve", 2015); Reinhard et al. 2002, equation 4;
none."""

VIEWS = ("colour", "level", "species")
"""The light of a frame, or the detail level of what is met, without or with its species."""


@dataclass(frozen=True)
class PictureStyle:
    """How pictures for people are made.

    A tone curve by name, stops above the exposure that fits, and what they show, one of VIEWS.
    """

    tone: str = "filmic"
    stops: float = 0.0
    view: str = "colour"

    def __post_init__(self) -> None:
        if self.view not in VIEWS:
            raise InputError("--view", self.view, f"one of {', '.join(VIEWS)}", "try colour")
        if self.tone not in TONE_CURVES:
            raise InputError("--tone", self.tone, f"one of {', '.join(TONE_CURVES)}", "try filmic")
        if not -20 <= self.stops <= 20:
            raise InputError("--exposure", self.stops, "from -20 to 20 stops", "try 0")

    def exposure_of(self, rgb: np.ndarray) -> float:
        """Exposure factor for a picture, and for all that shall look alike."""
        return auto_exposure(rgb) * 2.0**self.stops


DEFAULT_STYLE = PictureStyle()


def to_srgb_8bit(rgb: np.ndarray, exposure: float, tone: str = DEFAULT_STYLE.tone) -> np.ndarray:
    """Tone-map linear Rec.709 times ``exposure`` to 8-bit sRGB, (h, w, 3)."""
    return np.rint(to_srgb(rgb, exposure, tone) * 255).astype(np.uint8)


def to_srgb(rgb: np.ndarray, exposure: float, tone: str = DEFAULT_STYLE.tone) -> np.ndarray:
    """Tone-map linear Rec.709 times ``exposure`` to sRGB from 0 to 1, not rounded, (h, w, 3)."""
    if not (math.isfinite(exposure) and exposure > 0):
        raise InputError("exposure", exposure, "a factor above 0", "try 1")
    from colour.models import eotf_inverse_sRGB

    x = np.maximum(rgb.astype(np.float64), 0.0) * exposure
    return np.asarray(eotf_inverse_sRGB(np.clip(TONE_CURVES[tone](x), 0.0, 1.0)))


def auto_exposure(rgb: np.ndarray) -> float:
    """Factor that brings a picture's log-average luminance to KEY; 1 for a black picture."""
    from colour import RGB_COLOURSPACES

    luminance = rgb.astype(np.float64) @ RGB_COLOURSPACES["sRGB"].matrix_RGB_to_XYZ[1]
    lit = luminance[luminance > _DARKEST]
    return KEY / math.exp(float(np.log(lit).mean())) if len(lit) else 1.0


LEVELS = 13  # levels that have a colour of their own; finer ones have that of the last
SKY = (214, 218, 222)  # where nothing is met

_VIRIDIS = np.array(
    ((68, 1, 84), (59, 82, 139), (33, 145, 140), (94, 201, 98), (253, 231, 37)), np.float64
)
_FROM = np.array((-0.4, -0.6, 0.7))
_LEAST_SHADE = 0.7
_PAPER, _INK = (24, 24, 26), (220, 220, 220)


def level_colours() -> np.ndarray:
    """8-bit sRGB of each level, coarse to fine, (LEVELS, 3)."""
    at, anchors = np.linspace(0, len(_VIRIDIS) - 1, LEVELS), np.arange(len(_VIRIDIS))
    return np.stack([np.interp(at, anchors, column) for column in _VIRIDIS.T], axis=1)


_HUES = np.array(
    ((0, 114, 178), (230, 159, 0), (0, 158, 115), (204, 121, 167), (213, 94, 0), (86, 180, 233)),
    np.float64,
)
_OF_NO_SPECIES = (128.0, 128.0, 128.0)


def preview_pixels(
    layers: Layers, look: PictureStyle, exposure: float, header: Mapping[str, Any]
) -> np.ndarray:
    """Make a frame's pixels for a preview in a style, 8-bit sRGB, (h, w, 3).

    Species are those of the header's settings, by which the frame is pruned once more.
    """
    if look.view == "colour":
        return to_srgb_8bit(layers.rgb, exposure, look.tone)
    return species_pixels(layers, header) if look.view == "species" else level_pixels(layers)


def level_pixels(layers: Layers) -> np.ndarray:
    """Colour a frame by level, with a legend in its lowest rows, 8-bit sRGB, (h, w, 3)."""
    deepest = int(layers.level[layers.object > 0].max(initial=0))
    legend = {
        f"{level}{'+' if level == LEVELS - 1 < deepest else ''}": colour
        for level, colour in enumerate(level_colours()[: deepest + 1])
    }
    return _by_kind(layers, level_colours()[np.minimum(layers.level, LEVELS - 1)], "level", legend)


def species_pixels(layers: Layers, header: Mapping[str, Any]) -> np.ndarray:
    """Colour a frame by species, the finer the level the lighter; what is of none is grey."""
    from scenes.render.exr.header import FRAME, preset_from_settings, settings_in
    from scenes.render.object_keys import identities
    from scenes.scene import Scene

    if FRAME not in header:
        raise InputError("--view", "species", "asked of a frame that lodbench made", "try level")
    scene = Scene(preset_from_settings(settings_in(header)))
    names = sorted(scene.preset.species)
    hues = np.vstack((_HUES[np.arange(len(names)) % len(_HUES)], _OF_NO_SPECIES))
    row = np.full(int(layers.object.max()) + 1, len(names))
    for each in identities(scene, int(header[FRAME])):
        if each.of in names and each.object < len(row):
            row[each.object] = names.index(each.of)
    found = row[layers.object]
    fine = np.minimum(layers.level, LEVELS - 1)[..., None] / (LEVELS - 1)
    dark = hues[found] * (0.5 + fine / 2)
    present = np.unique(found[layers.object > 0])
    legend = {[*names, "other"][n]: hues[n] for n in present.tolist()}
    return _by_kind(layers, dark + (255.0 - dark) * fine / 2, "species", legend)


def _by_kind(
    layers: Layers, colours: np.ndarray, title: str, legend: Mapping[str, np.ndarray]
) -> np.ndarray:
    """Shade colours of pixels (h, w, 3), and write a legend where there is room for it."""
    facing = np.clip(layers.N @ (_FROM / np.linalg.norm(_FROM)), 0.0, 1.0)
    shaded = colours * (_LEAST_SHADE + (1 - _LEAST_SHADE) * facing)[..., None]
    met = layers.object > 0
    picture = np.where(met[..., None], np.rint(shaded), SKY).astype(np.uint8)
    height, width = picture.shape[:2]
    size = max(8, height // 24)
    font = ImageFont.load_default(size)
    steps = [max(5 * size / 2, 2 * size + font.getlength(text)) for text in legend]
    left = 4 + size + font.getlength(title)
    if left + sum(steps) > width:
        return picture
    image, top = Image.fromarray(picture), height - size - 4
    draw = ImageDraw.Draw(image)
    draw.rectangle((0, top - 2, width, height), _PAPER)
    draw.text((4, top - 1), title, _INK, font)
    for (text, colour), step in zip(legend.items(), steps, strict=True):
        box = (left, top, left + size - 2, top + size - 2)
        draw.rectangle(box, tuple(colour.astype(int).tolist()))
        draw.text((left + size + 1, top - 1), text, _INK, font)
        left += step
    return np.asarray(image)


_GAP = 6
SHEET_WIDTH = 320  # of each frame of a contact sheet [px]


def preview(path: str | Path, out_png: str | Path, look: PictureStyle = DEFAULT_STYLE) -> Path:
    """Write one frame as a PNG, exposed for itself."""
    (picture,) = _pictures([path], look)
    return save_picture(Image.fromarray(picture), out_png)


def write_contact_sheet(
    paths: Sequence[str | Path],
    out_png: str | Path,
    look: PictureStyle = DEFAULT_STYLE,
) -> Path:
    """Write frames side by side, SHEET_WIDTH pixels each; all are exposed for the first.

    The label of each is the frame's number as the file name has it, or the name.
    """
    if not paths:
        raise InputError("contact sheet", [], "at least one frame")
    tiles = []
    for picture in _pictures(paths, look):
        height = max(1, round(SHEET_WIDTH * picture.shape[0] / picture.shape[1]))
        tile = Image.fromarray(picture).resize((SHEET_WIDTH, height), Image.Resampling.LANCZOS)
        tiles.append(tile)
    stems = [Path(path).stem for path in paths]
    labels = [(re.findall(r"\d+", stem) or [stem])[-1] for stem in stems]
    return save_sheet(tiles, labels, default_columns(len(tiles)), out_png)


def default_columns(count: int) -> int:
    """About as many columns as rows, and few gaps in the last row."""
    widest = math.ceil(math.sqrt(count))
    return min(range(widest, min(count, widest + 2) + 1), key=lambda columns: -count % columns)


def save_sheet(
    tiles: Sequence[Image.Image], labels: Sequence[str], columns: int, out_png: str | Path
) -> Path:
    """Write pictures row by row as one PNG, each with its label below."""
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
    return save_picture(sheet, out_png)


def save_picture(picture: Image.Image, path: str | Path, optimize: bool = False) -> Path:
    """Write a PNG that says who made it; in fewer bytes and more time where ``optimize``."""
    about = PngInfo()
    about.add_text("Software", software())
    with whole_file(path, overwrite=True) as temporary:
        picture.save(temporary, "PNG", pnginfo=about, optimize=optimize)
    return Path(path)


def _pictures(paths: Sequence[str | Path], look: PictureStyle) -> Iterator[np.ndarray]:
    from scenes.render.exr.layer_file import read_exr

    exposure = None
    for path in paths:
        layers, header = read_exr(path)
        exposure = exposure or look.exposure_of(layers.rgb)
        yield preview_pixels(layers, look, exposure, header)


def write_movie(
    paths: Sequence[str | Path], out_mp4: str | Path, fps: float, look: PictureStyle = DEFAULT_STYLE
) -> Path | None:
    """Write frames as H.264, all exposed for the first; None where there is no ffmpeg.

    The file is whole or not there at all. Raises OSError with ffmpeg's last words where it fails.
    """
    if ffmpeg_path() is None:
        return None
    if not paths:
        raise InputError("movie", [], "at least one frame")
    # H.264 wants even sides.
    pictures = (
        np.pad(each, ((0, each.shape[0] % 2), (0, each.shape[1] % 2), (0, 0)), mode="edge")
        for each in _pictures(paths, look)
    )
    coded = "-c:v libx264 -pix_fmt yuv420p -movflags +faststart -f mp4"
    return encode_movie(pictures, out_mp4, fps, coded)


NEARLY_LOSSLESS = (
    "-vf scale=out_color_matrix=bt709 -colorspace bt709 -c:v libvpx-vp9 -pix_fmt yuv444p"
    " -crf 8 -b:v 0 -deadline good -cpu-used 4 -f webm"
)
"""How ffmpeg writes a WebM of full colour that eyes do not tell from its pictures."""


def encode_movie(pictures: Iterator[np.ndarray], path: str | Path, fps: float, coded: str) -> Path:
    """Write pictures (h, w, 3), uint8, as a film, coded as these words of ffmpeg's say.

    Raises InputError where there is no ffmpeg, and OSError with its last words where it fails.
    """
    first = next(pictures)
    size = f"{first.shape[1]}x{first.shape[0]}"
    source = f"-f rawvideo -pix_fmt rgb24 -s {size} -r {fps:g} -i -"
    about = "-metadata comment=lodbench"
    arguments = f"-hide_banner -loglevel error -y {source} {about} {coded}".split()
    ffmpeg = needed_ffmpeg()
    with whole_file(path, overwrite=True) as target, tempfile.TemporaryFile() as words:
        command = [ffmpeg, *arguments, str(target)]
        process = subprocess.Popen(command, stdin=subprocess.PIPE, stderr=words)
        # Picture by picture, so that a long sequence needs no more memory than a short one.
        with contextlib.suppress(BrokenPipeError), process:
            for picture in itertools.chain([first], pictures):
                process.stdin.write(picture.tobytes())  # type: ignore[union-attr]
        words.seek(0)
        said = words.read().decode(errors="replace").strip().splitlines()
        if process.returncode:
            raise OSError(errno.EIO, f"ffmpeg: {said[-1] if said else process.returncode}")
    return Path(path)


def ffmpeg_path() -> str | None:
    """The ffmpeg that the extra ``preview`` brings, else that on the PATH; None without either."""
    try:
        import imageio_ffmpeg

        return str(imageio_ffmpeg.get_ffmpeg_exe())
    except (ImportError, RuntimeError):  # not installed, or without a binary for this machine
        return shutil.which("ffmpeg")


def needed_ffmpeg() -> str:
    """Return the path of ffmpeg, or raise InputError where there is none."""
    if path := ffmpeg_path():
        return path
    raise InputError("ffmpeg", "none", "clips need one", "pip install 'lodbench[preview]'")


def check_denoiser() -> None:
    """Raise InputError where there is no denoiser, before anything is rendered for it."""
    try:
        import_module("mitsuba_oidn")
    except ImportError:
        rule, cure = "needs mitsuba-oidn", "pip install 'lodbench[denoise]'"
        raise InputError("output.denoise", True, rule, cure) from None


def denoise_layers(layers: Layers) -> Layers:
    """Add a denoised picture, never negative, to the layers of a frame."""
    import mitsuba_oidn

    start = time.perf_counter()
    picture = mitsuba_oidn.denoise(
        np.array(layers.rgb), albedo=np.array(layers.albedo), normal=np.array(layers.N), hdr=True
    )
    denoised = np.maximum(np.array(picture), 0.0)
    seconds = {**layers.seconds, "denoise": time.perf_counter() - start}
    return replace(layers, denoised=denoised, seconds=seconds)
