"""How is the program started as a user starts it, in a folder of its own?"""

import contextlib
import os
import subprocess
import sys
import uuid
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

from bench.studies.soak.looks import LOOKS, PRESET_NAME
from bench.studies.soak.plan import STREAMS, Command
from bench.studies.soak.program import TOKEN, Running

_ROOT = Path(__file__).resolve().parents[3]


@dataclass(frozen=True)
class Place:
    """Where the program runs.

    folder       the current folder of every command
    out          the frames' folder, from there
    variant      that renders
    environment  of every command
    file_kb      that a file may hold; None = whatever the disk holds
    """

    folder: Path
    out: str
    variant: str
    environment: Mapping[str, str]
    file_kb: int | None = None

    @property
    def frames(self) -> Path:
        """Folder of the frames."""
        return self.folder / self.out

    def start(self, command: Command, logs: Path) -> Running:
        """Start a command in a process group of its own."""
        token = uuid.uuid4().hex
        frames = self.folder / "long" if command.verb == "long" else self.frames
        limit = "" if self.file_kb is None else f"ulimit -f {2 * self.file_kb}; "
        shell = f'{limit}exec "$@"{STREAMS[command.stream]}'
        program = [sys.executable, "-P", "-m", "bench.cli.main", *self.words(command)]
        paths = os.pathsep.join([str(_ROOT), *filter(None, [os.environ.get("PYTHONPATH")])])
        with _reader_gone(command.stream) as lost, logs.with_suffix(".err").open("wb") as err:
            with logs.with_suffix(".out").open("wb") as out:
                process = subprocess.Popen(
                    ["/bin/sh", "-c", shell, "sh", *program],
                    cwd=self.folder,
                    env={**self.environment, "PYTHONPATH": paths, TOKEN: token},
                    stdin=subprocess.DEVNULL,
                    stdout=out if lost is None else lost,
                    stderr=err,
                    start_new_session=True,
                )
        return Running(command, process, token, logs, frames, hit=command.hit)

    def words(self, command: Command) -> list[str]:
        """Write a command as it is typed after the program's name."""
        pattern = f"{self.out}/{command.stem}.####.exr"
        match command.verb:
            case "render" | "long":
                return self._render(command, pattern)
            case "verify":
                return ["verify", "--json", "--", self.out]
            case "repair":
                return ["verify", "--repair", "--json", "--", self.out]
            case "ids":
                return ["list", "--objects", pattern.replace("####", f"{command.frames[0]:04d}")]
        return ["count", PRESET_NAME]

    def _render(self, command: Command, pattern: str) -> list[str]:
        look, frames = LOOKS[command.look], ",".join(map(str, command.frames))
        if command.verb == "long":
            pattern, frames = "long/a.####.exr", "1"
            look = "--size", "640x360", "--spp", "4096"
        flags = [*look, *command.flags, "--variant", self.variant, "--json"]
        return ["render", PRESET_NAME, "-o", pattern, "--frames", frames, *flags]


@contextlib.contextmanager
def _reader_gone(stream: str) -> Iterator[int | None]:
    """Open a pipe that nobody reads any more, where that is what a command writes to."""
    if stream != "reader gone":
        yield None
        return
    reader, writer = os.pipe()
    os.close(reader)
    try:
        yield writer
    finally:
        os.close(writer)
