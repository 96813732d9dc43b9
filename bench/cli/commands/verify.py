"""`lodbench verify`: every frame of a folder against its manifest."""

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from bench.cli.commands.render import Workers, render_job
from bench.cli.flags import StrictCommand, memory_flag, memory_limit_bytes
from bench.cli.output import Output, frame_progress, output, progress_bar

if TYPE_CHECKING:
    from scenes.render.exr.sequence import Job, Manifest
    from scenes.render.exr.verify import Checked


@click.command("verify", cls=StrictCommand)
@click.argument("folder", metavar="DIR")
@click.option(
    "--repair",
    is_flag=True,
    help="Rebuild the manifest; where it is right, render what is wrong, remove partial files.",
)
@click.option("--threads", type=click.IntRange(0, 1024), default=0, help="0 = one for each core.")
@click.option(
    "--cluster", metavar="N|ADDRESS|FILE", help="Workers that repair: as many here, or Dask's."
)
@memory_flag
@click.option("--json", "as_json", is_flag=True, help="A JSON object for each wrong file.")
def command(
    folder: str,
    repair: bool,
    threads: int,
    cluster: str | None,
    max_memory: str | None,
    as_json: bool,
) -> None:
    """Hashes, headers, sizes, channels, NaN, infinite and negative values, partial files."""
    from scenes.render.exr.verify import open_manifest

    most_bytes = memory_limit_bytes(max_memory)
    with output(as_json) as out:
        taken = _rebuild(out, Path(folder)) if repair else ()
        manifest = open_manifest(Path(folder), repair)
        wrong = _look(out, manifest)
        workers = Workers(threads, most_bytes, cluster)
        repairs = repair and wrong and not taken
        left = _repair(out, manifest, wrong, workers) if repairs else wrong
        counts = {"frames": len(manifest.frames), "wrong": len(wrong)}
        out.record({**counts, "repaired": len(wrong) - len(left)})
        out.say(_summary(len(manifest.frames), wrong, left))
    if left:
        raise click.ClickException(_verdict(left, repair, bool(taken)))


def _rebuild(out: Output, folder: Path) -> tuple[str, ...]:
    """Take whole frames into the manifest that it does not know, and say which."""
    from scenes.render.exr.sequence import rebuild_manifest

    taken = rebuild_manifest(folder) if folder.is_dir() else ()
    for name in taken:
        what = "taken into the manifest as its header says"
        out.record({"path": str(folder / name), "repaired": what})
        out.say(f"{folder / name}: {what}")
    return taken


def _look(out: Output, manifest: "Manifest") -> list["Checked"]:
    """Check a folder, print what is wrong as it is found, and give it."""
    from scenes.render.exr.verify import check_folder

    wrong = []
    with progress_bar("file") as progress:
        for number, checked in enumerate(check_folder(manifest)):
            progress(number, len(manifest.frames), checked.path.name)
            if checked.wrong:
                wrong.append(checked)
                _tell(out, checked)
    return wrong


def _repair(
    out: Output, manifest: "Manifest", wrong: list["Checked"], workers: Workers
) -> list["Checked"]:
    """Repair what is wrong, and give what is wrong still."""
    from scenes.render.exr.verify import repairs

    left = []
    with frame_progress(sum(found.frame is not None for found in wrong)) as progress:

        def render(job: "Job") -> Iterator[dict[str, Any]]:
            return render_job(job, workers, progress.show_samples, out.note)

        for after in repairs(manifest, wrong, render):
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


def _verdict(left: list["Checked"], repaired: bool, rebuilt: bool) -> str:
    how = "the same command again" if rebuilt else "--repair"
    cure = "" if repaired and not rebuilt else f"; {how} renders frames and removes partial files"
    verb = "is" if len(left) == 1 else "are"
    return f"{_files(len(left))} {verb} wrong, first {left[0].path}: {left[0].wrong[0]}{cure}"


def _files(count: int) -> str:
    return "1 file" if count == 1 else f"{count} files"
