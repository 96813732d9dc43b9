"""What time and memory do frames take, each world in a fresh process, all taking turns?

The first frame of a fresh process compiles, and says how much memory such a frame takes at most.
The others are timed, from asking until the file is written, and so are the processor's seconds,
which other programs hardly change. They follow each other, as those of a
sequence do: what stands still keeps its cut. A process that holds far more than it may, or leaves
the machine next to nothing, is ended at once.
"""

import time
from collections.abc import Callable, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, field
from pathlib import Path

import psutil

from scenes.preset.tables import Preset
from scenes.render.mitsuba.variants import choose
from scenes.render.sequence.settings import Record, frame_settings
from scenes.render.sequence.worker import Worker

LEFT_BYTES = 1_000_000_000
"""Share of the machine's memory that must stay free."""

GUARD = 1.2
"""A process is ended at this many times the memory that its first frame may take."""

FILLED = 0.95
"""Share of the memory that the largest world is meant to take: no prediction is exact."""

SMALLER = 0.85


class TooLarge(Exception):
    """A frame would have taken more memory than it may."""


@dataclass(frozen=True)
class FrameProcess:
    """A process that has rendered one frame, and can render more.

    Each record also has the seconds ``wall`` of the clock and ``cpu`` of the processor.

    first  the record of the frame that compiled;  later  those of the frames since
    """

    first: Record
    render: Callable[[int], Record]
    later: list[Record] = field(default_factory=list)

    def turn(self) -> None:
        """Render the next frame."""
        self.later.append(self.render(len(self.later) + 2))

    @property
    def peak_bytes(self) -> int:
        """Peak memory of the fresh process [bytes]."""
        return int(self.first["peak_rss_bytes"])

    def samples(self) -> dict[str, list[int]]:
        """Give the microseconds of every later frame and of each stage, and the peak memory."""
        stages = {
            f"{stage}_us": [round(1e6 * each["seconds"][stage]) for each in self.later]
            for stage in self.first["seconds"]
        }
        return {
            "wall_us": [round(1e6 * each["wall"]) for each in self.later],
            "cpu_us": [round(1e6 * each["cpu"]) for each in self.later],
            **stages,
            "first_us": [round(1e6 * self.first["wall"])],
            "peak_bytes": [self.peak_bytes],
            **{name: [count] for name, count in self.first["statistics"].items()},
        }


def start_process(stack: ExitStack, folder: Path, preset: Preset, most_bytes: int) -> FrameProcess:
    """Start a process that renders the first frame; it lives as long as the stack.

    Raises TooLarge where it held more than ``most_bytes``.
    """

    seen: set[int] = set()

    def watch(process: int, taken: int, of: int) -> None:
        seen.add(process)
        if _held(process) > GUARD * most_bytes or psutil.virtual_memory().available < LEFT_BYTES:
            raise TooLarge

    settings, target = frame_settings(preset, choose(preset.render.variant)), folder / "frame.exr"
    with ExitStack() as mine:
        worker = mine.enter_context(Worker(watch=watch))

        def render(frame: int) -> Record:
            start, before = time.perf_counter(), _processor_s(seen)
            record = worker(settings, frame, target)
            wall, cpu = time.perf_counter() - start, _processor_s(seen) - before
            target.unlink()
            return {**record, "wall": wall, "cpu": cpu}

        first = render(1)
        if first["peak_rss_bytes"] > most_bytes:
            raise TooLarge
        stack.push(mine.pop_all())
    return FrameProcess(first, render)


def largest_world(
    sizes: Sequence[float],
    peaks: Sequence[int],
    most_bytes: int,
    start: Callable[[float], FrameProcess],
) -> tuple[float, FrameProcess]:
    """Find the largest world whose frame fits into the memory, and start its process.

    The size is extrapolated from the memory of the last two worlds, and reduced while it does not
    fit.
    """
    each = (peaks[-1] - peaks[-2]) / (sizes[-1] - sizes[-2])
    objects = sizes[-1] + (FILLED * most_bytes - peaks[-1]) / each
    while True:
        try:
            return objects, start(objects)
        except TooLarge:
            objects *= SMALLER


def interleave_frames(
    runners: Sequence[FrameProcess], turns: int, say: Callable[[str], object]
) -> None:
    """Render ``turns`` more frames with each process, the processes taking turns."""
    for turn in range(turns):
        say(f"turn {turn + 1} of {turns}")
        for each in runners:
            each.turn()


def _processor_s(processes: set[int]) -> float:
    """Sum the processor seconds that these processes have had on all cores."""
    return sum(sum(psutil.Process(each).cpu_times()[:2]) for each in processes)


def _held(process: int) -> int:
    try:
        return int(psutil.Process(process).memory_info().rss)
    except psutil.NoSuchProcess:
        return 0
