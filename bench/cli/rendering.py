"""Where frames are rendered: in a process of its own here, or on a cluster."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from bench.cli.progress import FrameProgress

if TYPE_CHECKING:
    from scenes.render.sequence.sequence import Job


@dataclass(frozen=True)
class Rendering:
    """How a job is rendered; called with one, it gives a record after each frame.

    threads     for the renderer; 0 = as many as there are
    most_bytes  that a frame may need of memory; None = whatever it needs
    cluster     as scenes.render.sequence.dask_cluster has it; None = here
    say         told what someone who waits may want to know
    """

    threads: int
    most_bytes: int | None
    cluster: str | None
    say: Callable[[str], object]

    def __call__(self, job: "Job", progress: FrameProgress) -> Iterator[dict[str, Any]]:
        """Render the job's frames."""
        return self._here(job, progress) if self.cluster is None else self._there(job, self.cluster)

    def _here(self, job: "Job", progress: FrameProgress) -> Iterator[dict[str, Any]]:
        from scenes.render.sequence.sequence import render_sequence
        from scenes.render.sequence.worker import Worker

        with Worker(self.threads, progress.show_samples, self.most_bytes) as worker:
            yield from render_sequence(job, worker)

    def _there(self, job: "Job", where: str) -> Iterator[dict[str, Any]]:
        from scenes.render.sequence.dask_cluster import cluster
        from scenes.render.sequence.dask_frames import render_on_cluster, sweep

        variant = job.settings["render"]["variant"]
        try:
            with cluster(where, self.threads, variant, self.most_bytes) as workers:
                self.say(f"lodbench: dashboard at {workers.dashboard}")
                yield from render_on_cluster(job, workers)
        finally:
            sweep(job)
