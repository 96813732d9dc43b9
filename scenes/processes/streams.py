"""Standard streams that are always there, and that nobody needs to read.

A process that is started without one of them (``2>&-``) would give its number to the next file that
it opens, and a library's warning would then be written into a frame. A full disk behind stdout, or
a reader that goes away, is no reason to stop rendering: what cannot be written is lost, and
remembered, for whoever ends the program to say so. A child process ends with its parent, and keeps
its answers from chatter.
"""

import contextlib
import ctypes
import errno
import io
import os
import select
import signal
import sys
from collections.abc import Iterator
from typing import Any, TextIO

_STREAMS = ("stdin", "stdout", "stderr")


class LenientFile(io.FileIO):
    """A file whose writer never hears that writing failed; ``failure`` is the first such error."""

    failure: OSError | None = None

    def write(self, data: Any, /) -> int:
        """Write what can be written, waiting for a reader who is slow; give the size of all."""
        rest = memoryview(data).cast("B")
        while rest and self.failure is None:
            try:
                written = super().write(rest)
            except OSError as error:
                self.failure = error
                break
            if written is None:  # a pipe that does not block, and is full
                select.select([], [self], [])
            else:
                rest = rest[written:]
        return memoryview(data).nbytes


def open_standard_streams() -> None:
    """Open what the system left closed as /dev/null, and make stdout and stderr lenient.

    Streams that stand in for the process's own, as those of tests, are left as they are.
    """
    for number, name in enumerate(_STREAMS):
        try:
            os.fstat(number)
        except OSError:
            os.set_inheritable(os.open(os.devnull, os.O_RDWR), True)  # the lowest number is free
        if name != "stdin" and getattr(sys, name) is getattr(sys, f"__{name}__"):
            setattr(sys, name, lenient_stream(number, getattr(sys, name)))


def lenient_stream(number: int, like: TextIO | None = None, closefd: bool = False) -> TextIO:
    """Open a lenient text stream on a file descriptor, with the encoding of another one.

    What that encoding lacks is written as an escape.
    """
    file = LenientFile(number, "w", closefd=closefd)
    stream = io.TextIOWrapper(
        io.BufferedWriter(file),
        encoding=like.encoding if like else "utf-8",
        errors="backslashreplace",
        line_buffering=number == 2 or file.isatty(),
    )
    stream.mode = "w"  # type: ignore[misc]  # as open() does: it belongs to a TextIO
    return stream


@contextlib.contextmanager
def stdout_to_stderr() -> Iterator[None]:
    """Send what libraries print, from Python and from C, to stderr: stdout is for results."""
    if sys.stdout is None:  # as without a terminal on Windows, and where a caller says so
        yield
        return
    sys.stdout.flush()
    kept = os.dup(1)
    try:
        os.dup2(2, 1)
        with contextlib.redirect_stdout(sys.stderr):
            yield
    finally:
        os.dup2(kept, 1)
        os.close(kept)


def write_failure(stream: Any) -> OSError | None:
    """Flush a stream, and give the first error that was met while writing to it, if any."""
    raw = getattr(getattr(stream, "buffer", None), "raw", None)
    if not isinstance(raw, LenientFile):
        return None
    stream.flush()
    return raw.failure


def carry_failure(source: TextIO, target: object) -> None:
    """Let a stream that goes on answer for the failure of one that ends."""
    failure, raw = write_failure(source), getattr(getattr(target, "buffer", None), "raw", None)
    if isinstance(raw, LenientFile):
        raw.failure = raw.failure or failure


def is_unread(failure: OSError | None) -> bool:
    """Say whether the reader went away, as that of ``| head`` does, which is nobody's fault."""
    return failure is not None and failure.errno == errno.EPIPE


_PR_SET_PDEATHSIG = 1


def end_with_parent(parent: int) -> None:
    """Have this process killed when its parent dies, however it dies, where the system can."""
    prctl = getattr(ctypes.CDLL(None), "prctl", None)
    if prctl is not None:
        prctl(_PR_SET_PDEATHSIG, signal.SIGKILL)
    if os.getppid() != parent:
        os._exit(1)


def own_stdout() -> TextIO:
    """Take stdout for answers alone; what libraries print then goes to stderr."""
    answers = os.fdopen(os.dup(1), "w", encoding="utf-8")
    os.dup2(2, 1)
    return answers
