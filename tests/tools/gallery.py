"""A picture of every preset, and the same frame by detail level, as a gallery page.

Frames are rendered into a scratch folder; what stays are two pictures (WebP) for each preset and a
page. With
``--references`` some presets have a third: the middle of a larger picture as shipped, beside the
same at half the detail threshold.
"""

import shlex
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path

import click
from PIL import Image

from scenes.files import make_folder, whole_file
from scenes.presets.load import preset_names

FRAMES = {"campfire": 30, "fly_in": 40, "playground": 48}
"""The frame of a preset that shows most; presets that are not named show frame 1."""

SHEETS = {"fly_in": "1,9,17,25,33,41", "playground": "1,17,33,49,65,81"}
"""The frames of a preset's contact sheet."""

FILMS = {"fly_in": "1-48", "playground": "1-96"}

BESIDE = {
    **dict.fromkeys(("badlands", "meadow", "mountain"), "1280x720"),
    "aerial": "640x360",
}
"""Presets that are shown beside a reference, and the sizes that memory allows for it."""

REFERENCE_PX, BESIDE_SPP, SHOWN_PX = 0.5, 64, 640
"""Detail of a reference [px], samples of both pictures, and the most columns that are shown."""

FIGURE_4_FILE = "figure_4.webp"
QUALITY = 90  # of WebP

FIGURE_4 = "joe right leg/lower leg/foot orient y 40deg"
FOOT_VIEW = (
    *("-D", "view.detail=1", "-D", 'camera.behaviour=""', "--say", "camera stand -1.3 -1.6 0.6"),
    *("--say", "camera face 39 -14", "--frames", "2", "--size", "320x240", "--spp", "32"),
)
"""Flags that show joe's feet from near, and without the detail exaggerated."""


def render_preset(name: str, size: str, spp: int, folder: Path, *more: str) -> Path:
    """Render one frame of a preset as EXR, with ``more`` flags, and give its path."""
    frame = FRAMES.get(name, 1)
    flags = [*f"--frames {frame} --size {size} --spp {spp} --overwrite".split(), *more]
    target = folder / name / f"{name}.####.exr"
    subprocess.run(
        [sys.executable, "-m", "bench.cli.main", "render", name, "-o", str(target), *flags],
        check=True,
    )
    return target.with_name(f"{name}.{frame:04d}.exr")


def render_beside(name: str, folder: Path, target: Path) -> None:
    """Keep the middle of a preset's frame as shipped beside that of its reference, not denoised."""
    from scenes.render.exr.layer_file import read_exr
    from scenes.render.pictures import DEFAULT_STYLE, save_sheet, to_srgb_8bit

    exposure, panels = None, []
    for label, detail in (("shipped", []), ("reference", ["--detail", str(REFERENCE_PX)])):
        frame = render_preset(name, BESIDE[name], BESIDE_SPP, folder / label, *detail)
        light = read_exr(frame)[0].rgb
        exposure = exposure or DEFAULT_STYLE.exposure_of(light)
        first = max(light.shape[1] - SHOWN_PX, 0) // 2
        shown = light[:, first : first + SHOWN_PX]
        panels.append(Image.fromarray(to_srgb_8bit(shown, exposure, DEFAULT_STYLE.tone)))
    save_sheet(panels, ("as shipped, 1 px", f"reference, {REFERENCE_PX} px"), 2, target)


def save_pictures(frame: Path, name: str, folder: Path) -> None:
    """Write both pictures of a frame: its light, denoised, and its detail levels."""
    from scenes.render.exr.layer_file import read_exr
    from scenes.render.pictures import (
        DEFAULT_STYLE,
        PictureStyle,
        preview,
        save_picture,
        to_srgb_8bit,
    )

    layers = read_exr(frame)[0]
    light = layers.rgb if layers.denoised is None else layers.denoised
    picture = Image.fromarray(
        to_srgb_8bit(light, DEFAULT_STYLE.exposure_of(light), DEFAULT_STYLE.tone)
    )
    save_picture(picture, folder / f"{name}.png", optimize=True)
    preview(frame, folder / f"{name}_level.png", PictureStyle(view="level"))


def render_sheet(name: str, frames: str, folder: Path, target: Path) -> None:
    """Render some frames of a preset, small, and keep the contact sheet of them."""
    from scenes.render.pictures import save_picture

    film = folder / f"{name}_film" / f"{name}.####.exr"
    flags = f"--frames {frames} --size 320x180 --spp 8 --denoise --overwrite".split()
    flags += ["-o", str(film), "--preview"]
    subprocess.run([sys.executable, "-m", "bench.cli.main", "render", name, *flags], check=True)
    with Image.open(film.with_name(f"{name}.png")) as sheet:
        save_picture(sheet, target, optimize=True)


