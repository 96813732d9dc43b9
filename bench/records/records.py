"""A record is what one run of an experiment measured: raw, immutable, with its provenance.

It holds a point for each case: named columns of raw numbers, beside what was predicted for them. A
column is named by its quantity and by further keys, as ``parts`` with ``air`` hazy and ``size``
over 3 m: claims, tables and plots pick and group columns by these names, and no text is parsed.

The file is JSON, ``experiment-<first 16 of the SHA-256>.json``. The SHA-256 is that of the content
as canonical JSON (sorted keys, no blanks), stands in the file, and is checked on every reading. Run
as a module, this file prints the schema. Pictures that the report lays over each other are small
WebP files as base64 text under ``notes["pictures"]``, inside the record and so under its hash.
"""

import base64
import gzip
import hashlib
import io
import json
import re
import zlib
from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass, field, fields
from functools import cached_property
from pathlib import Path
from typing import Annotated, Any

import numpy as np
from PIL import Image
from pydantic import AfterValidator, StringConstraints, TypeAdapter, ValidationError

from bench.records.claims import JSON_VERDICT, Claim, claim_from
from bench.records.provenance import Provenance
from lod.arrays import Reals
from lod.errors import InputError
from scenes.files import write_text

Key = str | int | float | bool  # the value of a named key of a column


@dataclass(frozen=True)
class Column:
    """Raw numbers of one quantity: one for each field, frame, part or repeat that was measured."""

    quantity: str
    values: list[int]
    keys: dict[str, Key] = field(default_factory=dict)

    @property
    def name(self) -> tuple[str, dict[str, Key]]:
        """The quantity and the further keys, which a prediction of it has, too."""
        return self.quantity, self.keys

    @property
    def label(self) -> str:
        """The name in words: ``parts, air hazy, size 3``."""
        return ", ".join((self.quantity, *(f"{key} {value}" for key, value in self.keys.items())))


@dataclass(frozen=True)
class Prediction:
    """What the law gives for the mean of a quantity, named as the column that it predicts."""

    quantity: str
    value: float
    keys: dict[str, Key] = field(default_factory=dict)


@dataclass(frozen=True)
class Point:
    """One case, what was predicted for it, and its columns of samples.

    ``scene`` is a digest of what was looked at, where the case alone does not say it.
    """

    case: dict[str, Any]
    predicted: tuple[Prediction, ...] = ()
    samples: tuple[Column, ...] = ()
    scene: str = ""

    def column(self, quantity: str, **keys: Key) -> list[int]:
        """Give the numbers of the column with exactly this name.

        Raises InputError where there is none.
        """
        for each in self.samples:
            if each.quantity == quantity and each.keys == keys:
                return each.values
        raise _missing(self, quantity, keys)

    def values(self, quantity: str, **keys: Key) -> Reals:
        """Give a column as float64, (n,). Raises InputError where there is none."""
        return np.array(self.column(quantity, **keys), np.float64)

    def prediction(self, quantity: str, **keys: Key) -> float:
        """Give what was predicted under exactly this name. Raises InputError where nothing was."""
        for each in self.predicted:
            if each.quantity == quantity and each.keys == keys:
                return each.value
        raise _missing(self, quantity, keys)


def columns(samples: Mapping[str, list[int]], **keys: Key) -> tuple[Column, ...]:
    """Make one column of each quantity; all of them have these keys."""
    return tuple(Column(quantity, values, dict(keys)) for quantity, values in samples.items())


def predictions(means: Mapping[str, float], **keys: Key) -> tuple[Prediction, ...]:
    """Make one prediction of each quantity; all of them have these keys."""
    return tuple(Prediction(quantity, float(v), dict(keys)) for quantity, v in means.items())


def where(points: Iterable[Point], **case: Any) -> list[Point]:
    """Give the points whose case has all these values, in their order."""
    return [p for p in points if all(p.case.get(k) == v for k, v in case.items())]


def grouped(points: Iterable[Point], *names: str) -> dict[tuple[Any, ...], list[Point]]:
    """Group points by the values that their cases have under these names, in their order."""
    groups: dict[tuple[Any, ...], list[Point]] = {}
    for point in points:
        groups.setdefault(tuple(point.case.get(name) for name in names), []).append(point)
    return groups


