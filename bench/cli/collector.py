"""When does a command not look for garbage? While it makes what stays until it ends."""

import gc
from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def collector_paused() -> Iterator[None]:
    """Pause Python's search for garbage in cycles, which takes a tenth of a command that is short.

    Modules and compiled kernels are a million objects that are never garbage, and each search looks
    at them again. Arrays are freed as ever, when nothing refers to them.
    """
    was_on = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if was_on:
            gc.enable()
