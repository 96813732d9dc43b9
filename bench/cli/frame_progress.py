"""How far a sequence is: frames, samples, time left and memory, on a terminal only."""

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

_FORMAT = "{percentage:3.0f} % {bar} {n:.1f}/{total} frames, {elapsed}, {remaining} left{postfix}"


class FrameProgress:
    """A bar over the frames of a sequence that also moves within a frame."""

    def __init__(self, bar: Any) -> None:
        self._bar, self._done = bar, 0

    def aside(self) -> None:
        """Make way for a line that is about to be printed."""
        self._bar.clear()

    def finished(self, record: dict[str, Any]) -> None:
        """One frame more; a kept one says nothing about the time that the others take."""
        if self._bar.disable:
            return
        self._done += 1
        if record.get("kept"):
            self._bar.initial += 1
        self._move(self._done)

    def watch(self, process: int, taken: int, of: int) -> None:
        """The process that renders, and the samples of its frame: taken, and of how many."""
        if self._bar.disable:
            return
        words = [f"{taken / of:.0%} of {of / 1e6:.1f} M samples" if of else "preparing"]
        self._bar.set_postfix_str(", ".join([*words, *_memory(process)]), refresh=False)
        self._move(self._done + (taken / of if of else 0.0))

    def _move(self, frames: float) -> None:
        self._bar.n = frames
        self._bar.refresh()


@contextmanager
def frame_progress(frames: int) -> Iterator[FrameProgress]:
    """A bar for so many frames; away from a terminal it is silent."""
    from tqdm import tqdm

    off = not sys.stderr.isatty()
    with tqdm(
        total=frames, disable=off, leave=False, file=sys.stderr, bar_format=_FORMAT, smoothing=0
    ) as bar:
        yield FrameProgress(bar)


def _memory(process: int) -> Iterator[str]:
    import psutil

    try:
        yield f"{psutil.Process(process).memory_info().rss / 1e9:.2f} GB"
    except psutil.Error:
        return
