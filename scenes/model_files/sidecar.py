"""What is said of a model's nodes beyond their meshes: named attributes, and a table beside it.

A file's own attributes are named ``lod:level``, ``lod:albedo``, ``lod:axis``, ``lod:turns`` and
``lod:swing``. ``oak.usda.toml`` beside ``oak.usda`` says the same of nodes by their paths, and the
unit and the period of the whole; what it says goes before the file's own.
"""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any

from pydantic import BaseModel, Field, ValidationError

from lod.errors import InputError
from scenes.model_files.part_tree import NodeSettings
from scenes.model_files.read import CLOSED, read_model_file

PREFIX = "lod:"

_Unit = Annotated[float, Field(ge=-1e6, le=1e6)]
_Share = Annotated[float, Field(ge=0, le=1)]


class NodeTable(BaseModel):
    """What a table says of one node, as NodeSettings."""

    model_config = CLOSED

    level: Annotated[int, Field(ge=0, le=64)] | None = None
    albedo: tuple[_Share, _Share, _Share] | None = None
    axis: tuple[_Unit, _Unit, _Unit] | None = None
    turns: Annotated[int, Field(ge=-64, le=64)] = 1
    swing: Annotated[float, Field(ge=0, le=170)] = 0.0


class Sidecar(BaseModel):
    """The table beside a model.

    metres_per_unit  of the file's lengths; absent: what the file says itself [m]
    period           of all that turns or swings [s]
    parts            of nodes by their paths
    """

    model_config = CLOSED

    metres_per_unit: Annotated[float, Field(gt=0, le=1e6)] | None = None
    period: Annotated[float, Field(ge=0.01, le=1e6)] = 4.0
    parts: dict[str, NodeTable] = Field(default_factory=dict)


def read_sidecar(model: Path) -> Sidecar:
    """Read the table beside a model; an empty one where there is none."""
    file = model.with_name(f"{model.name}.toml")
    return read_model_file(file, Sidecar, {}) if file.is_file() else Sidecar()


def node_settings(where: str, attributes: Mapping[str, Any]) -> NodeSettings:
    """Read the settings of a node from the attributes of its file; others are not looked at."""
    ours = {
        name.rpartition(PREFIX)[2]: value for name, value in attributes.items() if PREFIX in name
    }
    if not ours:
        return NodeSettings()
    try:
        table = NodeTable.model_validate_json(_as_json(where, ours))
    except ValidationError as error:
        first = error.errors(include_url=False)[0]
        key = ".".join(map(str, first["loc"]))
        raise InputError(f"{where} {PREFIX}{key}", first["input"], first["msg"]) from None
    return settings_of(table)


def settings_of(table: NodeTable) -> NodeSettings:
    """Return what a table says as the settings of a node."""
    return NodeSettings(**table.model_dump())


def _as_json(where: str, values: Mapping[str, Any]) -> str:
    try:
        return json.dumps(values)
    except (TypeError, ValueError) as error:
        raise InputError(where, "attributes", f"plain numbers and lists ({error})") from None
