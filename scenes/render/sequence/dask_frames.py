"""The frames of a sequence as tasks of a cluster: one task a frame, one frame a worker at a time.

What the workers write is renamed and noted here, so the manifest has one writer. Workers must see
the folder under the same path.

Every frame has MOST_TRIES tries: an exception is tried again by Dask; a worker's death is not laid
to a frame that was merely queued there, because the last try of every frame that was about when a
worker died is made with nothing else about.
"""

import contextlib
import threading
import uuid
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

from lod.errors import InputError
from scenes.processes.standard_streams import open_standard_streams
from scenes.render.files.disk import DiskError, partial_path, stray_partials
from scenes.render.files.header import software
from scenes.render.sequence.dask_cluster import Cluster
from scenes.render.sequence.frame_session import FrameSession
from scenes.render.sequence.sequence import Job, commit_frame, kept_record, record_failure
from scenes.render.sequence.settings import Record, Settings
from scenes.render.sequence.worker import MOST_TRIES
from scenes.render.sequence.worker_child import answer

_ONE_AT_A_TIME = threading.Lock()
"""Workers may have many threads: they are the renderer's, not for many frames."""


Task = Callable[[Settings, int, str, int, int | None], dict[str, Any]]
"""What a worker runs, as frame_task."""


def frame_task(
    settings: Settings, frame: int, path: str, threads: int, most_bytes: int | None
) -> dict[str, Any]:
    """Render a frame beside where it will stand.

    Gives {record, partial}, or {input} or {disk} as worker_child does; raises RuntimeError for
    anything else that goes wrong, for Dask to try again.
    """
    from distributed import get_worker

    open_standard_streams()
    worker = get_worker()
    if settings["software"] != software():
        rule = f"a worker with {settings['software']}, as here; {worker.address} has another"
        return {"input": ["--cluster", software(), rule, "install the same versions there"]}
    partial = partial_path(Path(path))
    with _ONE_AT_A_TIME:
        _set_threads(threads or worker.state.nthreads)
        partial.unlink(missing_ok=True)
        found = answer(
            lambda: _session(worker, settings).render(frame, partial, most_bytes=most_bytes)
        )
    if "failed" in found:
        raise RuntimeError(found["failed"])
    return {**found, "partial": str(partial)}


def _session(worker: Any, settings: Settings) -> FrameSession:
    """The session of a worker, for whom it is kept from frame to frame of the same settings."""
    session: FrameSession | None = getattr(worker, "frame_session", None)
    if session is None or session.settings != settings:
        worker.frame_session = None  # its world goes before another comes
        worker.frame_session = session = FrameSession(settings)
    return session


def _set_threads(threads: int) -> None:
    import drjit

    drjit.set_thread_count(threads)


def render_on_cluster(job: Job, cluster: Cluster, task: Task = frame_task) -> Iterator[Record]:
    """Render what is not done, giving a record after each frame, in the order in which they end.

    Records and errors are those of sequence.render_sequence.
    """
    for frame in job.paths:
        if frame in job.done:
            yield kept_record(job, frame)
    tries = {frame: 0 for frame in job.paths if frame not in job.done}
    for turn in range(MOST_TRIES):
        together = [list(tries)] if turn < MOST_TRIES - 1 else [[frame] for frame in tries]
        for frames in filter(None, together):
            yield from _turn(job, cluster, task, frames, tries)


def _turn(
    job: Job, cluster: Cluster, task: Task, frames: list[int], tries: dict[int, int]
) -> Iterator[Record]:
    """Try these frames; those that end, one way or another, leave ``tries``."""
    for frame, found in _ended(job, cluster, task, frames):
        if isinstance(found, int):
            tries[frame] += found
            if tries[frame] >= MOST_TRIES:
                many = tries.pop(frame)
                yield record_failure(job, frame, f"it ended its worker {many} times", many)
            continue
        first = len(tries) == len(job.paths) - len(job.done)
        del tries[frame]
        if isinstance(found, InputError):
            if first:
                raise found
            yield record_failure(job, frame, str(found), 1)
        elif isinstance(found, BaseException):
            yield record_failure(job, frame, str(found), MOST_TRIES)
        else:
            yield commit_frame(job, frame, found["record"], Path(found["partial"]))


def _ended(
    job: Job, cluster: Cluster, task: Task, frames: list[int]
) -> Iterator[tuple[int, dict[str, Any] | BaseException | int]]:
    """Each frame as it ends: what the task gave, its error, or how many workers it ended."""
    from distributed import as_completed
    from distributed.scheduler import KilledWorker

    name, client = f"lodbench-{uuid.uuid4().hex[:12]}", cluster.client
    frame_of = {f"{name}-{frame}": frame for frame in frames}
    futures = [
        client.submit(
            task,
            job.settings,
            frame,
            str(job.paths[frame].resolve()),
            cluster.threads,
            cluster.most_bytes,
            key=key,
            retries=MOST_TRIES - 1,
            pure=False,
        )
        for key, frame in frame_of.items()
    ]
    try:
        for future in as_completed(futures):
            frame, error = frame_of[future.key], future.exception()
            if isinstance(error, KilledWorker):
                yield frame, error.allowed_failures + 1
            else:
                yield frame, error or _result(future.result(), job.paths[frame])
            future.release()
    finally:
        client.cancel(futures, force=True)


def _result(found: dict[str, Any], path: Path) -> dict[str, Any] | InputError:
    """What a task gave, or what it says of bad input. Raises what it says of the disk."""
    if "input" in found:
        where, arrived, rule, cure = found["input"]
        return InputError(where, arrived, rule, cure)
    if "disk" in found:
        raise DiskError(OSError(*found["disk"]), path)
    return found


def sweep(job: Job) -> None:
    """Remove what workers left that died; to be called when they are gone or done."""
    names = {path.name for path in job.paths.values()}
    for name, stray in stray_partials(job.folder):
        if name in names:
            with contextlib.suppress(OSError):
                stray.unlink()
