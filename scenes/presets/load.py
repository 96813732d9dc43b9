"""Presets are TOML files: found by name or path, checked key by key, changed, and written again.

The imported models of a preset are held to the hash of what they were when it was read. Every key
can be said in words, and an error about one is one line.
"""

import difflib
import os
import re
import tomllib
import types
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from importlib import resources
from pathlib import Path
from typing import Annotated, Any, Literal, Union, get_args, get_origin

import numpy as np
from pydantic import BaseModel, ValidationError
from pydantic.fields import FieldInfo
from pydantic_core import ErrorDetails

from lod.errors import InputError
from scenes.model_files import built_in_names
from scenes.presets.schema import (
    ActorPreset,
    PlacedPreset,
    PlumePreset,
    Preset,
    RepresentationPreset,
    SpeciesPreset,
    TroupePreset,
)
from scenes.presets.values import is_length

NAMED: dict[str, type[BaseModel]] = {
    "species": SpeciesPreset,
    "placed": PlacedPreset,
    "plumes": PlumePreset,
    "representations": RepresentationPreset,
    "actors": ActorPreset,
    "troupes": TroupePreset,
}
"""Tables of tables whose names the user chooses."""

_KINDS = {int: "whole number", float: "number", str: "text", bool: "true or false"}
_UNIT = re.compile(r" ?\[([^\]]*)\]")


@dataclass(frozen=True)
class KeyEntry:
    """One key of a preset, in words: all that `lodbench list --keys` and the page of keys say.

    default is None for a key that is absent by default, and for one that is required.
    """

    name: str
    kind: str
    unit: str
    range: str
    required: bool
    default: Any
    about: str


def walk_keys(
    named: Mapping[str, Iterable[str]], model: type[BaseModel] = Preset, lead: str = ""
) -> Iterator[tuple[str, FieldInfo]]:
    """Walk all dotted keys of a preset in which these tables have these names, with their fields.

    The tables are followed in the order in which the models declare them.
    """
    for name, field in model.model_fields.items():
        if model is Preset and name in NAMED:
            for each in named.get(name, ()):
                yield from walk_keys({}, NAMED[name], f"{name}.{each}.")
        elif table := table_of(field.annotation):
            yield from walk_keys(named, table, f"{lead}{name}.")
        else:
            yield lead + name, field


def known_keys(named: Mapping[str, Iterable[str]]) -> list[str]:
    """List every dotted key of a preset in which these tables have these names."""
    return [name for name, _ in walk_keys(named)]


def table_of(annotation: Any) -> type[BaseModel] | None:
    """Find the table that a field is, or may be left out as; None for a plain key."""
    for each in (annotation, *get_args(annotation)):
        if isinstance(each, type) and issubclass(each, BaseModel):
            return each
    return None


def key_entries() -> list[KeyEntry]:
    """Describe every key, with NAME in place of a table's name that the user chooses."""
    return [_entry(*each) for each in walk_keys(dict.fromkeys(NAMED, ("NAME",)))]


def _entry(name: str, field: FieldInfo) -> KeyEntry:
    about = field.title or ""
    unit = _UNIT.search(about)
    return KeyEntry(
        name=name,
        kind="length" if is_length(field) else _kind(field.annotation),
        unit=unit[1] if unit else "",
        range=field.description or "",
        required=field.is_required(),
        default=None if field.is_required() else field.get_default(call_default_factory=True),
        about=_UNIT.sub("", about).strip(),
    )


def _kind(annotation: Any) -> str:
    origin, inner = get_origin(annotation), get_args(annotation)
    if origin is Annotated:
        return _kind(inner[0])
    if origin is Literal:
        return " or ".join(f'"{each}"' for each in inner)
    if origin in (Union, types.UnionType):
        return " or ".join(dict.fromkeys(_kind(e) for e in inner if e is not type(None)))
    if origin is tuple:
        return f"list of {'' if Ellipsis in inner else f'{len(inner)} '}{_kind(inner[0])}s"
    return "table" if origin is dict else _KINDS[annotation]


Blame = Callable[[str], str]

_RULES = {
    "int_type": "a whole number",
    "int_from_float": "a whole number",
    "float_type": "a number",
    "finite_number": "a finite number",
    "string_type": "text in quotes",
    "bool_type": "true or false",
    "tuple_type": "a list in square brackets",
    "model_type": "a table of keys",
    "dict_type": "a table of keys",
    "string_pattern_mismatch": "a name of letters, digits, - and _, letter first",
}
_BOUNDS = {
    "greater_than": "above {gt}",
    "greater_than_equal": "at least {ge}",
    "less_than": "below {lt}",
    "less_than_equal": "at most {le}",
    "literal_error": "one of {expected}",
    "too_short": "at least {min_length} of them",
    "too_long": "at most {max_length} of them",
    "string_too_short": "at least {min_length} character",
    "string_too_long": "at most {max_length} characters",
}
_CURES = {
    "string_pattern_mismatch": "try oak_2",
    "string_too_long": "try a shorter one",
}
_EVERY_KEY = "`lodbench list --keys` shows every key"


