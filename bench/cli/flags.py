"""The flags that commands share, and the rules between them, checked before anything slow begins.

A flag that says what is seen sets a key of the preset, and errors name the flag. One table says
which flags exclude or need one another; what is said twice of one key is refused, be it by a flag,
by --density or by -D.
"""

import os
import re
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from functools import reduce
from importlib import resources
from itertools import chain
from pathlib import Path
from typing import Any

import click
from click.core import ParameterSource
from click.shell_completion import CompletionItem

from bench.cli.output import output
from lod.errors import InputError
from scenes.files import LAST_FRAME, checked_frames
from scenes.presets.load import Setting, load_preset
from scenes.presets.schema import Preset, ScriptLine

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
FLAG_KEYS = VIEW_KEYS | QUALITY_KEYS | FILE_KEYS  # the key that each flag sets, by the flag's name

_TEXT = {"size", "metric", "smear", "visibility", "variant", "haze", "compression", "half"}


def complete_preset(_: click.Context, __: click.Parameter, begun: str) -> list[CompletionItem]:
    """Offer a shell the presets whose names begin so, and leave paths to it."""
    if "/" in begun or begun.startswith("."):
        return [CompletionItem(begun, type="file")]
    names = sorted(each.name for each in (resources.files("scenes") / "presets").iterdir())
    presets = [name.removesuffix(".toml") for name in names if name.endswith(".toml")]
    return [CompletionItem(name) for name in presets if name.startswith(begun)]


def complete_value(_: click.Context, option: click.Parameter, begun: str) -> list[CompletionItem]:
    """Offer a shell the words that a flag's key may be, and after -D the keys themselves."""
    from scenes.plugins import metric_names
    from scenes.presets.load import key_entries

    if option.name in ("tone", "view", "variant"):
        from scenes.render.pictures import TONE_CURVES, VIEWS
        from scenes.render.variants import JIT_VARIANT, SCALAR_VARIANT

        known = {"tone": [*TONE_CURVES], "view": [*VIEWS]}.get(option.name)
        known = known or ["auto", JIT_VARIANT, SCALAR_VARIANT]
        return [CompletionItem(word) for word in known if word.startswith(begun)]
    kinds = {each.name: each.kind for each in key_entries()}
    key, equals, _value = begun.partition("=")
    if option.name == "settings" and not equals:
        return [CompletionItem(f"{name}=") for name in kinds if name.startswith(key)]
    lead = f"{key}=" if option.name == "settings" else ""
    name = key if lead else FLAG_KEYS[option.name or ""]
    words = metric_names() if name == "view.metric" else re.findall(r'"(\w+)"', kinds.get(name, ""))
    return [CompletionItem(f"{lead}{word}") for word in words if f"{lead}{word}".startswith(begun)]


def value_option(*names: str, **rest: Any) -> Callable[[Command], Command]:
    """Make an option whose values a shell completes."""
    return click.option(*names, shell_complete=complete_value, **rest)


_VALUES = (
    ("--size", "WxH", "Picture size in pixels."),
    ("--seed", "N", "Seed of every random choice."),
    ("--metric", "NAME", "Member of the metric family."),
    ("--detail", "PX", "Detail threshold τ in pixels."),
    ("--max-parts", "N", "Set --detail so that no frame displays more."),
    ("--visibility", "LENGTH", "In haze: 20km, 500m, or clear."),
    ("--shutter", "DEGREES", "Shutter angle, 360 = a whole frame; 0 = no blur."),
    ("--smear", "NAME", "Which blur hides parts: shutter, window (the eye's, too), off."),
    ("--fade", "SHARE", "Share of its limit distance over which a part fades."),
    ("--display-ppd", "N", "Judge detail by an eye at N pixels per degree."),
)
_VIEW_FLAGS: tuple[Callable[[Command], Command], ...] = (
    click.argument("preset", shell_complete=complete_preset),
    *(value_option(name, metavar=metavar, help=about) for name, metavar, about in _VALUES),
    click.option(
        "--haze-aware/--no-haze-aware", default=None, help="Leave out parts that the haze hides."
    ),
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
    value_option(
        "-D", "settings", multiple=True, metavar="KEY=VALUE", help="Any key: lodbench list --keys."
    ),
)
_FILES = (
    ("--multipart", True, "Write each group of layers as an EXR part."),
    ("--half", "half", "Write colour as half instead of float."),
    ("--motion", True, "Add layers motion.X/Y: pixels to the next frame."),
    ("--denoise", True, "Add layers denoised.R/G/B beside the raw ones."),
    ("--cryptomatte", True, "Add mattes of objects and species."),
)
_FILE_FLAGS: tuple[Callable[[Command], Command], ...] = (
    value_option("--compression", metavar="NAME", help="zip, zips, piz, rle or none."),
    *(click.option(name, flag_value=v, default=None, help=about) for name, v, about in _FILES),
)
_PICTURE_FLAGS = (
    value_option("--tone", default="filmic", metavar="NAME", help="filmic, reinhard or linear."),
    value_option("--view", default="colour", metavar="NAME", help="colour, level or species."),
    click.option("--exposure", type=float, default=0.0, metavar="STOPS", help="Brighter previews."),
)


