"""A frame without its manifest: what it says that it is, once it is known to be whole.

manifest.json: what every frame in a folder was made with, its state, and its file's hash.

A manifest rebuilt from the frames of its folder, whose headers say what and how whole they are.

Nothing is rendered, and no damaged frame is accepted: one whose hash within does not fit, or that
says it is another frame than its name does, stays wrong.

A sequence of frames in a folder: each whole or not there at all, and kept if it is right.
"""

import contextlib
import fcntl
import hashlib
import json
import os
import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from lod.errors import InputError
from scenes.files import DiskError, frame_path, make_folder, may_name, partial_path, stray_partials
from scenes.processes.memory import peak_rss_bytes
from scenes.processes.ownership import Claimed, claim
from scenes.render.exr.header import FRAME, Record, Settings, settings_in
from scenes.render.exr.layers import UNREADABLE_CURE, is_sealed, read_header


def whole_frame(path: str | Path) -> tuple[int, dict[str, Any]]:
    """Read a frame's number and settings from its header.

    Raises InputError for a file that is none of ours, and where a byte of it is not as written.
    """
    header = read_header(path)
    if FRAME not in header:
        raise InputError(
            "frame",
            str(path),
            "a frame of lodbench, with its number in the header",
            UNREADABLE_CURE,
        )
    if not is_sealed(path):
        raise InputError(
            "frame",
            str(path),
            "undamaged; its bytes are not those that were written",
            UNREADABLE_CURE,
        )
    return header[FRAME], settings_in(header)


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


_NOTED = ("frame", "sha256", "seconds", "statistics")

Render = Callable[[Settings, int, Path], Record]
"""Renders a frame of these settings into a file. Here a Worker (worker.py) does, which passes the
settings and the frame to a FrameSession (frame_session.py) in a process of its own."""


class FrameFailed(RuntimeError):
    """One frame cannot be rendered, whatever the others do; why, and after how many tries."""

    def __init__(self, why: str, tries: int) -> None:
        super().__init__(why)
        self.tries = tries


@dataclass(frozen=True, eq=False)
class Job:
    """A sequence of frames to render, and which of them are right already.

    paths  by frame, in the order in which they were asked for
    """

    paths: dict[int, Path]
    settings: Settings
    manifest: Manifest
    done: frozenset[int]

    @property
    def folder(self) -> Path:
        """Folder of the frames and their manifest."""
        return self.manifest.folder


def open_job(
    pattern: str | Path, frames: Sequence[int], settings: Settings, overwrite: bool = False
) -> Job:
    """Look through the folder of ``pattern`` (name.####.exr) before anything is rendered.

    A frame that stands there with these settings and the hash on record is done. The rest goes
    into the manifest as pending; partial files that a dead process left of them are removed. Raises
    InputError for frames that are on record with other settings, whatever became of them, and for
    files that the manifest does not know, unless ``overwrite``.
    """
    paths = {frame: frame_path(pattern, frame) for frame in frames}
    folder = make_folder(Path(pattern).parent)
    manifest = _open_manifest(folder, overwrite)
    done = set() if overwrite else _finished(manifest, paths, settings)
    job = Job(paths, settings, manifest, frozenset(done))
    left = {path.name: frame for frame, path in paths.items() if frame not in done}
    with _disk(folder):
        for name, stray in stray_partials(folder):
            if name in left or name == NAME:
                stray.unlink(missing_ok=True)
        if left:
            entries = {name: {"frame": frame, "state": PENDING} for name, frame in left.items()}
            manifest.put(settings, entries, overwrite)
    return job


@contextlib.contextmanager
def owned_folder(folder: str | Path, settings: Settings) -> Iterator[None]:
    """Keep everyone with other settings out of a folder; several of the same may share it.

    Raises InputError where another process renders there with other settings.
    """
    folder = make_folder(folder)
    with contextlib.ExitStack() as stack:
        try:
            with _disk(folder):
                stack.enter_context(claim(folder, "frames", settings_hash(settings)))
        except Claimed as other:
            rule = f"{other} renders there with other settings"
            cure = "wait for its end, or choose another folder"
            raise InputError("folder", str(folder), rule, cure) from None
        yield


