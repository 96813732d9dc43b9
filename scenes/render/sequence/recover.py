"""A manifest rebuilt from the frames of its folder, whose headers say what and how whole they are.

Nothing is rendered, and no damaged frame is accepted: one whose hash within does not fit, or that
says it is another frame than its name does, stays wrong.
"""

import os
import re
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from lod.errors import InputError
from scenes.render.files.frame_paths import may_name
from scenes.render.files.manifest import (
    DONE,
    NAME,
    PENDING,
    Manifest,
    file_hash,
    load_manifest,
    settings_hash,
)
from scenes.render.files.whole_frame import whole_frame
from scenes.render.sequence.settings import Settings

NOTHING_WHOLE = (
    f"no frame in it is whole, to rebuild its {NAME} from",
    "render the frames again, with --overwrite",
)
"""Rule and cure where a manifest is lost or broken, and every frame with it."""

_NUMBER = re.compile(r"\d{4,}")


@dataclass
class _Found:
    """What a folder's frames say of themselves: settings by hash, and entries by name."""

    settings: dict[str, Settings] = field(default_factory=dict)
    entries: dict[str, dict[str, Any]] = field(default_factory=dict)


def rebuild_manifest(folder: Path) -> tuple[str, ...]:
    """Take frames into the manifest that are whole, and on record wrongly or not at all.

    Gives the names of frames that are taken in. Other files that look like theirs, and frames whose
    settings or number on record were changed, become frames to be rendered with the settings of the
    others, if those are all of one kind. Raises InputError for a broken manifest where no frame is
    whole.
    """
    try:
        manifest, broken = load_manifest(folder), None
    except InputError as error:
        manifest, broken = Manifest(folder), error
    found = _whole_frames(manifest)
    taken = tuple(name for name, entry in found.entries.items() if _differs(manifest, name, entry))
    if broken is not None:
        if (folder / NAME).is_dir():
            raise broken
        if not taken:
            raise InputError(broken.where, broken.arrived, *NOTHING_WHOLE) from None
        (folder / NAME).unlink()
    pending = _to_be_rendered(manifest, found)
    if not taken:  # then a file that the manifest does not know is left alone
        pending = {name: entry for name, entry in pending.items() if name in manifest.frames}
    if taken or pending:
        for key, settings in found.settings.items():
            entries = {
                name: {k: v for k, v in entry.items() if k != "settings"}
                for name, entry in {**found.entries, **pending}.items()
                if entry["settings"] == key and (name in taken or name in pending)
            }
            if entries:
                manifest.put(settings, entries, overwrite=True)
    return taken


def _whole_frames(manifest: Manifest) -> _Found:
    found = _Found()
    for name in _frame_files(manifest.folder):
        path = manifest.folder / name
        try:
            frame, settings = whole_frame(path)
            digest = file_hash(path)
        except (InputError, OSError):
            continue
        key = settings_hash(settings)
        if may_name(name, frame) and _may_be(manifest, name, key, digest):
            found.settings[key] = settings
            entry = {"frame": frame, "state": DONE, "sha256": digest, "settings": key}
            found.entries[name] = {"seconds": {}, "statistics": {}, **entry}
    return found


def _may_be(manifest: Manifest, name: str, key: str, digest: str) -> bool:
    """Whether the record agrees that this file is the frame: by its bytes or by its settings."""
    entry = manifest.frames.get(name)
    if entry is None or not _is_right(manifest, entry["settings"]):
        return True
    return entry["settings"] == key or entry["sha256"] == digest


def _is_right(manifest: Manifest, key: str) -> bool:
    return settings_hash(manifest.settings[key]) == key


def _differs(manifest: Manifest, name: str, entry: dict[str, Any]) -> bool:
    known = manifest.frames.get(name)
    if known is None or not _is_right(manifest, known["settings"]):
        return True
    return any(known[key] != entry[key] for key in ("frame", "state", "sha256", "settings"))


def _to_be_rendered(manifest: Manifest, found: _Found) -> dict[str, dict[str, Any]]:
    """Entries of what is not whole, where whole frames named like it leave no doubt what it is."""
    kinds: dict[str, set[str]] = {}
    for name, entry in found.entries.items():
        kinds.setdefault(_NUMBER.sub("#", name), set()).add(entry["settings"])
    pending = {}
    for name in {*_frame_files(manifest.folder), *manifest.frames} - found.entries.keys():
        known, kind = manifest.frames.get(name), kinds.get(_NUMBER.sub("#", name), set())
        edited = known is None or not _is_right(manifest, known["settings"])
        edited = edited or (known is not None and not may_name(name, known["frame"]))
        if edited and len(kind) == len(_numbers(name)) == 1:
            (frame,), (key,) = _numbers(name), kind
            pending[name] = {"frame": frame, "state": PENDING, "settings": key}
    return pending


def _frame_files(folder: Path) -> list[str]:
    """Names of files that are named as frames are."""
    return sorted(n for n in os.listdir(folder) if n.endswith(".exr") and _NUMBER.search(n))


def _numbers(name: str) -> list[int]:
    """The numbers in a file's name that may be its frame's."""
    return [int(number) for number in _NUMBER.findall(name)]
