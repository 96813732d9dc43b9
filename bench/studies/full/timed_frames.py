"""Frames of several worlds, each in a process of its own, all taking turns; and their memory.

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

from scenes.preset.load import Preset
from scenes.render.mitsuba.variants import choose
from scenes.render.sequence.one_frame import Record, frame_settings
from scenes.render.sequence.worker import Worker

LEFT_BYTES = 1_000_000_000
"""Of the machine's memory, below which no frame may bring it."""

GUARD = 1.2
"""Times the memory that a first frame may take at most, at which a process is ended."""

FILLED = 0.95
"""Share of the memory that the largest world is meant to take: no foretelling is exact."""

SMALLER = 0.85


class TooLarge(Exception):
    """A frame that would have taken more memory than it may."""


@dataclass(frozen=True)
class Runner:
    """A process that has rendered one frame, and goes on; each record has seconds of the clock,
    ``wall``, and of the processor, ``cpu``, too.

    first  the record of the frame that compiled;  later  those of the frames since
    """

    first: Record
    render: Callable[[int], Record]
    later: list[Record] = field(default_factory=list)

    def turn(self) -> None:
        """The next frame."""
        self.later.append(self.render(len(self.later) + 2))

    @property
    def peak_bytes(self) -> int:
        """The most memory of the fresh process."""
        return int(self.first["peak_rss_bytes"])

    def samples(self) -> dict[str, list[int]]:
        """Microseconds of every later frame and of each of its stages, and what it all took."""
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


def started(stack: ExitStack, folder: Path, preset: Preset, most_bytes: int) -> Runner:
    """A fresh process that has rendered the first frame, and lives as long as the stack.

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
    return Runner(first, render)


def largest(
    sizes: Sequence[float], peaks: Sequence[int], most_bytes: int, start: Callable[[float], Runner]
) -> tuple[float, Runner]:
    """The largest world whose frame fits: foretold by the line through the last two of these worlds
    with their memory, and made smaller for as long as it does not.
    """
    each = (peaks[-1] - peaks[-2]) / (sizes[-1] - sizes[-2])
    objects = sizes[-1] + (FILLED * most_bytes - peaks[-1]) / each
    while True:
        try:
            return objects, start(objects)
        except TooLarge:
            objects *= SMALLER


def take_turns(runners: Sequence[Runner], turns: int, say: Callable[[str], object]) -> None:
    """So many more frames of each."""
    for turn in range(turns):
        say(f"turn {turn + 1} of {turns}")
        for each in runners:
            each.turn()


def _processor_s(processes: set[int]) -> float:
    """Seconds of all cores that these have had."""
    return sum(sum(psutil.Process(each).cpu_times()[:2]) for each in processes)


def _held(process: int) -> int:
    try:
        return int(psutil.Process(process).memory_info().rss)
    except psutil.NoSuchProcess:
        return 0
