"""`lodbench verify`: every frame of a folder against its manifest."""

from pathlib import Path
from typing import TYPE_CHECKING

import click

from bench.output import Output, output
from bench.progress import progress_bar

if TYPE_CHECKING:
    from scenes.render.manifest import Manifest
    from scenes.render.verify import Checked


@click.command("verify")
@click.argument("folder", metavar="DIR")
@click.option("--repair", is_flag=True, help="Render again what is wrong; remove partial files.")
@click.option("--threads", type=click.IntRange(0, 1024), default=0, help="0 = one for each core.")
@click.option("--json", "as_json", is_flag=True, help="A JSON object for each wrong file.")
def command(folder: str, repair: bool, threads: int, as_json: bool) -> None:
    """Hashes, headers, sizes, channels, NaN, infinite and negative values, partial files."""
    from scenes.render.verify import manifest_of

    manifest = manifest_of(Path(folder))
    with output(as_json) as out:
        wrong = _look(out, manifest)
        left = _repair(out, manifest, wrong, threads) if repair else wrong
        counts = {"frames": len(manifest.frames), "wrong": len(wrong)}
        out.record({**counts, "repaired": len(wrong) - len(left)})
        out.say(_summary(len(manifest.frames), wrong, left))
    if left:
        raise click.ClickException(_verdict(left, repair))


def _look(out: Output, manifest: "Manifest") -> list["Checked"]:
    """What is wrong, said as it is found."""
    from scenes.render.verify import check_folder

    wrong = []
    with progress_bar("file") as progress:
        for number, checked in enumerate(check_folder(manifest)):
            progress(number, len(manifest.frames), checked.path.name)
            if checked.wrong:
                wrong.append(checked)
                _tell(out, checked)
    return wrong


def _repair(
    out: Output, manifest: "Manifest", wrong: list["Checked"], threads: int
) -> list["Checked"]:
    """What is wrong still."""
    from scenes.render.verify import repair
    from scenes.render.worker import Worker

    left = []
    with progress_bar("file") as progress, Worker(threads) as worker:
        for number, found in enumerate(wrong):
            progress(number, len(wrong), found.path.name)
            after = repair(manifest, found, worker)
            if after.wrong:
                left.append(after)
                _tell(out, after)
            else:
                what = "removed" if found.frame is None else "rendered again"
                data = {"frame": found.frame, "path": str(found.path), "repaired": what}
                out.record(data)
                out.say(f"{found.path}: {what}")
    return left


def _tell(out: Output, checked: "Checked") -> None:
    data = {"frame": checked.frame, "path": str(checked.path), "wrong": list(checked.wrong)}
    out.record(data)
    out.say(f"{checked.path}: {'; '.join(checked.wrong)}")


def _summary(frames: int, wrong: list["Checked"], left: list["Checked"]) -> str:
    bad = sum(each.frame is not None for each in left)
    mended = f", {len(wrong) - len(left)} repaired" if len(left) < len(wrong) else ""
    return f"{frames} frames: {frames - bad} right, {bad} wrong{mended}"


def _verdict(left: list["Checked"], repaired: bool) -> str:
    cure = "" if repaired else "; --repair renders frames again and removes partial files"
    return f"{len(left)} files are wrong, first {left[0].path}: {left[0].wrong[0]}{cure}"
