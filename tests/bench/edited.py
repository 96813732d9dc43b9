"""Points with a column of samples changed, and records of points, for tests of what follows."""

from dataclasses import replace

from bench.records.provenance import provenance
from bench.records.records import Record


def edited(point, quantity, change, **keys):
    """The point with ``change`` made to the values of one column."""
    before = point.column(quantity, **keys)
    samples = tuple(
        replace(each, values=change(before)) if each.values is before else each
        for each in point.samples
    )
    return replace(point, samples=samples)


def record_of(experiment, points):
    """A record of these points of an experiment, judged."""
    here, points = provenance("ab" * 32, 0), tuple(points)
    made, claims = "2026-01-01T00:00:00Z", experiment.judged(points)
    return Record(experiment.name, experiment.version, True, made, here, points, claims, {})


def with_cases(experiment, topic, cases):
    """The experiment with these cases of a topic."""
    changed = replace(experiment.topics[topic], cases=lambda **sizes: cases)
    return replace(experiment, topics={**experiment.topics, topic: changed})


def svg_of(plot):
    """All that is drawn of a figure, as one text."""
    return plot.key + "".join(each.svg for each in plot.drawings)
