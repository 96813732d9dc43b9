"""What is a record? What one run of an experiment measured: raw, immutable, with its provenance.

The file is JSON, ``experiment-<first 16 of the SHA-256>.json``. The SHA-256 is that of the content
as canonical JSON (sorted keys, no blanks), stands in the file, and is checked on every reading.
"""

import hashlib
import json
import os
import re
import tempfile
from dataclasses import asdict, dataclass, fields
from functools import cached_property
from pathlib import Path
from typing import Any

from bench.records.claims import Claim, claim_from
from bench.records.points import Point, point_from_json, point_json
from bench.records.provenance import Provenance
from lod.errors import InputError

FORMAT = "lodbench-record"
FORMAT_VERSION = 3
"""The version of the file's format; files of other versions are refused.

In version 3 samples and predictions are columns that are named by quantity and keys.
"""

_IN_NAME = 16


@dataclass(frozen=True)
class Record:
    """A record holds what one run measured; ``notes`` say how it was run, and are never judged."""

    experiment: str
    version: int
    quick: bool
    made: str
    provenance: Provenance
    points: tuple[Point, ...]
    claims: tuple[Claim, ...]
    notes: dict[str, Any]

    @property
    def content(self) -> dict[str, Any]:
        """The whole record as plain data."""
        data = {f.name: getattr(self, f.name) for f in fields(self)}
        data["provenance"] = asdict(self.provenance)
        data["points"] = [point_json(point) for point in self.points]
        data["claims"] = [claim.as_json() for claim in self.claims]
        return data

    @cached_property
    def sha256(self) -> str:
        """The SHA-256 of the whole content."""
        return _hash(self.content)

    @cached_property
    def samples_sha256(self) -> str:
        """The SHA-256 of cases, predictions and counts: one seed gives one, whoever runs it."""
        return _hash(self.content["points"])

    @property
    def name(self) -> str:
        """The name of the record's file."""
        return f"{self.experiment}-{self.sha256[:_IN_NAME]}.json"


def write_record(record: Record, folder: Path) -> Path:
    """Write a record whole or not at all, read it back, and return its path.

    Raises InputError for a folder that cannot be written, and where the file reads back otherwise.
    """
    path = Path(folder) / record.name
    body = {"format": FORMAT, "format_version": FORMAT_VERSION, "sha256": record.sha256}
    text = _text(body | {"content": record.content})
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        _replace(path, text)
    except OSError as error:
        raise InputError(
            "-o",
            str(folder),
            f"a folder that can be written ({error.strerror})",
            "choose another, or make room",
        ) from None
    if read_record(path) != record:
        raise InputError(
            "record", str(path), "what was written reads back the same", "free the disk"
        )
    return path


def read_record(path: Path) -> Record:
    """Read and verify a record. Raises InputError for one that is damaged, edited or too new."""
    try:
        body = json.loads(Path(path).read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise InputError(
            "record", str(path), f"a readable JSON file ({error})", "run it again"
        ) from None
    if not isinstance(body, dict) or body.get("format") != FORMAT:
        raise InputError("record", str(path), f"its format is {FORMAT}", "give a record's path")
    if body.get("format_version") != FORMAT_VERSION:
        arrived = body.get("format_version")
        raise InputError(
            f"record {path}", arrived, f"format version {FORMAT_VERSION}", "run it again"
        )
    try:
        sha256 = _hash(body.get("content"))
    except ValueError as error:
        rule = f"finite numbers alone ({error})"
        raise InputError("record", str(path), rule, "run it again") from None
    if body.get("sha256") != sha256 or sha256[:_IN_NAME] not in Path(path).name:
        raise InputError(
            "record", str(path), "its content has the SHA-256 it names", "run it again"
        )
    try:
        return _record(body["content"])
    except (TypeError, ValueError, KeyError, AttributeError) as error:
        rule = f"content as the schema has it ({type(error).__name__}: {error})"
        raise InputError("record", str(path), rule, "run it again") from None


def read_records(folder: Path) -> tuple[Record, ...]:
    """Read every record of a folder, ordered by experiment, the newest of each first."""
    paths = sorted(p for p in Path(folder).glob("*-*.json") if _NAMED.fullmatch(p.name))
    newest_first = sorted((read_record(path) for path in paths), key=lambda r: r.made, reverse=True)
    return tuple(sorted(newest_first, key=lambda r: r.experiment))


_NAMED = re.compile(rf"[a-z_]+-[0-9a-f]{{{_IN_NAME}}}\.json")


def _record(content: dict[str, Any]) -> Record:
    data = dict(content)
    data["provenance"] = Provenance(**data["provenance"])
    data["points"] = tuple(point_from_json(point) for point in data["points"])
    data["claims"] = tuple(claim_from(claim) for claim in data["claims"])
    return Record(**data)


def _hash(content: Any) -> str:
    canonical = json.dumps(content, sort_keys=True, separators=(",", ":"), allow_nan=False)
    return hashlib.sha256(canonical.encode()).hexdigest()


def _text(body: dict[str, Any]) -> str:
    """Write readable JSON, with each list of numbers on one line."""
    text = json.dumps(body, indent=1, allow_nan=False)
    return re.sub(r"\[\n[-+.e\d,\s]*\]", lambda found: "".join(found[0].split()), text) + "\n"


def _replace(path: Path, text: str) -> None:
    handle, temporary = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name}.")
    try:
        with os.fdopen(handle, "w", encoding="utf-8") as file:
            file.write(text)
            file.flush()
            os.fsync(file.fileno())
        os.chmod(temporary, 0o644)
        os.replace(temporary, path)
    except BaseException:
        os.unlink(temporary)
        raise
