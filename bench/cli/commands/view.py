"""`lodbench view`: a frame as a picture for people."""

from pathlib import Path

import click

from bench.cli.flags import StrictCommand, picture_flags
from bench.cli.output import Output
from scenes.files import check_ours


@click.command("view", cls=StrictCommand)
@click.argument("frame", type=click.Path(path_type=Path))
@click.option("-o", "target", required=True, metavar="FILE.png", type=click.Path(path_type=Path))
@picture_flags
@click.option("--overwrite", is_flag=True, help="Replace a file that lodbench did not make.")
def command(
    frame: Path, target: Path, tone: str, view: str, exposure: float, overwrite: bool, out: Output
) -> None:
    """Write a frame as the picture of `render --preview`, and print the factor on its light."""
    from scenes.render.exr.layer_file import read_exr
    from scenes.render.pictures import PictureStyle, preview

    look = PictureStyle(tone, exposure, view)
    check_ours([target], overwrite, "-o")
    factor = look.exposure_of(read_exr(frame)[0].rgb)
    preview(frame, target, look)
    out.record({"path": str(target), "exposure": factor, "tone": tone, "view": view})
    out.say(f"{target}  light × {factor:.4g}, {tone}")
