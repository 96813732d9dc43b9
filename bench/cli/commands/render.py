"""`lodbench render`: frames of a preset as an EXR sequence.

The steps of a frame, with the file and function of each, are listed in docs/architecture.md.
"""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import Any

import click

from bench.cli.flags import (
    StrictCommand,
    check_targets,
    file_flags,
    frame_numbers,
    memory_flag,
    picture_flags,
    preset_from_flags,
    value_option,
    view_flags,
)
from bench.cli.output import Output, frame_progress, tell_first_run
from scenes.files import check_ours, check_pattern, frame_path
from scenes.presets.schema import Preset
from scenes.render.pictures import PictureStyle


@click.command("render", cls=StrictCommand, json="A JSON object per frame on stdout.")
@view_flags
@memory_flag
@click.option("-o", "pattern", required=True, metavar="OUT/NAME.####.exr", help="Frames to write.")
@click.option(
    "--frames", default="1", metavar="LIST", help="1-24, 1,5,9 or 1-100x10.", show_default=True
)
@click.option("--spp", metavar="N", help="Samples per pixel.")
@value_option("--variant", metavar="NAME", help="Mitsuba variant, or auto.")
@value_option("--haze", metavar="NAME", help="analytic or medium.")
@click.option("--spectral", is_flag=True, default=None, help="Wavelengths instead of RGB.")
@click.option(
    "--update-threshold", metavar="PX", help="Redraw parts once they moved by this; 0 = always."
)
@file_flags
@click.option("--preview", is_flag=True, help="Write a PNG; of frames an mp4, if ffmpeg is there.")
@picture_flags
@click.option("--overwrite", is_flag=True, help="Render again and replace what is there.")
@click.option("--threads", type=click.IntRange(0, 1024), default=0, help="0 = one for each core.")
@click.option(
    "--reference", is_flag=True, help="Leave nothing out: as fine as --max-memory allows."
)
@click.option(
    "--cluster", metavar="N|ADDRESS|FILE", help="Workers to start here, or a Dask scheduler."
)
def command(
    preset: str,
    pattern: str,
    frames: str,
    preview: bool,
    tone: str,
    view: str,
    exposure: float,
    overwrite: bool,
    threads: int,
    max_memory: int | None,
    reference: bool,
    cluster: str | None,
    out: Output,
    **flags: Any,
) -> None:
    """Prune, render and write frames: colour, depth, normals, albedo and ids.

    The same command again goes on where it ended: frames done with these settings are kept.
    """
    check_pattern(pattern)
    numbers = frame_numbers(frames)
    look = PictureStyle(tone, exposure, view)
    chosen = preset_from_flags(preset, **flags)
    from scenes.render.budget import reference_preset
    from scenes.render.render_files import Workers, render_files, settled

    tell = partial(click.echo, err=True)
    check_targets([frame_path(pattern, number) for number in numbers])
    check_ours(_previews(pattern) if preview else (), overwrite, "--preview")
    if reference:
        some = [numbers[0], numbers[len(numbers) // 2], numbers[-1]]
        chosen = reference_preset(chosen, sorted(set(some)), max_memory, tell)
    settings = settled(chosen, pattern, numbers, max_memory, tell)
    workers = Workers(threads, max_memory, cluster)
    records: list[dict[str, Any]] = []
    tell_first_run()
    with _counted(out, records), frame_progress(len(numbers)) as progress:
        for record in render_files(
            settings, pattern, numbers, workers, overwrite, progress.show_samples, out.note
        ):
            records.append(record)
            progress.clear()
            if "error" in record:
                out.note(f"lodbench: {record['path']}: {record['error']}")
            else:
                out.record(record)
                out.say(_line(record))
            progress.finish_frame(record)
    done = [Path(record["path"]) for record in records if "error" not in record]
    failed = [record for record in records if "error" in record]
    pictures = _preview(out, chosen, pattern, done, look) if preview and done else []
    end = {"done": len(done), "failed": len(failed), "failures": failed}
    out.record({**end, "previews": pictures})
    if failed:
        first = "; ".join(f"frame {each['frame']}: {each['error']}" for each in failed[:3])
        raise click.ClickException(f"{len(failed)} of {len(numbers)} frames failed: {first}")


@contextmanager
def _counted(out: Output, records: Sequence[dict[str, Any]]) -> Iterator[None]:
    """What ends the sequence before its end is counted among the failures, too."""
    try:
        yield
    except BaseException:
        failures = [record for record in records if "error" in record]
        done = len(records) - len(failures)
        out.record({"done": done, "failed": len(failures) + 1, "failures": failures})
        raise


def _line(record: dict[str, Any]) -> str:
    took = "kept" if record["kept"] else f"{sum(record['seconds'].values()):.1f} s"
    return f"{record['path']}  {record['sha256'][:16]}  {took}"


def _preview(
    out: Output, preset: Preset, pattern: str, paths: Sequence[Path], look: PictureStyle
) -> list[str]:
    """Write a picture of one frame, or a contact sheet and a film of more; give their paths."""
    from scenes.render.pictures import preview, write_contact_sheet, write_movie

    still, target = _previews(pattern)
    many = len(paths) > 1
    pictures = [
        write_contact_sheet(paths, still, look=look) if many else preview(paths[0], still, look)
    ]
    try:
        film = write_movie(paths, target, preset.camera.fps, look) if many else None
        pictures += [film] if film else []
    except OSError as error:
        out.note(f"lodbench: no mp4: {error.strerror}")
    for picture in pictures:
        out.say(str(picture))
    return [str(picture) for picture in pictures]


def _previews(pattern: str) -> tuple[Path, Path]:
    stem = preview_stem(pattern)
    return stem.with_name(f"{stem.name}.png"), stem.with_name(f"{stem.name}.mp4")


def preview_stem(pattern: str) -> Path:
    """Turn out/name.####.exr into out/name, and into out/sheet where the name is all number."""
    path = Path(pattern)
    return path.with_name(
        path.name.removesuffix(".exr").replace("####", "").strip("._-") or "sheet"
    )
