"""Settings and records: what determines a frame's pixels, and what is known of it, as plain data.

Settings travel to other processes and machines, stand in every header and in the manifest, and make
the same frame again.
"""

from collections.abc import Mapping
from typing import Any

from scenes.preset.load import preset_from
from scenes.preset.models import MODEL_TABLES
from scenes.preset.tables import Preset
from scenes.render.files.header import software

Settings = Mapping[str, Any]
"""A preset as plain data, with the software that renders it (``frame_settings``)."""


_BESIDE = ("software", "track")
"""What settings hold beside a preset."""

Record = dict[str, Any]
"""What is known of a rendered frame, as plain data (``FrameSession.render``)."""


def frame_settings(preset: Preset, variant: str, track: str | None = None) -> dict[str, Any]:
    """Collect everything that determines the pixels: preset, variant in place of auto, software.

    track  hash of the pose track by which its actors stand; None where nobody acts
    """
    settings = preset.model_dump(mode="json", exclude={"about"})
    settings["render"]["variant"] = variant
    for table in (each for kind in MODEL_TABLES for each in settings[kind].values()):
        if table["model_sha256"] is None:  # it is one of the program's own
            del table["model_sha256"]
    acts = {} if track is None else {"track": track}
    return {**settings, **acts, "software": software()}


def preset_from_settings(settings: Settings) -> Preset:
    """Check the preset that settings hold. Raises InputError for what no preset can be.

    Tables are put in the order of their names: species get their ids in that order, and presets
    that differ in it alone have the same settings hash, so they must give the same frame.
    """
    tables = {name: each for name, each in settings.items() if name not in _BESIDE}
    return preset_from(_in_order_of_names(tables), source="settings")


def _in_order_of_names(table: Mapping[str, Any]) -> dict[str, Any]:
    return {
        name: _in_order_of_names(each) if isinstance(each, Mapping) else each
        for name, each in sorted(table.items())
    }