def render_sequence(job: Job, render: Render) -> Iterator[Record]:
    """Render what is not done, giving a record after each frame, kept ones too.

    Record: frame, path, sha256, kept, seconds {stage: s}, peak_rss_bytes, statistics; of a frame
    that failed: frame, path, error, tries. Raises InputError where the first frame that is tried
    meets it and no frame was done before, because all frames would meet it; otherwise it fails that
    frame alone. DiskError ends the sequence.
    """
    first = not job.done
    for frame in job.paths:
        if frame in job.done:
            yield kept_record(job, frame)
            continue
        try:
            yield _render(job, frame, render)
        except FrameFailed as error:
            yield record_failure(job, frame, str(error), error.tries)
        except InputError as error:
            if first:
                raise
            yield record_failure(job, frame, str(error), 1)
        first = False


def kept_record(job: Job, frame: int) -> Record:
    """Make the record of a frame that is right already."""
    path = job.paths[frame]
    entry = job.manifest.frames[path.name]
    return {
        "frame": frame,
        "path": str(path),
        "sha256": entry["sha256"],
        "kept": True,
        "seconds": {},
        "peak_rss_bytes": peak_rss_bytes(),
        "statistics": entry.get("statistics", {}),
    }


def commit_frame(job: Job, frame: int, record: Record, partial: Path) -> Record:
    """Give a rendered frame its name, and give its whole record.

    It enters the manifest before the rename, so that no finished file is ever unknown to it.
    """
    path = job.paths[frame]
    with _disk(path):
        entry = {**{key: record[key] for key in _NOTED}, "state": DONE}
        job.manifest.put(job.settings, {path.name: entry}, then=lambda: os.replace(partial, path))
        sync_folder(path.parent)
    return {"frame": frame, "path": str(path), "kept": False, **record}


def record_failure(job: Job, frame: int, why: str, tries: int) -> Record:
    """Note in the manifest that a frame failed, and give its record."""
    path = job.paths[frame]
    entry = {"frame": frame, "error": why, "tries": tries}
    with _disk(path):
        job.manifest.put(job.settings, {path.name: {**entry, "state": FAILED}})
    return {**entry, "path": str(path)}


def _render(job: Job, frame: int, render: Render) -> Record:
    path = job.paths[frame]
    partial = partial_path(path)
    try:
        with _disk(path):
            record = render(job.settings, frame, partial)
        return commit_frame(job, frame, record, partial)
    finally:
        with contextlib.suppress(OSError):
            partial.unlink(missing_ok=True)


@contextlib.contextmanager
def _disk(path: Path) -> Iterator[None]:
    """What the system refuses, as a DiskError about the file that was to be."""
    try:
        yield
    except DiskError:
        raise
    except OSError as error:
        raise DiskError(error, path) from error


def sync_folder(folder: Path) -> None:
    """Have the system keep a rename; some file systems cannot, and that is no harm."""
    with contextlib.suppress(OSError):
        handle = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(handle)
        finally:
            os.close(handle)


def _open_manifest(folder: Path, overwrite: bool) -> Manifest:
    try:
        return load_manifest(folder)
    except InputError:
        if not overwrite:
            raise
        with _disk(folder):
            (folder / NAME).unlink()
        return Manifest(folder)


def _finished(manifest: Manifest, paths: Mapping[int, Path], settings: Settings) -> set[int]:
    """Frames that need no rendering. Raises InputError for files that are not ours to replace."""
    done = set()
    for frame, path in paths.items():
        manifest.check_settings(path.name, settings)
        if not path.exists():
            continue
        entry = manifest.frames.get(path.name)
        if entry is None:
            rule = "a file stands there that the folder's manifest does not know"
            raise InputError("-o", str(path), rule, "choose another folder, or --overwrite")
        if file_hash(path) == entry["sha256"]:
            done.add(frame)
    return done
