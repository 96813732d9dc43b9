"""A process that renders frames and can be killed, by Ctrl-C at once or by its own death.

It stays from frame to frame, so that its world, its compiled kernels and its caches do. The
renderer never enters the process that starts it. ``Worker`` is the one end, ``serve`` the other.

Requests and answers are JSON objects, one a line. A request is {settings}, which opens a session
with them, {preflight: frames, folder, most_bytes} or {frame, target, most_bytes}. The answers are
{ready} once; an empty {record} of a session that is open, and of frames whose memory is estimated;
and of each frame {samples: [taken, of]} some times, and then its {record}. Before any of them may
come {making: [what, done, steps]} of what is made once and then kept. In place of any record may
come {input: [where, arrived, rule, cure]}, {disk: [errno, strerror, file]} or {failed: text}.
"""

import contextlib
import json
import os
import select
import signal
import subprocess
import sys
import traceback
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from pathlib import Path
from typing import Any

from lod.errors import InputError
from scenes.processes.progress import followed_by, kernels_told
from scenes.processes.streams import (
    end_with_parent,
    open_standard_streams,
    own_stdout,
    signals_held,
)
from scenes.render.exr.frames_on_disk import FrameFailed, Job, render_sequence
from scenes.render.exr.header import Record, Settings
from scenes.render.variants import trusting

MOST_TRIES = 3  # how often a frame may kill its worker

MOST_ESTIMATED = 16
"""Frames of a sequence whose memory is estimated before the first of them is rendered."""

CHILD = (sys.executable, "-P", "-m", "scenes.render.worker")

_ROOT = Path(__file__).resolve().parents[2]

_TICK_S = 0.5

Making = tuple[str, float, int]
"""What is made once and then kept, the steps done of it, and their number (``Follow``)."""

ProcessWatch = Callable[[int, int, int, Making | None], object]
"""Called twice a second, and whenever samples are taken or something is made, with the process's
id, the samples of the frame so far, how many it will have, and what is made before them."""

_MALLOC = {
    "MALLOC_MMAP_THRESHOLD_": str(2**23),
    "MALLOC_TRIM_THRESHOLD_": str(2**24),
    "GLIBC_TUNABLES": "glibc.malloc.hugetlb=1",
}
"""Settings of glibc's allocator in the process that renders.

The memory of an array of 8 MB and more goes back to the system as soon as the array is freed
(MMAP_THRESHOLD). Smaller arrays reuse memory, because asking the system again would cost more time
than the room is worth: up to 16 MB of free memory stay with the process (TRIM_THRESHOLD), which
threads would otherwise give back after each run of points. hugetlb=1 asks for large pages on
systems that give them only on request: the memory of a frame is new, and one large page takes the
place of 512 small ones that would have to be mapped one by one."""


def ignore(*_: object) -> None:
    """Watch nothing."""


class Worker(contextlib.AbstractContextManager):
    """Renders frames in a process of its own, which ends with the context.

    threads     for the renderer; 0 = one for each core
    most_bytes  that a frame may need of memory
    """

    def __init__(
        self, threads: int = 0, watch: ProcessWatch = ignore, most_bytes: int | None = None
    ) -> None:
        self._threads, self._watch, self._most_bytes = threads, watch, most_bytes
        self._process: subprocess.Popen[bytes] | None = None
        self._unread = b""
        self._settings: Settings | None = None

    def __exit__(self, *_: object) -> None:
        self.end()

    def __call__(self, settings: Settings, frame: int, target: Path) -> Record:
        """Render a frame into ``target``, as FrameSession.render does.

        The settings go to the process once, until others come. Raises what FrameSession raises, and
        FrameFailed for any other error and for a frame that has killed MOST_TRIES workers.
        """
        request = {"frame": frame, "target": str(target), "most_bytes": self._most_bytes}
        for _ in range(MOST_TRIES):
            if self._process is None:
                self._start(settings["render"]["variant"])
            if self._open_session(settings):
                found = self._ask(request)
                if found is not None:
                    return _record(found)
            target.unlink(missing_ok=True)
            why = self.end()
        raise FrameFailed(f"it ended its worker {MOST_TRIES} times ({why})", MOST_TRIES)

    def preflight(self, settings: Settings, frames: Sequence[int], folder: Path) -> None:
        """Raise InputError where one of these frames is estimated to need more than it may.

        A process that dies of it says nothing: the frames' own turns will tell.
        """
        if self._process is None:
            self._start(settings["render"]["variant"])
        request = {"preflight": frames, "folder": str(folder), "most_bytes": self._most_bytes}
        found = self._ask(request) if self._open_session(settings) else None
        if found is None:
            self.end()
        else:
            _record(found)

    def _open_session(self, settings: Settings) -> bool:
        """Send settings that the process does not have yet; gives whether it lives."""
        if self._settings == settings:
            return True
        self._settings = None
        found = self._ask({"settings": settings})
        if found is None:
            return False
        _record(found)
        self._settings = settings
        return True

    def end(self) -> str:
        """Kill the process, if there is one, and wait for its end; says how it ended."""
        process, self._process, self._unread = self._process, None, b""
        self._settings = None
        if process is None:
            return ""
        with process:  # closes both pipes
            code = process.poll()
            process.kill()
        return _how(process.returncode if code is None else code)

    def _start(self, variant: str) -> None:
        """Start the process, which no signal asks to end: this one ends it."""
        paths = os.pathsep.join([str(_ROOT), *filter(None, [os.environ.get("PYTHONPATH")])])
        with signals_held():
            self._process = subprocess.Popen(
                [*CHILD, str(os.getpid()), str(self._threads)],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                bufsize=0,
                env={**_MALLOC, **trusting(variant), "PYTHONPATH": paths},
            )
        if self._answer() is None:
            raise RuntimeError(f"the process that renders does not start ({self.end()})")

    def _ask(self, request: dict[str, Any]) -> dict[str, Any] | None:
        """Send a request and wait for the answer; None from a process that died."""
        assert self._process is not None and self._process.stdin is not None
        try:
            self._process.stdin.write(json.dumps(request).encode() + b"\n")
            self._process.stdin.flush()
        except BrokenPipeError:
            return None
        return self._answer()

    def _answer(self) -> dict[str, Any] | None:
        """The next line of the process, watched while it is awaited; None when it died."""
        assert self._process is not None and self._process.stdout is not None
        source = self._process.stdout.fileno()
        samples, of = 0, 0
        making: Making | None = None
        while True:
            line, end, rest = self._unread.partition(b"\n")
            if end:
                self._unread = rest
                found: dict[str, Any] = json.loads(line)
                if "making" in found:
                    what, done, steps = found["making"]
                    making = (what, done, steps) if done < steps or not steps else None
                elif "samples" in found:
                    making, (samples, of) = None, found["samples"]
                else:
                    return found
            elif select.select([source], [], [], _TICK_S)[0]:
                data = os.read(source, 2**16)
                if not data:
                    return None
                self._unread += data
                continue
            self._watch(self._process.pid, samples, of, making)


