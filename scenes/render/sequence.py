"""A sequence of frames in a folder: each whole or not there at all, and kept if it is right."""

import os
import sys
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from lod.errors import InputError
from scenes.render.exr import write_exr
from scenes.render.frame import FrameInput
from scenes.render.header import frame_header, software
from scenes.render.manifest import (
    Manifest,
    differences,
    file_hash,
    flatten,
    load_manifest,
    settings_hash,
)
from scenes.render.render import render_frame

HASHES = "####"
Record = dict[str, Any]


def render_sequence(
    pattern: str | Path,
    frames: Sequence[int],
    make_frame: Callable[[int], FrameInput],
    settings: Mapping[str, Any],
    overwrite: bool = False,
) -> Iterator[Record]:
    """Render ``frames`` into ``pattern`` (name.####.exr), giving a record after each.

    ``settings`` is nested plain data, everything that determines the pixels; it goes into every
    header and the manifest. A frame that stands there with these settings and the hash on record is
    kept, and its record says so. Everything in the way is found before the first frame is rendered:
    raises InputError for frames of other settings and for files that the manifest does not know,
    unless ``overwrite``.

    Record: frame, path, sha256, kept, seconds {stage: s}, peak_rss_bytes, statistics.
    """
    complete = {**settings, "software": software()}
    paths = {frame: frame_path(pattern, frame) for frame in frames}
    folder = _make_folder(Path(pattern).parent)
    manifest = _open_manifest(folder, overwrite)
    done = set() if overwrite else _finished(manifest, paths, complete)
    for frame, path in paths.items():
        if frame in done:
            yield _kept(frame, path, manifest)
        else:
            yield _render(frame, path, make_frame, complete, manifest)


def frame_path(pattern: str | Path, frame: int) -> Path:
    """The file of one frame: #### becomes its number, at least four digits."""
    path = Path(pattern)
    if path.name.count(HASHES) != 1 or path.name.count("#") != 4 or path.suffix != ".exr":
        rule = "an .exr file's name with #### once, for the frame's number"
        raise InputError("-o", str(pattern), rule, "try out/name.####.exr")
    if frame < 0:
        raise InputError("frame", frame, "0 or more")
    return path.with_name(path.name.replace(HASHES, f"{frame:04d}"))


def _make_folder(folder: Path) -> Path:
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        rule = f"a folder that can be made ({error.strerror})"
        raise InputError("-o", str(folder), rule, "choose another") from None
    if not os.access(folder, os.W_OK | os.X_OK):
        raise InputError("-o", str(folder), "a folder that can be written to", "choose another")
    return folder


def _open_manifest(folder: Path, overwrite: bool) -> Manifest:
    try:
        return load_manifest(folder)
    except InputError:
        if not overwrite:
            raise
        return Manifest(folder)


def _finished(
    manifest: Manifest, paths: Mapping[int, Path], settings: Mapping[str, Any]
) -> set[int]:
    """Frames that need no rendering. Raises InputError for files that are not ours to replace."""
    done, key = set(), settings_hash(settings)
    for frame, path in paths.items():
        if not path.exists():
            continue
        entry = manifest.frames.get(path.name)
        if entry is None:
            rule = "a file stands there that the folder's manifest does not know"
            raise InputError("-o", str(path), rule, "choose another folder, or --overwrite")
        if entry["settings"] != key:
            changed = differences(manifest.settings.get(entry["settings"], {}), settings)
            rule = f"rendered with other settings ({'; '.join(changed[:3]) or 'unknown'})"
            raise InputError("-o", str(path), rule, "choose another folder, or --overwrite")
        if file_hash(path) == entry["sha256"]:
            done.add(frame)
    return done


def _kept(frame: int, path: Path, manifest: Manifest) -> Record:
    entry = manifest.frames[path.name]
    return {
        "frame": frame,
        "path": str(path),
        "sha256": entry["sha256"],
        "kept": True,
        "seconds": {},
        "peak_rss_bytes": peak_rss_bytes(),
        "statistics": entry.get("statistics", {}),
    }


def _render(
    frame: int,
    path: Path,
    make_frame: Callable[[int], FrameInput],
    settings: Mapping[str, Any],
    manifest: Manifest,
) -> Record:
    start = time.perf_counter()
    made = make_frame(frame)
    prepared = made.seconds or {"prepare": time.perf_counter() - start}
    layers = render_frame(made.camera, made.visible, made.air, made.light, made.quality, frame)
    rendered = time.perf_counter()
    record: Record = {"frame": frame, "path": str(path), "sha256": "", "kept": False}

    def note(digest: str) -> None:
        """In the manifest before the rename, so that no finished file is ever unknown to it."""
        write = time.perf_counter() - rendered
        record["sha256"] = digest
        record["seconds"] = {**prepared, **layers.seconds, "write": write}
        record["peak_rss_bytes"] = peak_rss_bytes()
        record["statistics"] = layers.statistics
        noted = ("frame", "sha256", "seconds", "statistics")
        manifest.put(path, settings, {key: record[key] for key in noted})

    write_exr(path, layers, _header(made, settings, frame), note, made.form)
    return record


def _header(made: FrameInput, settings: Mapping[str, Any], frame: int) -> dict[str, Any]:
    return frame_header(made.camera, made.fps, {**dict(flatten(settings)), "frame": frame})


def peak_rss_bytes() -> int:
    """The most memory this process has held; 0 where the system does not say."""
    try:
        import resource
    except ImportError:
        return 0
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return peak if sys.platform == "darwin" else peak * 1024
