"""`lodbench list`: what there is to choose from, a line each."""

import dataclasses
import json
from typing import TYPE_CHECKING, Any

import click

from bench.cli.flags import StrictCommand
from bench.cli.output import output, table

if TYPE_CHECKING:
    from scenes.presets.keys import KeyEntry


@click.command("list", cls=StrictCommand)
@click.option(
    "--keys",
    "preset",
    is_flag=False,
    flag_value="",
    metavar="[PRESET]",
    help="The keys of presets with their meaning; with a name, that preset's values.",
)
@click.option("--json", "as_json", is_flag=True, help="One JSON object on stdout.")
def command(preset: str | None, as_json: bool) -> None:
    """Presets, metrics, what other packages bring, your models, experiments and studies."""
    if preset is not None:
        _keys(preset, as_json)
        return
    from bench.experiment import experiments
    from bench.studies.registry import study_descriptions
    from lod.metric import METRICS, Metric
    from scenes.actors.behaviours import described_behaviours
    from scenes.model_files.names import models_folder, user_model_names
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
        "studies": study_descriptions(),
    }
    with output(as_json) as out:
        out.record(sections)
        for title, entries in sections.items():
            if entries:
                out.say(f"{title}\n{table(entries.items())}")


def _keys(preset: str, as_json: bool) -> None:
    """List all keys that -D takes, or those of one preset with its values."""
    from scenes.presets.keys import key_entries
    from scenes.presets.load import load_preset, preset_values

    rows: list[tuple[Any, ...]]
    if preset:
        values = preset_values(load_preset(preset))
        data = {name: {"value": value} for name, value in values.items()}
        rows = [(name, _text(value)) for name, value in values.items()]
    else:
        entries = key_entries()
        data = {each.name: dataclasses.asdict(each) for each in entries}
        rows = [("key", "is", "in", "range", "by default", "meaning")]
        rows += [(e.name, e.kind, e.unit, e.range, _default(e), e.about) for e in entries]
    with output(as_json) as out:
        out.record({"keys": data})
        out.say(table(rows))


def _default(entry: "KeyEntry") -> str:
    return "required" if entry.required else _text(entry.default)


def _text(value: Any) -> str:
    """Write a value as -D takes it; what is absent has none."""
    if value is None:
        return "absent"
    return json.dumps(value) if not isinstance(value, str) else value
