"""The imported models of a preset, each held to the hash of what it was when that was read."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

from scenes.model_files.names import built_in_names
from scenes.preset.object_tables import ModelTable
from scenes.preset.tables import Preset

MODEL_TABLES = "species", "placed", "actors", "troupes"
"""The tables of a preset whose members each name a model."""


def with_model_digests(preset: Preset, blame: Callable[[str], str], folder: Path) -> Preset:
    """Return the preset with the hash of every imported model that it names.

    Scene files lie in ``folder``; ``blame`` turns a dotted key into its source. Raises InputError
    for a model that is not there, cannot be read, or is another than the preset's hash says.
    """
    built_in = built_in_names()

    def known(kind: str, name: str, table: ModelTable) -> Any:
        if table.model in built_in:
            return table
        from scenes.imported.library import model_digest

        where = blame(f"{kind}.{name}.model")
        digest = model_digest(where, table.model, folder, table.model_sha256)
        return table.model_copy(update={"model_sha256": digest})

    named = {
        kind: {name: known(kind, name, table) for name, table in getattr(preset, kind).items()}
        for kind in MODEL_TABLES
    }
    changed = {kind: tables for kind, tables in named.items() if tables != getattr(preset, kind)}
    return preset.model_copy(update=changed) if changed else preset
