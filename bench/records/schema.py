"""What is the JSON schema of a record's file? Run as a module, it is printed."""

import json
from typing import Any, get_args

from pydantic import TypeAdapter

from bench.records.claims import Verdict
from bench.records.records import FORMAT, FORMAT_VERSION, Record

_SHA256 = {"type": "string", "pattern": "^[0-9a-f]{64}$"}


def record_schema() -> dict[str, Any]:
    """Give the JSON schema (draft 2020-12) of a record's file, made from its data classes.

    ``sha256`` is that of ``content`` as canonical JSON: sorted keys, no blanks. The file is named
    experiment-FIRST_16_DIGITS.json. A claim's verdict is worked out from its numbers.
    """
    content = TypeAdapter(Record).json_schema()
    types = content.pop("$defs")
    types["Claim"]["properties"]["verdict"] = {"enum": list(get_args(Verdict))}
    types["Claim"]["required"] += ["relation", "verdict"]
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
