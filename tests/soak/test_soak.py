"""What is promised of frames, against commands, signals and damage in any order.

One folder, the program as a user starts it, and a model of what stands there. No frame that was
reported done is ever lost or wrong, unless the test itself harmed it; under a frame's name there
are no bytes but those that the same command makes alone; exit codes are those of the manual, and a
failure is one line. Kernels, kept arrays and models of the user's are harmed on the way as well.
LODBENCH_SOAK_MINUTES says for how long (2), and LODBENCH_SOAK_RECORD where what was tried goes.
"""

import hashlib
import json
import os
import random
import signal
import subprocess
import sys
import tempfile
import time
import uuid
from collections import Counter
from contextlib import suppress
from functools import cache
from pathlib import Path

import pytest
from hypothesis import HealthCheck, Phase, settings
from hypothesis import strategies as st
from hypothesis.errors import FlakyStrategyDefinition
from hypothesis.stateful import (
    RuleBasedStateMachine,
    invariant,
    precondition,
    rule,
    run_state_machine_as_test,
)

from bench.records.provenance import provenance
from tests.scenes.imported.sample_models import mill

ROOT = Path(__file__).resolve().parents[2]
TINY = ROOT / "tests" / "bench" / "cli" / "tiny.toml"
MINUTES = float(os.environ.get("LODBENCH_SOAK_MINUTES", "2"))
FRAMES, SEEDS = range(1, 5), (0, 1)
TOKEN = "LODBENCH_SOAK_TOKEN"
SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGKILL)

some_frames = st.lists(st.sampled_from(FRAMES), min_size=1, unique=True).map(sorted)
seeds = st.sampled_from(SEEDS)
TRIED: Counter[str] = Counter()


@cache
def kept() -> Path:
    """The folder of caches and models of all commands here."""
    return Path(tempfile.mkdtemp(prefix="lodbench-soak-"))


class Command:
    """The program, started in a folder, with a mark that all its processes inherit."""

    def __init__(self, folder: Path, *words: str) -> None:
        self.token = uuid.uuid4().hex
        TRIED[f"commands: {' '.join(words[: 1 + (words[0] == 'model')])}"] += 1
        environment = {
            **os.environ,
            "PYTHONPATH": str(ROOT),
            "LODBENCH_TRUSTED_VARIANT": "scalar_rgb",
            "LODBENCH_CACHE": str(kept() / "cache"),
            "XDG_DATA_HOME": str(kept()),
            TOKEN: self.token,
        }
        self.process = subprocess.Popen(
            [sys.executable, "-P", "-m", "bench.cli.main", *words],
            cwd=folder,
            env=environment,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )

    def end(self, ways: tuple[int, ...] = (0, 1, 2)) -> tuple[int, list[dict]]:
        """Wait for its end; gives its exit code and what it printed, half a last line aside."""
        out, err = self.process.communicate(timeout=300)
        code = self.process.returncode
        assert code in ways, (code, err)
        assert "Traceback" not in err, err
        if code in (1, 2):
            assert err.splitlines()[-1].startswith("lodbench: "), err
        lines = []
        for line in out.splitlines():
            try:
                lines.append(json.loads(line))
            except ValueError:
                assert code not in (0, 1, 2) and line == out.splitlines()[-1], line
        until = time.monotonic() + 20
        while self._left():
            assert time.monotonic() < until, "a process outlived its command"
            time.sleep(0.05)
        return code, lines

    def _left(self) -> list[str]:
        mark, found = f"{TOKEN}={self.token}".encode(), []
        for place in Path("/proc").glob("[0-9]*"):
            try:
                if mark in (place / "environ").read_bytes():
                    found.append(place.name)
            except OSError:
                continue
        return found


def render_words(seed: int, frames: list[int], *more: str) -> list[str]:
    words = ["render", str(TINY), "-o", "out/a.####.exr", "--seed", str(seed), "--json"]
    return [*words, "--frames", ",".join(map(str, frames)), *more]


@cache
def mill_file() -> Path:
    return mill(kept() / "mill.usda")


def harmed(whole: bytes, data: st.DataObject) -> dict[str, bytes]:
    """What is left of a file, by what happened to it."""
    at = data.draw(st.integers(0, max(len(whole) - 1, 0)))
    flipped = whole[:at] + bytes(byte ^ 1 << at % 8 for byte in whole[at : at + 1])
    flipped += whole[at + 1 :]
    return {"flip": flipped, "cut": whole[:at], "zero": bytes(len(whole)), "empty": b""}


@cache
def alone(seed: int) -> dict[int, str]:
    """SHA-256 of every frame of a seed, rendered by itself, by number."""
    with tempfile.TemporaryDirectory() as folder:
        code, (*lines, _) = Command(Path(folder), *render_words(seed, list(FRAMES))).end()
        assert code == 0
        return {line["frame"]: line["sha256"] for line in lines}


