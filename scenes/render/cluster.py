"""A sequence on a Dask cluster: one task a frame, one frame a worker at a time.

Workers are processes of this machine, or those of a scheduler that runs; they must see the folder
under the same path. What they write gets its name here. Every frame has MOST_TRIES tries: an
exception is tried again by Dask; a worker's death is not laid to a frame that was merely queued
there, because the last try of every frame that was about when a worker died is made with nothing
else about. The only file that imports Dask (the extra ``cluster``).
"""

import asyncio
import contextlib
import json
import logging
import os
import tempfile
import threading
import time
import uuid
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import chain
from pathlib import Path
from typing import Any

from lod.errors import InputError
from scenes.files import DiskError, partial_path, stray_partials
from scenes.processes.streams import open_standard_streams, signals_held
from scenes.render.exr.frames_on_disk import Job, commit_frame, failure, kept_record
from scenes.render.exr.header import Record, Settings, software
from scenes.render.frame_session import FrameSession
from scenes.render.variants import trusting
from scenes.render.worker import MOST_TRIES, answer

_ANSWER_S = 8
_WORKERS_S = 300
MOST_WORKERS = 1024


@dataclass(frozen=True, eq=False)
class Cluster:
    """A connection to workers.

    threads    for the renderer in each worker; 0 = as many as the worker was started with
    most_bytes  that a frame may need of memory
    """

    client: Any
    threads: int
    most_bytes: int | None = None


