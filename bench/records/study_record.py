"""What a study measured, as one JSON file: settings, figures, and what made them.

Pages of the manual quote figures from these files (``docs/write_figures.py``).
"""

import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from bench.records.provenance import provenance, scene_digest
from lod.errors import InputError
from scenes.files import whole_file


@dataclass(frozen=True)
class StudyRecord:
    """Figures of a study.

    study        its name, as `lodbench list` shows it
    settings     what it was asked for, by name
    figures      what it measured, by name; units are in the names
    provenance   what made them (``bench.records.provenance``)
    """

    study: str
    settings: Mapping[str, Any]
    figures: Mapping[str, Any]
    provenance: Mapping[str, Any]


def study_record(
    study: str, settings: Mapping[str, Any], figures: Mapping[str, Any], variant: str | None = None
) -> StudyRecord:
    """Make the record of figures that were measured here and now, with seed 0 and one thread."""
    made_by = asdict(provenance(scene_digest(settings), 0, variant=variant))
    return StudyRecord(study, settings, figures, made_by)


def write_study_record(path: Path, record: StudyRecord) -> None:
    """Write a record; an earlier one of that name is replaced. Raises OSError."""
    with whole_file(path, overwrite=True) as temporary:
        temporary.write_text(
            json.dumps(asdict(record), indent=1, allow_nan=False) + "\n", encoding="utf-8"
        )


def read_study_record(path: Path) -> StudyRecord:
    """Read a record. Raises FileNotFoundError without one, and InputError for anything else."""
    text = path.read_text(encoding="utf-8")
    try:
        return StudyRecord(**json.loads(text))
    except (ValueError, TypeError) as error:
        cure = "`lodbench study NAME --record FILE` writes one"
        raise InputError("record", str(path), f"the record of a study ({error})", cure) from None
