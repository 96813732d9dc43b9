"""`lodbench list`: what there is to choose from, a line each."""

import dataclasses
import json
from pathlib import Path
from typing import Any

import click

from bench.cli.flags import StrictCommand
from bench.cli.output import Output, table, tell_first_run
from lod.errors import InputError


@click.command("list", cls=StrictCommand, json="One JSON object on stdout, or per object.")
@click.option(
    "--keys",
    "preset",
    is_flag=False,
    flag_value="",
    metavar="[PRESET]",
    help="The keys of presets with their meaning; with a name, that preset's values.",
)
@click.option(
    "--objects", "frame", metavar="OUT/NAME.0001.exr", help="The objects of a rendered frame."
)
@click.option("--object", "only", type=int, multiple=True, help="With --objects, only this id.")
def command(preset: str | None, frame: str | None, only: tuple[int, ...], out: Output) -> None:
    """List presets, metrics, experiments, your models and what other packages bring.

    --objects: species, cell, number and 128-bit key of each object that a frame displays.
    """
    if preset is not None:
        _keys(preset, out)
        return
    if frame is not None:
        _objects(Path(frame), only, out)
        return
    from bench.experiment import experiments
    from lod.metric import METRICS, Metric
    from scenes.actors.behaviours import described_behaviours
    from scenes.model_files import models_folder, user_model_names
    from scenes.plugins import METRIC, REPRESENTATION, RepresentationPlugin, described
    from scenes.presets.load import preset_names

    sections = {
        "presets": dict(preset_names()),
        "metrics": {name: metric.about for name, metric in METRICS.items()}
        | dict(described(METRIC, Metric)),
        "representations": dict(described(REPRESENTATION, RepresentationPlugin)),
        "models": dict.fromkeys(user_model_names(), f"added by `model add`, in {models_folder()}"),
        "behaviours": dict(described_behaviours()),
        "experiments": {
            topic if topic == name else f"{name}: {topic}": told.about
            for name, each in experiments().items()
            for topic, told in each.topics.items()
        },
    }
    out.record(sections)
    for title, entries in sections.items():
        if entries:
            out.say(f"{title}\n{table(entries.items())}")


def _keys(preset: str, out: Output) -> None:
    from scenes.presets.load import key_entries, load_preset, preset_values

    rows: list[tuple[Any, ...]]
    if preset:
        values = preset_values(load_preset(preset))
        data = {name: {"value": value} for name, value in values.items()}
        rows = [(name, _text(value)) for name, value in values.items()]
    else:
        entries = key_entries()
        data = {each.name: dataclasses.asdict(each) for each in entries}
        rows = [("key", "is", "in", "range", "by default", "meaning")]
        for e in entries:
            default = "required" if e.required else _text(e.default)
            rows.append((e.name, e.kind, e.unit, e.range, default, e.about))
    out.record({"keys": data})
    out.say(table(rows))


def _text(value: Any) -> str:
    """Write a value as -D takes it; what is absent has none."""
    if value is None:
        return "absent"
    return json.dumps(value) if not isinstance(value, str) else value


def _objects(path: Path, only: tuple[int, ...], out: Output) -> None:
    from scenes.render.exr.frames_on_disk import read_whole
    from scenes.render.exr.header import preset_from_settings
    from scenes.render.memory import preflight
    from scenes.render.object_keys import identities
    from scenes.scene import Scene

    whole = read_whole(path)
    scene, frame = Scene(preset_from_settings(whole.settings)), whole.frame
    tell_first_run()
    preflight(scene, (frame,))
    found = list(identities(scene, frame))
    if unknown := sorted(set(only) - {each.object for each in found}):
        rule = f"an id.object that {path} displays"
        raise InputError("--object", unknown[0], rule, "leave it out to list them")
    rows: list[tuple[Any, ...]] = [("object", "of", "cell", "index", "key")]
    for each in found:
        if not only or each.object in only:
            out.record(dataclasses.asdict(each))
            cell = "–" if each.cell is None else f"{each.cell[0]},{each.cell[1]}"
            rows.append((each.object, each.of, cell, each.index, each.key or "–"))
    out.say(table(rows))
