"""A preset as a TOML file that says every key, its value and what it means, ready to edit."""

from collections.abc import Iterator
from typing import Any

import tomlkit
import tomlkit.items

from scenes.preset.keys import NAMED, KeyEntry, key_entries
from scenes.preset.tables import Preset


def preset_toml(preset: Preset) -> str:
    """Write a preset as TOML text, which ``load_preset`` reads back as an equal preset.

    Every key stands there with its value and, as a comment, its meaning and unit. A key that is
    absent stands in a comment of its own, because TOML has no value for that.
    """
    entries = {entry.name: entry for entry in key_entries()}
    data = preset.model_dump(mode="json")
    named = {name: data.pop(name) for name in NAMED}
    lines = list(_table("", "", data, entries))
    for kind, tables in named.items():
        for name, table in tables.items():
            lines += _table(f"{kind}.{name}", f"{kind}.NAME", table, entries)
    return "\n".join(lines).strip() + "\n"


def _table(
    path: str, known: str, data: dict[str, Any], entries: dict[str, KeyEntry]
) -> Iterator[str]:
    """Write a table and those inside it; ``known`` is its path among the entries."""
    if path:
        yield f"\n[{path}]"
    inner = {}
    for name, value in data.items():
        entry = entries.get(f"{known}.{name}".removeprefix("."))
        if entry is None and _holds_tables(name, known, entries):
            inner[name] = value
        else:
            yield _line(name, value, entry)
    for name, value in inner.items():
        below = f"{path}.{name}".removeprefix(".")
        if isinstance(value, list | tuple):
            for each in value:
                yield f"\n[[{below}]]"
                yield from (_line(k, v, entries.get(f"{below}.{k}")) for k, v in each.items())
        elif value is None:
            yield f"\n# [{below}] is absent."
        else:
            yield from _table(below, below, value, entries)


def _holds_tables(name: str, known: str, entries: dict[str, KeyEntry]) -> bool:
    lead = f"{known}.{name}.".removeprefix(".")
    return any(each.startswith(lead) for each in entries)


def _item(value: Any) -> tomlkit.items.Item:
    """Make a TOML value; a table of free keys stands on one line."""
    if not isinstance(value, dict):
        return tomlkit.item(value)
    table = tomlkit.inline_table()
    table.update(value)
    return table


def _line(name: str, value: Any, entry: KeyEntry | None) -> str:
    unit = f" [{entry.unit}]" if entry and entry.unit else ""
    about = f"{entry.about}{unit}" if entry else ""
    if value is None:
        return f"# {name} is absent: {about}"
    text = f"{name} = {_item(value).as_string()}"
    return f"{text}  # {about}" if about else text
