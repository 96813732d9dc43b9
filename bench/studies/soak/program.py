"""How is a program hit while it runs, and seen to its end with all its processes?"""

import json
import math
import os
import signal
import subprocess
import time
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import psutil

from bench.studies.soak.looks import frame_name
from bench.studies.soak.plan import Command, Hit, Moment

TOKEN = "LODBENCH_SOAK_RUN"
"""Environment variable by which the processes of a command are found, whoever their parent is."""
LONGEST_S = 300.0
"""Seconds after which a command that was not told to end counts as one that hangs."""
GRACE_S = 60.0
"""Seconds that a command may take to end once it was told to, and its processes after it."""

_PYTHONS_OWN = "resource_tracker"
"""In the command line of a process that multiprocessing keeps beside workers; it is none."""


@dataclass(frozen=True)
class Run:
    """How a command ended.

    code     exit status; -N where signal N ended it, None where it had to be killed
    out, err  what it printed; None where that could not be kept
    signals  that were sent to the program, by name; those to a worker are not among them
    workers  that were killed
    left     its processes that lived on, by their command lines
    """

    command: Command
    code: int | None
    out: str | None
    err: str | None
    signals: tuple[str, ...]
    workers: int
    left: tuple[str, ...]

    def lines(self) -> Iterator[dict[str, Any]]:
        """Give the whole JSON objects that it printed, one from each line."""
        for line in (self.out or "").splitlines():
            try:
                found = json.loads(line)
            except ValueError:
                continue
            if isinstance(found, dict):
                yield found


@dataclass
class Running:
    """A command that runs, by a token that its processes inherit from it.

    logs    path of its standard output and error, less the suffix
    folder  of its frames
    """

    command: Command
    process: subprocess.Popen[bytes]
    token: str
    logs: Path
    folder: Path
    asked: float = field(default_factory=time.time)
    told: float | None = None
    sent: list[str] = field(default_factory=list)
    workers: int = 0
    met: dict[Moment, float] = field(default_factory=dict)
    hit: Hit | None = None

    def is_due(self, moment: Moment) -> bool:
        """Say whether a moment of this command has come."""
        if moment not in self.met and self.worked() >= moment.cpu_s:
            if self._finished() >= moment.frames:
                self.met[moment] = time.monotonic()
        return time.monotonic() >= self.met.get(moment, math.inf) + moment.then_s

    def worked(self) -> float:
        """Give the seconds that the program itself has worked for."""
        try:
            times = psutil.Process(self.process.pid).cpu_times()
        except psutil.Error:
            return 0.0
        return float(times.user + times.system)

    def is_before(self, cpu_s: float) -> bool:
        """Say whether the program runs, and has worked for less than so many seconds."""
        return self.process.poll() is None and self.worked() < cpu_s

    def _finished(self) -> int:
        """Count the frames that came since the command started."""
        count = 0
        for frame in self.command.frames:
            try:
                path = self.folder / frame_name(self.command.stem, frame)
                count += path.stat().st_mtime >= self.asked
            except OSError:
                continue
        return count

    def step(self) -> bool:
        """Send what is due, end what hangs; gives whether the command still runs."""
        if self.process.poll() is not None:
            return False
        if self.hit is not None and self.is_due(self.hit.moment) and self._send(self.hit):
            self.hit = None
        too_long = time.time() - self.asked > LONGEST_S
        if too_long or (self.told is not None and time.monotonic() - self.told > GRACE_S):
            self.sent.append("hangs")
            for each in self.processes():
                each.kill()
            self.process.wait()
        return True

    def _send(self, hit: Hit) -> bool:
        """Send a signal; gives whether there was something to send it to."""
        number = signal.Signals[f"SIG{hit.signal}"]
        if hit.target == "worker":
            return self._end_worker(number, hit.pick)
        for _ in range(1 + hit.again):
            try:
                (os.killpg if hit.target == "group" else os.kill)(self.process.pid, number)
            except ProcessLookupError:
                break
            time.sleep(0.01)
        self.sent.append(hit.signal)
        self.told = time.monotonic()
        return True

    def _end_worker(self, number: int, pick: float) -> bool:
        try:
            below = psutil.Process(self.process.pid).children(recursive=True)
            workers = [each for each in below if _PYTHONS_OWN not in " ".join(each.cmdline())]
            if workers:
                workers[int(pick * len(workers))].send_signal(number)
                self.workers += 1
        except psutil.Error:
            return False
        return bool(workers)

    def processes(self) -> list[psutil.Process]:
        """Find every process that the command started and that still is at work."""
        found = []
        for each in psutil.process_iter():
            try:
                if each.environ().get(TOKEN) == self.token:
                    found.append(each)
            except psutil.Error:
                continue
        return found

    def end(self) -> Run:
        """Give how the command ended, once it has; its processes have GRACE_S to follow it."""
        deadline = time.monotonic() + GRACE_S
        while (left := self.processes()) and time.monotonic() < deadline:
            time.sleep(0.05)
        names = []
        for each in left:
            try:
                names.append(" ".join(each.cmdline())[:200])
                each.kill()
            except psutil.Error:
                continue
        hung = "hangs" in self.sent
        signals = tuple(name for name in self.sent if name != "hangs")
        code = None if hung else self.process.returncode
        out, err = (_read(self.logs.with_suffix(each)) for each in (".out", ".err"))
        stream = self.command.stream
        return Run(
            self.command,
            code,
            None if stream in ("no stdout", "neither", "full stdout", "reader gone") else out,
            None if stream in ("no stderr", "neither", "full stderr") else err,
            signals,
            self.workers,
            tuple(names),
        )


def _read(path: Path) -> str:
    return path.read_text(encoding="utf-8", errors="replace")
