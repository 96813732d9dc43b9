"""`lodbench list`: what there is to choose from, a line each."""

import click

from bench.output import output, table


@click.command("list")
@click.option("--json", "as_json", is_flag=True, help="One JSON object on stdout.")
def command(as_json: bool) -> None:
    """Presets, metrics and experiments."""
    from bench.experiments import EXPERIMENTS
    from lod.metric import METRICS
    from scenes.preset import preset_names

    sections = {
        "presets": dict(preset_names()),
        "metrics": {name: metric.about for name, metric in METRICS.items()},
        "experiments": {name: each.about for name, each in EXPERIMENTS.items()},
    }
    with output(as_json) as out:
        out.record(sections)
        for title, entries in sections.items():
            out.say(f"{title}\n{table(entries.items())}")
