"""What of another package's code is kept from this program: its printing, and ends of processes."""

import os
from collections.abc import Iterator
from contextlib import contextmanager

from scenes.processes.streams import stdout_to_stderr


class StrangersError(Exception):
    """Code of another package went wrong; the error's kind and what it says."""


@contextmanager
def guarded() -> Iterator[None]:
    """Run code of another package: stdout is not its own, and whatever it raises is caught.

    Raises StrangersError for all but Ctrl-C. A process that forked there ends there.
    """
    process, kept = os.getpid(), {number: os.dup(number) for number in (0, 2)}
    try:
        with stdout_to_stderr():
            yield
    except KeyboardInterrupt:
        raise
    except BaseException as error:
        raise StrangersError(f"{type(error).__name__}: {error}") from error
    finally:
        if os.getpid() != process:
            os._exit(1)
        for number, copy in kept.items():  # it may have closed them
            os.dup2(copy, number)
            os.close(copy)