def merge_points(points: Iterable[Point]) -> tuple[Point, ...]:
    """Merge points of one case: equally named columns one after the other, first predictions kept.

    Cases and columns keep the order in which they first come.
    """
    merged: dict[str, tuple[Point, dict[str, Column]]] = {}
    for point in points:
        _, found = merged.setdefault(repr(point.case), (point, {}))
        for each in point.samples:
            name = repr((each.quantity, each.keys))
            before = found[name].values if name in found else []
            found[name] = Column(each.quantity, [*before, *each.values], each.keys)
    return tuple(
        Point(first.case, first.predicted, tuple(found.values()), first.scene)
        for first, found in merged.values()
    )


def point_json(point: Point) -> dict[str, Any]:
    """Give a point as plain data that shares its lists of numbers: they are large."""
    return {
        "case": point.case,
        "predicted": [vars(each) for each in point.predicted],
        "samples": [vars(each) for each in point.samples],
        "scene": point.scene,
    }


def point_from_json(data: Mapping[str, Any]) -> Point:
    """Read a point back from plain data."""
    return Point(
        data["case"],
        tuple(Prediction(**each) for each in data["predicted"]),
        tuple(Column(**each) for each in data["samples"]),
        data["scene"],
    )


def _missing(point: Point, quantity: str, keys: Mapping[str, Key]) -> InputError:
    names = sorted({each.quantity for each in point.samples})
    return InputError("column", (quantity, dict(keys)), f"one of the point's: {', '.join(names)}")


FORMAT = "lodbench-record"
FORMAT_VERSION = 4
"""The version of the file's format; files of other versions are refused.

In version 4 claims are data: estimand, relation, margin, condition and unit of replication.
"""

_IN_NAME = 16

PRESET, PRESET_TEXT = "preset", "preset_text"
"""The notes that hold the name and the text of a user's own preset, where that was measured."""


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
    def subject(self) -> str:
        """The experiment, and the user's own preset where it measured one: ``law of my.toml``."""
        own = self.notes.get(PRESET)
        return f"{self.experiment} of {own}" if own else self.experiment

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
        return content_sha256(self.content)

    @cached_property
    def samples_sha256(self) -> str:
        """The SHA-256 of cases, predictions and counts: one seed gives one, whoever runs it."""
        return content_sha256(self.content["points"])

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
        write_text(path, text)
    except OSError as error:
        rule = f"a folder that can be written ({error.strerror})"
        raise InputError("-o", str(folder), rule, "choose another, or make room") from None
    if read_record(path) != record:
        rule = "what was written reads back the same"
        raise InputError("record", str(path), rule, "free the disk")
    return path


def read_record(path: Path) -> Record:
    """Read and verify a record, plain or compressed by gzip.

    Raises InputError for one that is damaged, edited or too new.
    """

    def refused(rule: str) -> InputError:
        return InputError("record", str(path), rule, "run it again")

    try:
        if not Path(path).is_file():
            raise OSError("no file is there")
        opened = gzip.open if Path(path).suffix == ".gz" else open
        with opened(path, "rb") as file:
            text = file.read(_MOST_BYTES + 1)
        if len(text) > _MOST_BYTES:
            raise OSError(f"it holds more than {_MOST_BYTES} bytes")
        body = json.loads(text)
    except (OSError, EOFError, zlib.error, ValueError, RecursionError) as error:
        raise refused(f"a readable JSON file ({error})") from None
    if not isinstance(body, dict) or body.get("format") != FORMAT:
        raise InputError("record", str(path), f"its format is {FORMAT}", "give a record's path")
    if (arrived := body.get("format_version")) != FORMAT_VERSION:
        rule = f"format version {FORMAT_VERSION}"
        raise InputError(f"record {path}", arrived, rule, "run it again")
    try:
        canonical = _canonical(body.get("content"))
    except (ValueError, RecursionError) as error:
        raise refused(f"finite numbers alone ({error})") from None
    sha256 = hashlib.sha256(canonical.encode()).hexdigest()
    if body.get("sha256") != sha256:
        raise refused("its content has the SHA-256 it names")
    try:
        TypeAdapter(Record).validate_json(canonical, strict=True)
        record = _record(body["content"])  # with numbers as they stand there, for their hash
        pictures_of(record)
    except (ValidationError, TypeError, KeyError) as error:  # of a key too many, or too few
        what = " ".join(str(error).split())[:200]
        raise refused(f"content as the schema has it ({what})") from None
    name = f"{record.experiment}-{sha256[:_IN_NAME]}.json"
    if Path(path).name.removesuffix(".gz") != name or not _NAMED.fullmatch(name):
        raise refused(f"it is named for its experiment and its SHA-256, {name!r}")
    return record


def record_paths(folder: Path) -> list[Path]:
    """List the files of a folder that are named as records are."""
    return sorted(p for p in Path(folder).glob("*-*.json*") if _NAMED.fullmatch(p.name))


