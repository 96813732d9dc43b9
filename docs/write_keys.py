"""Write docs/keys.md, the page of all keys, from the models that check presets."""

from itertools import groupby
from pathlib import Path
from typing import Any

from scenes.presets.load import KeyEntry, key_entries

PAGE = Path(__file__).parent / "keys.md"

_HEAD = """# All keys of a preset

A preset is a TOML file; [Presets](presets.md) says how to make one. `lodbench list --keys` prints
this list, `lodbench list --keys meadow` the values of one preset, and `lodbench show meadow` a
whole file to edit. A length is text with its unit, as `"20km"` or `"500m"`; where the unit is m, a
number of metres or such a text, in mm, cm, m or km. NAME is a name that you choose. A key that is
*absent* by default may be left out, and then nothing takes its place.

`make docs` writes this page from the models that check presets, and a test compares the two.
"""


def page() -> str:
    """Write the page: a section for each table, and a row for each of its keys."""
    tables = groupby(key_entries(), key=lambda entry: entry.name.rpartition(".")[0])
    return _HEAD + "".join(_section(name, list(entries)) for name, entries in tables)


def _section(table: str, entries: list[KeyEntry]) -> str:
    title = {"": "At the top", "camera.keys": "`[[camera.keys]]`"}.get(table, f"`[{table}]`")
    rows = [f"| `{e.name.rpartition('.')[2]}` | {' | '.join(_cells(e))} |" for e in entries]
    head = "| key | type | unit | range | default | meaning |\n|---|---|---|---|---|---|"
    return "\n".join(("", f"## {title}", "", head, *rows, ""))


def _cells(entry: KeyEntry) -> tuple[str, ...]:
    default = "required" if entry.required else _value(entry.default)
    return entry.kind, entry.unit, entry.range, default, entry.about


def _value(value: Any) -> str:
    if value is None:
        return "absent"
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, tuple):
        return f"[{', '.join(_value(each) for each in value)}]"
    return f'"{value}"' if isinstance(value, str) else f"{value}"


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
