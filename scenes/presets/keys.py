"""The keys that a preset may have, in words, and errors about them in one line."""

import difflib
import re
import types
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated, Any, Literal, Union, get_args, get_origin

from pydantic import BaseModel, ValidationError
from pydantic.fields import FieldInfo
from pydantic_core import ErrorDetails

from lod.errors import InputError
from scenes.presets.schema import Preset
from scenes.presets.things import (
    ActorPreset,
    PlacedPreset,
    PlumePreset,
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