def read_records(folder: Path) -> tuple[Record, ...]:
    """Read every record of a folder, ordered by experiment, the newest of each first."""
    records = map(read_record, record_paths(folder))
    newest_first = sorted(records, key=lambda r: r.made, reverse=True)
    return tuple(sorted(newest_first, key=lambda r: r.experiment))


_NAMED = re.compile(rf"[a-z0-9_-]+-[0-9a-f]{{{_IN_NAME}}}\.json(\.gz)?")
_MOST_BYTES = 2**28


def _record(content: dict[str, Any]) -> Record:
    data = dict(content)
    data["provenance"] = Provenance(**data["provenance"])
    data["points"] = tuple(point_from_json(point) for point in data["points"])
    data["claims"] = tuple(claim_from(claim) for claim in data["claims"])
    return Record(**data)


def _canonical(content: Any) -> str:
    return json.dumps(content, sort_keys=True, separators=(",", ":"), allow_nan=False)


def content_sha256(content: Any) -> str:
    """Return the SHA-256 of plain data as canonical JSON: sorted keys, no blanks.

    Raises ValueError for numbers that are not finite.
    """
    return hashlib.sha256(_canonical(content).encode()).hexdigest()


def _text(body: dict[str, Any]) -> str:
    text = json.dumps(body, indent=1, allow_nan=False)
    return re.sub(r"\[\n[-+.e\d,\s]*\]", lambda found: "".join(found[0].split()), text) + "\n"


NOTE = "pictures"


def _base64(text: str) -> str:
    base64.b64decode(text, validate=True)
    return text


@dataclass(frozen=True)
class Pictures:
    """Pictures of one view and one size; ``layers`` are their names and WebP files in base64."""

    name: Annotated[str, StringConstraints(pattern="^[a-z0-9_-]+$")]
    title: str
    caption: str
    alt: str
    layers: tuple[tuple[str, Annotated[str, AfterValidator(_base64)]], ...]


def pictures(
    name: str, words: tuple[str, str, str], layers: Mapping[str, np.ndarray]
) -> dict[str, Any]:
    """Return pictures as a record's notes hold them.

    words   title, caption and text alternative
    layers  display pictures by name, (h, w, 3) uint8, all of one size

    Raises InputError for fewer than two pictures, other sizes and other types.
    """
    shapes = {picture.shape for picture in layers.values()}
    if len(layers) < 2 or len(shapes) != 1 or any(p.dtype != np.uint8 for p in layers.values()):
        raise InputError(f"pictures {name}", sorted(shapes), "two or more of one size, uint8")
    title, caption, alt = words
    coded = []
    for label, picture in layers.items():
        stream = io.BytesIO()
        Image.fromarray(picture).save(stream, "WEBP", quality=80)
        coded.append([label, base64.b64encode(stream.getvalue()).decode()])
    return {"name": name, "title": title, "caption": caption, "alt": alt, "layers": coded}


def pictures_of(record: Record) -> tuple[Pictures, ...]:
    """Return the pictures that a record holds, in their order. Raises ValueError for others."""
    return TypeAdapter(tuple[Pictures, ...]).validate_python(record.notes.get(NOTE, ()))


_SHA256 = {"type": "string", "pattern": "^[0-9a-f]{64}$"}


def record_schema() -> dict[str, Any]:
    """Give the JSON schema (draft 2020-12) of a record's file, made from its data classes.

    ``sha256`` is that of ``content`` as canonical JSON: sorted keys, no blanks. The file is named
    experiment-FIRST_16_DIGITS.json. A claim's verdict is worked out from its numbers.
    """
    content = TypeAdapter(Record).json_schema()
    types = content.pop("$defs")
    said: dict[str, Any] = {key: {"type": "string"} for key in ("name", "sentence")}
    said |= {
        "predicted": {"type": "number"},
        "verdict": {"enum": sorted(set(JSON_VERDICT.values()))},
    }
    types["Claim"]["properties"] |= said
    types["Claim"]["required"] += list(said)
    types["Provenance"]["properties"]["scene"] = _SHA256
    for each in (content, *types.values()):
        each["additionalProperties"] = False
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": f"lodbench record, format version {FORMAT_VERSION}",
        "type": "object",
        "required": ["format", "format_version", "sha256", "content"],
        "additionalProperties": False,
        "properties": {
            "format": {"const": FORMAT},
            "format_version": {"const": FORMAT_VERSION},
            "sha256": _SHA256,
            "content": content,
        },
        "$defs": types,
    }


if __name__ == "__main__":
    print(json.dumps(record_schema(), indent=1))
