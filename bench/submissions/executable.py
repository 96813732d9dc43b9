"""Any executable takes part: called for each setting and repeat, and timed from outside.

The program gets no references. What it takes is seen from outside: seconds by the clock from its
start to its end, seconds of the processor of it and all that it waited for, and the most memory
that it and its descendants held at once, read every ``EVERY_S``. Where the last line that it prints
is JSON with ``stages``, these seconds are kept beside; nothing else that it says is believed.
"""

import json
import os
import shlex
import shutil
import signal
import subprocess
import threading
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import asdict, dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import psutil

from bench.submissions.entry import judged, published_baseline, record_of, setting_row, write_record
from bench.submissions.score import plain
from lod.errors import InputError

EVERY_S = 0.02
LONGEST_S = 3600.0
NAMES = "scene", "camera", "exr", "setting", "knob", "seed", "pack"
"""What a command may name in braces."""


@dataclass(frozen=True)
class Executed:
    """What one call of a program took.

    seconds      by the clock
    cpu_seconds  of the processor, of the program and all that it waited for
    peak_bytes   the most that it and its descendants held at once
    stages       seconds by stage, as the program itself says
    """

    seconds: float
    cpu_seconds: float
    peak_bytes: int
    stages: Mapping[str, float]


def words_of(command: str, values: Mapping[str, object]) -> list[str]:
    """Split a command as a shell would, then put values for the names in braces; no shell runs.

    Raises InputError for another name in braces, for no ``{exr}``, and for a program that is not
    there.
    """
    cure = f"names are {', '.join('{' + name + '}' for name in NAMES)}"
    try:
        words = shlex.split(command)
        made = [word.format(**values) for word in words]
    except (KeyError, IndexError, ValueError) as error:
        raise InputError("--command", command, f"a command ({error})", cure) from None
    if "{exr}" not in command:
        raise InputError("--command", command, "it writes the picture {exr}", cure)
    if shutil.which(made[0]) is None:
        raise InputError("--command", made[0], "a program that is here", "give its whole path")
    return made


def execute(words: Sequence[str], log: Path, timeout_s: float = LONGEST_S) -> Executed:
    """Run a program to its end; what it prints goes to a file.

    Raises InputError where it fails, or takes too long: then it is ended, with all it started.
    """
    with log.open("wb") as output:
        start = time.perf_counter()
        child = subprocess.Popen(
            words,
            stdin=subprocess.DEVNULL,
            stdout=output,
            stderr=subprocess.STDOUT,
            start_new_session=True,
        )
        ended = threading.Event()
        peaks = [0]
        watcher = threading.Thread(target=_watch, args=(child.pid, ended, peaks), daemon=True)
        watcher.start()
        timer = threading.Timer(timeout_s, _end, (child.pid,))
        timer.start()
        try:
            _, status, used = os.wait4(child.pid, 0)
        except BaseException:
            _end(child.pid)
            raise
        finally:
            seconds = time.perf_counter() - start
            timer.cancel()
            ended.set()
            watcher.join()
        child.returncode = os.waitstatus_to_exitcode(status)
        with suppress(ProcessLookupError):
            os.killpg(child.pid, signal.SIGKILL)  # what it left behind would disturb the next
    said = log.read_text(encoding="utf-8", errors="replace").strip().splitlines()
    if child.returncode:
        why = "took too long" if seconds >= timeout_s else f"exit code {child.returncode}"
        rule = f"a program that ends well ({said[-1][:200] if said else 'it printed nothing'})"
        raise InputError("--command", f"{words[0]}: {why}", rule, f"see {log}")
    # Not ru_maxrss: it begins at what this process held when it forked.
    return Executed(seconds, used.ru_utime + used.ru_stime, peaks[0], _stages(said))


def _end(pid: int) -> None:
    with suppress(ProcessLookupError):
        os.killpg(pid, signal.SIGKILL)


def _watch(pid: int, ended: threading.Event, peaks: list[int]) -> None:
    while True:
        with suppress(psutil.Error):
            root = psutil.Process(pid)
            held = 0
            for each in (root, *root.children(recursive=True)):
                with suppress(psutil.Error):
                    held += each.memory_info().rss
            peaks[0] = max(peaks[0], held)
        if ended.wait(EVERY_S):
            return


def _stages(said: Sequence[str]) -> dict[str, float]:
    """Read ``{"stages": {name: seconds}}`` from the last line; nothing where it is not that."""
    with suppress(ValueError, AttributeError, TypeError):
        stages = json.loads(said[-1] if said else "null")["stages"]
        return {str(name): float(seconds) for name, seconds in stages.items()}
    return {}


@contextmanager
def without_references(pack: str | Path) -> Iterator[Path]:
    """Give a copy of a pack, by links where the disk has them, that has no references.

    ``camera.json`` in it has the still's camera: its size, eye, forward, up, and field of view.
    """
    source = Path(pack)
    with TemporaryDirectory(prefix=".running-", dir=source.resolve().parent) as folder:
        target = Path(folder) / source.resolve().name

        def link(one: str, other: str) -> None:
            try:
                os.link(one, other)
            except OSError:
                shutil.copy2(one, other)

        left = shutil.ignore_patterns("reference", "recipe.json", "SHA256SUMS", ".*")
        shutil.copytree(source, target, copy_function=link, ignore=left)
        numbers = json.loads((target / "pack.json").read_text(encoding="utf-8"))
        numbers.pop("references", None)
        (target / "pack.json").unlink()  # a link: what is written to it would reach the pack
        (target / "pack.json").write_text(json.dumps(numbers), encoding="utf-8")
        camera = {k: v for k, v in numbers["camera"].items() if k not in ("still", "walk")}
        camera |= numbers["camera"]["still"]
        (target / "camera.json").write_text(json.dumps(camera), encoding="utf-8")
        yield target


def run_program(
    pack: Path,
    command: str,
    settings: Sequence[float],
    repeats: int,
    folder: Path,
    who: str,
    program: str,
    baseline: str | None,
    diagnose: bool,
    show: Callable[[int, int, str], None],
) -> tuple[Path, dict[str, Any]]:
    """Call a program for each setting, in turns, and write the record of what it made.

    Raises InputError where the program fails, or writes no picture.
    """
    beside = published_baseline(pack, baseline)
    runs: dict[float, list[dict[str, Any]]] = {setting: [] for setting in settings}
    turns = [(repeat, setting) for repeat in range(repeats) for setting in settings]
    with without_references(pack) as scene:
        for number, (repeat, setting) in enumerate(turns):
            show(number, len(turns), f"setting {setting:g}")
            place = folder / f"{setting:g}" / f"{repeat}"
            place.mkdir(parents=True, exist_ok=True)
            picture = place / "still.exr"
            picture.unlink(missing_ok=True)
            knob = f"{setting:g}"
            values: dict[str, object] = {
                "scene": scene / "scene.usda",
                "camera": scene / "camera.json",
                "pack": scene,
            }
            values |= {"exr": picture.resolve(), "setting": knob, "knob": knob, "seed": repeat}
            took = execute(words_of(command, values), place / "log.txt")
            if not picture.is_file():
                raise InputError("--command", command, f"it writes {{exr}}; see {place}/log.txt")
            runs[setting].append({"repeat": repeat, **plain(asdict(took))})
    rows, first = [], []
    for setting, row in runs.items():
        first = [folder / f"{setting:g}" / "0" / "still.exr"]
        rows.append(setting_row(setting, judged(first, pack, diagnose), row, first))
    record = record_of(pack, who, program, "measured", rows, beside, command)
    return write_record(folder, record, first, pack), record
