"""manifest.json: what every frame in a folder was made with, its state, and its file's hash."""

import contextlib
import fcntl
import hashlib
import json
import os
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from lod.errors import InputError
from scenes.processes.claims import claim
from scenes.render.files.disk import partial_path

NAME = "manifest.json"
VERSION = 3
DONE, PENDING, FAILED = "done", "pending", "failed"
_CURE = "`lodbench verify --repair` rebuilds it from its frames' headers"
_CURE_FOLDER = "move that folder elsewhere; then `lodbench verify --repair` writes it anew"


@dataclass(eq=False)
class Manifest:
    """What is on record of one folder's frames.

    frames    by file name: {frame, state, settings (a hash), sha256 (None until done)}, and what
              is known beside: seconds and statistics of a frame that is done, error and tries of
              one that failed
    settings  by hash: the settings themselves, nested
    """

    folder: Path
    frames: dict[str, dict[str, Any]] = field(default_factory=dict)
    settings: dict[str, dict[str, Any]] = field(default_factory=dict)

    def put(
        self,
        settings: Mapping[str, Any],
        entries: Mapping[str, dict[str, Any]],
        overwrite: bool = False,
        then: Callable[[], object] = lambda: None,
    ) -> None:
        """Note frames by file name, beside what others have noted meanwhile, and save.

        ``then`` is called before anyone else may write. Raises InputError for a frame that is on
        record with other settings, unless ``overwrite``; nothing is noted then.
        """
        key = settings_hash(settings)
        with _alone(self.folder):
            kept = load_manifest(self.folder)
            if not overwrite:
                for name in entries:
                    kept.check_settings(name, settings)
            self.frames = kept.frames
            self.settings = {**kept.settings, key: dict(settings)}
            for name, entry in entries.items():
                self.frames[name] = {"sha256": None, **entry, "settings": key}
            self._save()
            then()

    def check_settings(self, name: str, settings: Mapping[str, Any]) -> None:
        """Raise InputError where a frame is on record with other settings than these."""
        entry = self.frames.get(name)
        if entry is not None and entry["settings"] != settings_hash(settings):
            changed = differences(self.settings[entry["settings"]], settings)
            rule = f"on record with other settings ({'; '.join(changed[:3]) or 'unknown'})"
            cure = "choose another folder, or --overwrite"
            raise InputError("-o", str(self.folder / name), rule, cure)

    def _save(self) -> None:
        """Write under a temporary name and rename, so that it is always whole."""
        used = {entry["settings"] for entry in self.frames.values()}
        self.settings = {key: value for key, value in self.settings.items() if key in used}
        frames = dict(sorted(self.frames.items()))
        data = {"version": VERSION, "settings": self.settings, "frames": frames}
        path = self.folder / NAME
        temporary = partial_path(path)
        try:
            with temporary.open("w", encoding="utf-8") as file:
                json.dump(data, file, indent=1, allow_nan=False)
                file.flush()
                os.fsync(file.fileno())
            os.replace(temporary, path)
        finally:
            with contextlib.suppress(OSError):
                temporary.unlink(missing_ok=True)


@contextlib.contextmanager
def _alone(folder: Path) -> Iterator[None]:
    """One writer of the manifest at a time.

    Those of one machine queue at a lock of the folder, where there are locks; a claim keeps out
    those of others.
    """
    handle = os.open(folder, os.O_RDONLY)
    try:
        with contextlib.suppress(OSError):
            fcntl.flock(handle, fcntl.LOCK_EX)
        with claim(folder, "manifest", wait=True):
            yield
    finally:
        os.close(handle)


