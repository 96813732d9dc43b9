"""Frames of a preset as files: one door for the command line, the Python module and repairs."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from scenes.files import make_folder
from scenes.presets.schema import Preset
from scenes.render.budget import within_budget
from scenes.render.exr.frames_on_disk import Job, open_job, owned_folder
from scenes.render.exr.header import Record, Settings, frame_settings
from scenes.render.frame_session import check_acted, prepare_track
from scenes.render.variants import choose
from scenes.render.worker import ProcessWatch, Worker, ignore, render_left


@dataclass(frozen=True)
class Workers:
    """What renders frames.

    threads     for the renderer; 0 = as many as there are
    most_bytes  that a frame may need of memory, as of ``memory_limit``
    cluster     as scenes.render.cluster has it; None = a process of its own here
    """

    threads: int = 0
    most_bytes: int | None = None
    cluster: str | None = None


def settled(
    preset: Preset,
    pattern: str | Path,
    frames: Sequence[int],
    most_bytes: int | None = None,
    note: Callable[[str], object] = ignore,
) -> Settings:
    """Settle what frames of a preset are rendered with: detail within budgets, variant, actors.

    The actors act, if they have not yet, into the folder of ``pattern`` (name.####.exr). Raises
    InputError for what cannot be, and for what is estimated to need more memory than it may.
    """
    chosen = within_budget(preset, frames, most_bytes, note)
    check_acted(chosen, frames, most_bytes)
    variant = choose(chosen.render.variant, chosen.render.spectral)
    return frame_settings(chosen, variant, prepare_track(chosen, make_folder(Path(pattern).parent)))


def render_files(
    settings: Settings,
    pattern: str | Path,
    frames: Sequence[int],
    workers: Workers = Workers(),
    overwrite: bool = False,
    watch: ProcessWatch = ignore,
    note: Callable[[str], object] = ignore,
) -> Iterator[Record]:
    """Render frames that are not there yet into ``pattern``, giving a record after each.

    Raises InputError for frames of other settings that stand there, unless ``overwrite``, and while
    another process renders other settings into that folder. See ``render_job`` for the rest.
    """
    with owned_folder(make_folder(Path(pattern).parent), settings, note):
        yield from render_job(open_job(pattern, frames, settings, overwrite), workers, watch, note)


def render_job(
    job: Job, workers: Workers, watch: ProcessWatch, note: Callable[[str], object]
) -> Iterator[Record]:
    """Render the frames of a job that are not done, giving a record after each.

    ``watch`` follows the samples of a frame that is rendered here; ``note`` is called with what
    someone who waits may want to know.
    """
    if workers.cluster is None:
        with Worker(workers.threads, watch, workers.most_bytes) as worker:
            yield from render_left(job, worker)
        return
    from scenes.render.cluster import cluster, render_on_cluster, sweep

    limits = workers.threads, job.settings["render"]["variant"], workers.most_bytes
    try:
        with cluster(workers.cluster, *limits, note) as several:
            yield from render_on_cluster(job, several)
    finally:
        sweep(job)