def _adding(flags: Sequence[Callable[[Command], Command]]) -> Callable[[Command], Command]:
    return lambda command: reduce(lambda made, flag: flag(made), reversed(flags), command)


picture_flags = _adding(_PICTURE_FLAGS)
view_flags = _adding(_VIEW_FLAGS)
file_flags = _adding(_FILE_FLAGS)


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
            value = text if flag in _TEXT or isinstance(text, bool) else _number(text)
            laid.append(Setting(f"--{flag.replace('_', '-')}", FLAG_KEYS[flag], value))
    laid += [_density(text) for text in density]
    preset = load_preset(name, laid)
    if flags.get("smear") is not None and preset.view.shutter == 0:
        rule, cure = "it says what an open shutter hides", "add --shutter 180, or leave it out"
        raise InputError("--smear", flags["smear"], rule, cure)
    said = tuple(_said(text) for text in say)
    return preset.model_copy(update={"script": (*said, *preset.script)}) if said else preset


def _said(text: str) -> ScriptLine:
    from scenes.world.cast import check_action, parse_words

    words = parse_words(text)
    check_action(words, True, "--say")
    to = f"{words.who} {words.part}".strip()
    return ScriptLine(to=to, do=text.split(None, len(to.split()))[-1])


def _density(text: str) -> Setting:
    name, equals, value = (part.strip() for part in text.partition("="))
    if not (name and equals and value):
        rule = "NAME=K: a species and its objects per m²"
        raise InputError("--density", text, rule, "try --density figure=0.002")
    return Setting(f"--density {name}", f"species.{name}.density", _number(value))


def _number(text: str) -> int | float | str:
    """Read the number that a text means; another text is given back, for the preset to refuse."""
    for read in (int, float):
        with suppress(ValueError):
            return read(text)
    return text


EXCLUDES = (
    ("view.detail", "view.max_parts", "a budget of parts chooses the detail"),
    ("view.detail", "reference", "a reference is as fine as memory allows"),
    ("view.max_parts", "reference", "a reference is as fine as memory allows"),
)
NEEDS = (
    ("tone", "preview", "frames are linear, and only previews have a tone"),
    ("view", "preview", "frames hold all layers, and only previews show one"),
    ("exposure", "preview", "frames are linear, and only previews are exposed"),
    *(
        (name, "words", "it is of a program that is called")
        for name in ("pack", "settings", "repeats", "program", "who", "baseline", "diagnose")
    ),
    ("cluster", "repair", "workers only repair; looking is done here"),
    ("threads", "repair", "threads only repair; looking is done by one"),
    ("max_memory", "repair", "only what is rendered again needs memory"),
)
"""Two flags, or keys of a preset, of which one excludes or needs the other, and why.

A rule is for the commands that have both flags.
"""

GROUPS = (
    ("What is seen", (*VIEW_KEYS, "density", "say", "settings")),
    ("How it is sampled", tuple(QUALITY_KEYS)),
    ("Frames and their files", ("pattern", "frames", *FILE_KEYS, "overwrite")),
    ("Previews", ("preview", "tone", "view", "exposure")),
    ("Pack and program", ("words", "pack", "repeats", "program", "who", "baseline", "diagnose")),
    ("Memory and processors", ("max_memory", "reference", "threads", "cluster")),
)
"""Headings of -h, and the flags below each; what is in no group stands last."""