@contextlib.contextmanager
def cluster(
    where: str,
    threads: int = 0,
    variant: str = "",
    most_bytes: int | None = None,
    say: Callable[[str], object] = lambda text: None,
) -> Iterator[Cluster]:
    """Connect to workers: so many of this machine, or those of a scheduler's address or file.

    Local workers are given ``threads`` each, or an even share of the cores, and end with the
    context. They take tasks from this process alone: all of them share a certificate that exists
    only in their memory, listen on the loopback, and serve no page. ``say`` is told where to watch
    a scheduler that has a page, and when it has no worker yet. Raises InputError where Dask is not
    installed, nothing answers, no worker comes, or one has other versions than this process.
    """
    try:
        import distributed

        certificate = distributed.Security.temporary() if where.isdecimal() else None
    except ImportError:
        rule, cure = "needs Dask and cryptography", "pip install 'lodbench[cluster]'"
        raise InputError("--cluster", where, rule, cure) from None
    for logger in ("distributed", "distributed.client", "tornado.application"):
        logging.getLogger(logger).setLevel(logging.CRITICAL)
    with contextlib.ExitStack() as stack:
        if where.isdecimal():
            local = stack.enter_context(_local(where, variant, certificate))
            with signals_held():
                client = stack.enter_context(distributed.Client(local))
            threads = threads or max(1, (os.cpu_count() or 1) // int(where))
        else:
            address = where if "://" in where else _address_in(where)
            try:
                asyncio.run(_greet(address))
            except Exception as error:  # what is not Dask may appear as any error at all
                why = str(error).split("\n")[0][:200] or type(error).__name__
                rule = f"a Dask scheduler's address; connecting ended with: {why}"
                cure = "see that it runs: dask scheduler"
                raise InputError("--cluster", where, rule, cure) from None
            client = stack.enter_context(distributed.Client(address, timeout=_ANSWER_S))
            say(f"lodbench: dashboard at {client.dashboard_link}")
        if not client.scheduler_info()["workers"]:
            _wait_for_a_worker(client, where, say)
        check_versions(client)
        try:
            yield Cluster(client, threads, most_bytes)
        except distributed.CancelledError:
            raise ConnectionError(f"{where}: the scheduler has gone") from None


@contextlib.contextmanager
def _local(where: str, variant: str, certificate: Any) -> Iterator[Any]:
    """Start processes of this machine, one thread each, with as much memory as there is.

    Raises ChildProcessError where one of them ends while it starts.
    """
    import dask
    from distributed import LocalCluster

    if not 1 <= int(where) <= MOST_WORKERS:
        raise InputError("--cluster", where, f"from 1 to {MOST_WORKERS} workers", "try 2")
    # Whoever counts the tries of a frame is told of every worker that it ended.
    settings = {
        "distributed.scheduler.allowed-failures": 0,
        "distributed.scheduler.http.routes": [],
        "distributed.worker.http.routes": [],
    }
    with contextlib.ExitStack() as stack:
        parent = dask.config.get("temporary-directory")
        folder = stack.enter_context(
            tempfile.TemporaryDirectory("", "lodbench-workers-", parent, ignore_cleanup_errors=True)
        )
        # The scheduler, too, keeps its locks there.
        stack.enter_context(dask.config.set({**settings, "temporary-directory": folder}))
        with signals_held():
            try:
                local = LocalCluster(
                    n_workers=int(where),
                    threads_per_worker=1,
                    memory_limit=0,
                    host="127.0.0.1",
                    security=certificate,
                    dashboard_address="127.0.0.1:0",
                    scheduler_kwargs={"dashboard": False},
                    silence_logs=logging.CRITICAL,
                    env=trusting(variant) if variant else {},
                    local_directory=folder,
                )
            except RuntimeError as error:
                why = f"a worker ended while it started ({error}): try the same command again"
                raise ChildProcessError(why) from error
            stack.enter_context(local)
        yield local


def _wait_for_a_worker(client: Any, where: str, say: Callable[[str], object]) -> None:
    """Wait with a task to do: clusters that grow on demand start a worker for it."""
    say(f"lodbench: {where} has no worker yet: waiting for one, {_WORKERS_S} s at most")
    task = client.submit(software, pure=False)
    try:
        task.exception(timeout=_WORKERS_S)
    except TimeoutError:
        task.cancel()
        rule = f"a scheduler with workers; none came in {_WORKERS_S} s"
        cure = f"start one: dask worker {client.scheduler.address}"
        raise InputError("--cluster", where, rule, cure) from None


def _address_in(file: str) -> str:
    try:
        return str(json.loads(Path(file).read_bytes())["address"])
    except OSError:
        rule = "a number of workers, a scheduler's address, or the file of one"
        cure = "try --cluster 4 or --cluster tcp://HOST:8786"
    except (ValueError, TypeError, KeyError, RecursionError):
        rule, cure = "the file that a Dask scheduler wrote", "dask scheduler --scheduler-file FILE"
    raise InputError("--cluster", file, rule, cure)


async def _greet(address: str) -> None:
    """Greet what listens at an address as Dask does; a client of Dask would wait for ever."""
    from distributed import Security
    from distributed.comm import connect

    security = Security().get_connection_args("client")
    greeting = connect(address, timeout=_ANSWER_S / 2, **security)
    (await asyncio.wait_for(greeting, _ANSWER_S)).abort()


def check_versions(client: Any) -> None:
    """Raise InputError where a worker would not make the same pixels."""
    ours = software()
    for address, theirs in client.run(software, on_error="return").items():
        if theirs != ours:
            said = theirs if isinstance(theirs, str) else f"cannot say: {theirs}"
            rule = f"a worker with {ours}, as here; {address} has {said}"
            raise InputError("--cluster", said, rule, "install the same versions there")


_ONE_AT_A_TIME = threading.Lock()
"""Workers may have many threads: they are the renderer's, not for many frames."""

Task = Callable[[Settings, int, str, int, int | None], dict[str, Any]]
"""What a worker runs, as frame_task."""


def frame_task(
    settings: Settings, frame: int, path: str, threads: int, most_bytes: int | None
) -> dict[str, Any]:
    """Render a frame beside where it will stand.

    Gives {record, partial}, or {input} or {disk} as worker.answer does; raises RuntimeError
    for anything else that goes wrong, for Dask to try again.
    """
    from distributed import get_worker

    open_standard_streams()
    worker = get_worker()
    if settings["software"] != software():
        rule = f"a worker with {settings['software']}, as here; {worker.address} has another"
        return {"input": ["--cluster", software(), rule, "install the same versions there"]}
    partial = partial_path(Path(path))
    with _ONE_AT_A_TIME:
        import drjit

        drjit.set_thread_count(threads or worker.state.nthreads)
        partial.unlink(missing_ok=True)

        def render() -> Record:
            session: FrameSession | None = getattr(worker, "frame_session", None)
            if session is None or session.settings != settings:
                worker.frame_session = None  # its world goes before another comes
                worker.frame_session = session = FrameSession(settings)
            return session.render(frame, partial, most_bytes=most_bytes)

        found = answer(render)
    if "failed" in found:
        raise RuntimeError(found["failed"])
    return {**found, "partial": str(partial)}


def render_on_cluster(job: Job, cluster: Cluster, task: Task = frame_task) -> Iterator[Record]:
    """Render what is not done, giving a record after each frame, in the order in which they end.

    Records and errors are those of frames_on_disk.render_sequence.
    """
    for frame in job.paths:
        if frame in job.done:
            yield kept_record(job, frame)
    tries = {frame: 0 for frame in job.paths if frame not in job.done}
    first = True
    for turn in range(MOST_TRIES):
        together = [list(tries)] if turn < MOST_TRIES - 1 else [[frame] for frame in tries]
        for frame, found in chain.from_iterable(
            _ended(job, cluster, task, frames) for frames in together if frames
        ):
            if isinstance(found, int):
                tries[frame] += found
                if tries[frame] >= MOST_TRIES:
                    many = tries.pop(frame)
                    yield failure(job, frame, f"it ended its worker {many} times", many)
                continue
            del tries[frame]
            if isinstance(found, InputError):
                if first:
                    raise found
                yield failure(job, frame, str(found), 1)
            elif isinstance(found, BaseException):
                yield failure(job, frame, str(found), MOST_TRIES)
            else:
                try:
                    yield commit_frame(job, frame, found["record"], Path(found["partial"]))
                except InputError as error:  # what came to stand there meanwhile
                    yield failure(job, frame, str(error), 1)
            first = False


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
    ended, seen = as_completed(futures), time.monotonic()
    try:
        while ended.count():
            if not ended.has_ready():
                time.sleep(0.05)
                if time.monotonic() - seen > _WORKERS_S:
                    if not client.scheduler_info()["workers"]:
                        rule = f"a cluster that has a worker within {_WORKERS_S} s"
                        cure = "start workers, and give the same command again"
                        raise InputError("--cluster", "no worker is left", rule, cure)
                    seen = time.monotonic()
                continue
            future, seen = next(ended), time.monotonic()
            frame, error = frame_of[future.key], future.exception()
            if isinstance(error, KilledWorker):
                yield frame, error.allowed_failures + 1
            elif error:
                yield frame, error
            else:
                found = future.result()
                if "disk" in found:
                    raise DiskError(OSError(*found["disk"]), job.paths[frame])
                yield frame, InputError(*found["input"]) if "input" in found else found
            future.release()
    finally:
        client.cancel(futures, force=True)


def sweep(job: Job) -> None:
    """Remove what workers left that died; to be called when they are gone or done."""
    names = {path.name for path in job.paths.values()}
    for name, stray in stray_partials(job.folder):
        if name in names:
            with contextlib.suppress(OSError):
                stray.unlink()
