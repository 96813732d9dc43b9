"""Which frames were promised to somebody, and are they there?"""

from collections.abc import Iterable, Mapping
from pathlib import Path

from bench.studies.soak.judge import LOST, Broken
from bench.studies.soak.looks import frame_name
from bench.studies.soak.plan import Command
from bench.studies.soak.program import Run


def asked_names(command: Command) -> set[str]:
    """Name the files that a command is to make in the folder that is judged."""
    if command.verb != "render":
        return set()
    return {frame_name(command.stem, frame) for frame in command.frames}


def told_done(run: Run) -> set[str]:
    """Name the frames that a run said were done: one by one, or all of them by its exit code."""
    if run.command.verb != "render":
        return set()
    if run.code == 0:
        return asked_names(run.command)
    records = (line for line in run.lines() if "sha256" in line)
    return {Path(record["path"]).name for record in records}


class Ledger:
    """What is known of a folder by watching it from outside.

    promised         by file name: the look that somebody was told is done; several, where one
                     was to replace the other and was stopped
    asked            names that any command was to make
    harmed           names that were damaged, and not made again since
    unsettled        names that a run was to replace, and perhaps did not
    manifest_harmed  the manifest was damaged since it was last repaired
    """

    def __init__(self) -> None:
        self.promised: dict[str, set[str]] = {}
        self.asked: set[str] = set()
        self.harmed: set[str] = set()
        self.unsettled: set[str] = set()
        self.manifest_harmed = False

    def note_asked(self, command: Command) -> None:
        """Note what a command is to make, before it starts."""
        self.asked |= asked_names(command)

    def note_harm(self, names: Iterable[str]) -> None:
        """Note that files were damaged: nobody answers for them any more."""
        for name in names:
            if name.endswith(".json"):
                self.manifest_harmed = True
            self.promised.pop(name, None)
            self.harmed.add(name)

    def note_repair(self) -> None:
        """Note that everything was put right, so that what is wrong from now on is new."""
        self.manifest_harmed = False
        self.harmed.clear()
        self.unsettled.clear()

    def settle(
        self, runs: Iterable[Run], looks: Mapping[str, str | None], harmed: Iterable[str] = ()
    ) -> list[Broken]:
        """Hold a folder at rest against what the runs said and what was promised before.

        looks   as in ``judge_verdict``
        harmed  files that were damaged meanwhile
        """
        renders = [run for run in runs if run.command.verb == "render"]
        lost: dict[str, list[str]] = {}
        for run in renders:
            if "--overwrite" in run.command.flags:
                self.unsettled |= asked_names(run.command) - told_done(run)
        told: dict[str, set[str]] = {}
        for run in renders:
            for name in told_done(run):
                told.setdefault(name, set()).add(run.command.look)
        self.note_harm(harmed)
        for name in sorted({*self.promised, *told} - set(harmed)):
            if how := self._lost(name, told.get(name, set()), renders, looks.get(name)):
                lost.setdefault(how, []).append(name)
        return [
            Broken(LOST, f"{', '.join(names)}: {how}", len(names)) for how, names in lost.items()
        ]

    def _lost(self, name: str, told: set[str], renders: list[Run], look: str | None) -> str:
        """Judge one promised frame, note what it is from now on, and say how it was lost, if so."""
        before = self.promised.pop(name, set())
        claimed = told | before
        replacing = {
            run.command.look
            for run in renders
            if "--overwrite" in run.command.flags and name in asked_names(run.command)
        }
        alone = len(renders) == 1 and bool(told)
        if alone:
            self.harmed.discard(name)
            self.unsettled.discard(name)
        allowed = told if alone and replacing else claimed | replacing
        if look is not None:
            self.promised[name] = allowed if name in self.unsettled else {look}
        rivals = len(told) > 1 or bool(before and told - before)
        if rivals and not replacing and name not in self.unsettled:
            return f"promised as {', '.join(sorted(claimed))}, now {look}"
        if look not in allowed:
            was = " or ".join(sorted(allowed))
            return f"promised as {was}, now {look or 'no right frame'}"
        return ""
