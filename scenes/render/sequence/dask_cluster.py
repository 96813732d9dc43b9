"""A Dask cluster to render on: workers of this machine, or those of a scheduler that runs.

The only file that imports Dask (the extra ``cluster``).
"""

import asyncio
import contextlib
import json
import logging
import os
import shutil
import tempfile
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from lod.errors import InputError
from scenes.processes.signals import signals_held
from scenes.render.files.header import software
from scenes.render.mitsuba.variants import trusting

_ANSWER_S = 8
_WORKERS_S = 300
_NOT_DASK = "what listens there does not speak as Dask does"
_SCRATCH = "lodbench-workers-"
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
    context. ``say`` is told where to watch them, and when none is there yet. Raises InputError
    where Dask is not installed, nothing answers, no worker comes, or one has other versions than
    this process.
    """
    try:
        import distributed
    except ImportError:
        rule, cure = "needs Dask", "pip install 'lodbench[cluster]'"
        raise InputError("--cluster", where, rule, cure) from None
    logging.getLogger("distributed").setLevel(logging.CRITICAL)
    with contextlib.ExitStack() as stack:
        if where.isdecimal():
            local = stack.enter_context(_local(where, variant))
            with signals_held():
                client = stack.enter_context(distributed.Client(local))
            threads = threads or max(1, (os.cpu_count() or 1) // int(where))
        else:
            client = stack.enter_context(_remote(where))
        say(f"lodbench: dashboard at {client.dashboard_link}")
        _see_a_worker(client, where, say)
        check_versions(client)
        yield Cluster(client, threads, most_bytes)


@contextlib.contextmanager
def _local(where: str, variant: str) -> Iterator[Any]:
    """Start processes of this machine, one thread each, with as much memory as there is.

    Raises ChildProcessError where one of them ends while it starts.
    """
    import dask
    from distributed import LocalCluster

    if not 1 <= int(where) <= MOST_WORKERS:
        raise InputError("--cluster", where, f"from 1 to {MOST_WORKERS} workers", "try 2")
    # Whoever counts the tries of a frame is told of every worker that it ended.
    settings = {"distributed.scheduler.allowed-failures": 0}
    with contextlib.ExitStack() as stack:
        folder = stack.enter_context(scratch_folder(dask.config.get("temporary-directory")))
        # The scheduler, too, keeps its locks there.
        stack.enter_context(dask.config.set({**settings, "temporary-directory": folder}))
        with signals_held():
            try:
                local = LocalCluster(
                    n_workers=int(where),
                    threads_per_worker=1,
                    memory_limit=0,
                    dashboard_address=":0",
                    silence_logs=logging.CRITICAL,
                    env=trusting(variant) if variant else {},
                    local_directory=folder,
                )
            except RuntimeError as error:
                why = f"a worker ended while it started ({error}): try the same command again"
                raise ChildProcessError(why) from error
            stack.enter_context(local)
        yield local


@contextlib.contextmanager
def scratch_folder(parent: str | None = None) -> Iterator[str]:
    """Make a folder for what workers keep on disk, and remove it at the end with all in it.

    What a process left that was killed is removed, too: its lock on its folder died with it.
    ``parent`` is None for the system's temporary folder.
    """
    for old in Path(parent or tempfile.gettempdir()).glob(f"{_SCRATCH}*"):
        with contextlib.suppress(OSError), _locked(old):
            shutil.rmtree(old, ignore_errors=True)
    folder = tempfile.mkdtemp(prefix=_SCRATCH, dir=parent)
    try:
        with _locked(Path(folder)):
            yield folder
    finally:
        shutil.rmtree(folder, ignore_errors=True)


@contextlib.contextmanager
def _locked(folder: Path) -> Iterator[None]:
    """Hold the lock of a folder. Raises OSError where another process has it."""
    handle = os.open(folder, os.O_RDONLY)
    try:
        with contextlib.suppress(ImportError):
            import fcntl

            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
        yield
    finally:
        os.close(handle)


@contextlib.contextmanager
def _remote(where: str) -> Iterator[Any]:
    from distributed import Client

    address = where if "://" in where else _address_in(where)
    if wrong := asyncio.run(_what_is_wrong_at(address)):
        rule, cure = f"a Dask scheduler's address; {wrong}", "see that it runs: dask scheduler"
        raise InputError("--cluster", where, rule, cure)
    with Client(address, timeout=_ANSWER_S) as client:
        yield client


def _see_a_worker(client: Any, where: str, say: Callable[[str], object]) -> None:
    """Wait for the first worker, with a task to do: clusters that grow on demand start one for it.

    Raises InputError where none comes.
    """
    if client.scheduler_info()["workers"]:
        return
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
    """Read the address that a scheduler wrote into its file."""
    try:
        return str(json.loads(Path(file).read_bytes())["address"])
    except OSError:
        rule = "a number of workers, a scheduler's address, or the file of one"
        cure = "try --cluster 4 or --cluster tcp://HOST:8786"
    except (ValueError, TypeError, KeyError, RecursionError):
        rule, cure = "the file that a Dask scheduler wrote", "dask scheduler --scheduler-file FILE"
    raise InputError("--cluster", file, rule, cure)


async def _what_is_wrong_at(address: str) -> str:
    """Greet what listens at an address as Dask does; nothing where it answers as Dask does.

    The length of an answer is its first eight bytes, to Dask, so that whatever else answers may
    appear as any error at all, MemoryError among them.
    """
    from distributed.comm import CommClosedError, connect
    from distributed.security import Security

    security = Security().get_connection_args("client")
    try:
        greeting = connect(address, timeout=_ANSWER_S / 2, **security)
        (await asyncio.wait_for(greeting, _ANSWER_S)).abort()
    except CommClosedError:
        return "what listens there closes the connection"
    except TimeoutError:
        return f"what listens there says nothing for {_ANSWER_S} s"
    except OSError:
        return "nothing answers there, or closes the connection at once"
    except (ValueError, TypeError) as error:
        known = ("address" in str(error), "TLS" in str(error))
        return str(error) if any(known) else _NOT_DASK
    except Exception:
        return _NOT_DASK
    return ""


def check_versions(client: Any) -> None:
    """Raise InputError where a worker would not make the same pixels."""
    ours = software()
    for address, theirs in client.run(software, on_error="return").items():
        if theirs != ours:
            said = theirs if isinstance(theirs, str) else f"cannot say: {theirs}"
            rule = f"a worker with {ours}, as here; {address} has {said}"
            raise InputError("--cluster", said, rule, "install the same versions there")