def render_left(job: Job, worker: Worker) -> Iterator[Record]:
    """Render what is not done as ``render_sequence`` does, with its memory estimated before.

    Of more than MOST_ESTIMATED frames so many are estimated, evenly spread, the first and the last
    among them. Raises InputError before any is rendered where one would need more than it may.
    """
    left = [frame for frame in job.paths if frame not in job.done]
    if len(left) > 1:
        if (n := len(left) - 1) >= MOST_ESTIMATED:
            left = [left[round(k * n / (MOST_ESTIMATED - 1))] for k in range(MOST_ESTIMATED)]
        worker.preflight(job.settings, left, job.folder)
    yield from render_sequence(job, worker)


def _record(found: dict[str, Any]) -> Record:
    if "input" in found:
        where, arrived, rule, cure = found["input"]
        raise InputError(where, arrived, rule, cure)
    if "disk" in found:
        raise OSError(*found["disk"])
    if "failed" in found:
        raise FrameFailed(found["failed"], 1)
    record: Record = found["record"]
    return record


def _how(code: int) -> str:
    if code >= 0:
        return f"exit code {code}"
    name = signal.Signals(-code).name if -code in set(signal.Signals) else f"signal {-code}"
    return f"{name}, perhaps for want of memory" if code == -signal.SIGKILL else name


def answer(work: Callable[[], Record]) -> dict[str, Any]:
    """Do what is asked for; whatever goes wrong becomes an answer."""
    try:
        return {"record": work()}
    except InputError as error:
        return {"input": [error.where, error.arrived, error.rule, error.cure]}
    except OSError as error:
        return {"disk": [error.errno, error.strerror or str(error), error.filename]}
    except Exception as error:
        if os.environ.get("LODBENCH_TRACEBACK"):
            traceback.print_exc()
        text = " ".join(str(error).split())
        return {"failed": f"{type(error).__name__}: {text}" if text else type(error).__name__}


def serve(open_session: Callable[[Settings], Any]) -> None:
    """Answer every line of stdin until it ends. argv: the parent's number, threads (0 = all).

    A session is what a FrameSession is: it has ``preflight`` and ``render``.
    """
    parent, threads = map(int, sys.argv[1:3])
    end_with_parent(parent)
    open_standard_streams()
    answers = own_stdout()
    session: Any = None

    def say(data: dict[str, Any]) -> None:
        print(json.dumps(data, default=str), file=answers, flush=True)

    def watch(samples: int, of: int) -> None:
        say({"samples": [samples, of]})

    def work(request: dict[str, Any]) -> Record:
        nonlocal session
        if "settings" in request:
            session = None  # its world goes before another comes
            session = open_session(request["settings"])
            return {}
        record: Record
        if "preflight" in request:
            frames = request.pop("preflight")
            record = session.preflight(frames, **request)
        else:
            record = session.render(watch=watch, **request)
        return record

    say({"ready": os.getpid()})
    if threads:
        import drjit

        drjit.set_thread_count(threads)
    with followed_by(lambda *made: say({"making": made})), kernels_told():
        for line in sys.stdin:
            say(answer(partial(work, json.loads(line))))


if __name__ == "__main__":
    from scenes.render.frame_session import FrameSession

    serve(FrameSession)
