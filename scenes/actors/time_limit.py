"""A limit on the time that somebody else's code may take."""

import contextlib
import signal
import threading
from collections.abc import Iterator
from types import FrameType


class TimeLimitError(BaseException):
    """The time is up; no ``except Exception`` catches it."""


@contextlib.contextmanager
def time_limit(seconds: float) -> Iterator[None]:
    """Raise TimeLimitError within, once so many seconds have gone by.

    It works by an alarm, which only the main thread gets; within another limit and in other threads
    nothing is done.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    if signal.getitimer(signal.ITIMER_REAL)[0] > 0:
        yield
        return
    before = signal.signal(signal.SIGALRM, _time_is_up)
    signal.setitimer(signal.ITIMER_REAL, seconds, 1.0)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, before)


def _time_is_up(number: int, frame: FrameType | None) -> None:
    raise TimeLimitError
