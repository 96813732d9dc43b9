"""Presets are TOML files: found by name or path, checked key by key, changed, and written again.

The imported models of a preset are held to the hash of what they were when it was read.
"""

import os
import re
import tomllib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from importlib import resources
from pathlib import Path
from typing import Any

import numpy as np
from pydantic import ValidationError

from lod.errors import InputError
from scenes.model_files.names import built_in_names
from scenes.presets.keys import (
    NAMED,
    KeyEntry,
    explain,
    key_entries,
    known_keys,
    nearest_key,
    nearest_name,
    value_at,
)
from scenes.presets.schema import Preset

MODEL_TABLES = "species", "placed", "actors", "troupes"
"""The tables of a preset whose members each name a model."""

_LONGEST_FILE = 1_000_000


@dataclass(frozen=True)
class Setting:
    """One key of a preset set from outside it; errors blame ``source``, usually a flag."""

    source: str
    key: str
    value: Any


def setting(text: str) -> Setting:
    """Parse ``key=value`` of -D: a dotted key and a TOML value; what is no TOML is text."""
    key, equals, value = (part.strip() for part in text.partition("="))
    if not (key and equals and value):
        raise InputError("-D", text, "key=value with a dotted key", "try -D camera.height=200")
    return Setting(f"-D {key}", key, _toml_value(value))


def load_preset(name_or_path: str | Preset, overrides: Sequence[str | Setting] = ()) -> Preset:
    """Load the preset of that name, or in that .toml file, with -D settings over it; or take one.

    Raises InputError, in one line, for anything a user can get wrong.
    """
    if isinstance(name_or_path, Preset):
        return preset_from(name_or_path.model_dump(mode="json"), overrides)
    source, text = _find(name_or_path)
    is_file = source == name_or_path
    folder = Path(source).parent if is_file else Path()
    return preset_from(_parse(source, text), overrides, source, folder)


def preset_from(
    data: Mapping[str, Any],
    overrides: Sequence[str | Setting] = (),
    source: str = "preset",
    folder: Path = Path(),
) -> Preset:
    """Make a preset from plain nested data (as of ``Preset.model_dump``), with settings over it.

    Scene files that it names lie in ``folder``. The preset holds the hash of every imported model.
    Raises InputError for what cannot be, and for a model that is another than its hash says.
    """
    try:
        tables = _plain(data)
    except RecursionError:
        raise InputError(source, "tables", "tables nested less deeply", "take some away") from None
    settings = [setting(each) if isinstance(each, str) else each for each in overrides]
    for each in settings:
        _lay(tables, each)

    def blame(key: str) -> str:
        for each in reversed(settings):
            if key == each.key or key.startswith((f"{each.key}.", f"{each.key}[")):
                return each.source + key[len(each.key) :]
        return f"{source}: {key}"

    try:
        preset = Preset.model_validate(tables)
    except ValidationError as error:
        raise explain(error, blame, _names(tables)) from None
    built_in, changed = built_in_names(), {}
    for kind in MODEL_TABLES:
        tables = dict(getattr(preset, kind))
        for name, table in tables.items():
            if table.model not in built_in:
                from scenes.imported.library import model_digest

                where = blame(f"{kind}.{name}.model")
                digest = model_digest(where, table.model, folder, table.model_sha256)
                tables[name] = table.model_copy(update={"model_sha256": digest})
                changed[kind] = tables
    return preset.model_copy(update=changed) if changed else preset


def preset_values(preset: Preset) -> dict[str, Any]:
    """Give the value of every dotted key of a preset, as plain data that -D takes."""
    named = {table: list(getattr(preset, table)) for table in NAMED}
    data = preset.model_dump(mode="json")
    return {key: value_at(data, key) for key in known_keys(named)}


@cache
def preset_names() -> tuple[tuple[str, str], ...]:
    """List (name, about) of every preset that comes with the package, by name."""
    return tuple((name, load_preset(name).about) for name in _names_on_the_shelf())


def _shelf() -> Any:
    return resources.files("scenes") / "presets"


def _names_on_the_shelf() -> list[str]:
    names = (each.name for each in _shelf().iterdir())
    return sorted(name.removesuffix(".toml") for name in names if name.endswith(".toml"))


def _find(name_or_path: str) -> tuple[str, str]:
    if name_or_path.endswith(".toml") or "/" in name_or_path:
        return name_or_path, _read(name_or_path)
    names = _names_on_the_shelf()
    if name_or_path not in names:
        cure = f"{nearest_name(name_or_path, names)} (see `lodbench list`; a path ends in .toml)"
        raise InputError("PRESET", name_or_path, "no preset of that name", cure)
    return f"preset {name_or_path}", (_shelf() / f"{name_or_path}.toml").read_text("utf-8")


