"""The keys that a preset may have, each with its type, unit, range, default and meaning."""

import re
import types
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Annotated, Any, Literal, Union, get_args, get_origin

from pydantic import BaseModel
from pydantic.fields import FieldInfo

from scenes.preset.actor_tables import ActorPreset, TroupePreset
from scenes.preset.object_tables import (
    PlacedPreset,
    PlumePreset,
    RepresentationPreset,
    SpeciesPreset,
)
from scenes.preset.tables import Preset
from scenes.preset.values import is_length

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
    """Say in words what values a type has."""
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
