"""Standard streams that are always there, and that nobody needs to read.

A process that is started without one of them (``2>&-``) would give its number to the next file that
it opens, and a library's warning would then be written into a frame. A full disk behind stdout, or
a reader that goes away, is no reason to stop rendering: what cannot be written is lost, and
remembered, for whoever ends the program to say so. A child process ends with its parent, and keeps
its answers from chatter.

The signals that ask a program to end, which all end it in the same way: tidily.

Ctrl-C (SIGINT), ``kill`` (SIGTERM) and a terminal that closes (SIGHUP) raise ``Stopped`` wherever
the main thread is. As a KeyboardInterrupt it passes every handler of errors and runs every cleanup.
"""

import contextlib
import ctypes
import errno
import io
import os
import select
import signal
import sys
import threading
import time
from collections.abc import Iterator
from typing import Any, NoReturn, TextIO

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


ENDING = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
_AGAIN_S = 0.05
_ONE_PRESS_S = 1.0
"""Signals that follow within this time are the first one once more: a terminal sends it to every
process of a group, and programs between, such as ``timeout``, pass it on."""


class Stopped(KeyboardInterrupt):
    """A signal asked the program to end; its number, and the exit code that shells know."""

    def __init__(self, number: int) -> None:
        super().__init__()
        self.number, self.exit_code = number, 128 + number


def came_from_outside(error: BaseException) -> bool:
    """Tell whether a signal raised this, not code that raises KeyboardInterrupt by itself.

    Where Python's own handler of Ctrl-C is installed they look alike, and count as the signal.
    """
    if isinstance(error, Stopped):
        return True
    pythons = signal.getsignal(signal.SIGINT) is signal.default_int_handler
    return isinstance(error, KeyboardInterrupt) and pythons


def raise_when_stopped() -> dict[int, Any]:
    """Let the first signal wind the program up, and a Ctrl-C after it end it at once.

    Others that follow are ignored: a terminal that closes sends several. SIGHUP stays ignored where
    it is, as under ``nohup``. Gives the handlers that were installed before, for ``restore``.
    """

    def first(number: int, frame: object) -> NoReturn:
        ignore_signals()
        came = time.monotonic()

        def again(*_: object) -> None:
            if time.monotonic() - came > _ONE_PRESS_S:
                os._exit(128 + number)

        signal.signal(signal.SIGINT, again)
        raise Stopped(number)

    def lost(unraisable: Any) -> None:
        """Send the signal again where Python could only print that it was raised."""
        error = unraisable.exc_value
        if not isinstance(error, Stopped):
            sys.__unraisablehook__(unraisable)
            return
        install()
        again = threading.Timer(_AGAIN_S, os.kill, (os.getpid(), error.number))
        again.daemon = True
        again.start()

    def install() -> None:
        for number in ENDING:
            if number != signal.SIGHUP or before[number] != signal.SIG_IGN:
                signal.signal(number, first)

    before: dict[int, Any] = {number: signal.getsignal(number) for number in ENDING}
    sys.unraisablehook = lost
    install()
    return before


def restore(handlers: dict[int, Any]) -> None:
    """Install the handlers that ``raise_when_stopped`` gave."""
    sys.unraisablehook = sys.__unraisablehook__
    for number, handler in handlers.items():
        signal.signal(number, handler)


def ignore_signals() -> None:
    """Ignore every signal that asks for an end, because that has come."""
    for number in ENDING:
        signal.signal(number, signal.SIG_IGN)


@contextlib.contextmanager
def signals_held() -> Iterator[None]:
    """Hold those signals back from this thread, and for good from what is started within.

    A child then leaves its end to this process, whoever else is asked to end. What came meanwhile
    is raised at the end of the context.
    """
    before = signal.pthread_sigmask(signal.SIG_BLOCK, ENDING)
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def load_usd() -> None:
    """Import USD's modules; a signal that comes meanwhile is sent again afterwards.

    USD prints whatever is raised while it loads a module, and goes on. Raises ImportError where it
    is not installed.
    """
    came: list[int] = []
    in_main = threading.current_thread() is threading.main_thread()
    before = {n: signal.getsignal(n) for n in ENDING if in_main}
    before = {n: each for n, each in before.items() if each not in (signal.SIG_IGN, None)}
    for number in before:
        signal.signal(number, lambda n, _: came.append(n))
    try:
        from pxr import Ar, Gf, Sdf, Tf, Usd, UsdGeom, UsdLux, UsdShade, UsdUtils, Vt  # noqa: F401
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
        if came:
            os.kill(os.getpid(), came[0])