def load_manifest(folder: Path) -> Manifest:
    """The folder's manifest; an empty one where there is none. A broken one raises InputError."""
    path = folder / NAME
    try:
        text = path.read_text(encoding="utf-8")
    except FileNotFoundError:
        return Manifest(folder)
    except UnicodeDecodeError as error:
        raise InputError(str(path), f"byte {error.start}", "UTF-8 text", _CURE) from None
    except OSError as error:
        cure = _CURE_FOLDER if path.is_dir() else _CURE
        raise InputError(str(path), str(error.strerror), "a file to be read", cure) from None
    try:
        data = json.loads(text)
    except (ValueError, RecursionError) as error:
        raise InputError(str(path), str(error), "a manifest in JSON", _CURE) from None
    return Manifest(folder, *_read(path, data))


def _read(path: Path, data: Any) -> tuple[dict[str, dict[str, Any]], dict[str, dict[str, Any]]]:
    """(frames, settings), each value of the right kind; raises InputError with the key."""

    def need(good: bool, key: str, arrived: object, rule: str) -> None:
        if not good:
            raise InputError(f"{path}: {key}", arrived, rule, _CURE)

    need(isinstance(data, dict), "the whole", data, "a table of version, settings and frames")
    version = data.get("version")
    need(type(version) is int and version == VERSION, "version", version, f"it is {VERSION}")
    frames, settings = data.get("frames"), data.get("settings")
    need(isinstance(settings, dict), "settings", settings, "a table of settings by their hash")
    need(isinstance(frames, dict), "frames", frames, "a table of frames by file name")
    for key, each in settings.items():
        need(isinstance(each, dict), f"settings.{key}", each, "a table of settings")
    for name, entry in frames.items():
        for key, (good, rule) in _rules(name, entry, settings).items():
            arrived = entry.get(key) if isinstance(entry, dict) and key else entry
            need(good, f"frames.{name}{key and '.'}{key}", arrived, rule)
    return frames, settings


def _rules(name: str, entry: Any, settings: Iterable[str]) -> dict[str, tuple[bool, str]]:
    """By key of one frame's entry: whether it is right, and the rule."""
    if not isinstance(entry, dict):
        return {"": (False, "a table about a frame")}
    frame, state, digest = entry.get("frame"), entry.get("state"), entry.get("sha256")
    plain = name == os.path.basename(name) and name.endswith(".exr") and "\0" not in name
    hexadecimal = isinstance(digest, str) and len(digest) == 64 and set(digest) <= _HEXADECIMAL
    key = entry.get("settings")
    return {
        "": (plain, "the name of an .exr file in this folder"),
        "frame": (type(frame) is int and frame >= 0, "a frame's number, 0 or more"),
        "state": (state in (DONE, PENDING, FAILED), f"{DONE}, {PENDING} or {FAILED}"),
        "settings": (isinstance(key, str) and key in settings, "the hash of settings given above"),
        "sha256": (hexadecimal or state != DONE, "64 hexadecimal digits"),
    }


_HEXADECIMAL = set("0123456789abcdef")


def settings_hash(settings: Mapping[str, Any]) -> str:
    """SHA-256 of the settings as canonical JSON."""
    text = json.dumps(settings, sort_keys=True, separators=(",", ":"), allow_nan=False)
    return hashlib.sha256(text.encode()).hexdigest()


def differences(old: Mapping[str, Any], new: Mapping[str, Any]) -> list[str]:
    """What differs between two nested settings: ``key: old → new``."""
    before, after = dict(_flatten(old)), dict(_flatten(new))
    keys = [key for key in {**before, **after} if before.get(key) != after.get(key)]
    return [f"{key}: {before.get(key, 'absent')} → {after.get(key, 'absent')}" for key in keys]


def _flatten(settings: Mapping[str, Any], prefix: str = "") -> Iterator[tuple[str, Any]]:
    """Nested settings as (dotted key, value)."""
    for key, value in settings.items():
        if isinstance(value, Mapping):
            yield from _flatten(value, f"{prefix}{key}.")
        else:
            yield f"{prefix}{key}", value


def file_hash(path: Path) -> str:
    """SHA-256 of a file's bytes."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()