class Nothing:
    """What arrived where a required key is missing."""

    def __repr__(self) -> str:
        return "missing"


def explain(error: ValidationError, blame: Blame, named: Mapping[str, Iterable[str]]) -> InputError:
    """Explain the first thing wrong; ``blame`` turns a dotted key into its source."""
    first, *others = error.errors(include_url=False)
    key = str(first.get("ctx", {}).get("key") or dotted(first["loc"]))
    field = _field(first["loc"])
    rule, cure = _rule(first, field)
    arrived = first["input"]
    if first["type"] == "missing":
        arrived = Nothing()
    elif first["type"] == "extra_forbidden":
        rule, cure = "no such key", nearest_key(key, known_keys(named))
    elif first["type"] == "rule" and key != dotted(first["loc"]):
        arrived = value_at(arrived, key.removeprefix(dotted(first["loc"])).lstrip("."))
    if others:
        cure = f"{cure} (and {len(others)} more)".strip()
    return InputError(blame(key), arrived, rule, cure)


def dotted(location: Sequence[int | str]) -> str:
    """Write ('species', 'tree', 'sizes', 0) as a dotted key, ``species.tree.sizes[0]``."""
    steps = [f"[{step}]" if isinstance(step, int) else f".{step}" for step in location]
    return "".join(steps).removesuffix(".[key]").lstrip(".")


def nearest_key(key: str, known: Sequence[str]) -> str:
    """Ask for the known key that was probably meant; list the choices where none is near.

    A key without a dot may also have been meant for a table.
    """
    parent, _, name = key.rpartition(".")
    if not parent:
        tables = {each.partition(".")[0]: each for each in known}
        if close := difflib.get_close_matches(key, tables, 1):
            return f"did you mean {close[0]}?"
    beside = {each.rpartition(".")[2]: each for each in known if each.rpartition(".")[0] == parent}
    namesakes = [each for each in known if each.rpartition(".")[2] == name]
    close = namesakes or difflib.get_close_matches(key, known, 1)
    if close:
        return f"did you mean {close[0]}?"
    names = beside or {each.partition(".")[0]: each for each in known}
    return f"known here: {', '.join(names)}"


def nearest_name(name: str, known: Iterable[str]) -> str:
    """Ask for the known name that was probably meant; list the choices where none is near."""
    names = list(known)
    close = difflib.get_close_matches(name, names, 1)
    return f"did you mean {close[0]}?" if close else f"one of: {', '.join(names) or 'none yet'}"


def _rule(error: ErrorDetails, field: FieldInfo | None) -> tuple[str, str]:
    """Rule and cure: the key's own range and meaning where it has them."""
    kind, context = error["type"], error.get("ctx", {})
    if kind == "rule":
        return context["rule"], context["cure"]
    rule = _RULES.get(kind) or _BOUNDS.get(kind, error["msg"]).format_map(context)
    if kind == "missing":
        rule = "a required key"
    if field is None or field.title is None:
        return rule, _CURES.get(kind, _EVERY_KEY)
    if kind in _BOUNDS and field.description:
        rule = field.description
    elif kind == "float_type" and "[m]" in field.title:
        rule = "a number, or a length as 170cm or 2km"
    return rule, f"{field.title}{_default(field)}"


def _default(field: FieldInfo) -> str:
    default = field.get_default(call_default_factory=True)
    if field.is_required() or default in (None, "", {}):
        return ""
    default = list(default) if isinstance(default, tuple) else default
    return f"; the default is {default}"


def _field(location: Sequence[int | str]) -> FieldInfo | None:
    model: type[BaseModel] = Preset
    field = None
    for step in location:
        if isinstance(step, int):
            break
        if field is not None and field.annotation is not None and step not in model.model_fields:
            model = NAMED.get(str(location[0]), model)  # a name that the user chose
            field = None
            continue
        field = model.model_fields.get(step)
        if field is None:
            return None
        model = table_of(field.annotation) or model
    return field


def value_at(data: Any, key: str) -> Any:
    """Give what ``data`` (tables or models) holds at a dotted key; of lists what each one does."""
    for step in filter(None, key.split(".")):
        if isinstance(data, list):
            data = [value_at(each, step) for each in data]
            continue
        data = data.get(step) if isinstance(data, dict) else getattr(data, step, None)
    return data


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
