"""Which flags say what is seen? Each one sets a key of the preset, and errors name the flag."""

from collections.abc import Callable, Sequence
from importlib import resources
from typing import Any

import click
from click.shell_completion import CompletionItem

from lod.errors import InputError
from scenes.preset.actor_tables import ScriptLine
from scenes.preset.load import Setting, load_preset
from scenes.preset.tables import Preset

Command = Callable[..., Any]

VIEW_KEYS = {
    "size": "render.size",
    "seed": "seed",
    "metric": "view.metric",
    "detail": "view.detail",
    "max_parts": "view.max_parts",
    "visibility": "air.visibility",
    "haze_aware": "view.haze_aware",
    "display_ppd": "display.pixels_per_degree",
    "fade": "view.fade",
    "shutter": "view.shutter",
    "smear": "view.smear",
}
QUALITY_KEYS = {
    "spp": "render.spp",
    "variant": "render.variant",
    "haze": "render.haze",
    "spectral": "render.spectral",
    "update_threshold": "view.update_threshold",
}
FILE_KEYS = {
    "compression": "output.compression",
    "multipart": "output.multipart",
    "half": "output.colour",
    "motion": "output.motion",
    "denoise": "output.denoise",
    "cryptomatte": "output.cryptomatte",
}
FLAG_KEYS = VIEW_KEYS | QUALITY_KEYS | FILE_KEYS
"""The key that each flag sets, by the flag's name."""

_TEXT = {"size", "metric", "smear", "visibility", "variant", "haze", "compression", "half"}


def complete_preset(_: click.Context, __: click.Parameter, begun: str) -> list[CompletionItem]:
    """Offer a shell the presets whose names begin so, and leave paths to it."""
    if "/" in begun or begun.startswith("."):
        return [CompletionItem(begun, type="file")]
    files = (resources.files("scenes") / "presets").iterdir()
    names = sorted(each.name.removesuffix(".toml") for each in files)
    return [CompletionItem(name) for name in names if name.startswith(begun)]


def view_flags(command: Command) -> Command:
    """Add PRESET and the flags that `render` and `count` share to a command."""
    flags = (
        click.argument("preset", shell_complete=complete_preset),
        click.option("--size", metavar="WxH", help="Picture size in pixels."),
        click.option("--seed", metavar="N", help="Seed of every random choice."),
        click.option("--metric", metavar="NAME", help="Member of the metric family."),
        click.option("--detail", metavar="PX", help="Detail threshold τ in pixels."),
        click.option(
            "--max-parts", metavar="N", help="Set --detail so that every frame displays N parts."
        ),
        click.option("--visibility", metavar="LENGTH", help="20km, 500m, or clear."),
        click.option(
            "--shutter", metavar="DEGREES", help="Shutter angle, 360 = a whole frame; 0 = no blur."
        ),
        click.option(
            "--smear", metavar="NAME", help="Leave out what blur hides: shutter, window (eye), off."
        ),
        click.option("--fade", metavar="SHARE", help="Share of its limit over which a part fades."),
        click.option(
            "--haze-aware/--no-haze-aware", default=None, help="Leave out what the air hides."
        ),
        click.option("--display-ppd", metavar="N", help="Seen by an eye, N pixels per degree."),
        click.option(
            "--density",
            multiple=True,
            metavar="NAME=K",
            help="Objects of a species per m², as figure=0.002.",
        ),
        click.option(
            "--say",
            multiple=True,
            metavar='"WHO [PART] ACTION"',
            help="Message to an actor before frame 1.",
        ),
        click.option(
            "-D", "settings", multiple=True, metavar="KEY=VALUE", help="Any preset key, dotted."
        ),
    )
    for flag in reversed(flags):
        command = flag(command)
    return command


def file_flags(command: Command) -> Command:
    """Add the flags that say how a frame's file is laid out, and what is in it, to a command."""
    flags = (
        click.option("--compression", metavar="NAME", help="zip, zips, piz, rle or none."),
        click.option(
            "--multipart", is_flag=True, default=None, help="A part for each group of layers."
        ),
        click.option(
            "--half", flag_value="half", default=None, help="Colour as half instead of float."
        ),
        click.option(
            "--motion", is_flag=True, default=None, help="Layers motion.X/Y: px to the next frame."
        ),
        click.option(
            "--denoise", is_flag=True, default=None, help="Layers denoised.R/G/B beside the raw."
        ),
        click.option(
            "--cryptomatte", is_flag=True, default=None, help="Mattes of objects and species."
        ),
    )
    for flag in reversed(flags):
        command = flag(command)
    return command


def preset_from_flags(
    name: str,
    settings: Sequence[str],
    density: Sequence[str],
    say: Sequence[str] = (),
    **flags: Any,
) -> Preset:
    """Load a preset with -D laid over it, and the flags over that; flags left out are None.

    Messages that are said stand before those of the preset's script.
    """
    laid: list[str | Setting] = list(settings)
    for flag, text in flags.items():
        if text is not None:
            value = text if flag in _TEXT or isinstance(text, bool) else parse_number(text)
            laid.append(Setting(f"--{flag.replace('_', '-')}", FLAG_KEYS[flag], value))
    laid += [_density(text) for text in density]
    preset = load_preset(name, laid)
    if flags.get("smear") is not None and preset.view.shutter == 0:
        rule, cure = "it says what an open shutter hides", "add --shutter 180, or leave it out"
        raise InputError("--smear", flags["smear"], rule, cure)
    said = tuple(_said(text) for text in say)
    return preset.model_copy(update={"script": (*said, *preset.script)}) if said else preset


def _said(text: str) -> ScriptLine:
    """Read a message in words as a line of the script, at the beginning."""
    from scenes.actors.say import check_action, parse_words

    words = parse_words(text)
    check_action(words, True, "--say")
    to = f"{words.who} {words.part}".strip()
    return ScriptLine(to=to, do=text.split(None, len(to.split()))[-1])


def _density(text: str) -> Setting:
    name, equals, value = (part.strip() for part in text.partition("="))
    if not (name and equals and value):
        rule = "NAME=K: a species and its objects per m²"
        raise InputError("--density", text, rule, "try --density figure=0.002")
    return Setting(f"--density {name}", f"species.{name}.density", parse_number(value))


def parse_number(text: str) -> int | float | str:
    """Read the number that a text means; another text is given back, for the preset to refuse."""
    for read in (int, float):
        try:
            return read(text)
        except ValueError:
            continue
    return text
