"""Is a record of older code? Marked where its sources are others and its probe has changed."""

from bench.experiment import experiments
from bench.records.probe import NOTE, SOURCES, has_changed, take_probe
from bench.records.records import Record
from bench.runs import sources

NO_PROBE = (
    "Of older code: this record keeps no probe by which to tell whether it would come out so."
)
CHANGED = "Of older code: the frame that this record keeps as a probe comes out otherwise today."
OTHER_VERSION = "Of older code: its experiment asks something else today."


def stale(record: Record) -> str:
    """Say in a sentence that a record is of older code; an empty text where it is not.

    A frame is rendered only where the sources are others than those that made the record.
    """
    experiment = experiments().get(record.experiment)
    if experiment is not None and experiment.version != record.version:
        return OTHER_VERSION
    probe = record.notes.get(NOTE)
    if probe is None:
        return NO_PROBE
    if record.notes.get(SOURCES) == sources():
        return ""
    return CHANGED if has_changed(probe, take_probe(probe["preset"])) else ""
