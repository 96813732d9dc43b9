"""How a frame gets on disk, and which frames of a folder are right already.

``owned_folder`` keeps others out. ``render_sequence`` has each frame rendered into a partial file
beside its place; ``write_exr`` of ``layer_file`` fills it, puts the hash of all its bytes into its
header, has the system store it and reads it back. ``commit_frame`` gives it its own name by a link,
or in place of what may be replaced (``scenes.files.give_name``), and removes the partial file: a
frame is whole or not there at all.

A frame is its own record. Its header holds its number, every setting and a hash of the whole file
(``seal``), so that the files alone say which frames of a folder are done; there is no index. Each
can be held against what it says of itself, and what is wrong be rendered again.
"""

import contextlib
import hashlib
import json
import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

from lod.errors import InputError
from scenes.files import DiskError, frame_path, give_name, make_folder, partial_path, stray_partials
from scenes.processes.memory_limit import peak_rss_bytes
from scenes.processes.ownership import owned
from scenes.render.exr.header import FRAME, Record, Settings, settings_in

Render = Callable[[Settings, int, Path], Record]
"""Renders a frame of these settings into a file. Here a Worker does, which passes the
settings and the frame to a FrameSession in a process of its own."""


class FrameFailed(RuntimeError):
    """One frame cannot be rendered, whatever the others do; why, and after how many tries."""

    def __init__(self, why: str, tries: int) -> None:
        super().__init__(why)
        self.tries = tries


class WholeFrame(NamedTuple):
    """What a frame says that it is, whose every byte is as it was written.

    sha256  of the file
    """

    frame: int
    settings: dict[str, Any]
    sha256: str


def read_whole(path: str | Path) -> WholeFrame:
    """Read what a frame is, from its header alone.

    Raises InputError for a file that is none of ours, and where a byte of it is not as written;
    OSError where it cannot be read.
    """
    from scenes.render.exr.layer_file import UNREADABLE_CURE, is_sealed, read_header

    def need(good: bool, rule: str) -> None:
        if not good:
            raise InputError("frame", str(path), rule, UNREADABLE_CURE)

    need(Path(path).is_file(), "a plain file")
    need(is_sealed(path), "undamaged; its bytes are not those that were written")
    header = read_header(path)
    need(FRAME in header, "a frame of lodbench, with its number in the header")
    with open(path, "rb") as file:
        digest = hashlib.file_digest(file, "sha256").hexdigest()
    return WholeFrame(header[FRAME], settings_in(header), digest)


def is_remains(path: str | Path) -> bool:
    """Say whether a file that is no whole frame may be what is left of one of ours.

    So may a file of zeros be, or one without a byte, as a crash of the system leaves them, and an
    OpenEXR file that is too short for any header.
    """
    if not Path(path).is_file():
        return False
    with open(path, "rb") as file:
        begin = file.read(_SEARCHED)
        if any(mark in begin for mark in _MARKS):
            return True
        if begin.startswith(_MAGIC):
            return len(begin) < _SHORTEST_HEADER
        return not any(begin) and not any(map(any, iter(lambda: file.read(2**20), b"")))


_MAGIC, _MARKS = b"\x76\x2f\x31\x01", (b"lod:file_sha256\0string", b"lod:frame\0int")

_SEARCHED, _SHORTEST_HEADER = 2**16, 2**12


def settings_hash(settings: Mapping[str, Any]) -> str:
    """SHA-256 of the settings as canonical JSON."""
    text = json.dumps(settings, sort_keys=True, separators=(",", ":"), allow_nan=False)
    return hashlib.sha256(text.encode()).hexdigest()


def differences(old: Mapping[str, Any], new: Mapping[str, Any]) -> list[str]:
    """What differs between two nested settings, the version first: ``key: old → new``."""

    def flat(settings: Mapping[str, Any], prefix: str = "") -> Iterator[tuple[str, Any]]:
        for key, value in settings.items():
            if isinstance(value, Mapping):
                yield from flat(value, f"{prefix}{key}.")
            else:
                yield f"{prefix}{key}", value

    before, after = dict(flat(old)), dict(flat(new))
    keys = [key for key in {**before, **after} if before.get(key) != after.get(key)]
    keys.sort(key=lambda key: key != "software")
    return [f"{key}: {before.get(key, 'absent')} → {after.get(key, 'absent')}" for key in keys]


@dataclass(frozen=True, eq=False)
class Job:
    """A sequence of frames to render, and which of them are right already.

    paths      by frame, in the order in which they were asked for
    done       SHA-256 of the files that are right, by frame
    overwrite  whether what stands in the others' places is replaced, whatever it is
    """

    paths: dict[int, Path]
    settings: Settings
    done: Mapping[int, str]
    overwrite: bool = False

    @property
    def folder(self) -> Path:
        """Folder of the frames."""
        return next(iter(self.paths.values())).parent


