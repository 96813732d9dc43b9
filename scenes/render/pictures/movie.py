"""A sequence as an mp4, where ffmpeg is there: that of imageio-ffmpeg, or one on the PATH."""

import contextlib
import errno
import itertools
import shutil
import subprocess
import tempfile
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path

import numpy as np

from lod.errors import InputError
from scenes.render.files.exr import read_exr
from scenes.render.files.whole_file import whole_file
from scenes.render.pictures.level_view import preview_pixels
from scenes.render.pictures.tone_map import DEFAULT_STYLE, PictureStyle


def movie(
    paths: Sequence[str | Path], out_mp4: str | Path, fps: float, look: PictureStyle = DEFAULT_STYLE
) -> Path | None:
    """Write frames as H.264, all exposed for the first; None where there is no ffmpeg.

    The file is whole or not there at all. Raises OSError with ffmpeg's last words where it fails.
    """
    ffmpeg = ffmpeg_path()
    if ffmpeg is None:
        return None
    if not paths:
        raise InputError("movie", [], "at least one frame")
    pictures = _pictures(paths, look)
    first = next(pictures)
    path = Path(out_mp4)
    arguments = _arguments(first.shape[1], first.shape[0], fps)
    with whole_file(path, overwrite=True) as temporary:
        _feed([ffmpeg, *arguments, str(temporary)], itertools.chain([first], pictures))
    return path


def ffmpeg_path() -> str | None:
    """The ffmpeg that the extra ``preview`` brings, else that on the PATH; None without either."""
    try:
        import imageio_ffmpeg

        return str(imageio_ffmpeg.get_ffmpeg_exe())
    except (ImportError, RuntimeError):  # not installed, or without a binary for this machine
        return shutil.which("ffmpeg")


def _pictures(paths: Sequence[str | Path], look: PictureStyle) -> Iterator[np.ndarray]:
    """8-bit sRGB pictures with even sides, as H.264 wants them."""
    exposure = None
    for path in paths:
        layers = read_exr(path)[0]
        exposure = exposure or look.exposure_of(layers.rgb)
        height, width = layers.rgb.shape[:2]
        even = ((0, height % 2), (0, width % 2), (0, 0))
        yield np.pad(preview_pixels(layers, look, exposure), even, mode="edge")


def _arguments(width: int, height: int, fps: float) -> list[str]:
    source = f"-f rawvideo -pix_fmt rgb24 -s {width}x{height} -r {fps:g} -i -"
    coded = "-c:v libx264 -pix_fmt yuv420p -movflags +faststart -f mp4"
    about = "-metadata comment=lodbench"
    return f"-hide_banner -loglevel error -y {source} {about} {coded}".split()


def _feed(command: list[str], pictures: Iterable[np.ndarray]) -> None:
    """Picture by picture, so that a long sequence needs no more memory than a short one."""
    with tempfile.TemporaryFile() as words:
        process = subprocess.Popen(command, stdin=subprocess.PIPE, stderr=words)
        with contextlib.suppress(BrokenPipeError), process:
            for picture in pictures:
                process.stdin.write(picture.tobytes())  # type: ignore[union-attr]
        words.seek(0)
        said = words.read().decode(errors="replace").strip().splitlines()
    if process.returncode:
        raise OSError(errno.EIO, f"ffmpeg: {said[-1] if said else process.returncode}")
