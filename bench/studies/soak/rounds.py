"""How is a round done: its steps, what is judged after each, and how the folder is healed?"""

import json
import os
import shutil
import signal
import time
from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from dataclasses import replace

from bench.studies.soak.damage import do_damage
from bench.studies.soak.disk import Disk
from bench.studies.soak.judge import FILES, STUCK, Broken, judge_run, judge_verdict
from bench.studies.soak.ledger import Ledger
from bench.studies.soak.looks import FRAMES, Truth, frame_files, frame_name, frame_number
from bench.studies.soak.place import Place
from bench.studies.soak.plan import Burst, Command, Harm, Step
from bench.studies.soak.program import Run, Running
from scenes.render.exr.sequence import NAME, file_hash

_TICK_S = 0.01
_DAMAGE_S = 1.5
_REPAIRS = 2  # the first rebuilds the manifest, and the next one renders what it lists
_MADE_BY_PREVIEW = (".png", ".mp4")


class Folder:
    """A folder that a round is done to, and everything that was seen there.

    place  where the program runs
    disk   that the frames lie on
    truth  the right bytes of every frame
    say    told of every action before it is taken
    """

    def __init__(
        self, place: Place, disk: Disk, truth: Truth, say: Callable[[str], object]
    ) -> None:
        self._place, self._disk, self._truth, self._say = place, disk, truth, say
        self._ledger, self._runs, self._killed = Ledger(), 0, False
        self.tried: Counter[str] = Counter()
        self.broken: list[Broken] = []

    def do(self, step: Step) -> None:
        """Do one step of a round, and judge what it leaves."""
        if isinstance(step, Harm):
            self._say(f"{step}")
            self._ledger.note_harm(self._damage(step))
            return
        self._burst(step)
        self._look()
        self._disk.thaw()

    def heal(self) -> None:
        """Repair the folder, go on with what was begun, and judge both."""
        self._disk.heal()
        self._place = replace(self._place, file_kb=None)
        for _ in range(_REPAIRS):
            if self._alone(Command("repair")).code == 0:
                break
        self._ledger.note_repair()
        self._killed = False
        verdict = self._look()
        looks = {look for name, look in self._looks().items() if name.startswith("a.")}
        whose = min(filter(None, looks), default="plain")
        healthy = looks <= {whose} and (verdict is None or verdict.code == 0)
        flags = () if healthy else ("--overwrite",)
        run = self._alone(Command("render", look=whose, flags=flags))
        found = self._looks()
        right = all(found.get(frame_name("a", frame)) == whose for frame in FRAMES)
        if run.code != 0 or not right:
            said = (run.err or "").strip()[-300:]
            self.broken.append(Broken(STUCK, f"{run.command}: exit {run.code}: {said}"))
        self._look()

    def _burst(self, burst: Burst) -> None:
        self._say(f"{burst}")
        with _started() as running:
            runs, harmed = self._run(burst, running)
        for run in runs:
            self.broken += judge_run(run)
            self._count(run)
        at_once = len(burst.commands)
        self.tried[f"commands at once: {at_once}"] += 1
        self._killed |= any("KILL" in run.signals or run.code is None for run in runs)
        self.broken += self._ledger.settle(runs, self._looks(), harmed)
        if any(run.command.verb == "repair" and run.code == 0 for run in runs) and at_once == 1:
            self._ledger.note_repair()
        self.broken += self._files_left()
        if at_once == 1 and runs[0].command.verb == "verify":
            self._judge(runs[0])

    def _run(self, burst: Burst, running: list[Running]) -> tuple[list[Run], set[str]]:
        """Start the commands, do to them what is planned, and wait for their ends."""
        waiting = sorted(burst.commands, key=lambda command: command.wait_s)
        harmed, meanwhile, freeze = set[str](), burst.meanwhile, burst.freeze
        while sum(each.step() for each in running) or waiting:  # hits come while others wait
            while waiting and not (running and running[0].is_before(waiting[0].wait_s)):
                self._runs += 1
                logs = self._place.folder.parent / "logs" / f"{self._runs:03d}"
                self._ledger.note_asked(waiting[0])
                running.append(self._place.start(waiting.pop(0), logs))
            first = running[0]
            if meanwhile and not first.is_before(_DAMAGE_S):
                harmed |= self._damage(meanwhile)
                meanwhile = None
            if freeze and first.is_due(freeze):
                self.tried["disks made read-only"] += self._disk.freeze()
                freeze = None
            time.sleep(_TICK_S)
        return [each.end() for each in running], harmed

    def _alone(self, command: Command) -> Run:
        """Run a command with nothing beside it, and judge its end."""
        self._say(f"{command}")
        with _started() as running:
            ((run,), _) = self._run(Burst((command,)), running)
        self.broken += judge_run(run)
        self._count(run)
        self.broken += self._ledger.settle([run], self._looks())
        self.broken += self._files_left()
        return run

    def _look(self) -> Run | None:
        """Have the program verify the folder, if there is one, and judge its verdict."""
        if not self._place.frames.is_dir():
            return None
        run = self._alone(Command("verify"))
        self._judge(run)
        return run

    def _judge(self, run: Run) -> None:
        """Judge a verdict that could be read, or an exit code where only the words were lost."""
        looks, ledger = self._looks(), self._ledger
        right = {name for name, look in looks.items() if look is not None}
        right -= ledger.harmed | ledger.unsettled
        self.tried["frames judged by verify"] += len(looks)
        if run.signals or run.code is None:
            return
        if run.command.stream in ("kept", "no stderr", "full stderr"):
            known = self._sequences_on_record()
            looks = {n: look for n, look in looks.items() if look or _sequence(n) in known}
            self.broken += judge_verdict(run, looks, right, ledger.manifest_harmed)

    def _sequences_on_record(self) -> set[str]:
        """Name the sequences of which the manifest, if it can be read, has a frame.

        `verify` judges no other: where a manifest was lost with every whole frame of a sequence,
        nothing says that there was one, and its other files are anybody's.
        """
        try:
            data = json.loads((self._place.frames / NAME).read_bytes())
            return {_sequence(name) for name in data["frames"]}
        except (OSError, ValueError, KeyError, TypeError):
            return set()

    def _looks(self) -> dict[str, str | None]:
        """Whose bytes every file has that some command was to make."""
        found = {}
        for path in frame_files(self._place.frames):
            if path.name in self._ledger.asked:
                found[path.name] = self._truth.look_of(frame_number(path.name), file_hash(path))
        return found

    def _damage(self, harm: Harm) -> set[str]:
        if not self._place.frames.is_dir():
            return set()
        names = do_damage(self._place.frames, harm.kind, harm.pick, harm.place)
        self.tried[f"damages: {harm.kind}"] += bool(names)
        self._killed |= any(name.endswith(".part") for name in names)
        return names

    def _files_left(self) -> Iterable[Broken]:
        """Files that no command may leave, unless one was killed and nothing was repaired since."""
        scratch, frames = self._place.folder.parent / "tmp", self._place.frames
        left = [] if self._killed else [path.name for path in scratch.iterdir()]
        for path in scratch.iterdir():
            shutil.rmtree(path) if path.is_dir() else path.unlink()
        if frames.is_dir() and not self._killed:
            known = (".exr", *_MADE_BY_PREVIEW)
            names = sorted(os.listdir(frames))
            left += [name for name in names if not (name.endswith(known) or name == NAME)]
            left += [name for name in names if name.endswith(known) and name.startswith(".")]
        return [Broken(FILES, ", ".join(left), len(left))] if left else []

    def _count(self, run: Run) -> None:
        command, tried = run.command, self.tried
        tried[f"commands: {command.verb}"] += 1
        if command.stream != "kept":
            tried[f"streams: {command.stream}"] += 1
        for name in run.signals:
            tried[f"signals: {name}"] += 1
        on_cluster = "--cluster" in command.flags
        tried["commands: render on a cluster"] += on_cluster
        tried[f"workers killed{' of a cluster' if on_cluster else ''}"] += run.workers
        tried["frames promised"] += len([line for line in run.lines() if "sha256" in line])


@contextmanager
def _started() -> Iterator[list[Running]]:
    """Keep the commands that were started, and leave none behind, whatever happens."""
    running: list[Running] = []
    try:
        yield running
    finally:
        for each in running:
            if each.process.poll() is None:
                os.killpg(each.process.pid, signal.SIGKILL)
                each.process.wait()


def _sequence(name: str) -> str:
    """The name of a frame's file before its number."""
    return name.partition(".")[0]