def open_job(
    pattern: str | Path, frames: Sequence[int], settings: Settings, overwrite: bool = False
) -> Job:
    """Look through the folder of ``pattern`` (name.####.exr) before anything is rendered.

    A frame that stands there whole, with these settings, is done; what is left of a damaged one
    will be replaced. Partial files that a dead process left of the others are removed. Raises
    InputError for frames of other settings, and for files that are no frames, unless ``overwrite``.
    """
    paths = {frame: frame_path(pattern, frame) for frame in frames}
    folder = make_folder(Path(pattern).parent)
    with _disk(folder):
        found = {} if overwrite else {k: _done(path, k, settings) for k, path in paths.items()}
        done = {frame: digest for frame, digest in found.items() if digest}
        left = {path.name for frame, path in paths.items() if frame not in done}
        for name, stray in stray_partials(folder):
            if name in left:
                stray.unlink(missing_ok=True)
    return Job(paths, settings, done, overwrite)


def _done(path: Path, frame: int, settings: Settings) -> str | None:
    """SHA-256 of the frame that stands at a path; None where it is to be rendered.

    Raises InputError where what stands there is not ours to replace.
    """
    if not os.path.lexists(path):
        return None
    try:
        whole = read_whole(path)
    except InputError:
        if is_remains(path):
            return None
        rule = "something stands there that is no frame of lodbench"
        raise InputError("-o", str(path), rule, "choose another folder, or --overwrite") from None
    if changed := differences(whole.settings, settings):
        rule = f"there with other settings ({'; '.join(changed[:3])})"
        raise InputError("-o", str(path), rule, "choose another folder, or --overwrite")
    return whole.sha256 if whole.frame == frame else None


@contextlib.contextmanager
def owned_folder(
    folder: str | Path, settings: Settings, note: Callable[[str], object] = lambda text: None
) -> Iterator[None]:
    """Keep everyone with other settings out of a folder; several of the same may share it.

    Raises InputError where another process renders there with other settings.
    """
    folder = make_folder(folder)
    with contextlib.ExitStack() as stack:
        with _disk(folder):
            does = "renders there with other settings"
            stack.enter_context(owned(folder, settings_hash(settings), does, note))
        yield


def render_sequence(job: Job, render: Render) -> Iterator[Record]:
    """Render what is not done, giving a record after each frame, kept ones too.

    Record: frame, path, sha256, kept, seconds {stage: s}, peak_rss_bytes, statistics; of a frame
    that failed: frame, path, error, tries. Raises InputError where the first frame that is tried
    meets it and no frame was done before, because all frames would meet it; otherwise it fails that
    frame alone. DiskError ends the sequence.
    """
    first = not job.done
    for frame, path in job.paths.items():
        if frame in job.done:
            yield kept_record(job, frame)
            continue
        partial = partial_path(path)
        try:
            with _disk(path):
                record = render(job.settings, frame, partial)
            yield commit_frame(job, frame, record, partial)
        except FrameFailed as error:
            yield failure(job, frame, str(error), error.tries)
        except InputError as error:
            if first:
                raise
            yield failure(job, frame, str(error), 1)
        finally:
            with contextlib.suppress(OSError):
                partial.unlink(missing_ok=True)
        first = False


def kept_record(job: Job, frame: int) -> Record:
    """Make the record of a frame that is right already."""
    return {
        "frame": frame,
        "path": str(job.paths[frame]),
        "sha256": job.done[frame],
        "kept": True,
        "seconds": {},
        "peak_rss_bytes": peak_rss_bytes(),
        "statistics": {},
    }


def commit_frame(job: Job, frame: int, record: Record, partial: Path) -> Record:
    """Give a rendered frame its name, and give its whole record.

    Raises InputError for what came to stand there meanwhile, and is not ours to replace.
    """
    path = job.paths[frame]
    with _disk(path):
        ours = os.path.lexists(path)
        if ours and not job.overwrite:
            _done(path, frame, job.settings)
        give_name(partial, path, overwrite=ours)
        partial.unlink(missing_ok=True)
    return {"frame": frame, "path": str(path), "kept": False, **record}


def failure(job: Job, frame: int, why: str, tries: int) -> Record:
    """Make the record of a frame that failed."""
    return {"frame": frame, "path": str(job.paths[frame]), "error": why, "tries": tries}


@contextlib.contextmanager
def _disk(path: Path) -> Iterator[None]:
    """What the system refuses, as a DiskError about the file that was to be."""
    try:
        yield
    except DiskError:
        raise
    except OSError as error:
        raise DiskError(error, path) from error


Kinds = dict[tuple[str, str], dict[str, Settings]]
"""Sequences of a folder: settings by their hash, by what is before and after a frame's number."""


def sequences_in(folder: Path) -> tuple[dict[str, WholeFrame], Kinds]:
    """Find the whole frames of a folder by file name, and the sequences that they are of."""
    whole: dict[str, WholeFrame] = {}
    kinds: Kinds = {}
    for name in sorted(name for name in os.listdir(folder) if name.endswith(".exr")):
        with contextlib.suppress(InputError, OSError):
            whole[name] = found = read_whole(folder / name)
            before, number, after = name.rpartition(f"{found.frame:04d}")
            if number:
                kinds.setdefault((before, after), {})[settings_hash(found.settings)] = (
                    found.settings
                )
    return whole, kinds
