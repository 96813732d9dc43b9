"""Where frames are rendered: in a process of its own here, or on a cluster."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from scenes.render.exr.sequence import Job
    from scenes.render.worker import ProcessWatch


@dataclass(frozen=True)
class Workers:
    """What renders the frames of a job.

    threads     for the renderer; 0 = as many as there are
    most_bytes  that a frame may need of memory; None = whatever it needs
    cluster     as scenes.render.cluster has it; None = a process of its own here
    """

    threads: int
    most_bytes: int | None
    cluster: str | None


def render_job(
    job: "Job", workers: Workers, watch: "ProcessWatch", note: Callable[[str], object]
) -> Iterator[dict[str, Any]]:
    """Render the frames of a job that are not done, giving a record after each.

    ``watch`` follows the samples of a frame that is rendered here; ``note`` is called with what
    someone who waits may want to know.
    """
    if workers.cluster is None:
        from scenes.render.worker import Worker, render_foretold

        with Worker(workers.threads, watch, workers.most_bytes) as worker:
            yield from render_foretold(job, worker)
        return
    from scenes.render.cluster import cluster, render_on_cluster, sweep

    variant = job.settings["render"]["variant"]
    try:
        limits = workers.threads, variant, workers.most_bytes
        with cluster(workers.cluster, *limits, note) as several:
            yield from render_on_cluster(job, several)
    finally:
        sweep(job)
