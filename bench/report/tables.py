"""Which numbers does the report give to programs? All claims and points, with record hashes."""

import csv
import io
import json
from collections.abc import Iterable, Sequence

from bench.report.document import Section

TABLES = "tables"
"""Folder of the points, with a file for each record."""

_CLAIM = (
    *("name", "verdict", "estimand", "relation", "value", "margin", "measured", "low", "high"),
    *("unit", "where", "source", "kind", "sentence"),
)


def claims_csv(sections: Sequence[Section]) -> str:
    """Write a CSV row for each claim."""
    heads = "experiment", "quick", "record_sha256", *_CLAIM
    rows = (
        (s.record.experiment, s.record.quick, s.record.sha256, *(getattr(c, k) for k in _CLAIM))
        for s in sections
        for c in s.claims
    )
    return _csv(heads, rows)


def claims_json(sections: Sequence[Section]) -> str:
    """Write a JSON object for each record."""
    data = [
        {
            "experiment": s.record.experiment,
            "quick": s.record.quick,
            "record_sha256": s.record.sha256,
            "commit": s.record.provenance.commit,
            "claims": [claim.as_json() for claim in s.claims],
        }
        for s in sections
    ]
    return json.dumps(data, indent=1, ensure_ascii=False, allow_nan=False) + "\n"


def points_csv(section: Section) -> str:
    """Write the record's point table as CSV, as it is on the page."""
    heads, rows = section.point_table
    sha256 = section.record.sha256
    return _csv(("record_sha256", *heads), ((sha256, *row) for row in rows))


def _csv(heads: Sequence[str], rows: Iterable[Sequence[object]]) -> str:
    stream = io.StringIO()
    writer = csv.writer(stream, lineterminator="\n")
    writer.writerow(heads)
    writer.writerows(rows)
    return stream.getvalue()
