"""`lodbench score`: is a picture of another program right, and what is it worth?"""

from pathlib import Path

import click

from bench.cli.flags import StrictCommand
from bench.cli.output import Output, progress_bar
from scenes.files import make_folder


@click.command("score", cls=StrictCommand, json="The record on stdout.")
@click.argument("paths", metavar="EXR...", nargs=-1, required=True)
@click.option("--pack", required=True, metavar="DIR", help="The pack that they are pictures of.")
@click.option("--seconds", type=click.FloatRange(0, min_open=True), help="Of work, as you say.")
@click.option("--bytes", "held", type=click.IntRange(1), help="Peak memory, as you say.")
@click.option("--setting", type=float, default=1.0, help="Of the program's knob; 1 by default.")
@click.option("--who", default="unnamed", help="Who submits; the record names it.")
@click.option("--program", default="unnamed", help="Name and version of the program.")
@click.option("--baseline", metavar="JSON", help="Record of blake; by default the published one.")
@click.option("--diagnose", is_flag=True, help="Render likely mistakes from the pack's recipe.")
@click.option("--check", metavar="JSON", help="A record whose pictures these are: is it true?")
@click.option("-o", "folder", metavar="DIR", help="Folder for the record and its page.")
def command(
    paths: tuple[str, ...],
    pack: str,
    seconds: float | None,
    held: int | None,
    setting: float,
    who: str,
    program: str,
    baseline: str | None,
    diagnose: bool,
    check: str | None,
    folder: str | None,
    out: Output,
) -> None:
    """Score pictures of a pack: validity, errors, and the time to blake's error at one pixel.

    Files named NAME.0001.exr are frames of the walk; another name is the still.
    """
    from bench.submissions.entry import (
        check_again,
        judged,
        page,
        published_baseline,
        read_submission,
        record_of,
        setting_row,
        views_of,
        write_record,
    )

    if check is not None:
        if wrong := check_again(read_submission(check, "--check"), paths, pack):
            raise click.ClickException("; ".join(wrong))
        click.echo(f"{check}: {len(paths)} pictures scored again, and the record is true")
        return
    with progress_bar("step") as show:
        show(0, 1, "judging pictures")
        found = judged(paths, pack, diagnose)
    told = {"seconds": seconds, "peak_bytes": held, "repeat": 0}
    row = setting_row(setting, found, [told], list(views_of(paths).values()))
    beside = published_baseline(pack, baseline)
    record = record_of(pack, who, program, "reported", [row], beside)
    out.record(record)
    out.say(page(record))
    if folder is not None:
        out.note(str(write_record(make_folder(folder), record, paths, Path(pack))))
    if any(each.void for each in found.values()):
        raise click.ClickException(f"void: {next(e.void for e in found.values() if e.void)}")