class StrictCommand(click.Command):
    """A command that refuses what is said twice, and flags that the table sets against another.

    It has --json, which prints what ``json`` says, and is given ``out``, where its results go.
    """

    def __init__(self, *words: Any, json: str = "One JSON object on stdout.", **more: Any) -> None:
        super().__init__(*words, **more)
        if json:
            self.params.append(click.Option(("--json", "as_json"), is_flag=True, help=json))

    def invoke(self, ctx: click.Context) -> Any:
        """Open the results of the command, and call it with them."""
        if "as_json" not in ctx.params:
            return super().invoke(ctx)
        with output(ctx.params.pop("as_json")) as ctx.params["out"]:
            return super().invoke(ctx)

    def format_options(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write the flags in groups."""
        options = (each for each in self.get_params(ctx) if isinstance(each, click.Option))
        flags = {each.name: each.get_help_record(ctx) for each in options}
        rest = [name for name in flags if not any(name in names for _, names in GROUPS)]
        for heading, names in (*GROUPS, ("Options", rest)):
            if rows := [row for name in names if (row := flags.get(name))]:
                with formatter.section(heading):
                    formatter.write_dl(rows)

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        """Parse as click does, then hold what was given against the rules. Raises InputError."""
        words = list(args)
        rest = super().parse_args(ctx, args)
        if not ctx.resilient_parsing:
            *_, order = self.make_parser(ctx).parse_args(args=words)
            check_flags(ctx, order)
        return rest


def check_flags(ctx: click.Context, order: Sequence[click.Parameter]) -> None:
    """Raise InputError where flags contradict; ``order`` has each as often as it was given."""
    said: dict[str, str] = {}
    for key, source in _said_keys(ctx, order):
        if key in said:
            told = f"{said[key]} {source}" if said[key] != source else source
            raise InputError(told, "twice", "each key is said once", "leave one out")
        said[key] = source
    names = {FLAG_KEYS.get(each.name or "", each.name) for each in ctx.command.params}
    for one, other, why in EXCLUDES:
        if one in said and other in said:
            raise InputError(f"{said[one]} {said[other]}", "both", why, "leave one out")
    for one, other, why in NEEDS:
        if one in said and other in names and other not in said:
            flag = "--command" if other == "words" else f"--{other.replace('_', '-')}"
            raise InputError(said[one], "alone", why, f"add {flag}, or leave it out")


def _said_keys(ctx: click.Context, order: Sequence[click.Parameter]) -> Iterator[tuple[str, str]]:
    for parameter in order:
        name = parameter.name or ""
        given = ctx.get_parameter_source(name) == ParameterSource.COMMANDLINE
        if given and not parameter.multiple and isinstance(parameter, click.Option):
            yield FLAG_KEYS.get(name, name), f"--{name.replace('_', '-')}"
    settings = ctx.params.get("settings")
    for text in settings if isinstance(settings, tuple) else ():  # -D, not a program's --settings
        key = text.partition("=")[0].strip()
        yield key, f"-D {key}"
    for text in ctx.params.get("density") or ():
        name = text.partition("=")[0].strip()
        yield f"species.{name}.density", f"--density {name}"


_SPAN = re.compile(r"(\d{1,40})(?:-(\d{1,40})(?:x(\d{1,40}))?)?", re.ASCII)
_MEMORY = re.compile(r"(\d{1,9}(?:\.\d{1,9})?) ?(MB|GB|MiB|GiB)", re.ASCII | re.IGNORECASE)
_UNITS = {"mb": 10**6, "gb": 10**9, "mib": 2**20, "gib": 2**30}


def frame_numbers(text: str) -> tuple[int, ...]:
    """Read the frame numbers of ``1-24``, ``1,5,9`` or ``1-100x10``, each once, ascending.

    ``1-100x10`` is every tenth frame from 1: 1, 11, 21 and so on up to 91.

    Raises InputError for anything else.
    """
    spans = []
    for span in text.split(","):
        match = _SPAN.fullmatch(span.strip())
        if match is None:
            raise InputError("--frames", text, "whole numbers, as 1-24 or 1,5,9", "try 1-24")
        if max(int(each or 0) for each in match.groups()) > LAST_FRAME:
            raise InputError(
                "--frames", text, f"frames are numbered up to {LAST_FRAME}", "try 1-24"
            )
        first, last, step = int(match[1]), int(match[2] or match[1]), int(match[3] or 1)
        if step < 1:
            raise InputError("--frames", text, "a step of at least 1", f"write {first}-{last}x10")
        if last < first:
            raise InputError("--frames", text, "a range runs upwards", f"write {last}-{first}")
        spans.append(range(first, last + 1, step))
    return tuple(sorted(checked_frames(chain(*spans), "--frames", text)))


def memory_limit_bytes(text: str | None) -> int | None:
    """Read --max-memory: the bytes of ``4GB`` or ``2.5GiB``, 0 of ``0`` (no limit), or None.

    Raises InputError for anything else.
    """
    if text is None or text.strip() == "0":
        return None if text is None else 0
    match = _MEMORY.fullmatch(text.strip())
    if match is None or not float(match[1]):
        raise InputError("--max-memory", text, "above 0, in MB, GB, MiB or GiB", "try 4GB")
    return round(float(match[1]) * _UNITS[match[2].lower()])


def memory_flag(command: Command) -> Command:
    """Add --max-memory to a command, which is given its bytes (``memory_limit_bytes``)."""

    def read(context: click.Context, option: click.Parameter, text: str | None) -> int | None:
        return memory_limit_bytes(text)

    about = "Refuse what needs more, as 4GB; 0 = never. By default 80 % of what is free."
    return click.option("--max-memory", metavar="SIZE", callback=read, help=about)(command)


def memory_flag_of_all(command: Command) -> Command:
    """Add --max-memory to a command that renders in many ways: it is kept in the environment."""

    def keep(context: click.Context, option: click.Parameter, text: str | None) -> None:
        most = memory_limit_bytes(text)
        if most is not None:
            from scenes.processes.memory_limit import VARIABLE

            os.environ[VARIABLE] = str(most)

    about = "Refuse pictures that need more, as 4GB; 0 = never. By default 80 % of what is free."
    option = click.option(
        "--max-memory", metavar="SIZE", expose_value=False, callback=keep, help=about
    )
    return option(command)


def check_targets(paths: Sequence[Path]) -> None:
    """Raise InputError where a folder stands in a frame's place."""
    for path in paths:
        if path.is_dir():
            raise InputError("-o", str(path), "a file's place, and a folder is there", "move it")
