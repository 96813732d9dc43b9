"""The signals that ask a program to end, which all end it in the same way: tidily.

Ctrl-C (SIGINT), ``kill`` (SIGTERM) and a terminal that closes (SIGHUP) raise ``Stopped`` wherever
the main thread is. As a KeyboardInterrupt it passes every handler of errors and runs every cleanup.
"""

import contextlib
import os
import signal
import sys
import threading
import time
from collections.abc import Iterator
from typing import Any, NoReturn

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
