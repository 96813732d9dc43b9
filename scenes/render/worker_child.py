"""The process that renders frames for scenes/render/worker.py.

Requests and answers are JSON objects, one a line. A request is {settings}, which opens a session
with them, {preflight: frames, folder, most_bytes} or {frame, target, most_bytes}. The answers are
{ready} once; an empty {record} of a session that is open, and of frames whose memory is estimated;
and of each frame {samples: [taken, of]} some times, and then its {record}. Before any of them may
come {making: [what, done, steps]} of what is made once and then kept. In place of any record may
come {input: [where, arrived, rule, cure]}, {disk: [errno, strerror, file]} or {failed: text}.
"""

import json
import os
import sys
import traceback
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any, Protocol

from lod.errors import InputError
from scenes.processes.progress import followed_by
from scenes.processes.streams import end_with_parent, open_standard_streams, own_stdout
from scenes.render.exr.header import Record, Settings
from scenes.render.frame_session import FrameSession


class Session(Protocol):
    """What renders frames, as FrameSession does."""

    def preflight(self, frames: Sequence[int], folder: str, most_bytes: int | None) -> Record:
        """Estimate the memory of frames."""

    def render(
        self,
        frame: int,
        target: str,
        watch: Callable[[int, int], object],
        most_bytes: int | None,
    ) -> Record:
        """Render a frame into a file."""


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


def serve(open_session: Callable[[Settings], Session] = FrameSession) -> None:
    """Answer every line of stdin until it ends. argv: the parent's number, threads (0 = all)."""
    parent, threads = map(int, sys.argv[1:3])
    end_with_parent(parent)
    open_standard_streams()
    answers = own_stdout()
    session: Session | None = None

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
        if session is None:
            raise RuntimeError("a frame before its settings")
        if "preflight" in request:
            return session.preflight(request["preflight"], request["folder"], request["most_bytes"])
        return session.render(watch=watch, **request)

    say({"ready": os.getpid()})
    if threads:
        import drjit

        drjit.set_thread_count(threads)
    with followed_by(lambda *made: say({"making": made})):
        for line in sys.stdin:
            say(answer(partial(work, json.loads(line))))


if __name__ == "__main__":
    serve()
