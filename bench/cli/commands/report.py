"""`lodbench report`: the records of a folder as one page that opens offline."""

from pathlib import Path

import click

from bench.cli.flags import StrictCommand
from bench.cli.output import Output, progress_bar


@click.command("report", cls=StrictCommand)
@click.argument("folder", metavar="DIR")
@click.option("--overwrite", is_flag=True, help="Replace files that no report wrote.")
def command(folder: str, overwrite: bool, out: Output) -> None:
    """Write DIR/report.html and DIR/report.md from the records in DIR."""
    from bench.report.write import write_report

    left_out: list[str] = []
    with progress_bar("step") as show:
        written = write_report(Path(folder), overwrite, show, left_out.append)
    out.record({"written": written, "left_out": left_out})
    for line in left_out:
        out.note(f"lodbench: {line}")
    for path in written:
        out.say(str(path))
    if left_out:
        raise click.ClickException(f"{len(left_out)} of the folder's records left out")
