"""A Dask cluster to render on: workers of this machine, or those of a scheduler that runs.

The only file that imports Dask (the extra ``cluster``).
"""

import contextlib
import logging
import os
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from lod.errors import InputError
from scenes.render.files.header import software
from scenes.render.mitsuba.variants import trusting

_ANSWER_S = 15
MOST_WORKERS = 1024


@dataclass(frozen=True, eq=False)
class Cluster:
    """A connection to workers.

    threads    for the renderer in each worker; 0 = as many as the worker was started with
    dashboard  where to watch it
    most_bytes  that a frame may need of memory
    """

    client: Any
    threads: int
    dashboard: str
    most_bytes: int | None = None


@contextlib.contextmanager
def cluster(
    where: str, threads: int = 0, variant: str = "", most_bytes: int | None = None
) -> Iterator[Cluster]:
    """Connect to workers: so many of this machine, or those of a scheduler's address or file.

    Local workers are given ``threads`` each, or an even share of the cores, and end with the
    context. Raises InputError where Dask is not installed, nothing answers, or a worker has other
    versions than this process.
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
            client = stack.enter_context(distributed.Client(local))
            threads = threads or max(1, (os.cpu_count() or 1) // int(where))
        else:
            client = stack.enter_context(_remote(where))
        check_versions(client)
        yield Cluster(client, threads, client.dashboard_link, most_bytes)


@contextlib.contextmanager
def _local(where: str, variant: str) -> Iterator[Any]:
    """Processes of this machine, one thread each, as much memory as there is."""
    import dask
    from distributed import LocalCluster

    if not 1 <= int(where) <= MOST_WORKERS:
        raise InputError("--cluster", where, f"from 1 to {MOST_WORKERS} workers")
    # Whoever counts the tries of a frame is told of every worker that it ended.
    settings = {"distributed.scheduler.allowed-failures": 0}
    with (
        dask.config.set(settings),
        LocalCluster(
            n_workers=int(where),
            threads_per_worker=1,
            memory_limit=0,
            dashboard_address=":0",
            silence_logs=logging.CRITICAL,
            env=trusting(variant) if variant else {},
        ) as local,
    ):
        yield local


@contextlib.contextmanager
def _remote(where: str) -> Iterator[Any]:
    from distributed import Client

    is_address = "://" in where
    if not is_address and not Path(where).is_file():
        rule = "a number of workers, a scheduler's address, or the file of one"
        raise InputError("--cluster", where, rule, "try --cluster 4 or tcp://HOST:8786")
    named = {"address": where} if is_address else {"scheduler_file": where}
    try:
        client = Client(**named, timeout=_ANSWER_S)
    except (OSError, ValueError, TypeError, KeyError) as error:
        rule = f"a scheduler that answers ({' '.join(str(error).split())})"
        raise InputError("--cluster", where, rule, "see that it runs: dask scheduler") from None
    with client:
        yield client


def check_versions(client: Any) -> None:
    """Raise InputError where a worker would not make the same pixels."""
    ours = software()
    for address, theirs in client.run(software, on_error="return").items():
        if theirs != ours:
            said = theirs if isinstance(theirs, str) else f"cannot say: {theirs}"
            rule = f"a worker with {ours}, as here; {address} has {said}"
            raise InputError("--cluster", said, rule, "install the same versions there")
