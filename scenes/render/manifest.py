"""manifest.json: what every frame in a folder was made with, and the hash of its file."""

import hashlib
import json
import os
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from lod.errors import InputError

NAME = "manifest.json"
VERSION = 1


@dataclass(eq=False)
class Manifest:
    """One folder's frames.

    frames    by file name: {frame, settings (a hash), sha256, seconds, statistics}
    settings  by hash: the settings themselves, nested
    """

    folder: Path
    frames: dict[str, dict[str, Any]] = field(default_factory=dict)
    settings: dict[str, dict[str, Any]] = field(default_factory=dict)

    def put(self, path: Path, settings: Mapping[str, Any], entry: dict[str, Any]) -> None:
        """Note a finished frame and save."""
        key = settings_hash(settings)
        self.frames[path.name] = {"settings": key, **entry}
        self.settings[key] = dict(settings)
        used = {entry["settings"] for entry in self.frames.values()}
        self.settings = {key: value for key, value in self.settings.items() if key in used}
        self.save()

    def save(self) -> None:
        """Write under a temporary name and rename, so that it is always whole."""
        frames = dict(sorted(self.frames.items()))
        data = {"version": VERSION, "settings": self.settings, "frames": frames}
        path = self.folder / NAME
        temporary = path.with_name(f".{NAME}.{os.getpid()}.part")
        try:
            with temporary.open("w", encoding="utf-8") as file:
                json.dump(data, file, indent=1, allow_nan=False)
                file.flush()
                os.fsync(file.fileno())
            os.replace(temporary, path)
        finally:
            temporary.unlink(missing_ok=True)


def load_manifest(folder: Path) -> Manifest:
    """The folder's manifest; an empty one where there is none. A broken one raises InputError."""
    path = folder / NAME
    if not path.exists():
        return Manifest(folder)
    try:
        data = json.loads(path.read_text(encoding="utf-8"))
        if data["version"] != VERSION:
            rule = f"version {VERSION}"
            raise InputError(str(path), data["version"], rule, "use another folder, or --overwrite")
        frames = {str(name): _entry(entry) for name, entry in data["frames"].items()}
        settings = {str(key): dict(value) for key, value in data["settings"].items()}
    except (OSError, ValueError, TypeError, KeyError, AttributeError) as error:
        if isinstance(error, InputError):
            raise
        rule = "a manifest that lodbench wrote"
        raise InputError(
            str(path), str(error), rule, "use another folder, or --overwrite"
        ) from None
    return Manifest(folder, frames, settings)


def _entry(entry: Mapping[str, Any]) -> dict[str, Any]:
    if not (isinstance(entry["settings"], str) and isinstance(entry["sha256"], str)):
        raise TypeError("a frame without its hashes")
    return dict(entry)


def settings_hash(settings: Mapping[str, Any]) -> str:
    """SHA-256 of the settings as canonical JSON."""
    text = json.dumps(settings, sort_keys=True, separators=(",", ":"), allow_nan=False)
    return hashlib.sha256(text.encode()).hexdigest()


def differences(old: Mapping[str, Any], new: Mapping[str, Any]) -> list[str]:
    """What differs between two nested settings: ``key: old → new``."""
    before, after = dict(flatten(old)), dict(flatten(new))
    keys = [key for key in {**before, **after} if before.get(key) != after.get(key)]
    return [f"{key}: {before.get(key, 'absent')} → {after.get(key, 'absent')}" for key in keys]


def flatten(settings: Mapping[str, Any], prefix: str = "") -> Iterator[tuple[str, Any]]:
    """Nested settings as (dotted key, value)."""
    for key, value in settings.items():
        if isinstance(value, Mapping):
            yield from flatten(value, f"{prefix}{key}.")
        else:
            yield f"{prefix}{key}", value


def file_hash(path: Path) -> str:
    """SHA-256 of a file's bytes."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()