class Frames(RuleBasedStateMachine):
    """A folder of frames.

    reported  seed of every frame that a command reported done, and that nobody harmed since
    harmed    what the test wrote in a frame's place: "remains" of a frame, another's "file", or the
              seed of a whole frame of another number
    """

    def __init__(self) -> None:
        super().__init__()
        self.temporary = tempfile.TemporaryDirectory()
        self.folder = Path(self.temporary.name)
        self.reported: dict[int, int] = {}
        self.harmed: dict[int, str | int] = {}

    def teardown(self) -> None:
        self.temporary.cleanup()

    def path(self, frame: int) -> Path:
        return self.folder / "out" / f"a.{frame:04d}.exr"

    def whole(self) -> dict[int, int]:
        """Seeds of the frames that stand there, which all are as they are alone, by number."""
        found = {}
        for frame in FRAMES:
            if self.path(frame).is_file() and frame not in self.harmed:
                seed = self.seed_at(frame)
                assert seed is not None, f"frame {frame} is not as it is alone"
                found[frame] = seed
        return found

    def take(self, lines: list[dict], seed: int) -> None:
        """Believe what a command reports."""
        for line in lines:
            if "sha256" in line:
                assert line["sha256"] == alone(seed)[line["frame"]]
                self.reported[line["frame"]] = seed
                self.harmed.pop(line["frame"], None)

    def remains(self) -> list[int]:
        """Frames in whose place is what is left of one."""
        return [frame for frame, what in self.harmed.items() if what != "file"]

    def seed_at(self, frame: int) -> int | None:
        """Seed of what stands in a frame's place, where it is as that frame is alone."""
        digest = hashlib.sha256(self.path(frame).read_bytes()).hexdigest()
        return next((seed for seed in SEEDS if alone(seed)[frame] == digest), None)

    @rule(seed=seeds, frames=some_frames)
    def render(self, seed: int, frames: list[int]) -> None:
        before = dict(self.harmed), self.whole()
        code, lines = Command(self.folder, *render_words(seed, frames)).end()
        refused = any(before[1].get(each, seed) != seed for each in frames)
        refused |= any(before[0].get(each, seed) not in ("remains", seed) for each in frames)
        assert code == (2 if refused else 0)
        self.take(lines, seed)
        assert refused or {each: self.whole()[each] for each in frames} == dict.fromkeys(
            frames, seed
        )

    @rule(seed=seeds, frames=some_frames)
    def overwrite(self, seed: int, frames: list[int]) -> None:
        for each in frames:
            self.reported.pop(each, None)
        code, lines = Command(self.folder, *render_words(seed, frames, "--overwrite")).end()
        assert code == 0
        self.take(lines, seed)

    @rule(seed=seeds, number=st.sampled_from(SIGNALS), after=st.floats(0.4, 4.0))
    def stop(self, seed: int, number: int, after: float) -> None:
        """A signal at any moment: what was reported stays, and nothing half-written has a name."""
        command = Command(self.folder, *render_words(seed, list(FRAMES)))
        lines = self.stopped(command, number, after)
        self.take(lines, seed)
        for frame in self.remains():
            if self.seed_at(frame) is not None:  # it was replaced, and not reported any more
                del self.harmed[frame]

    def stopped(self, command: Command, number: int, after: float) -> list[dict]:
        """What a command says until a signal ends it, or it ends by itself."""
        TRIED[f"signals: {signal.Signals(number).name}"] += 1
        time.sleep(after)
        command.process.send_signal(number)
        return command.end((0, 1, 2, 128 + number, -number))[1]

    @rule(data=st.data(), how=st.sampled_from(["flip", "cut", "zero", "empty"]))
    def damaged_cache(self, data: st.DataObject, how: str) -> None:
        """Of kernels or kept arrays; what is seen stays the same."""
        if found := sorted(path for path in (kept() / "cache").rglob("*") if path.is_file()):
            path = data.draw(st.sampled_from(found))
            path.write_bytes(harmed(path.read_bytes(), data)[how])
            TRIED[f"damages: {path.suffix} {how}"] += 1

    @rule(data=st.data(), number=st.sampled_from(SIGNALS), after=st.floats(0.4, 3.0))
    def model(self, data: st.DataObject, number: int, after: float) -> None:
        """One is added and that is stopped, others are harmed: the list tells which are whole."""
        words = ("model", "add", str(mill_file()), "--name", "mill", "--overwrite", "--json")
        self.stopped(Command(self.folder, *words), number, after)
        for path in (kept() / "lodbench" / "models").glob("broken*"):
            path.unlink()
        ((before,),) = [Command(self.folder, "model", "list", "--json").end((0,))[1]]
        for path in (kept() / "lodbench" / "models").glob("mill.npz"):
            for how, content in harmed(path.read_bytes(), data).items():
                path.with_name(f"broken-{how}.npz").write_bytes(content)
        ((after_it,),) = [Command(self.folder, "model", "list", "--json").end((0,))[1]]
        whole = before["models"].get("mill")
        assert after_it["models"].get("mill") == whole
        assert all(each == whole for each in after_it["models"].values())

    @rule(pair=st.lists(seeds, min_size=2, max_size=2), frames=some_frames)
    def two_at_once(self, pair: list[int], frames: list[int]) -> None:
        commands = [Command(self.folder, *render_words(seed, frames)) for seed in pair]
        ended = [each.end() for each in commands]
        for seed, (_, lines) in zip(pair, ended, strict=True):
            self.take(lines, seed)
        codes = sorted(code for code, _ in ended)
        assert codes in ([0, 0], [0, 2], [2, 2])
        if pair[0] != pair[1]:
            assert codes != [0, 0]
        elif codes[0] == 0:
            assert codes[1] == 0

    @precondition(lambda self: self.whole())
    @rule(data=st.data(), how=st.sampled_from(["flip", "cut", "zero", "empty", "remove", "theirs"]))
    def damage(self, data: st.DataObject, how: str) -> None:
        frame = data.draw(st.sampled_from(sorted(self.whole())))
        path = self.path(frame)
        TRIED[f"damages: frame {how}"] += 1
        self.reported.pop(frame, None)
        if how == "remove":
            path.unlink()
            return
        path.write_bytes(harmed(path.read_bytes(), data).get(how, b"of somebody else"))
        self.harmed[frame] = "file" if how == "theirs" else "remains"

    @precondition(lambda self: len(self.whole()) > 1)
    @rule(data=st.data())
    def exchange(self, data: st.DataObject) -> None:
        """Two frames change places: each is what is left of the other."""
        one, two = data.draw(st.permutations(sorted(self.whole())))[:2]
        seeds_of = self.whole()
        contents = self.path(one).read_bytes(), self.path(two).read_bytes()
        for frame, content in zip((two, one), contents, strict=True):
            self.path(frame).write_bytes(content)
            self.reported.pop(frame, None)
        if len({seeds_of[one], seeds_of[two]}) == 1:
            self.harmed |= {one: seeds_of[one], two: seeds_of[one]}
        else:  # whole frames of two settings: each is refused as the other's
            for frame in (one, two):
                self.path(frame).unlink()

    @rule(text=st.sampled_from(["", "{", '{"version": 3}']))
    def index_of_an_earlier_version(self, text: str) -> None:
        """It is neither read nor needed."""
        path = self.folder / "out" / "manifest.json"
        if path.exists():
            path.unlink()
        elif path.parent.is_dir():
            path.write_text(text)

    @precondition(lambda self: (self.folder / "out").is_dir())
    @rule()
    def verify(self) -> None:
        self.judge(*Command(self.folder, "verify", "out", "--json").end())

    def judge(self, code: int, lines: list[dict]) -> None:
        """What passes is right, and what is right passes."""
        wrong = {Path(line["path"]).name for line in lines if "path" in line}
        whole = self.whole()
        assert not wrong & {self.path(each).name for each in whole}
        if code == 0:
            assert not self.remains()
        elif code == 2:
            assert not whole

    @precondition(lambda self: (self.folder / "out").is_dir())
    @rule()
    def repair(self) -> None:
        kinds = set(self.whole().values())
        _, lines = Command(self.folder, "verify", "out", "--repair", "--json").end()
        for frame in [each["frame"] for each in lines if each.get("repaired") == "rendered again"]:
            self.harmed.pop(frame, None)
            self.reported[frame] = self.whole()[frame]
        assert len(kinds) != 1 or not self.remains()
        self.verify()

    @invariant()
    def nothing_that_was_reported_is_lost(self) -> None:
        whole = self.whole()
        assert {each: whole.get(each) for each in self.reported} == self.reported


@pytest.mark.slow
def test_promises_hold_for_minutes() -> None:
    start = time.monotonic()
    plan = settings(
        max_examples=2,  # of which the first is the simplest, where no command runs at all
        stateful_step_count=12,
        deadline=None,
        database=None,
        phases=(Phase.generate,),
        print_blob=True,
        suppress_health_check=list(HealthCheck),
    )
    while time.monotonic() < start + 60 * MINUTES:
        random.seed(time.time_ns())
        with suppress(FlakyStrategyDefinition):  # which rules apply depends on what signals hit
            run_state_machine_as_test(Frames, settings=plan)
        TRIED["rounds"] += 1
    assert len(TRIED) > 3
    if place := os.environ.get("LODBENCH_SOAK_RECORD"):
        found = {"commit": provenance("", 0).commit, "seconds": round(time.monotonic() - start)}
        Path(place).write_text(json.dumps(found | {"tried": dict(sorted(TRIED.items()))}, indent=1))
