"""A sequence of frames in a folder: each whole or not there at all, and kept if it is right."""

import contextlib
import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from lod.errors import InputError
from scenes.processes.claims import Claimed, claim
from scenes.render.files.disk import DiskError, partial_path, stray_partials
from scenes.render.files.frame_paths import frame_path, make_folder
from scenes.render.files.manifest import (
    DONE,
    FAILED,
    NAME,
    PENDING,
    Manifest,
    file_hash,
    load_manifest,
    settings_hash,
)
from scenes.render.pipeline.peak_memory import peak_rss_bytes
from scenes.render.sequence.settings import Record, Settings

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