def _read(path: str) -> str:
    try:
        if not Path(path).is_file():
            what = "it is a folder" if Path(path).is_dir() else "no such file"
            raise InputError("PRESET", path, "the path of a TOML file", what)
        if Path(path).stat().st_size > _LONGEST_FILE:
            rule = f"a preset of at most {_LONGEST_FILE} bytes"
            raise InputError("PRESET", path, rule, "shorten it")
        return Path(path).read_text("utf-8-sig")  # some editors begin a file with a mark
    except UnicodeDecodeError as error:
        rule, cure = "TOML is UTF-8 text", f"byte {error.start} is not"
        raise InputError("PRESET", path, rule, cure) from None
    except OSError as error:
        raise InputError("PRESET", path, "a file that can be read", str(error.strerror)) from None


def _parse(source: str, text: str) -> dict[str, Any]:
    try:
        return tomllib.loads(text)
    except RecursionError:
        raise InputError(source, "brackets", "TOML nested less deeply", "take some away") from None
    except ValueError as error:
        at = re.search(r"line (\d+)", str(error))
        lines = text.splitlines()
        line = lines[int(at[1]) - 1] if at and int(at[1]) <= len(lines) else text[-40:]
        cure = "mend that line (toml.io has the grammar)"
        raise InputError(source, line.strip(), f"not TOML: {error}", cure) from None


def _toml_value(text: str) -> Any:
    if text[:2].lower() in ("0x", "0o", "0b"):
        return text  # a size such as 0x360, not a number in base 16
    if ratio := re.fullmatch(r"(\d{1,9})/(\d{1,9})", text):  # as rates of films are written
        return int(ratio[1]) / int(ratio[2]) if int(ratio[2]) else text
    try:
        table = tomllib.loads(f"value = {text}")
    except (ValueError, RecursionError):
        return text
    return table["value"] if list(table) == ["value"] else text


def _plain(data: Any) -> Any:
    """Nested data with its own tables, tuples for lists, Python's numbers, and text for paths."""
    data = os.fspath(data) if isinstance(data, os.PathLike) else data
    data = data.tolist() if isinstance(data, np.ndarray | np.generic) else data
    if isinstance(data, Mapping):
        return {name: _plain(value) for name, value in data.items()}
    if isinstance(data, list | tuple):
        return tuple(_plain(value) for value in data)
    return data


def _names(tables: Mapping[str, Any]) -> dict[str, list[str]]:
    found = {kind: tables.get(kind) for kind in NAMED}
    return {kind: list(each) for kind, each in found.items() if isinstance(each, Mapping)}


def _lay(tables: dict[str, Any], each: Setting) -> None:
    """Lay one setting over the tables. Raises InputError for a key that no preset has."""
    names = _names(tables)
    known = known_keys(names)
    opened = {key.rpartition(".")[0] for key in known} - {""} | NAMED.keys()
    *path, name = each.key.split(".")
    if len(path) == 2 and path[0] in NAMED and path[1] not in names.get(path[0], ()):
        new = f"a new one is a table [{path[0]}.{path[1]}] in a file, as `lodbench show` writes one"
        cure = f"{new}; {nearest_name(path[1], names.get(path[0], ()))}"
        raise InputError(each.source, each.value, f"no {path[0]} {path[1]} in this preset", cure)
    if each.key not in known and each.key not in opened and path not in ([k] for k in NAMED):
        raise InputError(each.source, each.value, "no such key", nearest_key(each.key, known))
    for step in path:
        inner = tables[step] = {} if tables.get(step) is None else tables[step]
        if not isinstance(inner, dict):
            raise InputError(each.source, inner, f"{step} is a table of keys", f"leave {step} out")
        tables = inner
    tables[name] = _plain(each.value)


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
        lead = f"{known}.{name}.".removeprefix(".")
        if entry is None and any(each.startswith(lead) for each in entries):
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


def _line(name: str, value: Any, entry: KeyEntry | None) -> str:
    unit = f" [{entry.unit}]" if entry and entry.unit else ""
    about = f"{entry.about}{unit}" if entry else ""
    if value is None:
        return f"# {name} is absent: {about}"
    import tomlkit  # slow to import, and few commands write presets

    item = tomlkit.inline_table() if isinstance(value, dict) else tomlkit.item(value)
    if isinstance(value, dict):  # of free keys: on one line
        item.update(value)
    text = f"{name} = {item.as_string()}"
    return f"{text}  # {about}" if about else text


def has_acting(preset: Preset) -> bool:
    """Tell whether a preset has live actors, or a camera that acts."""
    return bool(preset.actors or preset.troupes or preset.script or preset.camera.behaviour)
