"""`lodbench verify`: every frame of a folder against what it says of itself."""

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from bench.cli.flags import StrictCommand, frame_numbers, memory_flag
from bench.cli.output import Output, frame_progress, progress_bar

if TYPE_CHECKING:
    from scenes.render.exr.frames_on_disk import Job
    from scenes.render.exr.verify import Checked
    from scenes.render.render_files import Workers


@click.command("verify", cls=StrictCommand, json="A JSON object for each wrong file.")
@click.argument("folder", metavar="DIR")
@click.option(
    "--repair", is_flag=True, help="Render again what is wrong or missing, remove partial files."
)
@click.option(
    "--frames", metavar="LIST", help="Those that must be there, as 1-24; else gaps are named."
)
@click.option("--threads", type=click.IntRange(0, 1024), default=0, help="0 = one for each core.")
@click.option(
    "--cluster", metavar="N|ADDRESS|FILE", help="Workers that repair: as many here, or Dask's."
)
@memory_flag
def command(
    folder: str,
    repair: bool,
    frames: str | None,
    threads: int,
    cluster: str | None,
    max_memory: int | None,
    out: Output,
) -> None:
    """Check all frames of a folder: bytes, headers, channels, numbers, gaps, partial files."""
    from scenes.render.render_files import Workers

    numbers = frame_numbers(frames) if frames else None
    count, wrong = _check(out, Path(folder), numbers)
    workers = Workers(threads, max_memory, cluster)
    left = _repair(out, Path(folder), wrong, workers) if repair and wrong else wrong
    out.record({"frames": count, "wrong": len(wrong), "repaired": len(wrong) - len(left)})
    out.say(_summary(count, wrong, left))
    if left:
        raise click.ClickException(_verdict(left, repair))


def _check(out: Output, folder: Path, frames: Sequence[int] | None) -> tuple[int, list["Checked"]]:
    """Check a folder, print what is wrong as it is found; give the number of frames and that."""
    from scenes.render.exr.verify import check_folder

    wrong, count = [], 0
    files = sum(1 for _ in folder.glob("*.exr"))
    with progress_bar("file") as progress:
        for checked in check_folder(folder, frames):
            progress(min(count, files), files, checked.path.name)
            count += checked.frame is not None
            if checked.wrong:
                wrong.append(checked)
                _tell(out, checked)
    return count, wrong


def _repair(
    out: Output, folder: Path, wrong: list["Checked"], workers: "Workers"
) -> list["Checked"]:
    from scenes.render.exr.verify import repairs
    from scenes.render.render_files import render_job

    left = []
    with frame_progress(sum(found.frame is not None for found in wrong)) as progress:

        def render(job: "Job") -> Iterator[dict[str, Any]]:
            return render_job(job, workers, progress.show_samples, out.note)

        for after in repairs(folder, wrong, render):
            progress.clear()
            if after.wrong:
                left.append(after)
                _tell(out, after)
            else:
                what = "removed" if after.frame is None else "rendered again"
                out.record({"frame": after.frame, "path": str(after.path), "repaired": what})
                out.say(f"{after.path}: {what}")
    return left


def _tell(out: Output, checked: "Checked") -> None:
    data = {"frame": checked.frame, "path": str(checked.path), "wrong": list(checked.wrong)}
    out.record(data)
    out.say(f"{checked.path}: {'; '.join(checked.wrong)}")


def _summary(frames: int, wrong: list["Checked"], left: list["Checked"]) -> str:
    bad = sum(each.frame is not None for each in left)
    mended = f", {len(wrong) - len(left)} repaired" if len(left) < len(wrong) else ""
    rest = len(left) - bad
    others = f", {_files(rest)} beside them wrong" if rest else ""
    return f"{frames} frames: {frames - bad} right, {bad} wrong{others}{mended}"


def _verdict(left: list["Checked"], repaired: bool) -> str:
    cure = "" if repaired else "; --repair renders frames and removes partial files"
    verb = "is" if len(left) == 1 else "are"
    return f"{_files(len(left))} {verb} wrong, first {left[0].path}: {left[0].wrong[0]}{cure}"


def _files(count: int) -> str:
    return "1 file" if count == 1 else f"{count} files"
