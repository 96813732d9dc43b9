"""`lodbench render`: frames of a preset as an EXR sequence."""

import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import click

from bench.frame_flags import check_targets, frame_numbers, frame_path, frame_pattern, make_folder
from bench.output import Output, output
from bench.progress import progress_bar
from bench.view_flags import file_flags, preset_of, view_flags
from lod.errors import InputError
from scenes.preset import Preset
from scenes.render.frame import FrameInput


@click.command("render")
@view_flags
@click.option("-o", "pattern", required=True, metavar="OUT/NAME.####.exr", help="Frames to write.")
@click.option("--frames", default="1", metavar="LIST", help="1-24 or 1,5,9.", show_default=True)
@click.option("--spp", metavar="N", help="Samples per pixel.")
@click.option("--variant", metavar="NAME", help="Mitsuba variant, or auto.")
@file_flags
@click.option("--preview", is_flag=True, help="A PNG contact sheet; an mp4 where ffmpeg is there.")
@click.option("--resume", is_flag=True, help="Keep frames done with these settings (the default).")
@click.option("--overwrite", is_flag=True, help="Render anew and replace whatever is there.")
@click.option("--json", "as_json", is_flag=True, help="A JSON object per frame on stdout.")
def command(
    preset: str,
    pattern: str,
    frames: str,
    preview: bool,
    resume: bool,
    overwrite: bool,
    as_json: bool,
    **flags: Any,
) -> None:
    """Prune, render and write frames: colour, depth, normals, albedo and ids."""
    frame_pattern(pattern)
    numbers = frame_numbers(frames)
    if resume and overwrite:
        raise InputError("--resume --overwrite", "both", "one of the two", "leave one out")
    chosen = preset_of(preset, **flags)
    paths = [frame_path(pattern, number) for number in numbers]
    check_targets(paths)
    from scenes.render.variants import choose

    variant = choose(chosen.render.variant)
    make_folder(Path(pattern).parent)
    with output(as_json) as out:
        _render(out, chosen, variant, pattern, numbers, overwrite)
        pictures = _preview(out, chosen, pattern, paths) if preview else []
        out.record({"done": len(numbers), "failed": 0, "previews": pictures})


def _render(
    out: Output,
    preset: Preset,
    variant: str,
    pattern: str,
    numbers: Sequence[int],
    overwrite: bool,
) -> None:
    """A line for each finished frame; the first failure ends it, and is counted."""
    from scenes.render.sequence import render_sequence

    made, settings = frame_maker(preset, variant), settings_of(preset, variant)
    done = 0
    try:
        with progress_bar("frame") as progress:
            progress(0, len(numbers), variant)
            for record in render_sequence(pattern, numbers, made, settings, overwrite):
                done += 1
                progress(done, len(numbers), variant)
                out.record(record)
                out.say(_line(record))
    except BaseException:
        out.record({"done": done, "failed": 1})
        raise


def frame_maker(preset: Preset, variant: str) -> Callable[[int], FrameInput]:
    """Makes frames of a preset; the world is built for the first, in that frame's time."""
    from scenes.shot import shoot
    from scenes.world import World, build_world

    worlds: list[World] = []

    def make(frame: int) -> FrameInput:
        start = time.perf_counter()
        if not worlds:
            worlds.append(build_world(preset))
        seconds = {"world": time.perf_counter() - start}
        made = shoot(worlds[0], preset, frame, variant)
        return replace(made, seconds=seconds | made.seconds)

    return make


def settings_of(preset: Preset, variant: str) -> dict[str, Any]:
    """Everything that determines the pixels, as plain nested data."""
    settings = preset.model_dump(mode="json", exclude={"about"})
    settings["render"]["variant"] = variant
    return settings


def _line(record: dict[str, Any]) -> str:
    took = "kept" if record["kept"] else f"{sum(record['seconds'].values()):.1f} s"
    return f"{record['path']}  {record['sha256'][:16]}  {took}"


def _preview(out: Output, preset: Preset, pattern: str, paths: Sequence[Path]) -> list[str]:
    """One frame as it is; of more, a contact sheet and a film. The paths of what was made."""
    from scenes.render.contact_sheet import contact_sheet, preview
    from scenes.render.movie import movie

    stem = preview_stem(pattern)
    still = stem.with_name(f"{stem.name}.png")
    pictures = [contact_sheet(paths, still) if len(paths) > 1 else preview(paths[0], still)]
    try:
        target = stem.with_name(f"{stem.name}.mp4")
        film = movie(paths, target, preset.camera.fps) if len(paths) > 1 else None
        pictures += [film] if film else []
    except OSError as error:
        out.note(f"lodbench: no mp4: {error.strerror}")
    for picture in pictures:
        out.say(str(picture))
    return [str(picture) for picture in pictures]


def preview_stem(pattern: str) -> Path:
    """out/name.####.exr → out/name, and out/sheet where the name is all number."""
    path = Path(pattern)
    return path.with_name(
        path.name.removesuffix(".exr").replace("####", "").strip("._-") or "sheet"
    )