def render_figure_4(folder: Path, target: Path) -> None:
    """Render joe as he stands and after the message of figure 4, side by side."""
    from scenes.render.pictures import save_sheet

    panels = []
    for said in ([], ["--say", FIGURE_4]):
        out = folder / f"figure_4_{len(said)}" / "joe.####.exr"
        words = ["render", "fly_in", *FOOT_VIEW, *said, "-o", str(out), "--preview"]
        subprocess.run([sys.executable, "-m", "bench.cli.main", *words], check=True)
        with Image.open(out.with_name("joe.png")) as panel:
            panels.append(panel.convert("RGB"))
    save_sheet(panels, ("before", "after"), 2, target)


def gallery_page(presets: Sequence[tuple[str, str]], folder: Path) -> str:
    """Write the gallery as Markdown, from the names of presets and what they show.

    Contact sheets are shown of presets that have one in the folder, with the command of the film.
    """
    head = (
        "# Gallery\n\nEvery preset, and beside it the same frame by detail level"
        " (`--view level`): dark is coarse, light is fine. Made by"
        " `python -m tests.tools.gallery`, 16"
        " samples a pixel, denoised. [Clips](motion.md) of what motion hides lie beside.\n"
    )
    rows = [
        f"\n## {name}\n\n{about}\n\n![{name}]({name}.webp) ![{name} by level]({name}_level.webp)\n"
        for name, about in presets
    ]
    for number, (name, _) in enumerate(presets):
        if (folder / f"{name}_beside.webp").exists():
            rows[number] += (
                f"\nAt {BESIDE[name]}, {BESIDE_SPP} samples, not denoised; as shipped, and at"
                f" {REFERENCE_PX} px:\n\n![{name} beside its reference]({name}_beside.webp)\n"
            )
        if (folder / f"{name}_sheet.webp").exists():
            film = (
                f"lodbench render {name} -o film/{name}.####.exr --frames {FILMS[name]} --preview"
            )
            rows[number] += f"\n```\n{film}\n```\n\n![film of {name}]({name}_sheet.webp)\n"
    if (folder / FIGURE_4_FILE).exists():
        words = f"lodbench render fly_in {shlex.join((*FOOT_VIEW, '--say', FIGURE_4))}"
        rows.append(
            "\n## Figure 4\n\njoe's right foot, before and after it is told to turn by 40° about"
            f" its y ([actors](../../docs/actors.md))\n\n```\n{words} -o joe.####.exr\n```\n\n"
            f"![the foot turns]({FIGURE_4_FILE})\n"
        )
    return head + "".join(rows)


@click.command()
@click.argument("names", nargs=-1)
@click.option("-o", "folder", default="results/gallery", metavar="DIR", show_default=True)
@click.option("--size", default="640x360", metavar="WxH", show_default=True)
@click.option("--spp", default=16, show_default=True)
@click.option("--references", is_flag=True, help="Show some beside references: 13 GB, minutes.")
def command(names: tuple[str, ...], folder: str, size: str, spp: int, references: bool) -> None:
    """Render the presets of these NAMES, or all, and write the page of all that have pictures."""
    target = make_folder(folder)
    wanted = [name for name, _ in preset_names() if name in names or not names]
    for name in wanted:
        with tempfile.TemporaryDirectory() as each:
            scratch, made = Path(each), Path(each, "made")
            made.mkdir()
            save_pictures(render_preset(name, size, spp, scratch, "--denoise"), name, made)
            if name in SHEETS:
                render_sheet(name, SHEETS[name], scratch, made / f"{name}_sheet.png")
            if references and name in BESIDE:
                render_beside(name, scratch, made / f"{name}_beside.png")
            if name == "fly_in":
                render_figure_4(scratch, made / "figure_4.png")
            for picture in made.glob("*.png"):
                with Image.open(picture) as pixels:
                    pixels.convert("RGB").save(target / f"{picture.stem}.webp", quality=QUALITY)
    done = [each for each in preset_names() if (target / f"{each[0]}_level.webp").exists()]
    with whole_file(target / "README.md", overwrite=True) as page:
        page.write_text(gallery_page(done, target), "utf-8")


if __name__ == "__main__":
    command()
