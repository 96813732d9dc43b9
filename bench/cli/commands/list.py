"""`lodbench list`: what there is to choose from, a line each."""

import click

from bench.cli.output import output, table


@click.command("list")
@click.option("--json", "as_json", is_flag=True, help="One JSON object on stdout.")
def command(as_json: bool) -> None:
    """Presets, metrics, what other packages bring, experiments and studies."""
    from bench.experiments.registry import EXPERIMENTS
    from bench.studies.registry import study_descriptions
    from lod.metric.family import METRICS, Metric
    from scenes.plugins.entry_points import METRIC, REPRESENTATION, described
    from scenes.plugins.representation import RepresentationPlugin
    from scenes.preset.load import preset_names

    sections = {
        "presets": dict(preset_names()),
        "metrics": {name: metric.about for name, metric in METRICS.items()}
        | dict(described(METRIC, Metric)),
        "representations": dict(described(REPRESENTATION, RepresentationPlugin)),
        "experiments": {name: each.about for name, each in EXPERIMENTS.items()},
        "studies": study_descriptions(),
    }
    with output(as_json) as out:
        out.record(sections)
        for title, entries in sections.items():
            if entries:
                out.say(f"{title}\n{table(entries.items())}")
