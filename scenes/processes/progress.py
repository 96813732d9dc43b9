"""How far is work that is done once and then kept? Told from deep below, to whoever follows.

Work has a number of steps. Whoever follows hears of it when a step is begun or done, and nothing of
steps whose result was kept: work that was all done before is silent.
"""

import itertools
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass

Follow = Callable[[str, float, int], object]
"""Called with what is done, the steps done of it, whole and parts, and their number."""


@dataclass
class _Work:
    what: str
    steps: int
    done: float = 0.0
    told: bool = False


def _ignore(what: str, done: float, steps: int) -> None:
    """Follow nothing."""


_FOLLOW: ContextVar[Follow] = ContextVar("follow", default=_ignore)
_WORK: ContextVar[_Work | None] = ContextVar("work", default=None)


@contextmanager
def followed_by(follow: Follow) -> Iterator[None]:
    """Have ``follow`` called of all work that is done inside."""
    before = _FOLLOW.set(follow)
    try:
        yield
    finally:
        _FOLLOW.reset(before)


@contextmanager
def kernels_told() -> Iterator[None]:
    """Tell of every kernel that Numba compiles inside; nobody knows how many there will be."""
    from numba.core import event

    follow, number = _FOLLOW.get(), itertools.count(1)

    class Told(event.Listener):
        def on_start(self, event: object) -> None:
            follow(f"compiling kernels, which are kept: {next(number)}", 0.0, 0)

        def on_end(self, event: object) -> None:
            pass

    with event.install_listener("numba:compile", Told()):
        yield


@contextmanager
def work(what: str, steps: int) -> Iterator[None]:
    """Announce work of so many steps, which are told of inside; its end is told if any step was."""
    mine = _Work(what, steps)
    before = _WORK.set(mine)
    try:
        yield
        if mine.told:
            _FOLLOW.get()(what, steps, steps)
    finally:
        _WORK.reset(before)


def tell(share: float = 0.0) -> None:
    """Tell that a share of a step is done, or by default that one begins."""
    mine = _WORK.get()
    if mine is not None:
        mine.told, mine.done = True, min(mine.done + share, mine.steps)
        _FOLLOW.get()(mine.what, mine.done, mine.steps)


@contextmanager
def steps(count: int) -> Iterator[None]:
    """Do so many steps; what is not told of inside was kept, and is only counted."""
    mine = _WORK.get()
    first = mine.done if mine else 0.0
    yield
    if mine is not None:
        mine.done = min(first + count, mine.steps)
